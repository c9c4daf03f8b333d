"""Paths of a driven arm: parts, frames, guards, and how far it strays."""

import math
import re
from dataclasses import replace
from itertools import pairwise

import pytest
from amounts import amount
from faults import OVER_THE_TABLE, arm_config, driven, ready_arm, sim_config

from armdrive import (
    Arm,
    BadRequest,
    Jog,
    JointPart,
    LineMove,
    LinePart,
    OutOfBounds,
    Pose,
    PoseMove,
    PosePart,
)
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmFileError
from armdrive.motion.deviation import SMALL_STEPS, has_room
from armdrive.motion.frames import axes_of
from armdrive.motion.jog.bounds import Bounds
from armdrive.motion.plan import SpeedLimits, fewer, legs_along, plan_joints, plan_route
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import parse_arm
from armdrive.runtime.position import ArmCoordinates, joints_between
from kinematics import Joints, Motors, preset
from kinematics.frames.user_frame import UserFrame
from kinematics.guards import AngleSum
from kinematics.guards.shapes import Box

STEP_MM = 0.6
LINE_MM = 0.5


def pose(x, y, z, pitch=-60, roll=0):
    return Pose.of(x_mm=x, y_mm=y, z_mm=z, pitch_deg=pitch, roll_deg=roll)


def place(where):
    return where.x_mm, where.y_mm, where.z_mm


def followed(arm, act):
    """Do something, and return the tips at the ends of its bursts, as the controller was told."""
    tips = [place(arm.pose)]
    move = arm.parts.context.move

    def noted(target, *rest, **more):
        tips.append(
            place(arm.config.model.arm.fk(arm.parts.core.transmission.to_joints(target)[0]))
        )
        return move(target, *rest, **more)

    arm.parts.context.move = noted
    try:
        act()
    finally:
        arm.parts.context.move = move
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
    ],
    ids=["its end", "a corner", "the tool moves", "no such frame"],
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
    for name, ramps in (("grbl", True), ("teachmover", False)):
        with Arm.connect(f"sim:{name}") as arm:
            assert (arm.config.motion.ramp_s > 0.0) is ramps
            legs = plan_joints(arm.config, arm.parts.speeds, START, END, 1.0).legs
            assert (len(legs) > 1) is ramps


def test_legs_within_the_tolerance_are_joined_into_one_burst():
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


# -- Frames ----------------------------------------------------------------------------------------

BOARD = UserFrame.turned((180.0, 40.0, 30.0), math.radians(30.0))


def framed():
    return replace(simulated_config("teachmover"), frames={"board": BOARD})


def test_a_goal_of_the_board_is_reached_on_the_board():
    with ready_arm(framed()) as arm:
        goal = Pose.of(x_mm=50, y_mm=-20, z_mm=40, pitch_deg=-90)
        arm.move_to(goal, frame="board")
        assert math.dist(place(arm.twin.world.pose), place(BOARD.to_base(goal))) < STEP_MM
        assert math.dist(place(arm.pose_in("board")), place(goal)) < STEP_MM
        arm.move_l(replace(goal, y_mm=0.0), frame="board")
        wanted = BOARD.to_base(replace(goal, y_mm=0.0))
        assert math.dist(place(arm.twin.world.pose), place(wanted)) < STEP_MM


def test_a_goal_of_the_tool_goes_on_as_the_hand_points():
    with ready_arm(framed()) as arm:
        arm.move_to(Pose.of(x_mm=250, y_mm=30, z_mm=120, pitch_deg=-45))
        before, joints = arm.pose, arm.joints
        _, _, along = axes_of(arm.config, joints, "tool")
        arm.move_l(Pose(0.0, 0.0, 25.0, 0.0), frame="tool")
        wanted = [a + 25.0 * b for a, b in zip(place(before), along, strict=True)]
        assert math.dist(place(arm.pose), wanted) < STEP_MM
        assert arm.pose.pitch_deg == pytest.approx(-45.0, abs=0.3)


