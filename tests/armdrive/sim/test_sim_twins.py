"""The simulated device of every dialect, and its wire."""

import json
import math
from dataclasses import dataclass

import pytest
from amounts import every_row
from cli_calls import Caller
from faults import arm_config, driven
from hypothesis import given, settings
from hypothesis import strategies as st
from sim_bench import RobkoBench, SilentDevice, TeachMoverBench, axes

from armdrive.connect.target import simulated_config
from armdrive.errors import BadRequest, StateFileError
from armdrive.registry import DIALECTS, simulate, simulated_kind
from armdrive.sim.device import SimDevice, chosen, parse_settings
from armdrive.sim.wire import DeviceLine, PacedWire, WireDevice
from armdrive.text.toml import setting
from firmware_protocol.robko01 import MoveAbsolute
from firmware_protocol.teachmover import Step
from kinematics import Joints

SPOKEN = tuple(DIALECTS)


@dataclass(frozen=True)
class Table:
    pace: float = setting(0.5, "how fast")
    slots: int = setting(3, "how many")
    deaf: bool = setting(False, "whether")
    board: str = setting("avr", "which", words=("avr", "esp32"))
    inner: int = 7


@pytest.fixture
def call(capsys):
    return Caller(capsys)


def lived(dialect, **settings):
    """Return a simulated arm that was switched on, referenced and moved, as a driver does."""
    return driven(arm_config(dialect), **settings).twin


@pytest.mark.parametrize("dialect", SPOKEN)
@pytest.mark.parametrize("moved", [False, True])
def test_every_row_makes_a_device_that_can_be_saved_and_made_again(dialect, moved):
    twin = lived(dialect) if moved else simulate(simulated_config(dialect))
    if moved:
        twin.device.jog((10, 0, -3, 0, 0, 7))
    saved = json.loads(json.dumps(twin.save()))
    assert saved["dialect"] == dialect
    again = simulate(simulated_config(dialect), saved)
    assert again.save() == saved
    assert again.world.motors == twin.world.motors
    assert again.world.energised == twin.world.energised
    assert again.device.registers == twin.device.registers
    assert again.board.details() == twin.board.details()
    assert isinstance(twin.board, simulated_kind(dialect).board)


@every_row("dialect", SPOKEN)
def test_every_device_is_brought_where_somebody_wants_it_and_counts_the_way(dialect):
    device: SimDevice = simulate(simulated_config(dialect)).device
    before, energised = device.world.motors, device.world.energised
    assert device.powered
    assert not device.moving
    joints = Joints.of(20, 60, -80, -40, 10)
    device.bring_to(joints, 33.0)
    assert device.world.joints.deg == pytest.approx(joints.deg, abs=0.25)
    assert device.world.opening_mm == pytest.approx(33.0, abs=0.1)
    assert device.registers == device.world.motors - before
    assert device.world.energised is energised
    device.power_off()
    with pytest.raises(BadRequest):
        device.bring_to(joints, 20.0)


@pytest.mark.parametrize("dialect", SPOKEN)
def test_without_power_every_arm_sags_says_nothing_and_forgets_where_it_was(dialect):
    twin = lived(dialect)
    device, height_mm = twin.device, twin.world.pose.z_mm
    device.jog((10, 0, -3, 0, 0, 7))
    now_s = device.now_s
    device.power_off()
    assert not twin.world.energised
    assert twin.world.pose.z_mm < height_mm - 5
    assert not device.transmit(now_s + 1.0)
    assert not device.powered
    saved = json.loads(json.dumps(twin.save()))
    assert simulate(simulated_config(dialect), saved).save() == saved
    device.power_on()
    device.transmit(now_s + 5.0)
    assert not device.registers.largest


SAVED = [
    ("grbl", ("dialect",), "mks"),
    ("grbl", ("axes",), "XYZ"),
    ("grbl", ("state",), "Run"),
    ("grbl", ("settings",), {}),
    ("grbl", ("settings", "x"), 1.0),
    ("grbl", ("settings", "9" * 9000), 1.0),
    ("grbl", ("outputs", "P1"), "on"),
    ("mks", ("drives",), []),
    ("mks", ("drives", 0, "settings", "mode"), "09"),
    ("mks", ("drives", 0, "settings", "node"), ""),
    ("mks", ("drives", 0, "settings", "homing"), "zz"),
    ("mks", ("drives", 0, "settings", "extra"), "00"),
    ("cia402", ("drives", 0, "nmt"), "asleep"),
    ("cia402", ("drives", 0, "active_errors"), ["8130"]),
    ("cia402", ("drives", 0, "state"), "ill"),
    ("cia402", ("drives", 0, "objects"), {"6060:00": "xx"}),
]


@every_row("dialect, path, value", SAVED)
def test_a_state_that_no_device_saved_is_refused(dialect, path, value):
    saved = simulate(simulated_config(dialect)).save()
    *way, key = path
    table = saved
    for each in way:
        table = table[each]
    table[key] = value
    with pytest.raises(StateFileError, match="--fresh"):
        simulate(simulated_config(dialect), saved)


