"""Planned motion on the simulated arm: straightness, drift, limits, guards, impossible goals."""

import math
import random

import pytest
from amounts import amount
from faults import OVER_THE_TABLE, ready_arm, sim_config
from hypothesis import given, settings
from hypothesis import strategies as st

from armdrive.errors import OutOfBounds, Refused
from armdrive.status import Trust
from kinematics import Joints, KinematicsError, PathBroken, Pose, Unreachable
from kinematics.errors import BadNumber


def off_line_mm(point, start, end):
    along = [b - a for a, b in zip(start, end, strict=True)]
    share = sum(d * (p - a) for d, p, a in zip(along, point, start, strict=True))
    share = min(max(share / sum(d * d for d in along), 0.0), 1.0)
    return math.dist(point, [a + share * d for a, d in zip(start, along, strict=True)])


def step_travel_mm(arm):
    """How far the tip can be off because every motor stands up to a step from its exact place."""
    world = arm.twin.world
    geometry = world.body.arm
    turned_mm = (  # steps a turn, and the length that turns
        (7072, math.hypot(world.pose.x_mm, world.pose.y_mm)),
        (7072, geometry.upper_arm_mm),
        (4158, geometry.forearm_mm),
        (1536, geometry.hand_mm),
    )
    return sum(math.tau / steps * length_mm for steps, length_mm in turned_mm)


@pytest.mark.parametrize(
    "way_mm", [(0, 150, 0), (-90, 90, 40), (40, -160, 60), (-60, 0, 90), (0, 0, -60)]
)
@pytest.mark.parametrize("speed_error", [0.0, 0.7])
def test_the_physical_tip_stays_on_the_straight_line(way_mm, speed_error):
    arm = ready_arm(sim_config(planned_burst_s=0.4), speed_error=speed_error)
    goal = Pose.of(x_mm=280, y_mm=0, z_mm=120, pitch_deg=-80)
    arm.move_to(goal)
    start = arm.twin.world.tip
    end = (goal.x_mm + way_mm[0], goal.y_mm + way_mm[1], goal.z_mm + way_mm[2])
    handle = arm.move_l(Pose.of(x_mm=end[0], y_mm=end[1], z_mm=end[2], pitch_deg=-80), wait=False)
    bound_mm = arm.config.motion.line_tolerance_mm + step_travel_mm(arm)
    seen = 0
    while not handle.done:
        arm.sleep(0.05)
        seen += 1
        assert off_line_mm(arm.twin.world.tip, start, end) <= bound_mm
    assert seen > 10
    assert math.dist(arm.twin.world.tip, end) <= step_travel_mm(arm) / 2


@pytest.mark.parametrize("seed", range(amount(1, 5)))
def test_ten_thousand_random_moves_end_on_the_step_counts_they_began_with(seed):
    """Every way out is whole steps of absolute targets, and so is every way back.

    Three hundred moves every day; the ten thousand with THOROUGH=1 in the environment.
    """
    arm = ready_arm(sim_config(planned_burst_s=10.0, idle_poll_s=0.0))
    home, began = arm.joints, arm.twin.world.motors
    registers = arm.twin.device.registers
    draw = random.Random(seed)
    angles = dict(arm.core.position.coordinates.joints.deg)
    for _ in range(amount(150, 1_000)):
        name = draw.choice(list(angles))
        arm.move_j(**{f"{name}_deg": angles[name] + draw.uniform(-0.6, 0.6)})
        arm.move_j(**{f"{name}_deg": angles[name]})
        assert arm.status.acknowledged == began
    assert arm.twin.world.motors == began
    assert arm.twin.device.registers == registers
    assert arm.joints == home
    assert arm.status.trust is Trust.REFERENCED


ANGLES = st.tuples(
    st.floats(-80, 80), st.floats(20, 90), st.floats(-95, -20), st.floats(-50, 40), st.floats(-9, 9)
)


@settings(max_examples=15)
@given(st.lists(ANGLES, min_size=1, max_size=3))
def test_long_ways_over_many_goals_come_back_to_the_same_steps(goals):
    arm = ready_arm(sim_config(planned_burst_s=2.0))
    began = arm.twin.world.motors
    for angles in goals:
        named = zip(OVER_THE_TABLE.names, angles, strict=True)
        try:
            arm.move_j(**{f"{name}_deg": angle for name, angle in named})
        except OutOfBounds:
            continue
        status = arm.status
        assert arm.twin.world.motors == status.acknowledged == status.commanded == status.read_back
    back = {f"{name}_deg": angle for name, angle in OVER_THE_TABLE.deg.items()}
    try:
        arm.move_j(**back)
    except OutOfBounds:
        return
    assert arm.twin.world.motors == began


def test_a_motion_reports_where_the_motors_stand_and_not_where_they_were_sent():
    arm = ready_arm()
    goal = Pose.of(x_mm=250.3, y_mm=40.7, z_mm=120.1, pitch_deg=-81.3)
    moved = arm.move_to(goal)
    pose, tip = moved.pose, arm.twin.world.tip
    assert math.dist((pose.x_mm, pose.y_mm, pose.z_mm), tip) < 1e-6
    off_mm = math.dist((goal.x_mm, goal.y_mm, goal.z_mm), tip)
    assert moved.rounding_mm == pytest.approx(off_mm, abs=1e-6)
    assert off_mm > 0.001
    assert moved.joints == arm.twin.world.joints


