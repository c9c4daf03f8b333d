"""Arms of model files on the simulated controller: the physical arm reaches the requested goals."""

import math
from dataclasses import replace

import pytest
from chain_files import connected, five_joints, six_joints
from faults import sim_arm, sim_config

from armdrive.config.sections import MotionSettings
from armdrive.errors import BadRequest, OutOfBounds, Refused
from armdrive.sim.world.body import ArmBody
from armdrive.status import Trust, status_view
from kinematics import PRESETS, Joints, KinematicsError, Pose, Unreachable
from kinematics.chains.arm import ChainArm

READY = (0.0, -60.0, 120.0, 10.0, 40.0, 0.0)


@pytest.fixture
def six(tmp_path):
    config = six_joints(tmp_path)
    arm = connected(replace(config, motion=MotionSettings(planned_burst_s=2.0)))
    here = Joints.of(*READY, names=config.model.arm.joint_names)
    world = arm.twin.world
    world.drive_to(world.body.transmission.to_motors(here))
    arm.declare_posture(here)
    with arm:
        yield arm


def assert_physically_at(arm, pose, within_mm=1.0, within_deg=0.3):
    seen = arm.twin.world.pose
    assert math.dist(arm.twin.world.tip, (pose.x_mm, pose.y_mm, pose.z_mm)) < within_mm
    for angle in ("pitch_deg", "roll_deg", "yaw_deg"):
        wanted, got = getattr(pose, angle), getattr(seen, angle)
        if wanted is not None:
            assert abs(math.remainder(wanted - got, 360.0)) < within_deg, angle
    assert not arm.twin.world.incidents


def errands(arm):
    """Home, and go about in every way; yield the steps after each."""
    angles = {"base": 20, "shoulder": 40, "elbow": -80, "wrist_pitch": -40, "wrist_roll": 15}
    for go in (
        arm.home,
        lambda: arm.move_j({f"{name}_deg": angle for name, angle in angles.items()}),
        lambda: arm.move_to(Pose.of(x_mm=250, y_mm=-60, z_mm=140, pitch_deg=-80, roll_deg=10)),
        lambda: arm.move_l(Pose.of(x_mm=240, y_mm=60, z_mm=120, pitch_deg=-70, roll_deg=20)),
        lambda: arm.jog_j(shoulder_deg=2, wrist_pitch_deg=-3),
        lambda: arm.jog_l(x_mm=5, z_mm=-4, pitch_deg=2),
        lambda: arm.gripper.open(40),
        arm.park,
    ):
        go()
        yield arm.status.acknowledged


def test_a_link_table_of_the_teachmover_goes_the_same_steps_as_the_preset(tmp_path):
    config = five_joints(tmp_path)
    assert isinstance(config.model.arm, ChainArm)
    motion = sim_config().motion
    with (
        connected(replace(config, motion=motion)) as ours,
        sim_arm(sim_config()) as built_in,
    ):
        for got, wanted in zip(errands(ours), errands(built_in), strict=True):
            assert max(abs(a - b) for a, b in zip(got, wanted, strict=True)) <= 1
        assert ours.status.acknowledged == built_in.status.acknowledged
        assert ours.twin.world.motors == built_in.twin.world.motors
        assert math.dist(ours.twin.world.tip, built_in.twin.world.tip) < 1e-9


def test_the_link_table_of_the_teachmover_grasps(tmp_path):
    with connected(replace(five_joints(tmp_path), motion=sim_config().motion)) as arm:
        arm.home()
        arm.gripper.open(30)
        assert arm.gripper.grasp() == 0.0
        assert arm.gripper.force_n > 0.0


def test_six_joints_take_a_pose_with_yaw(six):
    assert six.status.trust is Trust.REFERENCED
    goal = Pose.of(x_mm=450, y_mm=250, z_mm=500, pitch_deg=-50, roll_deg=30, yaw_deg=60)
    six.move_to(goal)
    assert_physically_at(six, goal)
    assert status_view(six.status)["pose"]["yaw_deg"] == pytest.approx(60, abs=0.3)
    assert "yaw 60" in str(six.pose)


def test_six_joints_move_by_name(six):
    six.move_j(waist_deg=40, bend_deg=60)
    assert six.twin.world.joints.deg["waist"] == pytest.approx(40, abs=0.03)
    assert six.twin.world.joints.deg["bend"] == pytest.approx(60, abs=0.03)
    with pytest.raises(BadRequest, match="waist_deg"):
        six.move_j(base_deg=10)