SETTINGS = [
    ("teachmover", {"sped_error": 0.25}, "did you mean 'speed_error'"),
    ("robko01", {"watchdog_s": -1.0}, "watchdog_s must be at least 0"),
    ("armdroid", {"speed_error": -2.0}, "speed_error"),
    ("armdroid", {"bord": "uno"}, "did you mean 'board'"),
    ("armdroid", {"board": "mega"}, "leonardo"),
    ("grbl", {"firmware": "marlin"}, "grblhal"),
    ("mks", {"firmware": "1.0"}, "1.0.9"),
    ("mks", {"firmware": "1.0.6+1.0.9"}, "6 of them"),
    ("mks", {"bitrate": 9600}, "125000"),
    ("mks", {"flash_ms": -1.0}, "flash_ms must be from 0 to 1000"),
    ("cia402", {"bitrate": 123}, "bitrate"),
    ("cia402", {"missing": "60C"}, "missing"),
    ("cia402", {"profile": -1}, "profile"),
    ("cia402", {"missing": "608F"}, "608F"),
]


@every_row("dialect, setting, named", SETTINGS)
def test_a_setting_that_no_device_has_is_refused(dialect, setting, named):
    with pytest.raises(BadRequest, match=named):
        simulate(simulated_config(dialect), **setting)


@every_row("dialect", ["mks", "cia402"])
@every_row("ids", [(1, 2), (1, 2, 3)])
def test_every_motor_needs_a_drive(dialect, ids):
    with pytest.raises(BadRequest, match=f"{len(ids)} drives cannot turn 6 motors"):
        simulate(arm_config(dialect, {"ids": ids}))


HOSTS = {
    "teachmover": (TeachMoverBench, lambda move: Step(240, move)),
    "robko01": (lambda: RobkoBench().enabled(), lambda move: MoveAbsolute(axes(*move))),
}


def pass_time(bench, seconds):
    bench.host.receive_data(bench.pass_time(seconds))
    while bench.host.next_event() is not None:
        pass


@pytest.mark.parametrize("dialect", HOSTS)
@settings(max_examples=20)
@given(
    moves=st.lists(st.tuples(*[st.integers(-40, 40)] * 6), max_size=3),
    looks=st.lists(st.floats(0.0, 0.2), max_size=10),
)
def test_how_often_one_looks_changes_nothing(dialect, moves, looks):
    make, request = HOSTS[dialect]
    watched, alone = make(), make()
    for move in moves:
        for bench, pauses in ((watched, looks), (alone, [math.fsum(looks)])):
            bench.begin(request(move))
            for pause in (*pauses, 5.0):
                pass_time(bench, pause)
    assert watched.device.registers == alone.device.registers
    assert watched.device.world.motors == alone.device.world.motors


@every_row(
    "word, said",
    [
        ("pace", "NAME=VALUE"),
        ("pase=1", "did you mean 'pace'"),
        ("inner=1", "no setting 'inner'"),
        ("pace=fast", "a finite number"),
        ("pace=inf", "finite"),
        ("slots=1.5", "a whole number"),
        ("deaf=perhaps", "yes or no"),
        ("board=arm", "avr, esp32"),
    ],
)
def test_a_wrong_setting_is_named(word, said):
    with pytest.raises(BadRequest, match=said):
        chosen(Table, parse_settings(Table, [word]))


def test_without_a_pace_messages_arrive_at_once_and_each_by_itself():
    device: WireDevice = SilentDevice()
    line = DeviceLine(device, None)
    line.send(b"one", 1.0)
    line.send(b"two", 1.0)
    line.send(b"three", 2.0)
    line.advance(2.0)
    assert device.received == [(1.0, b"one"), (1.0, b"two"), (2.0, b"three")]


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


# -- The wire --------------------------------------------------------------------------------------

BYTE_S = 10 / 9600


@given(
    lines=st.lists(st.tuples(st.binary(max_size=20), st.floats(0, 0.02)), max_size=8),
    looks=st.lists(st.floats(0, 0.01), max_size=30),
)
def test_nothing_is_lost_reordered_or_early_however_often_one_looks(lines, looks):
    wire, now, sent = PacedWire(9600), 0.0, b""
    for data, pause in lines:
        now += pause
        wire.push(data, now)
        sent += data
    got, at = b"", 0.0
    for pause in looks:
        at += pause
        got += wire.pull(at)
        assert len(got) <= at / BYTE_S + 1e-2
    got += wire.pull(now + len(sent) * BYTE_S + 1e-9)
    assert got == sent


class Echo:
    """A device that repeats a line, a tenth of a second after it has heard its end."""

    def __init__(self):
        self.due = []
        self.heard = b""

    def receive(self, data, now_s):
        self.heard += data
        if data.endswith(b"\r"):
            self.due.append((now_s + 0.1, self.heard))
            self.heard = b""

    def transmit(self, now_s):
        said = b"".join(data for at, data in self.due if at <= now_s)
        self.due = [(at, data) for at, data in self.due if at > now_s]
        return said

    def next_s(self):
        return min((at for at, _ in self.due), default=math.inf)


def test_an_answer_is_as_late_as_it_should_be_whoever_looks_when():
    seldom, often = DeviceLine(Echo(), 9600), DeviceLine(Echo(), 9600)
    for line in (seldom, often):
        line.send(b"hell\r", 0.0)
    due = 10 * BYTE_S + 0.1
    assert seldom.receive(due - 1e-5) == b"hell"
    assert seldom.receive(due) == b"\r"
    seen = {}
    for tick in range(200):
        for byte in often.receive(tick / 1000):
            seen[byte] = tick / 1000
    assert due <= seen[ord("\r")] <= due + 0.001


def test_an_unplugged_cable_loses_both_directions():
    line = DeviceLine(Echo(), 9600)
    line.send(b"a\r", 0.0)
    line.advance(0.01)
    line.unplug()
    line.send(b"b\r", 0.02)
    line.replug(0.3)
    assert line.receive(1.0) == b""
    line.send(b"c\r", 1.0)
    assert line.receive(2.0) == b"c\r"
