"""What a device reports in a motion is raised by the call, however the motion has ended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import pytest
from faults import arm_config, as_it_stands, driven

from armdrive import Arm, Jog
from armdrive.arm.connected import Handle
from armdrive.config.sections import HomingSettings
from armdrive.errors import ArmError, DeviceFault, NoAnswer, Stopped
from armdrive.moves import JogMove
from armdrive.registry import DIALECTS
from armdrive.status import Evidence, State, Trust
from armdrive.tasks import Alert, AlertKind
from kinematics import Joints

WORDS = "somebody has opened the door"
MOTIONS: dict[str, Callable[[Arm], Handle[Any]]] = {
    "move": lambda arm: arm.move_j(base_deg=20.0, speed=0.5, wait=False),
    "jog": lambda arm: arm.start(JogMove(Jog.joint(base=20.0), 0.5)),
}
HOMING = HomingSettings(Joints.of(40.0, 40.0, -80.0, -40.0, 0.0), 20.0, ((1,), (2,)))


def alert(arm: Arm) -> None:
    """Have the device report an alarm that leaves its position right."""
    arm.engine.controller.io.notify(Alert(AlertKind.ALARM, WORDS))


@pytest.mark.parametrize(
    ("dialect", "motion", "stopped"), list(product(DIALECTS, MOTIONS, (False, True)))
)
def test_no_motion_ends_well_in_error_stop(dialect, motion, stopped):
    arm = driven(arm_config(dialect))
    handle = MOTIONS[motion](arm)
    arm.sleep(0.4)
    assert arm.status.state is State.MOVING
    if stopped:
        arm.request_stop()
    alert(arm)
    with pytest.raises(DeviceFault, match=WORDS):
        handle.wait()
    assert arm.status.state is State.ERROR_STOP


@pytest.mark.parametrize(("dialect", "motion"), list(product(DIALECTS, MOTIONS)))
def test_a_stop_does_not_hide_a_power_failure(dialect, motion):
    arm = driven(arm_config(dialect))
    handle = MOTIONS[motion](arm)
    arm.sleep(0.4)
    arm.twin.faults.add("brown-out")
    arm.request_stop()
    with pytest.raises(ArmError) as told:
        handle.wait()
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.state is State.ERROR_STOP or arm.status.trust_reason in str(told.value)


@pytest.mark.parametrize("dialect", ["teachmover", "armdroid", "grbl", "cia402"])
def test_a_stop_says_that_the_arm_did_not_answer_it(dialect):
    """Nobody waits for the end of a held jog, so only the stop can tell."""
    arm = driven(arm_config(dialect))
    arm.hold(Jog.joint(base=1.0), speed=0.5, for_s=1.0)
    arm.sleep(0.4)
    arm.twin.faults.add("brown-out")
    with pytest.raises(NoAnswer):
        arm.stop()
    arm.stop()  # it has been told


@pytest.mark.parametrize("motion", MOTIONS)
def test_an_emergency_stop_is_named_by_the_motion_that_it_ends(motion):
    arm = driven(arm_config("teachmover"))
    handle = MOTIONS[motion](arm)
    arm.sleep(0.4)
    arm.estop()
    with pytest.raises(Stopped, match=r"emergency stop.*reset"):
        handle.wait()


@pytest.mark.parametrize("dialect", ["grbl", "mks"])
def test_an_alarm_in_a_homing_group_ends_the_homing(dialect):
    arm = homing(dialect)
    before, told = arm.twin.world.motors, []
    arm.twin.device.at(arm.pace.now_s() + 0.5, lambda: alert(arm))
    with pytest.raises(DeviceFault, match=WORDS):
        arm.home(report=told.append)
    nothing_was_referenced(arm)
    assert not told
    assert arm.twin.world.motors[1] == before[1], "the next group was homed in error-stop"


@pytest.mark.parametrize("dialect", ["grbl", "mks"])
def test_an_alarm_after_the_last_homing_group_leaves_nothing_referenced(dialect):
    arm = homing(dialect)
    told = []

    def report(group):
        told.append(group)
        if len(told) == len(HOMING.groups):
            alert(arm)

    with pytest.raises(DeviceFault, match=WORDS):
        arm.home(report=report)
    nothing_was_referenced(arm)


def homing(dialect: str) -> Arm:
    """Return a referenced arm that homes by its switches."""
    device = {"homing": True} if dialect == "grbl" else {}
    return driven(replace(arm_config(dialect, device=device), homing=HOMING))


def nothing_was_referenced(arm: Arm) -> None:
    assert arm.status.state is State.ERROR_STOP
    assert WORDS in arm.status.error
    assert arm.status.trust_reason == Evidence.HOMING_FAILED.value


# -- counts that fall to zero, on a device that does not greet ------------------------------------


def at_zeros(dialect):
    arm = Arm.connect(f"sim:{dialect}")
    arm.enable()
    return as_it_stands(arm)


def seen_in_motion(arm, base_deg):
    """Begin to move; return when the driver has been told that the counts have changed."""
    start = arm.status.read_back
    arm.move_j(base_deg=base_deg, wait=False)
    for _ in range(200):
        arm.sleep(0.005)
        if arm.status.read_back != start:
            return


@pytest.mark.parametrize("base_deg", [30.0, -30.0])
def test_counts_that_return_to_their_start_are_those_of_a_restarted_device(base_deg):
    arm = at_zeros("robko01")
    seen_in_motion(arm, base_deg)
    arm.twin.faults.add("brown-out", for_s=0.1)
    arm.sleep(0.02)
    arm.stop()
    arm.sleep(1.0)
    assert not arm.twin.device.registers.largest
    assert arm.status.trust is Trust.SUSPECT
    assert "fell to zero" in arm.status.trust_reason


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_motion_back_to_zero_that_is_stopped_keeps_its_position(dialect):
    arm = at_zeros(dialect)
    there = arm.joints.deg["base"]
    arm.move_j(base_deg=there + 10.0)
    for after_s in (0.1, 0.4):
        arm.move_j(base_deg=there, wait=False)
        arm.sleep(after_s)
        arm.stop()
        assert arm.status.trust is Trust.REFERENCED
    arm.move_j(base_deg=there - 5.0, wait=False)
    arm.sleep(0.8)
    arm.stop()
    assert arm.status.trust is Trust.REFERENCED
    assert arm.twin.world.motors == arm.status.acknowledged
