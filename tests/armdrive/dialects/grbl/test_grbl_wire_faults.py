"""A GRBL board that is mute, or on a disturbed wire: no wrong position is trusted."""

import re

import pytest
from amounts import amount, each_value
from faults import Rule, becoming, honest, instead, late_by, lost, without_byte
from grbl_arm import (
    FIRMWARES,
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
from armdrive.errors import ArmError, DeviceFault
from armdrive.status import Evidence, State, Trust


@pytest.mark.parametrize("firmware", FIRMWARES[amount(2, 0) :])
def test_a_refused_motion_spoils_no_later_one(firmware):
    """grblHAL refuses all g-code after a refused line, also after the one that follows a jog."""
    arm = ready(firmware=firmware)
    arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=3.0)
    arm.sleep(0.5)
    arm.jogging.release()
    stands(arm)
    arm.move_j(base_deg=5)
    with pytest.raises(ArmError, match="error 3"):
        arm.controller.fix_settings(["$99=1"])
    arm.move_j(base_deg=10)
    assert arm.twin.world.motors == arm.status.acknowledged


def test_a_late_ok_of_a_jog_answers_no_later_line():
    arm = ready()
    arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=3.0)
    arm.sleep(0.5)
    arm.twin.link.back.append(Rule(rb"ok|error", late_by(0.3), times=1e9))
    sent = len(arm.twin.link.motions)
    while len(arm.twin.link.motions) == sent:
        arm.sleep(0.002)
    arm.jogging.release()
    while arm.status.state is not State.STANDBY:
        arm.sleep(0.005)
    with pytest.raises(ArmError, match="error 3"):
        arm.controller.fix_settings(["$99=1"])


def test_a_banner_that_is_garbled_does_not_lock_the_driver_out():
    arm = ready()
    arm.twin.link.back.append(Rule(b"Grbl", without_byte(2)))
    arm.move_j(base_deg=40, wait=False)
    arm.sleep(0.5)
    arm.stop()
    arm.move_j(base_deg=0)
    assert arm.twin.world.motors == arm.status.acknowledged


def test_an_arm_that_leaves_the_path_is_stopped_on_its_way():
    arm = ready()
    arm.twin.link.to.append(Rule(rb"G91G1", becoming(lambda line: line.replace(b"X+", b"X-")), 8))
    handle = arm.move_j(base_deg=80, wait=False)
    with pytest.raises(DeviceFault, match="off the path"):
        handle.wait(10.0)
    assert arm.twin.world.joints.deg["base"] < 30.0
    assert arm.twin.link.pressed(b"!")
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.trust_reason.startswith(Evidence.OFF_THE_PATH.value)
    assert arm.status.state is State.ERROR_STOP


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_a_jog_that_loses_its_axis_word_is_taken_by_the_board_and_noticed(firmware):
    """The boards answer `$J=G91F3000` with ok, and move nothing."""
    arm = ready(firmware=firmware)
    bare = becoming(lambda line: re.sub(rb"X[-+0-9]+", b"", line))
    arm.twin.link.to.append(Rule(rb"\$J=G91F[0-9.]+X", bare))
    with pytest.raises(DeviceFault, match=r"off the path|registers differ"):
        arm.jog_j(base_deg=2)
    assert arm.twin.world.motors == arm.status.read_back
    assert arm.status.trust is Trust.SUSPECT


@pytest.mark.parametrize(
    ("reported", "unheard"), [(True, rb"ALARM|Grbl"), (True, rb"(\r\n)?ALARM"), (False, rb"ALARM")]
)
def test_an_emergency_stop_whose_alarm_is_lost_is_no_kept_position(reported, unheard):
    arm = ready()
    arm.move_j(base_deg=40, wait=False)
    while not arm.twin.device.moving:
        arm.sleep(0.001)
    arm.sleep(0.28 if reported else 0.02)  # the first report of the motion comes between
    arm.twin.link.back.append(Rule(unheard, lost, times=2))
    arm.estop()
    arm.sleep(4.0)
    assert (arm.status.state, arm.status.trust) == (State.ERROR_STOP, Trust.SUSPECT)