def test_joints_that_are_not_named_keep_their_angle_to_the_last_digit():
    arm = ready_arm()
    before = arm.core.position.coordinates.joints
    arm.move_j(elbow_deg=-60.123)
    arm.jog_j(base_deg=3.3)
    after = arm.core.position.coordinates.joints
    for name in ("shoulder", "wrist_pitch", "wrist_roll"):
        assert after[name] == before[name]
    assert arm.core.transmission.to_motors(after, arm.core.position.coordinates.opening_mm) == (
        arm.status.acknowledged
    )


@pytest.mark.parametrize(
    ("call", "name", "words"),
    [
        (lambda arm: arm.move_j(base_deg=91), "base", "91.0°, 1.0° beyond its limit of 90.0°"),
        (lambda arm: arm.move_j(elbow_deg=2), "elbow", "limit of 0.0°"),
        (lambda arm: arm.move_j(shoulder_deg=-30, elbow_deg=-60), "table", "below the table"),
        (lambda arm: arm.gripper.open(80.0), "gripper", "0 to 76 mm"),
        (lambda arm: arm.gripper.close(-1.0), "gripper", "0 to 76 mm"),
    ],
)
def test_limits_and_guards_refuse_before_the_first_byte_and_name_the_bound(call, name, words):
    arm = ready_arm()
    sent, motors = len(arm.twin.link.sent), arm.twin.world.motors
    with pytest.raises(OutOfBounds, match=words) as refusal:
        call(arm)
    assert refusal.value.name == name
    assert math.isfinite(refusal.value.value)
    assert math.isfinite(refusal.value.bound)
    assert len(arm.twin.link.sent) == sent
    assert arm.twin.world.motors == motors


GOALS = {
    "too far": Pose.of(x_mm=600, y_mm=0, z_mm=100, pitch_deg=-45),
    "too near": Pose.of(x_mm=100, y_mm=0, z_mm=194, pitch_deg=0),
    "behind": Pose.of(x_mm=-250, y_mm=10, z_mm=100, pitch_deg=-90),
    "below the table": Pose.of(x_mm=250, y_mm=0, z_mm=-20, pitch_deg=-90),
    "on the base axis": Pose.of(x_mm=0, y_mm=0, z_mm=200, pitch_deg=-90),
    "into the base": Pose.of(x_mm=50, y_mm=0, z_mm=100, pitch_deg=-60),
    "over its head": Pose.of(x_mm=50, y_mm=0, z_mm=900, pitch_deg=0),
}


@pytest.mark.parametrize("goal", GOALS.values(), ids=GOALS)
def test_a_goal_that_cannot_be_met_names_a_nearest_pose_that_can(goal):
    arm = ready_arm()
    sent = len(arm.twin.link.sent)
    with pytest.raises((Unreachable, OutOfBounds)) as refusal:
        arm.move_to(goal)
    assert len(arm.twin.link.sent) == sent
    nearest = refusal.value.nearest
    assert nearest is not None
    assert str(nearest) in str(refusal.value)
    try:
        arm.move_to(nearest)
    except OutOfBounds:  # a guard is in the way: from above, then
        arm.move_j(shoulder_deg=80, elbow_deg=-130)
        arm.move_to(nearest)
    reached = arm.twin.world.pose
    assert math.dist(
        (reached.x_mm, reached.y_mm, reached.z_mm), (nearest.x_mm, nearest.y_mm, nearest.z_mm)
    ) <= step_travel_mm(arm)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, "far", None, True])
def test_a_pose_takes_numbers_alone(bad):
    with pytest.raises(BadNumber, match="x_mm"):
        Pose(bad, 0.0, 100.0, 0.0)


def test_a_line_out_of_the_reach_breaks_before_it_begins():
    arm = ready_arm()
    sent = len(arm.twin.link.sent)
    with pytest.raises((PathBroken, Refused, KinematicsError)):
        arm.move_l(Pose.of(x_mm=-300, y_mm=5, z_mm=150, pitch_deg=-60))
    assert len(arm.twin.link.sent) == sent


def test_an_arm_that_stands_beyond_a_guard_may_leave_it_but_not_go_deeper():
    low = Joints.of(0.0, -20.0, -30.0, -20.0, 0.0)
    arm = ready_arm()
    arm.declare_posture(low)
    assert arm.pose.z_mm < -1.0
    with pytest.raises(OutOfBounds, match="table"):
        arm.move_j(shoulder_deg=-25)
    arm.move_j(shoulder_deg=40)
    assert arm.pose.z_mm > 0.0


def test_an_arm_that_stands_beyond_a_limit_may_come_back_but_go_no_further():
    arm = ready_arm()
    arm.declare_posture(OVER_THE_TABLE.replace(base=math.radians(89.0)))
    arm.move_motors(79, 0, 0, 0, 0, 0)  # knows no limits
    assert arm.joints.deg["base"] == pytest.approx(93.0, abs=0.1)
    for further_deg in (93.5, 170.0):
        with pytest.raises(OutOfBounds, match="nothing was moved"):
            arm.move_j(base_deg=further_deg)
    arm.move_j(base_deg=92.0)
    arm.move_j(base_deg=80.0)
    assert arm.joints.deg["base"] == pytest.approx(80.0, abs=0.1)


@pytest.mark.parametrize("speed", [1.0, 0.3, 0.04])
def test_a_motion_is_never_faster_than_asked(speed):
    arm = ready_arm()
    began_s = arm.status.time_s
    arm.move_j(base_deg=20, speed=speed)
    took_s = arm.status.time_s - began_s
    assert took_s >= math.radians(20) / (0.37 * speed)
    assert took_s <= math.radians(20) / (0.37 * speed) * 2.2 + 1.0
