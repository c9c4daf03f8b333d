"""One-line commands steer a simulated arm, and say what they did."""

from __future__ import annotations

import json

import pytest

from armdrive.sim.device import SimDevice
from armdrive.sim.serving.console import COMMANDS, Console
from armdrive.sim.teachmover import TeachMoverBoard
from armdrive.sim.wire import PacedDevice
from firmware_protocol.teachmover import Key


class Wire:
    """A server that only remembers whether it is offered."""

    address = "here"

    def __init__(self):
        self.is_open = True

    def open(self, address=None):
        self.is_open = True
        self.address = address or self.address

    def close(self):
        self.is_open = False

    def filenos(self):
        return ()

    def read(self):
        return b""

    def write(self, data):
        pass


@pytest.fixture
def console():
    device = SimDevice(TeachMoverBoard())
    return Console(device, Wire(), PacedDevice(device, device.board.baud))


def state(console):
    return json.loads(console.answer("state --json"))


def test_state_tells_the_physical_arm_in_words_and_as_data(console):
    line = console.answer("state")
    assert "power on" in line
    assert "still" in line
    told = state(console)
    assert told["motors"] == list(console.device.world.motors)
    assert told["registers"] == [0] * 6
    assert told["pose"]["x_mm"] == pytest.approx(console.device.world.pose.x_mm, abs=0.001)
    assert told["joints_deg"]["shoulder"] == pytest.approx(70, abs=0.05)


def test_a_key_is_pressed_whatever_its_case(console):
    assert console.answer("key stop") == "pressed STOP"
    assert console.device.board.key is Key.STOP
    assert "TRAIN" in console.answer("key sotp")


def test_somebody_guides_the_arm_to_its_reference_posture(console):
    before = console.device.registers
    assert "reference posture" in console.answer("guide")
    world = console.device.world
    assert world.pose.x_mm == pytest.approx(127.0, abs=0.3)
    assert world.pose.z_mm == pytest.approx(0.0, abs=0.3)
    assert console.device.registers != before  # the pendant's moves are counted


def test_blocks_are_put_and_taken(console):
    assert "z 0.0" in console.answer("put A 200 10 30 20")
    assert "z 20.0" in console.answer("put B 200 10")
    assert [block["name"] for block in state(console)["blocks"]] == ["A", "B"]
    assert console.device.world.scene.blocks["A"].height_mm == 20
    assert console.device.world.scene.blocks["B"].width_mm == 25
    console.answer("take A")
    assert console.device.world.scene.blocks["B"].z_mm == 0
    assert "there are: B" in console.answer("take A")


def test_power_is_switched_off_and_on(console):
    assert console.answer("power off") == "power is off"
    assert state(console)["energised"] is False
    console.answer("power on")
    assert state(console)["powered"] is True


@pytest.mark.parametrize(("line", "where"), [("replug", "here"), ("replug as there", "there")])
def test_the_cable_is_pulled_and_put_back_perhaps_under_another_name(console, line, where):
    console.answer("unplug")
    assert not console.server.is_open
    assert console.answer(line) == f"plugged in at {where}"
    assert console.server.is_open


def test_faults_are_begun_listed_and_ended(console):
    assert console.answer("fault") == "no faults"
    assert console.answer("fault stall 2") == "fault: a motor no longer follows"
    assert console.answer("fault drop 0.5 --from host @60").startswith("fault in 60 s: ")
    assert state(console)["stalled"] == [2]
    assert json.loads(console.answer("fault --json")) == {"faults": ["stall 2"]}
    assert console.answer("fault off stall") == "ended: stall 2"
    assert state(console)["stalled"] == []
    assert console.answer("fault off") == "ended: nothing"


def test_the_faults_that_this_device_can_have_are_listed(console):
    told = json.loads(console.answer("faults --json"))
    assert "stall MOTOR" in told
    assert "reset" not in told


def test_inputs_pushes_and_speed(console):
    console.answer("input 4 1")
    assert state(console)["inputs"] == 8
    console.answer("input 4 off")
    assert state(console)["inputs"] == 0
    before = console.device.world.motors
    console.answer("push 2 -15")
    assert console.device.world.motors - before == (0, -15, 0, 0, 0, 0)
    console.answer("speed-error 0.2")
    assert console.device.board.motor_speed.error == 0.2


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("sate", "did you mean 'state'?"),
        ("xyzzy", "help"),
        ("put A 1", "put NAME X Y [WIDTH [HEIGHT]]"),
        ("put A one 2", "'one' is not a number"),
        ("put A nan 2", "finite"),
        ("put A 1 2 -3", "wider"),
        ("push 7 10", "1 to 6"),
        ("push 1 half", "not a whole number"),
        ("input 1 1", "grip switch"),
        ("input 9 1", "numbered 1 to 8"),
        ("input 0 1", "numbered 1 to 8"),
        ("power maybe", "neither on nor off"),
        ("speed-error -2", "speed error"),
        ("return", "no control"),
        ("fault flood", "there is no fault 'flood'"),
        ("fault reset", "no reset"),
        ("quit now", "write it like this: quit"),
    ],
)
def test_a_wrong_line_is_answered_by_one_sentence(console, line, said):
    before = state(console)
    answer = console.answer(line)
    assert said in answer
    assert "\n" not in answer
    assert json.loads(console.answer(line + " --json")) == {"ok": False, "error": answer}
    assert state(console) == before


def test_every_command_is_in_the_help(console):
    told = json.loads(console.answer("help --json"))
    assert [usage.split()[0] for usage in told] == list(COMMANDS)
    assert all(command.usage in console.answer("help") for command in COMMANDS.values())


def test_an_empty_line_is_not_answered_and_quit_ends(console):
    assert console.answer("  ") == ""
    assert not console.ended
    assert json.loads(console.answer("quit --json")) == {"ok": True, "text": "ending"}
    assert console.ended
