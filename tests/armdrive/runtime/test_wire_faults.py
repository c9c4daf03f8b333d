"""A disturbed wire: whatever is lost, garbled, repeated or late, nothing false is trusted."""

import re
from dataclasses import replace

import pytest
from amounts import in_pairs
from faults import (
    FaultyLink,
    Rule,
    arm_config,
    as_it_stands,
    driven,
    echoed_after,
    garbled,
    honest,
    instead,
    late_by,
    lost,
    ready_arm,
    twice,
    without_byte,
)
from hypothesis import given
from hypothesis import strategies as st

from armdrive import Arm, Jog
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import (
    ArmError,
    DeviceFault,
    PositionMismatch,
)
from armdrive.registry import simulate
from armdrive.status import Evidence, State, Trust
from kinematics import KinematicsError

CHANGES = {
    "lost": lost,
    "twice": twice,
    "echoed later": echoed_after(0.12),
    "echoed much later": echoed_after(0.7),
    "late": late_by(0.2),
    "very late": late_by(3.0),
    "first byte gone": without_byte(0),
    "second byte gone": without_byte(1),
    "end gone": without_byte(-1),
    "first byte garbled": garbled(0),
    "middle garbled": garbled(7),
    "a digit changed": garbled(-2, ord("7")),
    "answered no": instead(b"0\r"),
}


def moved_and_looked(arm):
    """Return an arm that was moved and jogged as well as its wire let it, and then stood."""
    try:
        arm.move_j(base_deg=25)
        arm.jog_j(shoulder_deg=1)
    except DeviceFault:
        assert arm.status.state is State.ERROR_STOP
    arm.sleep(8.0)
    assert honest(arm)
    return arm


MESSAGES = [
    *(("back", start) for start in (b"1", b"-", b"")),
    *(("to", start) for start in (b"@STEP", b"@READ")),
]
"""Answers and commands: the direction, and how the message begins."""


@in_pairs("what, message, skip", list(CHANGES), MESSAGES, [0, 1, 2])
def test_a_disturbed_message_is_survived_or_found_out(what, message, skip):
    """`skip` messages of the kind pass before one is disturbed."""
    arm = ready_arm()
    direction, start = message
    getattr(arm.twin.link, direction).append(Rule(start, CHANGES[what], skip=skip))
    moved_and_looked(arm)
    if arm.status.state is State.ERROR_STOP:
        moved = arm.twin.world.motors
        arm.reset()
        assert arm.twin.world.motors == moved
    as_it_stands(arm)
    arm.move_j(base_deg=-5)
    assert arm.twin.world.joints.deg["base"] == pytest.approx(-5.0, abs=0.1)
    assert honest(arm)


def test_a_burst_of_other_steps_is_found_out_before_its_call_returns():
    """No check bytes guard the line, and the answer is that of a motion that went well."""
    arm = ready_arm()

    def farther(line):
        return [(0.0, re.sub(rb",(\d+),", lambda n: b",%d," % (int(n[1]) + 3), line, count=1))]

    arm.twin.link.to.append(Rule(b"@STEP", farther))
    with pytest.raises(PositionMismatch):
        arm.move_j(base_deg=1.0)
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.state is State.ERROR_STOP


def test_an_answer_that_comes_too_early_is_compared_with_the_registers_at_once():
    """It may be an echo: the next burst would be sent while the motors still turn."""
    arm = ready_arm()
    link = arm.twin.link

    def echo(data):
        if data.startswith(b"@STEP"):
            link.on_write = lambda _: None
            link.arriving.append((arm.parts.engine.now_s + 0.01, b"1\r"))

    link.on_write = echo
    arm.move_j(base_deg=25.0)
    lines = [line for _, line in link.sent]
    step = next(index for index, line in enumerate(lines) if line.startswith(b"@STEP"))
    assert lines[step + 1].startswith(b"@READ")
    assert arm.twin.world.joints.deg["base"] == pytest.approx(25.0, abs=0.1)


def test_a_motion_that_is_answered_by_no_leaves_a_suspect_position():
    arm = ready_arm()
    arm.move_j(base_deg=1.0)
    arm.twin.link.to.append(Rule(b"@STEP", instead(b"@STXP 1,2\r")))
    with pytest.raises(DeviceFault, match="refused a valid motion"):
        arm.move_j(base_deg=2.0)
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.trust_reason == Evidence.MOTION_REFUSED.value


@pytest.mark.parametrize("noise", [b"\x00\xff\x80", b"1\r", b"2\r", b"0\r", b"x" * 700 + b"\r"])
def test_noise_on_an_idle_line_moves_nothing_and_harms_nothing(noise):
    arm = ready_arm()
    before = arm.twin.world.motors
    arm.twin.link.arriving.append((arm.status.time_s + 0.3, noise))
    arm.sleep(3.0)
    assert arm.twin.world.motors == before
    arm.move_j(base_deg=5)
    assert honest(arm)


CALLS = st.sampled_from(
    [
        lambda arm: arm.move_j(base_deg=4),
        lambda arm: arm.move_j(base_deg=-4, wait=False),
        lambda arm: arm.jog_j(elbow_deg=1),
        lambda arm: arm.jog_l(z_mm=2),
        lambda arm: arm.jogging.hold(Jog.joint(base=1.0), speed=0.5, for_s=0.3),
        lambda arm: arm.jogging.nudge(Jog.joint(shoulder=-1.0), speed=0.5),
        lambda arm: arm.jogging.release(),
        lambda arm: arm.request_stop(),
        lambda arm: arm.stop(),
        lambda arm: arm.estop(),
        lambda arm: arm.reset(),
        lambda arm: arm.home(),
        lambda arm: arm.disable(),
        lambda arm: arm.enable(),
        lambda arm: arm.io.read(),
        lambda arm: arm.io.write(3),
        lambda arm: arm.gripper.open(15.0),
        lambda arm: arm.sleep(0.07),
        lambda arm: arm.sleep(1.3),
    ]
)


@given(st.lists(CALLS, max_size=9))
def test_nothing_is_sent_before_the_answer_to_what_went_before(calls):
    arm = ready_arm()
    for call in calls:
        try:
            call(arm)
        except (ArmError, KinematicsError):
            continue
    arm.close()
    assert arm.twin.link.overlaps == []
    assert arm.twin.board.lost_bytes == 0
    assert arm.twin.link.messages.count(b"@RESET\r") <= sum(1 for _ in calls)
    assert honest(arm)


def test_registers_that_are_not_zero_at_first_do_not_make_the_first_jog_a_leap():
    twin = simulate(simulated_config("teachmover"))
    twin.board.count_from((4000, -3000, 2500, 100, -900, 32000))
    before = twin.world.motors
    arm = Arm(
        connect_simulated(
            simulated_config("teachmover"), twin=replace(twin, link=FaultyLink(twin.link))
        )
    )
    arm.jog_j(base_deg=1.0)
    assert tuple(arm.twin.world.motors - before) == (20, 0, 0, 0, 0, 0)


@pytest.mark.parametrize("dialect", ["teachmover", "armdroid"])
def test_registers_may_wrap_without_a_step_being_lost(dialect):
    arm = driven(arm_config(dialect))
    arm.twin.board.count_from((32760, -32760, 32760, -32768, 32767, 5))
    arm.sleep(2.0)
    as_it_stands(arm)
    arm.move_j(base_deg=60, shoulder_deg=60)
    arm.move_j(base_deg=-60, shoulder_deg=30)
    assert arm.status.trust is Trust.REFERENCED
    assert honest(arm)
