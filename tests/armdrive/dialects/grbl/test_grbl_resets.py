"""Lost resets and holds of a GRBL board, and greetings that answer no reset of the driver."""

import itertools
from dataclasses import replace

import pytest
from faults import Rule, lost
from grbl_arm import (
    BEGINNINGS,
    FIRMWARES,
    begin_line,
    begin_planned,
    config,
    found,
    ready,
    standing_as_said,
    stands,
    tip_mm,
)

from armdrive import Jog
from armdrive.config.sections import HomingSettings
from armdrive.motion.reference import home_device
from armdrive.status import State, Trust
from kinematics import Joints


def begin_held_jog(arm):
    arm.hold(Jog.joint(base=1.0), speed=1.0, for_s=3.0)


def lose(arm, what):
    """Lose one byte, or all that the next message says."""
    if what == "message":
        arm.twin.faults.add("drop", "next", side="host")
    else:
        arm.twin.link.to.append(Rule(what, lost))


def stops_as_announced(arm, stop):
    status, tip = arm.status, arm.twin.world.tip
    assert status.state is State.MOVING
    stop()
    assert stands(arm) - status.time_s <= status.stop_time_s
    assert tip_mm(arm, tip) <= status.stop_distance_mm


RESET, HOLD, CANCEL = b"\x18", b"!", b"\x85"
LOST = [
    *itertools.product(BEGINNINGS, [RESET, "message"], ["estop"], FIRMWARES[1:2]),
    *itertools.product([begin_planned], [RESET], ["estop"], FIRMWARES),
    *itertools.product([begin_planned, begin_line], [HOLD, "message"], ["request_stop"],
                       FIRMWARES[1:2]),
    *itertools.product([begin_held_jog], [CANCEL, "message"], ["release"], FIRMWARES[1:2]),
]  # fmt: skip


@pytest.mark.parametrize(("begin", "what", "stop", "firmware"), LOST)
def test_a_stop_that_is_lost_is_said_again_within_what_was_announced(begin, what, stop, firmware):
    arm = ready(firmware=firmware)
    begin(arm)
    arm.sleep(0.5)
    lose(arm, what)
    began_s = arm.status.time_s
    stops_as_announced(arm, getattr(arm, stop))
    arm.sleep(2.0)
    if stop == "estop":
        resets = [sent_s - began_s for sent_s, piece in arm.twin.link.sent if piece == RESET]
        assert resets[1] <= 0.03
        assert arm.status.state is State.ERROR_STOP
        assert arm.status.trust is Trust.SUSPECT
        arm.reset()
    else:
        assert arm.status.trust is Trust.REFERENCED
        assert standing_as_said(arm)
        assert arm.twin.link.pressed(CANCEL) == (stop == "release")
    assert arm.status.state is State.STANDBY


def test_one_that_is_lost_before_the_first_report_of_motion_as_well():
    for later_s in (0.0, 0.01, 0.02, 0.04):
        arm = ready()
        begin_planned(arm)
        while len(arm.twin.link.motions) < 1:
            arm.sleep(0.001)
        arm.sleep(later_s)
        lose(arm, rb"\x18")
        stops_as_announced(arm, arm.estop)


@pytest.mark.parametrize(
    ("begin", "firmware"),
    [*zip(BEGINNINGS, FIRMWARES, strict=True), *((begin_planned, each) for each in FIRMWARES[1:])],
)
def test_one_that_arrives_is_said_once(begin, firmware):
    arm = ready(firmware=firmware)
    begin(arm)
    for more_s in (0.30, 0.31, 0.32, 0.33):  # with and without a report on its way
        arm.sleep(more_s - 0.3)
    arm.estop()
    arm.sleep(2.5)
    assert arm.twin.link.pressed(b"\x18") == 1
    assert "emergency stop" in arm.status.error


@pytest.mark.parametrize("firmware", FIRMWARES)
@pytest.mark.parametrize("what", [rb"\x18", "message", "nothing"])
def test_homing_that_is_stopped_ends_in_time_although_a_byte_is_lost(firmware, what):
    made = config(device={"homing": True})
    homing = HomingSettings(Joints.of(60.0, 20.0, -90.0, -20.0, 0.0), 60.0, ())
    arm = found(replace(made, homing=homing), firmware=firmware)
    task = arm.runner.submit(home_device(arm.wire, homing))
    arm.sleep(1.0)
    assert arm.twin.device.moving
    if what != "nothing":
        lose(arm, what)
    status = arm.status
    arm.request_stop()
    assert stands(arm) - status.time_s <= status.stop_time_s
    arm.sleep(3.0)
    assert task.done
    assert arm.status.trust is not Trust.REFERENCED
    assert arm.status.state is State.STANDBY


def at_zeros(**options):
    """Return an arm whose counts are zero, so that only the greeting shows a reset."""
    arm = found(**options)
    arm.declare_posture(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)
    assert not arm.twin.device.registers.largest
    arm.twin.link.sent.clear()
    return arm


def reset_instead(arm):
    """Press the board's own button just as the driver sends its reset."""

    def press(_):
        assert not arm.twin.device.registers.largest
        arm.twin.board.reset()
        return []

    arm.twin.link.to.append(Rule(rb"\x18", press))


@pytest.mark.parametrize("firmware", FIRMWARES)
@pytest.mark.parametrize("after_s", [0.003, 0.006])
def test_a_greeting_that_comes_late_is_no_answer_to_a_stop(firmware, after_s):
    arm = at_zeros(firmware=firmware)
    handle = arm.move_j(base_deg=40, wait=False)
    arm.sleep(after_s)
    reset_instead(arm)
    arm.stop()
    arm.sleep(3.0)
    assert handle.done
    assert arm.twin.link.pressed(b"\x18") == 1
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.state is State.ERROR_STOP
    assert "reset, or lost its power" in arm.status.error
    arm.reset()
    arm.enable()
    assert arm.status.state is State.STANDBY


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_nor_is_a_second_one(firmware):
    arm = at_zeros(firmware=firmware)
    arm.move_j(base_deg=40, wait=False)
    arm.sleep(0.003)
    arm.stop()
    assert arm.status.trust is Trust.REFERENCED
    arm.twin.board.reset()
    arm.sleep(2.0)
    assert arm.status.trust is Trust.SUSPECT


def test_nor_is_one_that_a_mute_board_says_as_it_is_reset():
    arm = at_zeros()
    arm.estop()
    arm.sleep(0.5)
    assert arm.status.trust is Trust.REFERENCED
    arm.sleep(0.1)
    arm.twin.board.reset()  # its start takes longer than the timeout of a report
    arm.reset()
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.state is State.STANDBY


def test_a_greeting_in_time_keeps_the_position():
    for after_s in (0.003, 0.05, 0.2, 0.6):
        arm = at_zeros()
        arm.move_j(base_deg=40, wait=False)
        arm.sleep(after_s)
        arm.stop()
        arm.sleep(2.0)
        assert arm.status.trust is Trust.REFERENCED
        assert standing_as_said(arm)
