"""`armdrive home` and `verify` with typed answers, on a simulated twin."""

import sys

import pytest
from cli_calls import Terminal, write_arm_file
from simulated_port import SimulatedPorts

from armdrive import Arm
from armdrive.cli import terminal_operator
from armdrive.cli.chosen_arm import connect_remembered, world_file
from armdrive.cli.terminal_operator import TerminalOperator
from armdrive.connect.target import simulated_config
from armdrive.errors import DeviceFault, LinkLost, Stopped
from armdrive.registry import DIALECTS
from armdrive.status import State, Trust
from kinematics import preset

ARM = "sim:teachmover"


def at_the_mark() -> None:
    """Bring the remembered simulated arm to its mark by hand."""
    with connect_remembered(simulated_config("teachmover")) as arm:
        arm.twin.device.bring_to(arm.model.arm.ik(arm.model.reference.pose), 0.0)


def test_a_person_is_led_through_and_confirms(call, typing):
    at_the_mark()
    jogs = ("shoulder -200", "shoulder -2", "shoulder 2", "gripper 3 gripper -3")
    typing("yes", "", "ok", *jogs, "show", "done")
    called = call("home", "--guide", code=0)
    assert "Step 1 of 3" in called.out
    assert called.out.count("Is the way clear? Type ok: ") == 3  # until it is yes or no
    assert called.out.count("Type ok to go on, or no to leave.") == 2
    assert "Step 3 of 3" in called.out
    assert "reference posture" in called.out
    assert "jog by at most 20 degrees or mm at a time, not -200" in called.out
    assert "shoulder -2: done" in called.out
    assert "referenced: tip" in called.out
    assert call("status", "--json", code=0).json["trust"] == "restored"


ABORTED = [
    (),
    ("no", "ok", "done"),
    ("shoulder 5", "done"),
    ("ok", "quit", "done"),
    ("ok", "shoulder 1"),
]


@pytest.mark.parametrize("lines", ABORTED)
def test_without_a_confirmation_nothing_is_referenced_and_before_a_clear_way_nothing_moves(
    call, typing, lines
):
    at_the_mark()
    before = world_file(ARM).read_text()
    typing(*lines)
    said = call("home", "--guide", code=3)
    if lines[:1] != ("ok",):
        assert world_file(ARM).read_text() == before
        assert "Step 2 of 3" not in said.out
        assert "Answer the questions in a terminal, or state where the arm is" in said.err
    assert call("status", "--json", code=0).json["pose"] is None


def test_motors_that_are_off_are_switched_on_only_when_the_person_holds_the_arm(
    call, typing, monkeypatch
):
    row = DIALECTS["armdroid"]
    keys = f'dialect = "{row.name}"\nport = "/dev/ttyUSB0"\n'
    write_arm_file("bench", f'model = "{row.preset}"\n[connection]\n{keys}')
    device = SimulatedPorts(monkeypatch).put("/dev/ttyUSB0", row.name).device
    device.world.energised = False
    typing("ok", "", "no")
    said = call("home", "--arm", "bench", code=3).out
    assert "Hold the arm by hand until they are" in said
    assert not device.world.energised
    typing("ok", "on", "done")
    assert "referenced: tip" in call("home", "--arm", "bench", code=0).out
    assert device.world.energised


def fault(name):
    return lambda arm: arm.twin.faults.add(name) or arm.sleep(8.0)


@pytest.mark.parametrize(
    ("ends", "error", "words"),
    [
        (lambda arm: arm.stop(), Stopped, "homing was stopped"),
        (lambda arm: arm.estop(), Stopped, "emergency stop"),
        (fault("unplug"), LinkLost, "unplugged"),
        (fault("mute"), DeviceFault, "no answer"),
    ],
)
def test_the_guiding_ends_with_its_reason_before_the_next_line_moves_anything(
    monkeypatch, ends, error, words
):
    arm = Arm.connect(ARM)
    before = arm.twin.world.motors
    lines = iter(("shoulder 2", "done"))

    def line_after_that(prompt: str) -> str | None:
        ends(arm)
        return next(lines, None)

    monkeypatch.setattr(terminal_operator, "typed", line_after_that)
    with arm, pytest.raises(error, match=words):
        arm.home(operator=TerminalOperator())
    assert arm.twin.world.motors == before