def test_six_joints_follow_a_straight_line_and_turn_the_hand_on_the_way(six):
    start = six.pose
    goal = replace(
        start,
        x_mm=start.x_mm - 60,
        y_mm=start.y_mm + 120,
        z_mm=start.z_mm - 50,
        yaw_rad=start.yaw_rad + math.radians(25),
    )
    origin = six.twin.world.tip
    way = [b - a for a, b in zip(origin, (goal.x_mm, goal.y_mm, goal.z_mm), strict=True)]
    handle = six.move_l(goal, wait=False)
    looked = 0
    while not handle.done:
        six.sleep(0.1)
        off = [b - a for a, b in zip(origin, six.twin.world.tip, strict=True)]
        share = sum(a * b for a, b in zip(off, way, strict=True)) / sum(a * a for a in way)
        assert math.dist(off, [share * one for one in way]) < 1.5
        looked += 1
    assert looked > 5
    assert_physically_at(six, goal)


def test_six_joints_jog_along_and_about_the_axes(six):
    before = six.pose
    six.jog_l(z_mm=-6, yaw_deg=3, speed=1.0)
    assert_physically_at(
        six, replace(before, z_mm=before.z_mm - 6, yaw_rad=before.yaw_rad + math.radians(3))
    )
    six.jog_l(x=-1, duration_s=0.4, speed=0.5)
    assert six.pose.x_mm < before.x_mm - 2


def test_a_missing_or_extra_yaw_is_an_error(six, tmp_path):
    with pytest.raises(KinematicsError, match="need a yaw: yaw_deg in Python"):
        six.move_to(Pose.of(x_mm=450, y_mm=250, z_mm=500, pitch_deg=-50))
    five = five_joints(tmp_path).model.arm
    with pytest.raises(KinematicsError, match="five joints"):
        five.ik(Pose.of(x_mm=250, y_mm=0, z_mm=100, pitch_deg=-50, yaw_deg=0))


def test_a_pose_out_of_reach_of_six_joints_is_refused_with_the_nearest_one(six):
    far = Pose.of(x_mm=2000, y_mm=0, z_mm=700, pitch_deg=0, yaw_deg=0)
    with pytest.raises(Unreachable, match="all links together") as refusal:
        six.move_to(far)
    six.move_to(refusal.value.nearest)
    assert_physically_at(six, refusal.value.nearest)


def test_the_table_is_guarded_and_nothing_else(six):
    assert six.model.guards.table
    assert six.model.guards.inner_radius_mm is None
    steps = six.status.acknowledged
    with pytest.raises(OutOfBounds, match="below the table"):
        six.move_to(Pose.of(x_mm=600, y_mm=0, z_mm=-40, pitch_deg=-60, yaw_deg=0))
    assert six.status.acknowledged == steps


def test_an_arm_without_a_gripper_motor_says_so(six):
    assert six.status.gripper_mm is None
    for call in (
        six.gripper.open,
        six.gripper.close,
        six.gripper.grasp,
        lambda: six.gripper.move(10),
        lambda: six.gripper.opening_mm,
        lambda: six.jog_j(gripper_mm=3),
    ):
        with pytest.raises(Refused, match="no gripper motor"):
            call()


def test_a_joint_beyond_its_limit_is_refused_by_its_own_name(six):
    with pytest.raises(OutOfBounds, match="bend would turn to 120"):
        six.move_j(bend_deg=120)


def test_an_unpowered_arm_of_any_build_comes_down(six):
    world = six.twin.world
    before = world.pose
    world.cut_current()
    assert world.pose.z_mm < before.z_mm - 5
    assert world.joints["waist"] == pytest.approx(0.0, abs=1e-3)
    assert not world.grip_switch


def test_a_new_world_has_the_arm_clear_of_the_table(tmp_path):
    for make in (five_joints, six_joints):
        arm = connected(make(tmp_path))
        points = arm.twin.world.body.arm.points(arm.twin.world.joints)
        assert min(point[2] for point in points) >= 0.0
        arm.close()


@pytest.mark.parametrize("key", [key for key, one in PRESETS.items() if one.transmission])
def test_the_motors_that_stall_are_found_in_the_transmission(key):
    assert ArmBody.of_preset(PRESETS[key]).stalls == ((0,), (1,), (2,), (3, 4), (3, 4))