FAR = Pose.of(x_mm=900, y_mm=0, z_mm=0, pitch_deg=-90)
LOW = Pose.of(x_mm=70, y_mm=0, z_mm=-50, pitch_deg=-90)


@pytest.mark.parametrize(
    ("goal", "frame", "said"),
    [
        (FAR, "base", ""),
        (FAR, "board", " (in the base frame)"),
        (Pose(0.0, 0.0, 900.0, 0.0), "tool", " (in the base frame)"),
        (LOW, "board", " (in the base frame)"),
    ],
)
def test_a_refusal_says_if_its_poses_are_in_another_frame_than_the_goal(goal, frame, said):
    with ready_arm(framed()) as arm:
        for move in (PoseMove(goal, frame=frame), LineMove(goal, frame=frame)):
            refusal = arm.preview(move).problem
            assert str(refusal).endswith(f"{refusal.nearest}{said}")


def test_a_refusal_without_poses_names_no_frame():
    with ready_arm(framed()) as arm:
        arm.move_to(Pose.of(x_mm=127, y_mm=0, z_mm=0.2, pitch_deg=-90))
        refusal = arm.preview(PoseMove(LOW.replace(z_mm=-25), frame="board")).problem
        assert isinstance(refusal, OutOfBounds)
        assert str(refusal).endswith("nothing was moved")


TABLE = {
    "model": "teachmover",
    "tool": {"along_mm": 40.0, "up_mm": 10.0},
    "frames": {"board": {"x_mm": 180.0, "yaw_deg": 30.0}},
}


def test_a_tool_of_the_arm_file_is_what_poses_are_of():
    held = parse_arm(TABLE, name="held")
    bare = parse_arm({"model": "teachmover"}, name="bare")
    joints = bare.model.arm.ik(Pose.of(x_mm=250, y_mm=0, z_mm=150, pitch_deg=0))
    assert place(held.model.arm.fk(joints)) == pytest.approx((290.0, 0.0, 160.0))
    assert held.calibration == bare.calibration  # a remembered position is of the joints


def test_a_tool_is_driven_to_where_its_point_is_wanted():
    config = replace(parse_arm(TABLE, name="held"), connection=framed().connection)
    with ready_arm(config) as arm:
        goal = Pose.of(x_mm=260, y_mm=60, z_mm=120, pitch_deg=-60, roll_deg=20)
        arm.move_l(goal)
        assert math.dist(place(arm.twin.world.pose), place(goal)) < STEP_MM


def test_links_that_guards_look_at_are_one_more_with_a_tool():
    guards = {"radii_mm": [35.0, 30.0, 25.0], "base_radius_mm": 60.0, "base_top_mm": 150.0}
    table = TABLE | {"guards": guards}
    bare = {key: value for key, value in table.items() if key != "tool"}
    assert len(parse_arm(bare, name="x").model.guards.radii_mm) == 3
    held = parse_arm(table | {"tool": {"along_mm": 40.0, "radius_mm": 8.0}}, name="x")
    assert held.model.guards.radii_mm == (35.0, 30.0, 25.0, 8.0)


# -- Guards ----------------------------------------------------------------------------------------

RADII = (35.0, 30.0, 25.0)
STANDS_OFF_MM = 70.0
"""How near a tip comes to the wall whose forearm ends 30 mm thick at an upright hand's wrist."""

WALL = Box("wall", (0.0, 100.0, -10.0), (500.0, 104.0, 600.0))
FOREARM = AngleSum("forearm elevation", (("shoulder", 1.0), ("elbow", 1.0)), -1.8, 0.5)
LOOK_S = 0.05
LAST_MM = 5.0
"""The guard's tolerance, and the last steps before it, which are made at once."""


def guarded(config, **guards):
    model = config.model
    return replace(config, model=replace(model, guards=replace(model.guards, **guards)))


def walled(config):
    return guarded(config, radii_mm=RADII, boxes=(WALL,))