def test_a_stop_in_the_middle_of_a_line_ends_the_line(typing, monkeypatch):
    arm, jogs = Arm.connect(ARM), []

    def stopped(_, name: str, amount: float) -> str:
        jogs.append(name)
        arm.stop()
        return f"{name} {amount}: the jog was stopped"

    monkeypatch.setattr(terminal_operator, "jogged", stopped)
    typing("shoulder 5 elbow 5", "elbow 5", "done")
    with arm, pytest.raises(Stopped, match="homing was stopped"):
        arm.home(operator=TerminalOperator())
    assert jogs == ["shoulder"]


# -- declaring ------------------------------------------------------------------------------------


def test_a_posture_is_declared_by_its_joints_or_by_its_name(call):
    angles = {"base": 10, "shoulder": 40, "elbow": -60, "wrist_pitch": -70, "wrist_roll": 5}
    words = [f"{name}={angle}" for name, angle in angles.items()]
    seen = call("home", "--declare", *words, "gripper=12", "--json", code=0).json
    assert seen["trust"] == "referenced"
    assert "declared" in seen["trust_reason"]
    for name, angle in angles.items():
        assert seen["joints"][f"{name}_deg"] == pytest.approx(angle, abs=0.2)
    assert seen["gripper_mm"] == pytest.approx(12, abs=0.1)
    parked = call("home", "--declare", "park", "--json", code=0).json
    assert parked["pose"]["z_mm"] == pytest.approx(30.0, abs=1.0)


# -- switches -------------------------------------------------------------------------------------

SWITCHED = """
model = "minimover5"
[connection]
dialect = "grbl"
port = "/dev/ttyNOWHERE"
[grbl]
homing = true
[homing]
joints_deg = {{ {angles} }}
opening_mm = 10
groups = [[1], [2, 3, 4, 5, 6]]
"""


@pytest.fixture
def switched(call, monkeypatch):
    """An arm file with switches, whose twin stands in for it."""
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    model = preset("minimover5")
    angles = model.arm.ik(model.reference.pose).deg
    text = ", ".join(f"{name} = {angle:.4f}" for name, angle in angles.items())
    write_arm_file("switched", SWITCHED.format(angles=text))
    return ("--arm", "switched")


def test_homing_by_switches_warns_of_motion(call, switched):
    said = call("home", *switched, code=0).out
    assert "THE ARM WILL MOVE" in said
    assert "switches of base, then shoulder and elbow and" in said


def test_a_real_arm_with_switches_moves_to_them_only_after_a_yes(call, switched, monkeypatch):
    monkeypatch.delenv("ARMDRIVE_FORCE_SIM")
    device = SimulatedPorts(monkeypatch).put("/dev/ttyNOWHERE", "grbl").device
    before = device.world.motors
    monkeypatch.setattr(sys, "stdin", Terminal("no\n"))
    called = call("home", *switched, code=3)
    assert "THE ARM WILL MOVE" in called.out
    assert "not confirmed, so nothing moved" in called.err
    assert device.world.motors == before


# -- verifying ------------------------------------------------------------------------------------


def losing_steps() -> None:
    """Have the first motor lose 15 steps."""
    with connect_remembered(simulated_config("teachmover"), allow_restored=True) as arm:
        arm.twin.faults.add("lose-steps", "1", "15")
        arm.move_j(base_deg=20)


def test_a_simulated_arm_is_verified_by_a_command(call):
    call("home", code=0)
    said = call("verify", code=0).out
    assert "within rounding" in said
    losing_steps()
    off = call("verify", "--json", code=1).json
    assert off["steps"] == [15, 0, 0, 0, 0, 0]
    assert off["verdict"] == "drift"
    assert off["accepted"] is False
    assert "suspect" in call.refused("verify", code=3)
    call("home", code=0)
    losing_steps()
    assert "new reference" in call("verify", "--accept", code=0).out
    call("move", "--base", "0", code=0)


def test_a_person_types_the_tips_onto_the_mark(typing):
    arm = Arm.connect(ARM)
    arm.home()
    typing("z -10", "z -10", "z -10", "done")
    found = arm.reference.verify(operator=TerminalOperator())
    assert found.drift.steps.largest <= 1
    assert arm.status.state is State.STANDBY
    assert arm.status.trust is Trust.REFERENCED
