"""Simulated devices are made by their dialect's row, with its settings, and saved by its name."""

from __future__ import annotations

import json

import pytest
from cli_calls import Caller

from armdrive.connect.target import simulated_config
from armdrive.errors import BadRequest, StateFileError
from armdrive.registry import DIALECTS, simulated_kind
from armdrive.registry.simulate import simulate, simulate_device
from armdrive.sim.device import Option, Options, SimDevice
from armdrive.sim.teachmover.device import TeachMoverBoard
from armdrive.sim.wire import PacedDevice, WireDevice

SPOKEN = tuple(DIALECTS)
TABLE = (
    Option("pace", 0.5, "how fast"),
    Option("slots", 3, "how many"),
    Option("deaf", False, "whether"),
    Option("board", "avr", "which", ("avr", "esp32")),
)


@pytest.fixture
def call(capsys):
    return Caller(capsys)


@pytest.mark.parametrize("dialect", SPOKEN)
def test_every_row_makes_a_device_that_can_be_saved_and_made_again(dialect):
    config = simulated_config(dialect)
    twin = simulate(config)
    saved = json.loads(json.dumps(twin.save()))
    assert saved["dialect"] == dialect
    assert simulate(config, saved).save() == saved
    assert isinstance(twin.board, simulated_kind(dialect).board)


@pytest.mark.parametrize("dialect", SPOKEN)
def test_every_device_stands_powered_and_is_brought_where_somebody_wants_it(dialect):
    device: SimDevice = simulate_device(simulated_config(dialect))
    assert device.powered
    assert not device.moving
    joints = device.world.joints.replace(shoulder=1.0)
    device.bring_to(joints, device.world.opening_mm)
    assert device.world.joints["shoulder"] == pytest.approx(1.0, abs=0.01)
    device.power_off()
    with pytest.raises(BadRequest):
        device.bring_to(joints, 20.0)


def test_a_world_of_another_dialect_is_refused():
    saved = simulate(simulated_config("teachmover")).save() | {"dialect": "robko01"}
    with pytest.raises(StateFileError, match="'robko01', not 'teachmover'"):
        simulate(simulated_config("teachmover"), saved)


def test_a_world_from_before_there_were_dialects_is_a_teachmovers():
    saved = simulate(simulated_config("teachmover")).save()
    del saved["dialect"]
    assert simulate(simulated_config("teachmover"), saved).save()["dialect"] == "teachmover"


def test_a_dialect_without_a_device_is_refused_with_the_nearest():
    with pytest.raises(BadRequest, match="did you mean 'teachmover'"):
        simulated_kind("teachmoover")


def test_settings_reach_the_device():
    twin = simulate(simulated_config("teachmover"), speed_error=0.25)
    assert isinstance(twin.board, TeachMoverBoard)
    assert twin.board.motor_speed.error == 0.25
    with pytest.raises(BadRequest, match="did you mean 'speed_error'"):
        simulate(simulated_config("teachmover"), sped_error=0.25)


def test_settings_are_read_as_a_person_types_them():
    words = ["pace=2", "slots=7", "deaf=yes", "board=esp32"]
    chosen = Options(TABLE, Options.parse(TABLE, words))
    assert (chosen.number("pace"), chosen.whole("slots")) == (2.0, 7)
    assert (chosen.flag("deaf"), chosen.text("board")) == (True, "esp32")
    rest = Options(TABLE)
    assert (rest.number("pace"), rest.flag("deaf"), rest.text("board")) == (0.5, False, "avr")


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("pace", "NAME=VALUE"),
        ("pase=1", "did you mean 'pace'"),
        ("pace=fast", "a number"),
        ("pace=inf", "finite"),
        ("slots=1.5", "a whole number"),
        ("deaf=perhaps", "yes or no"),
        ("board=arm", "avr, esp32"),
    ],
)
def test_a_wrong_setting_is_named(word, said):
    with pytest.raises(BadRequest, match=said):
        Options.parse(TABLE, [word])


@pytest.mark.parametrize("value", [True, "1", None])
def test_a_setting_of_the_wrong_kind_is_refused(value):
    with pytest.raises(BadRequest):
        Options(TABLE, {"pace": value})


class Heard:
    """A device that only remembers what came at once."""

    byte_gap_s = 0.0

    def __init__(self):
        self.pieces = []

    def receive(self, data, now_s):
        self.pieces.append((now_s, data))

    def transmit(self, now_s):
        return b""

    def next_s(self):
        return float("inf")


def test_without_a_pace_messages_arrive_at_once_and_each_by_itself():
    device: WireDevice = Heard()
    line = PacedDevice(device, None)
    line.send(b"one", 1.0)
    line.send(b"two", 1.0)
    line.send(b"three", 2.0)
    line.advance(2.0)
    assert device.pieces == [(1.0, b"one"), (1.0, b"two"), (2.0, b"three")]


def test_the_command_line_lists_settings_and_faults(call):
    for words in (["sim", "--list"], ["sim", "teachmover", "--list"]):
        out = call(*words).out
        assert "speed_error=0.0" in out
        assert "stall MOTOR" in out
        assert "reset" not in out.split("teachmover: ")[1].split(": a simulated")[0]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["sim"], "a dialect is required"),
        (["sim", "teachmover", "--udp", "x"], "HOST:PORT"),
        (["sim", "teachmover", "--tcp", "0", "--set", "sped_error=1"], "'speed_error'"),
        (["sim", "teachmover", "--tcp", "0", "--fault", "reset"], "no reset"),
        (["sim", "teachmover", "--tcp", "0", "--fault", "drop@x"], "not a number"),
    ],
)
def test_a_wrong_word_of_the_command_line_is_named(call, words, said):
    called = call(*words, code=4 if "--udp" in words else 2)
    assert said in called.err