def over(y_mm, z_mm=120.0):
    return Pose.of(x_mm=250, y_mm=y_mm, z_mm=z_mm, pitch_deg=-90)


def test_a_path_through_a_box_to_a_goal_beyond_it_is_refused_before_the_first_byte():
    pillar = Box("pillar", (240.0, 95.0, -10.0), (260.0, 105.0, 600.0))
    arm = ready_arm(guarded(sim_config(), radii_mm=RADII, boxes=(pillar,)))
    arm.move_to(over(0))
    behind = over(250)
    assert not arm.config.model.guards.violations(
        arm.config.model.arm, arm.config.model.arm.ik(behind)
    )
    sent = len(arm.twin.link.sent)
    for call in (arm.move_to, arm.move_l):
        with pytest.raises(OutOfBounds, match="inside the box 'pillar'") as caught:
            call(behind)
        assert caught.value.name == "box pillar"
        assert caught.value.value < 0.0 == caught.value.bound
    assert len(arm.twin.link.sent) == sent


def test_a_goal_in_a_box_is_refused_with_the_nearest_pose_that_can_be_taken():
    arm = ready_arm(walled(sim_config()))
    arm.move_to(over(0))
    with pytest.raises(OutOfBounds, match="nearest pose that is allowed") as caught:
        arm.move_to(over(90))
    nearest = caught.value.nearest
    assert nearest.y_mm == pytest.approx(STANDS_OFF_MM, abs=1.0)
    arm.move_to(nearest)


def test_a_forearm_beyond_its_elevation_is_refused_in_degrees():
    arm = ready_arm(guarded(sim_config(), sums=(FOREARM,)))
    with pytest.raises(OutOfBounds, match="forearm elevation would be -10") as caught:
        arm.move_j(shoulder_deg=25, elbow_deg=-132, wrist_pitch_deg=60)
    assert caught.value.name == "range of the forearm elevation"
    assert -110.0 <= caught.value.value < -103.13
    assert caught.value.bound == pytest.approx(-103.13, abs=0.01)


@pytest.mark.parametrize(
    "flawed_jog",
    [
        lambda arm: arm.jog_l(y_mm=60),
        lambda arm: arm.jog_l(y=1.0, speed=1.0, duration_s=3.0),
    ],
)
def test_a_jog_is_audited_although_it_keeps_to_its_bounds_by_itself(flawed_jog, monkeypatch):
    """Nothing goes unaudited: also not what a course proposes that sees no guard."""
    monkeypatch.setattr(Bounds, "holds", lambda *_: True)
    arm = ready_arm(walled(sim_config()))
    arm.move_to(over(40))
    assert "box 'wall'" in flawed_jog(arm).note
    assert arm.twin.world.pose.y_mm <= STANDS_OFF_MM + 1.0


@pytest.mark.parametrize("speed", amount([1.0], [1.0, 0.2]))
def test_an_arm_that_runs_on_while_it_stops_is_slowed_before_a_guard(speed):
    arm = driven(walled(arm_config("robko01")))
    arm.move_to(over(30))
    runs_on_s = arm.parts.core.controller.stopping(arm.config.motion.jog_burst_s).asked_motion_s
    assert runs_on_s > 0.0
    ways = []
    before_mm, before_s = arm.twin.world.pose.y_mm, arm.status.time_s
    for _ in range(40):
        arm.jogging.hold(Jog.cartesian(y=1.0), speed=speed, for_s=1.0)
        arm.sleep(0.25)
        here_mm, now_s = arm.twin.world.pose.y_mm, arm.status.time_s
        ways.append((here_mm, (here_mm - before_mm) / (now_s - before_s)))
        before_mm, before_s = here_mm, now_s
    assert ways[-1][0] == pytest.approx(STANDS_OFF_MM, abs=3.0)
    for (here_mm, _), (_, after_mm_s) in pairwise(ways):
        assert here_mm + after_mm_s * runs_on_s <= STANDS_OFF_MM + 1.0 + 1.0