def test_a_report_that_is_garbled_ends_no_motion_and_keeps_none_from_its_end():
    arm = ready()
    arm.twin.link.back += [
        Rule(b"<", becoming(lambda told: told.replace(b"Bf:3", b"Bf:7"))),
        Rule(b"<Run", becoming(lambda told: told.replace(b"MPos:", b"MPos:9")), skip=2),
    ]
    arm.move_j(base_deg=5)
    assert not any(rule.times for rule in arm.twin.link.back)
    arm.move_j(base_deg=10)
    assert honest(arm)


def test_a_report_of_idle_while_lines_are_planned_ends_no_motion():
    """A board says so after the `ok` of a line, until it begins to drive it."""
    arm = ready()
    arm.twin.link.back.append(
        Rule(b"<Run", becoming(lambda told: told.replace(b"Run", b"Idle")), skip=2)
    )
    arm.move_j(base_deg=20)
    assert not arm.twin.link.back[0].times
    assert standing_as_said(arm)


FLIPPED = [bytes([ord("?") ^ 1 << bit]) for bit in range(7)]
OTHERS = [b"(", b"G", b"$", b"%", b"0", b"~", b"\r"]


@each_value("firmware, to", FIRMWARES, [*FLIPPED, *OTHERS][:: amount(4, 1)])
def test_a_poll_that_was_changed_on_the_idle_wire_spoils_nothing(firmware, to):
    """The board takes it for a character of the next line."""
    arm = ready(config(gripper="servo"), firmware=firmware)
    for act in (
        lambda: arm.move_j(base_deg=3, shoulder_deg=41),
        lambda: arm.jog_j(base_deg=2),
        lambda: arm.io.write(1),
        lambda: arm.gripper.open(76.0),
    ):
        arm.sleep(1.0)
        arm.twin.link.to.append(Rule(rb"\?", instead(to)))
        arm.sleep(1.0)
        assert not any(rule.times for rule in arm.twin.link.to)
        act()
    assert standing_as_said(arm)
    assert "flood" in arm.twin.board.details()["outputs"]
    assert arm.twin.world.opening_mm == pytest.approx(76.0, abs=1.0)
    assert (arm.status.state, arm.status.trust) == (State.STANDBY, Trust.REFERENCED)


@pytest.mark.parametrize("disturbed", ["the line loses its end", "its ok is late"])
def test_a_disturbed_line_is_neither_carried_out_with_the_next_one_nor_answers_it(disturbed):
    arm = ready()
    if disturbed == "its ok is late":
        arm.twin.faults.add("delay", 1.1, "next", side="device")
    else:
        arm.twin.link.to.append(Rule(rb"M8", without_byte(-1)))
    with pytest.raises(DeviceFault):
        arm.io.write(1)
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
    arm.move_j(base_deg=5)
    assert standing_as_said(arm)
    if disturbed == "its ok is late":
        assert arm.status.trust is Trust.REFERENCED
    else:
        assert "flood" not in arm.twin.board.details()["outputs"]


# -- A board that falls silent on an intact wire: how soon the driver notices, and how -------------

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
        arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=3.0)
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


def test_the_arm_file_says_how_long_a_board_may_be_mute():
    arm = ready(config(device={"report_timeout_s": 2.5, "answer_s": 5.0}))
    begin_planned(arm)
    arm.sleep(0.5)
    arm.twin.faults.add("mute")
    assert 2.4 <= noticed_s(arm) <= 2.5 + LOOK_S


@pytest.mark.parametrize(
    ("begin", "call", "most_s"), [(begin_planned, "request_stop", 1.5), (begin_jog, "estop", 4.0)]
)
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


def test_a_suspended_program_calls_no_board_mute():
    for at_s in (0.30, 0.34):
        arm = ready()
        handle = arm.move_j(base_deg=40, wait=False)
        arm.sleep(at_s)
        arm.parts.pace.clock.now_s += 1.3
        handle.wait(20.0)
        assert standing_as_said(arm)
        assert arm.status.trust is Trust.REFERENCED
