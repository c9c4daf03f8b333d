"""Arcs, blends and ramps on simulated arms: where the tip really goes, and what is refused."""

import math
import re
from itertools import pairwise

import pytest
from faults import ready_arm, sim_config

from armdrive import (
    Arm,
    BadRequest,
    JointPart,
    LinePart,
    NoArc,
    OutOfBounds,
    Pose,
    PosePart,
)
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmFileError
from armdrive.motion.plan import SpeedLimits, fewer, legs_along, plan_joints, plan_route
from armdrive.registry.arm_files import parse_arm
from armdrive.runtime.position import ArmCoordinates
from kinematics import Joints, preset

STEP_MM = 0.6
LINE_MM = 0.5


def pose(x, y, z, pitch=-60, roll=0):
    return Pose.of(x_mm=x, y_mm=y, z_mm=z, pitch_deg=pitch, roll_deg=roll)


def place(where):
    return where.x_mm, where.y_mm, where.z_mm


def followed(arm, act):
    """Do something, and return the tips at the ends of its bursts, as the controller was told."""
    tips = [place(arm.pose)]
    move = arm.wire.move

    def noted(target, *rest, **more):
        tips.append(place(arm.config.model.arm.fk(arm.core.transmission.to_joints(target)[0])))
        return move(target, *rest, **more)

    arm.wire.move = noted
    try:
        act()
    finally:
        arm.wire.move = move
    return tips


def test_an_arc_stays_on_its_circle():
    with ready_arm() as arm:
        arm.move_to(pose(220, -50, 120))
        tips = followed(arm, lambda: arm.move_c(pose(270, 0, 120), pose(220, 50, 120)))
        assert len(tips) > 5
        for x, y, z in tips:
            assert math.hypot(x - 220, y) == pytest.approx(50.0, abs=STEP_MM + LINE_MM)
            assert z == pytest.approx(120.0, abs=STEP_MM + LINE_MM)
        assert math.dist(place(arm.twin.world.pose), (220, 50, 120)) < STEP_MM


def test_points_on_one_line_make_no_arc_and_nothing_moves():
    with ready_arm() as arm:
        arm.move_to(pose(220, -50, 120))
        before = arm.twin.world.pose
        with pytest.raises(NoArc):
            arm.move_c(pose(220, 0, 120), pose(220, 50, 120))
        assert arm.twin.world.pose == before


CORNER, BEYOND = (220.0, 60.0, 120.0), (280.0, 60.0, 120.0)


@pytest.mark.parametrize(
    ("blend_mm", "last", "least_mm", "most_mm", "note"),
    [
        (20.0, LinePart, 2.0, 20.0, ""),
        (0.0, PosePart, 0.0, STEP_MM, ""),
        (100.0, LinePart, 2.0, 60.0, r"the blend after part 1 is .* instead of 100.0"),
    ],
    ids=["passes the corner within its radius", "reaches the corner", "is shortened with a note"],
)
def test_a_path_at_its_corner(blend_mm, last, least_mm, most_mm, note):
    with ready_arm() as arm:
        arm.move_to(pose(220, -60, 120))
        parts, moved = [LinePart(pose(*CORNER), blend_mm=blend_mm), last(pose(*BEYOND))], []
        tips = followed(arm, lambda: moved.append(arm.move_path(parts)))
        assert least_mm <= min(math.dist(tip, CORNER) for tip in tips) < most_mm
        assert math.dist(tips[-1], BEYOND) < STEP_MM
        assert re.fullmatch(f"{note}.*", moved[0].note)
        assert bool(moved[0].note) is bool(note)


@pytest.mark.parametrize(
    ("parts", "options", "error", "words"),
    [
        ([LinePart(pose(*CORNER), blend_mm=10), PosePart(pose(220, 60, -40))], {}, OutOfBounds,
         "nothing was moved"),
        ([JointPart(Joints.of(base, 60, -80, -40, 0)) for base in (100.0, 10.0)], {}, OutOfBounds,
         "base would turn to 100"),
        ([LinePart(pose(*CORNER))], {"frame": "tool"}, BadRequest, "tool"),
        ([LinePart(pose(*CORNER))], {"frame": "nowhere"}, BadRequest, "nowhere"),
        ([], {}, BadRequest, "at least one part"),
    ],
    ids=["its end", "a corner", "the tool moves", "no such frame", "no part"],
)  # fmt: skip
def test_a_path_is_audited_whole_before_its_first_byte(parts, options, error, words):
    with ready_arm() as arm:
        sent = len(arm.twin.link.sent)
        with pytest.raises(error, match=words):
            arm.move_path(parts, **options)
        assert len(arm.twin.link.sent) == sent


