"""Arms with backlash on every dialect: the physical arm is where the driver reports it."""

import math
from dataclasses import replace

import pytest
from backlash_bench import (
    DIALECTS,
    MIDDLE,
    PLAY,
    arm_with_play,
    move_at_random,
    off_mm,
    off_steps,
)

from armdrive import Jog, Pose
from armdrive.errors import ArmError, Stopped
from armdrive.sim.world.table import TableBlock
from armdrive.status import State, Trust
from armdrive.tasks import MoveAlong, MoveBy

every_dialect = pytest.mark.parametrize("dialect", DIALECTS)
every_kind = pytest.mark.parametrize("dialect", ["teachmover", "armdroid", "grbl"])
"""Bursts of coordinated motors, bursts of others, and a queue."""

AT_MIDDLE = {f"{name}_deg": deg for name, deg in MIDDLE.items()}


@every_dialect
def test_without_compensation_the_arm_is_off_by_its_play_and_with_it_by_nothing(dialect):
    plain = arm_with_play(dialect, backlash=0)
    assert max(move_at_random(plain, 4)) == PLAY
    plain.move_j(base_deg=4.0)
    plain.move_j(base_deg=1.0)
    assert off_mm(plain) > 2.0
    arm = arm_with_play(dialect)
    assert arm.status.notice == ""
    assert max(move_at_random(arm, 4)) == 0
    assert off_mm(arm) < 1e-9


def test_nothing_drifts_over_a_hundred_moves():
    arm = arm_with_play("teachmover", play=(12, 7, 30, 3, 0, 5), backlash=(12, 7, 30, 3, 0, 5))
    assert max(move_at_random(arm, 100, seed=2, deg=3.0)) == 0


def test_a_backlash_that_was_measured_a_little_wrong_is_off_by_no_more_than_that():
    arm = arm_with_play("teachmover", backlash=PLAY - 2)
    assert max(move_at_random(arm, 30)) <= 2 + 2  # beside the reference, which was no better


def beside_line_mm(arm):
    """Draw a line along y there and back; return the largest deviation of the tip."""
    pose = Pose.of(x_mm=300, y_mm=-35, z_mm=120, pitch_deg=-70)
    arm.move_to(pose)
    worst_mm = 0.0
    for goal in (replace(pose, y_mm=35.0), pose):
        handle = arm.move_l(goal, wait=False)
        while not handle.done:
            arm.sleep(0.01)
            x_mm, _, z_mm = arm.twin.world.tip
            worst_mm = max(worst_mm, math.hypot(x_mm - 300, z_mm - 120))
        moved = handle.wait()
        motion = arm.config.motion
        exact = arm.abilities.coordinated
        assert moved.straying_mm <= (motion.line_tolerance_mm if exact else motion.straying_mm)
        assert off_steps(arm) == 0
    return worst_mm


@every_kind
def test_a_line_is_kept_where_motors_turn_round_in_it(dialect):
    """The shoulder's and the elbow's in the middle of the line, the base's at its ends."""
    true_mm = beside_line_mm(arm_with_play(dialect, play=0, backlash=0))
    assert beside_line_mm(arm_with_play(dialect)) <= true_mm + 0.5


@every_kind
def test_jogging_by_small_increments_moves_the_arm_every_time(dialect):
    arm = arm_with_play(dialect)
    arm.move_j(**AT_MIDDLE)
    for sign in (1, -1, -1, 1, -1, 1):
        before = arm.twin.world.joints["base"]
        arm.jog_j(base_deg=0.3 * sign)
        assert (arm.twin.world.joints["base"] - before) * sign > 0.004
        assert off_steps(arm) == 0


@every_kind
def test_a_reversed_and_released_jog_ends_at_the_reported_position(dialect):
    arm = arm_with_play(dialect)
    arm.move_j(**AT_MIDDLE)
    for sign, for_s in ((1.0, 0.5), (-1.0, 0.12), (1.0, 0.31), (-1.0, 0.45)):
        arm.hold(Jog.joint(base=sign, elbow=-sign), speed=0.7, for_s=for_s)
        arm.sleep(for_s + 1.0)
        assert arm.status.state is State.STANDBY
        assert off_steps(arm) == 0
    assert arm.status.trust is Trust.REFERENCED