def test_an_arm_that_drives_on_from_leg_to_leg_could_stop_before_a_guard_at_any_moment():
    """The jog's own ramp is too short for that: it is slowed for as long as its device runs on."""
    arm = driven(walled(arm_config("grbl", jog_ramp_s=0.02)))
    arm.move_to(over(25))
    runs_on_s = arm.parts.core.controller.stopping(arm.config.motion.jog_burst_s).asked_motion_s
    before_mm = arm.twin.world.pose.y_mm
    fastest_mm_s = 0.0
    for _ in range(100):
        arm.jogging.hold(Jog.cartesian(y=1.0), speed=1.0, for_s=1.0)
        arm.sleep(LOOK_S)
        here_mm = arm.twin.world.pose.y_mm
        speed_mm_s = (here_mm - before_mm) / LOOK_S
        assert before_mm + speed_mm_s * runs_on_s <= STANDS_OFF_MM + LAST_MM
        fastest_mm_s, before_mm = max(fastest_mm_s, speed_mm_s), here_mm
    assert before_mm == pytest.approx(STANDS_OFF_MM, abs=3.0)
    assert fastest_mm_s * runs_on_s > 10.0


def test_an_arm_that_stands_in_a_box_may_leave_it_by_itself():
    arm = ready_arm(walled(sim_config()))
    inside = arm.config.model.arm.ik(over(90))
    arm.reference.declare(inside)
    with pytest.raises(OutOfBounds, match="box 'wall'"):
        arm.move_l(over(100))
    assert "box 'wall'" in arm.jog_l(y_mm=5).note
    arm.jog_l(y_mm=-5)
    arm.move_to(over(0))
    assert arm.pose.y_mm == pytest.approx(0.0, abs=0.5)


# -- Straying --------------------------------------------------------------------------------------

UNCOORDINATED = [name for name, row in DIALECTS.items() if not row.abilities.coordinated]
FEW_STEPS_MM = 6.0
"""What bursts of a few steps may stray, which are sent in any case."""


def standing(name, joints=OVER_THE_TABLE, **motion):
    return driven(arm_config(name, **motion), at=joints)


def postures_of(arm):
    """Return a list that collects every posture that the physical arm is driven to."""
    seen, drive = [], arm.twin.world.drive
    arm.twin.world.drive = lambda *args: (drive(*args), seen.append(arm.twin.world.joints))[0]
    return seen


@pytest.mark.parametrize("name", ["robko01"])
@pytest.mark.parametrize("limit_mm", [2.0, 20.0])
def test_the_tip_stays_within_the_announced_distance_of_the_line(name, limit_mm):
    arm = standing(name, deviation_mm=limit_mm)
    seen = postures_of(arm)
    goal = Joints.of(10.0, 48.0, -90.0, -30.0, 12.0)
    moved = arm.move_j(**{f"{joint}_deg": turn for joint, turn in goal.deg.items()})
    assert len(seen) > 10
    points = arm.model.arm.points
    way = [points(joints_between(OVER_THE_TABLE, goal, share / 75))[-1] for share in range(76)]
    left_mm = max(min(math.dist(points(there)[-1], one) for one in way) for there in seen[::3])
    rounding_mm = 1.0
    assert left_mm <= moved.deviation_mm + rounding_mm
    assert moved.deviation_mm <= max(limit_mm, FEW_STEPS_MM)


@pytest.mark.parametrize("name", UNCOORDINATED)
def test_a_burst_is_shorter_where_a_guard_is_near(name):
    high, low = (standing(name, deviation_mm=100.0) for _ in range(2))
    low.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=1.0, pitch_deg=-60))
    target = Motors((90, -60, 80, 40, 70, 0))
    rate_hz = high.parts.speeds.motor_hz
    assert has_room(high.parts.core, high.parts.core.position.acknowledged + target, rate_hz)
    assert not has_room(low.parts.core, low.parts.core.position.acknowledged + target, rate_hz)
    few = Motors((SMALL_STEPS, -3, 2, 1, 1, 0))
    assert has_room(low.parts.core, low.parts.core.position.acknowledged + few, rate_hz)