def test_a_joint_move_is_part_of_a_path_as_well():
    with ready_arm() as arm:
        there = Joints.of(10, 60, -80, -40, 0)
        arm.move_path([JointPart(there), LinePart(pose(240, 40, 140))])
        assert math.dist(place(arm.twin.world.pose), (240, 40, 140)) < STEP_MM


# -- ramps ------------------------------------------------------------------------------------


def speeds(**more):
    model = preset("teachmover")
    return SpeedLimits(model.joint_speeds_rad_s, 20.0, 470.0, model.transmission, **more)


START = ArmCoordinates(Joints.of(0, 70, -95, -35, 0), 20.0)
END = ArmCoordinates(Joints.of(60, 60, -80, -35, 90), 20.0)


def rates_rad_s(legs):
    return [abs(leg.end.joints[0] - leg.start.joints[0]) / leg.duration_s for leg in legs]


def test_without_ramps_a_joint_motion_is_one_leg_of_the_least_time():
    (leg,) = legs_along(speeds(), [START, END], 0.5, 0.1)
    assert leg.duration_s == pytest.approx(speeds().duration_s(START, END, 0.5))
    assert (leg.start, leg.end) == (START, END)


def test_with_ramps_the_speed_grows_and_falls_within_its_limits():
    ramped = speeds(ramp_s=0.4, jerk_s=0.1)
    legs = legs_along(ramped, [START, END], 1.0, 0.05)
    rates = rates_rad_s(legs)
    top = max(rates)
    assert rates[0] < 0.3 * top
    assert rates[-1] < 0.3 * top
    slope = ramped.joints_rad_s[0] / 0.4
    for (one, other), leg, after in zip(pairwise(rates), legs, legs[1:], strict=False):
        middle_s = (leg.duration_s + after.duration_s) / 2
        assert abs(other - one) <= slope * middle_s * 1.01
    assert legs[0].start == START
    assert legs[-1].end == END
    assert all(a.end == b.start for a, b in pairwise(legs))


def test_an_acceleration_of_the_arm_file_is_that_joints_own():
    table = {"model": "teachmover", "accelerations_deg_s2": {"base": 40.0}}
    config = parse_arm(table, name="x")
    own = speeds(accelerations_rad_s2=config.accelerations_rad_s2)
    assert own.limits.accelerations[0] == pytest.approx(math.radians(40.0))
    assert math.isinf(own.limits.accelerations[1])
    with pytest.raises(ArmFileError, match=r"accelerations_deg_s2\.base"):
        parse_arm({"model": "teachmover", "accelerations_deg_s2": {"base": 0}}, name="x")


def test_boards_that_queue_are_driven_with_ramps_and_others_are_not():
    for dialect, ramps in (("grbl", True), ("teachmover", False)):
        with Arm.connect(f"sim:{dialect}") as arm:
            assert (arm.config.motion.ramp_s > 0.0) is ramps
            legs = plan_joints(arm.config, arm.speeds, START, END, 1.0).legs
            assert (len(legs) > 1) is ramps


def test_what_one_burst_can_drive_within_the_tolerance_is_one_burst():
    arm = preset("teachmover").arm
    config = sim_config()
    made = plan_route(config, speeds(), START, [LinePart(pose(260, 60, 140))], 1.0)
    cut = legs_along(speeds(), [each.start for each in made.legs] + [made.end], 1.0, 0.5)
    assert fewer(arm, cut, 1e9, 1e9) == (
        type(cut[0])(made.start, made.end, pytest.approx(sum(leg.duration_s for leg in cut))),
    )
    assert fewer(arm, cut, 1e-9, 1e9) == cut
    assert fewer(arm, cut, 1e9, 0.0) == cut
    assert fewer(arm, (), 1.0, 1.0) == ()
    assert simulated_config("grbl").motion.jerk_s > 0.0
