"""`SpringBack` excuses the motor that was blocked, and only for a moment."""

import contextlib
import random

import pytest

from armdrive.errors import ArmError, NoAnswer
from kinematics import Motors

from .actions import connect
from .excuses import HOLDS_WITHIN_S, SPRINGS_BACK_S, SpringBack
from .faults import FAULTS
from .physical import Bound
from .stage import Stage

FINGERS, BASE = 5, 0
STOPPED_S, BLOCKED_S = 1.0, 3.0


def blocked_stage(can_hold) -> Stage:
    """Return an arm that was stopped, and one of whose motors is blocked long after that."""
    stage = Stage("cia402", random.Random(1), 0)
    stage.watch.spring_back.can_hold = can_hold
    stage.watch.add_bound(Bound("stop", STOPPED_S, stage.world.tip, 0.2, 20.0))
    stage.world.stalled.add(FINGERS)
    stage.world.drive(only(FINGERS), BLOCKED_S)
    stage.world.stalled.clear()
    assert not stage.watch.broken
    return stage


def only(motor: int, count: int = 80) -> Motors:
    return Motors(count if each == motor else 0 for each in range(6))


def all_but_fingers(motor: int, _time_s: float) -> bool:
    return motor != FINGERS


def test_the_shaft_of_a_drive_without_contact_goes_to_its_set_point():
    stage = blocked_stage(all_but_fingers)
    stage.world.drive(only(FINGERS), BLOCKED_S + 0.01)
    assert not stage.watch.broken


@pytest.mark.parametrize(("motor", "after_s"), [(BASE, 0.01), (FINGERS, SPRINGS_BACK_S + 0.01)])
def test_no_other_motor_moves_and_none_later(motor, after_s):
    stage = blocked_stage(all_but_fingers)
    stage.world.drive(only(motor), BLOCKED_S + after_s)
    assert any("stop: it moved" in each for each in stage.watch.broken)


def test_the_shaft_of_a_drive_in_contact_stays():
    stage = blocked_stage(lambda _motor, _time_s: True)
    stage.world.drive(only(FINGERS), BLOCKED_S + 0.01)
    assert any("stop: it moved" in each for each in stage.watch.broken)


def test_motors_that_are_not_blocked_are_not_excused():
    spring_back = SpringBack(can_hold=lambda _motor, _time_s: False)
    assert not spring_back.excuses({FINGERS}, 0.0)
    spring_back.note_blocked({FINGERS}, 1.0)
    assert spring_back.excuses({FINGERS}, 1.0)
    assert not spring_back.excuses({FINGERS, BASE}, 1.0)


@pytest.mark.parametrize(
    ("in_motion", "lasts_s", "excused"),
    [(True, HOLDS_WITHIN_S - 0.01, True), (True, HOLDS_WITHIN_S + 0.2, False), (False, 0.0, False)],
)
def test_a_drive_in_contact_holds_in_time_and_only_a_motion_runs_ahead_of_its_shaft(
    in_motion, lasts_s, excused
):
    spring_back = SpringBack()
    for time_s in (1.0 + 0.05 * step for step in range(round(lasts_s / 0.05) + 1)):
        spring_back.note_blocked({FINGERS}, time_s, in_motion=in_motion and time_s < 1.2)
    assert spring_back.excuses({FINGERS}, 1.0 + lasts_s) is excused


@pytest.mark.parametrize("lasts_s", [HOLDS_WITHIN_S + 0.2, 2.0 * HOLDS_WITHIN_S])
def test_a_block_that_lasts_is_not_excused_again_in_the_same_motion(lasts_s):
    spring_back = SpringBack()
    for time_s in (1.0 + 0.05 * step for step in range(round(lasts_s / 0.05) + 1)):
        spring_back.note_blocked({FINGERS}, time_s, in_motion=True)
    assert not spring_back.excuses({FINGERS}, 1.0 + lasts_s)


def test_no_drive_is_ordered_to_hold_between_a_lost_wire_and_the_reset():
    stage = Stage("mks", random.Random(1), 0)
    connect(stage)
    arm = stage.arm
    arm.enable()
    assert stage._can_hold(FINGERS, stage.now_s)
    stage.twin.faults.add("bus-off", for_s=0.2)
    arm.sleep(3.0)
    arm.reconnect()
    assert not stage._can_hold(FINGERS, stage.now_s)
    arm.reset()
    assert stage._can_hold(FINGERS, stage.now_s)


def test_an_emergency_stop_on_a_lost_wire_does_not_hide_the_loss():
    stage = Stage("mks", random.Random(1), 0)
    connect(stage)
    arm = stage.arm
    arm.enable()
    stage.twin.faults.add("bus-off", for_s=0.2)
    with contextlib.suppress(ArmError):
        arm.estop()
    arm.sleep(3.0)
    arm.reconnect()
    assert arm.status.error_code == "E303"
    assert not stage._can_hold(FINGERS, stage.now_s)
    arm.reset()
    assert stage._can_hold(FINGERS, stage.now_s)


def test_no_drive_is_ordered_to_hold_while_the_device_is_mute():
    stage = Stage("cia402", random.Random(1), 0)
    connect(stage)
    next(fault for fault in FAULTS if fault.name == "a mute device").begin(stage)
    assert not stage._can_hold(FINGERS, stage.now_s)
    assert stage._can_hold(FINGERS, stage.now_s + 10.0)


def test_no_drive_is_ordered_to_hold_between_a_lost_reply_and_the_reset():
    stage = Stage("cia402", random.Random(1), 0)
    connect(stage)
    arm = stage.arm
    arm.enable()
    stage.twin.faults.add("mute")
    with pytest.raises(NoAnswer):
        arm.jog_j(base_deg=1.0)
    stage.twin.faults.end()
    assert not stage._can_hold(FINGERS, stage.now_s)
    arm.reset()
    assert stage._can_hold(FINGERS, stage.now_s)