@pytest.mark.parametrize("name", UNCOORDINATED)
def test_a_path_just_above_the_table_never_enters_it(name):
    low = Pose.of(x_mm=220, y_mm=-30, z_mm=2.0, pitch_deg=-70)
    arm = standing(name, simulated_config(name).model.arm.ik(low))
    arm.move_to(Pose.of(x_mm=240, y_mm=35, z_mm=2.0, pitch_deg=-60))
    assert arm.twin.world.incidents == []


def beyond_deg(arm, joints):
    """How far a posture is beyond the limits."""
    return max((math.degrees(each.excess) for each in arm.model.arm.violations(joints)), default=0)


A_STEP_DEG = 0.5
"""A step of each motor that a joint depends on, and rounding."""

BESIDE_A_LIMIT = [
    ("elbow", Joints.of(0.0, 60.0, 0.0, -40.0, 0.0), {"shoulder_deg": 54.0}),
    ("elbow", Joints.of(0.0, 60.0, -149.0, 60.0, 0.0), {"shoulder_deg": 66.0}),
    ("wrist_pitch", Joints.of(0.0, 60.0, -60.0, -90.0, 0.0), {"wrist_roll_deg": 12.0}),
    ("wrist_pitch", Joints.of(0.0, 60.0, -80.0, 90.0, 0.0), {"elbow_deg": -73.0, "base_deg": 4.0}),
    (
        "shoulder",
        Joints.of(0.0, 144.0, -100.0, 0.0, 0.0),
        {"elbow_deg": -92.0, "wrist_roll_deg": 8},
    ),
]


@pytest.mark.parametrize("name", ["armdroid"])
@pytest.mark.parametrize(("joint", "start", "goal"), BESIDE_A_LIMIT)
def test_no_joint_passes_a_limit_that_it_moves_along(name, joint, start, goal):
    arm = standing(name, start)
    limit = arm.model.arm.limits[start.names.index(joint)]
    here = start[joint]
    assert min(here - limit.low_rad, limit.high_rad - here) < 1e-9, "the row is about a limit"
    seen = postures_of(arm)
    there = arm.move_j(**goal)
    assert max(beyond_deg(arm, joints) for joints in seen) <= A_STEP_DEG
    assert there.rounding_mm < 1.0
    busiest = max(
        abs(b - a)
        for a, b in zip(
            *map(arm.parts.core.transmission.to_motors, (start, there.joints)), strict=True
        )
    )
    assert there.bursts <= 40 + busiest
    back = {f"{name}_deg": turn for name, turn in start.deg.items()}
    arm.move_j(**back)
    assert max(beyond_deg(arm, joints) for joints in seen) <= A_STEP_DEG


@pytest.mark.parametrize("name", UNCOORDINATED)
def test_a_limit_is_reached_and_jogged_along(name):
    arm = standing(name, Joints.of(0.0, 60.0, -60.0, -70.0, 0.0))
    seen = postures_of(arm)
    arm.move_j(wrist_pitch_deg=-90.0, wrist_roll_deg=30.0, shoulder_deg=70.0)
    assert arm.joints.deg["wrist_pitch"] == pytest.approx(-90.0, abs=A_STEP_DEG)
    arm.jog_j(wrist_roll=1.0, shoulder=-1.0, duration_s=0.5)
    arm.jog_j(wrist_roll_deg=-5.0, wrist_pitch_deg=-5.0)
    assert arm.joints.deg["wrist_pitch"] == pytest.approx(-90.0, abs=A_STEP_DEG)
    assert arm.joints.deg["wrist_roll"] != pytest.approx(30.0, abs=1.0)
    assert max(beyond_deg(arm, joints) for joints in seen) <= A_STEP_DEG