@every_kind
def test_releasing_a_jog_during_backlash_compensation_stops_within_the_same_time(dialect):
    arm = arm_with_play(dialect, play=190, backlash=190)
    arm.move_j(**AT_MIDDLE)
    arm.jog_j(base_deg=2)
    before = arm.twin.world.motors
    bound_s = arm.status.silent_time_s
    arm.hold(Jog.joint(base=-1.0), speed=1.0, for_s=0.3)
    arm.sleep(0.3 + bound_s)
    registers = arm.twin.device.registers
    arm.sleep(1.0)
    assert arm.twin.device.registers == registers
    assert arm.twin.world.motors == before == arm.status.acknowledged
    assert list(arm.core.position.slack.taken) == arm.twin.world.play.ahead
    assert 0 < arm.core.position.slack.taken[0] < 190


@every_kind
def test_a_pause_during_backlash_compensation_stops_and_resumes_there(dialect):
    arm = arm_with_play(dialect, play=90, backlash=90)
    arm.move_j(**AT_MIDDLE)
    for number, after_s in enumerate((0.03, 0.15, 0.3)):
        handle = arm.move_j(base_deg=-3.0 if number % 2 else 3.0, shoulder_deg=40, wait=False)
        arm.sleep(after_s)
        bound_s = arm.status.silent_time_s
        arm.pause()
        arm.sleep(bound_s + 0.02)
        registers = arm.twin.device.registers
        arm.sleep(1.0)
        assert arm.twin.device.registers == registers
        arm.resume()
        handle.wait()
        assert off_steps(arm) == 0


@pytest.mark.parametrize(
    ("dialect", "wide"),
    [("teachmover", PLAY), ("armdroid", PLAY), ("grbl", PLAY), *((each, 90) for each in DIALECTS)],
)
def test_a_stop_at_any_moment_of_backlash_compensation_keeps_the_position(dialect, wide):
    arm = arm_with_play(dialect, play=wide, backlash=wide)
    arm.move_j(**AT_MIDDLE)
    for number, after_s in enumerate((0.05, 0.09, 0.16, 0.31, 0.02, 0.6)):
        way = 8.0 if number % 2 else -8.0
        handle = arm.move_j(base_deg=way, shoulder_deg=42.0 - way, speed=0.6, wait=False)
        arm.sleep(after_s)
        arm.stop()
        with pytest.raises((Stopped, ArmError)):
            handle.wait()
        assert off_steps(arm) == 0
        assert list(arm.core.position.slack.taken) == arm.twin.world.play.ahead
    assert arm.status.trust is Trust.REFERENCED


@every_kind
def test_no_burst_is_longer_than_announced_whatever_the_backlash(dialect):
    arm = arm_with_play(dialect, play=150, backlash=150)
    arm.move_j(**AT_MIDDLE)
    controller, lengths = arm.core.controller, []
    begin = controller.begin

    def noted(pieces):
        for each in pieces:
            lengths.append(each.duration_s)
            yield each

    def spied(request, now_s):
        if isinstance(request, MoveBy):
            lengths.append(controller.duration_s(request.steps.largest, request.rate_hz))
        if isinstance(request, MoveAlong):
            request = replace(request, segments=noted(request.segments))
        begin(request, now_s)

    controller.begin = spied
    for way in (6.0, -6.0):
        arm.move_j(base_deg=way, elbow_deg=-75 + way)
        assert off_steps(arm) == 0
    assert lengths
    assert max(lengths) <= arm.config.motion.planned_burst_s + 1e-6


def test_fingers_that_a_motor_with_backlash_pulls_measure_what_they_hold():
    arm = arm_with_play("teachmover")
    pose = Pose.of(x_mm=250, y_mm=0, z_mm=20, pitch_deg=-90)
    arm.gripper.open()
    arm.move_to(replace(pose, z_mm=90))
    arm.twin.world.put(TableBlock("A", 250.0, 0.0, 0.0, 30.0, 40.0))
    arm.move_to(pose)
    for _ in range(3):
        assert arm.gripper.grasp() == pytest.approx(30.0, abs=0.3)
        arm.gripper.open()
    assert off_steps(arm) == 0
