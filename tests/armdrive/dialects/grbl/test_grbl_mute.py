"""A GRBL board that falls silent on an intact wire: how soon the driver notices, and how."""

import pytest
from grbl_arm import (
    begin_jog,
    begin_line,
    begin_planned,
    begin_tip_jog,
    config,
    ready,
    standing_as_said,
    stands,
)

from armdrive import Jog
from armdrive.errors import Stopped
from armdrive.status import State, Trust

LOOK_S = 0.01


def noticed_s(arm, most_s=10.0):
    """Return the time until the arm is in error-stop."""
    began_s = arm.status.time_s
    while arm.status.state is not State.ERROR_STOP:
        assert arm.status.time_s < began_s + most_s
        arm.sleep(LOOK_S)
    return arm.status.time_s - began_s


@pytest.mark.parametrize(
    ("after_s", "begin"),
    [(0.1, begin_planned), (0.6, begin_line), (0.6, begin_jog), (0.1, begin_tip_jog)],
)
def test_a_board_that_goes_mute_in_motion_is_lost_within_a_second(begin, after_s):
    arm = ready()
    begin(arm)
    arm.sleep(after_s)
    if begin in (begin_jog, begin_tip_jog):
        arm.hold(Jog.joint(base=1.0), speed=1.0, for_s=3.0)
        arm.sleep(0.1)
    assert arm.status.state is State.MOVING
    began_s, silent_s = arm.status.time_s, arm.status.silent_time_s
    arm.twin.faults.add("mute")
    assert noticed_s(arm) <= 1.0 + LOOK_S
    assert arm.status.trust is Trust.SUSPECT
    assert "while the arm was moving; a feed hold was sent" in arm.status.error
    lines_s = [sent_s for sent_s, piece in arm.twin.link.sent if piece.endswith(b"\n")]
    assert lines_s[-1] <= began_s + silent_s
    assert arm.twin.link.pressed(b"!")
    assert not arm.twin.link.pressed(b"\x18")
    assert arm.twin.world.energised
    arm.sleep(2.0)
    assert not arm.twin.device.moving
    arm.twin.faults.end("mute")
    before = arm.twin.world.motors
    arm.reset()
    arm.sleep(1.0)
    assert arm.twin.world.motors == before
    assert arm.status.state is State.STANDBY
    assert standing_as_said(arm)


def test_a_board_that_is_mute_for_less_goes_on():
    arm = ready()
    arm.twin.faults.add("mute", after_s=0.4, for_s=0.7)
    arm.move_j(base_deg=40)
    assert standing_as_said(arm)
    assert arm.status.trust is Trust.REFERENCED


def test_how_long_a_board_may_be_mute_can_be_set():
    arm = ready(config(device={"mute_s": 2.5, "answer_s": 5.0}))
    begin_planned(arm)
    arm.sleep(0.5)
    arm.twin.faults.add("mute")
    assert 2.4 <= noticed_s(arm) <= 2.5 + LOOK_S


@pytest.mark.parametrize("begin", [begin_planned, begin_jog])
@pytest.mark.parametrize(("call", "most_s"), [("request_stop", 1.5), ("estop", 4.0)])
def test_a_stop_of_a_mute_board_ends_as_well(begin, call, most_s):
    arm = ready()
    begin(arm)
    arm.sleep(0.4)
    arm.twin.faults.add("mute")
    arm.sleep(0.2)
    getattr(arm, call)()
    assert noticed_s(arm) <= most_s
    assert stands(arm) <= arm.status.time_s
    arm.sleep(3.0)
    assert arm.status.trust is Trust.SUSPECT


def test_a_program_that_stood_still_itself_calls_no_board_mute():
    for at_s in (0.30, 0.32, 0.34):
        arm = ready()
        handle = arm.move_j(base_deg=40, wait=False)
        arm.sleep(at_s)
        arm.pace.clock.now_s += 1.3
        try:
            handle.wait(20.0)
        except Stopped:
            pytest.fail("it was stopped")
        assert standing_as_said(arm)
        assert arm.status.trust is Trust.REFERENCED
