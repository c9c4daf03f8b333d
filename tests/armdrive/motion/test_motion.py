"""Motions of a driven arm, of five joints and of other chains, and of its gripper."""

import math
import re
from dataclasses import replace
from functools import partial

import pytest
from amounts import every_row
from chain_files import connected, five_joints, six_joints
from faults import OVER_THE_TABLE, arm_config, driven, ready_arm, sim_arm, sim_config

from armdrive.config.sections import MotionSettings
from armdrive.errors import BadRequest, DeviceFault, OutOfBounds, Refused, Stopped
from armdrive.moves import GraspMove
from armdrive.registry import dialect
from armdrive.runtime.position import DeviceReadings, FingerState
from armdrive.sim.world.table import TableBlock
from armdrive.status import Current, State, Trust, status_view
from armdrive.tasks import ReadPosition, Registers
from kinematics import Joints, KinematicsError, Motors, Pose, Unreachable
from kinematics.chains.arm import ChainArm


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


def test_readings_midway_through_a_motion_say_so(monkeypatch):
    arm, asked = ready_arm(), []
    kind = type(arm.parts.core.controller)
    begin = kind.begin

    def noted(controller, request, now_s):
        asked.append(request)
        begin(controller, request, now_s)

    monkeypatch.setattr(kind, "begin", noted)
    arm.move_j(base_deg=80.0, speed=0.3)
    midway = [each.midway for each in asked if isinstance(each, ReadPosition)]
    assert midway == [True] * (len(midway) - 1) + [False]
    assert len(midway) > 3


def test_joints_that_are_not_named_keep_their_angle_to_the_last_digit():
    arm = ready_arm()
    before = arm.parts.core.position.coordinates.joints
    arm.move_j(elbow_deg=-60.123)
    arm.jog_j(base_deg=3.3)
    assert arm.twin.world.opening_mm == pytest.approx(20.0, abs=0.05)  # the elbow pulls its cable
    after = arm.parts.core.position.coordinates.joints
    for name in ("shoulder", "wrist_pitch", "wrist_roll"):
        assert after[name] == before[name]
    assert arm.parts.core.transmission.to_motors(
        after, arm.parts.core.position.coordinates.opening_mm
    ) == (arm.status.acknowledged)


def declared(arm, opening_mm):
    arm.reference.declare(arm.joints, opening_mm=opening_mm)


@every_row(
    "call, name, words",
    [
        (lambda arm: arm.move_j(base_deg=91), "base", "91.0°, 1.0° beyond its limit of 90.0°"),
        (lambda arm: arm.move_j(elbow_deg=2), "elbow", "limit of 0.0°"),
        (lambda arm: arm.move_j(shoulder_deg=-30, elbow_deg=-60), "table", "below the table"),
        (lambda arm: arm.gripper.open(80.0), "gripper", "0 to 76 mm, not to 80 mm"),
        (lambda arm: arm.gripper.open(76.02), "gripper", "not to 76.02 mm"),
        (lambda arm: arm.gripper.close(-1.0), "gripper", "0 to 76 mm"),
        *(
            (partial(declared, opening_mm=opening_mm), "gripper", "0 to 76 mm")
            for opening_mm in (-200.0, 200.0, 1e308)
        ),
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


BEHIND_A_GUARD = ("into the base",)
"""Goals whose nearest pose no joint motion reaches from the reference posture."""


def named_in(message):
    """Return the coordinates of the pose that a message prints."""
    names = {"x": "x_mm", "y": "y_mm", "z": "z_mm", "pitch": "pitch_deg", "roll": "roll_deg"}
    return {names[word]: float(value) for word, value in re.findall(r"(\w+) (-?[\d.]+)", message)}


def assert_reached(arm, pose):
    assert math.dist(arm.twin.world.pose.position_mm, pose.position_mm) <= step_travel_mm(arm)


@pytest.mark.parametrize("name", GOALS)
def test_a_goal_that_cannot_be_met_names_a_nearest_pose_that_can(name):
    arm, goal = ready_arm(), GOALS[name]
    sent = len(arm.twin.link.sent)
    with pytest.raises((Unreachable, OutOfBounds)) as refusal:
        arm.move_to(goal)
    assert len(arm.twin.link.sent) == sent
    nearest = refusal.value.nearest
    if name in BEHIND_A_GUARD:
        assert nearest is None
        assert "nearest" not in str(refusal.value)
        return
    assert str(nearest) in str(refusal.value)
    arm.move_to(Pose.of(**named_in(str(nearest))))  # as a person types what the message says
    assert_reached(arm, nearest)


def test_a_nearest_pose_behind_a_guard_is_named_where_the_way_is_clear():
    arm = ready_arm()
    arm.move_j(shoulder_deg=80, elbow_deg=-130)
    for name in BEHIND_A_GUARD:
        with pytest.raises((Unreachable, OutOfBounds), match="nearest pose") as refusal:
            arm.move_to(GOALS[name])
        arm.move_to(refusal.value.nearest)
        assert_reached(arm, refusal.value.nearest)
        arm.move_j(shoulder_deg=80, elbow_deg=-130)


def test_an_arm_that_stands_beyond_a_guard_may_leave_it_but_not_go_deeper():
    low = Joints.of(0.0, -20.0, -30.0, -20.0, 0.0)
    arm = ready_arm()
    arm.reference.declare(low)
    assert arm.pose.z_mm < -1.0
    with pytest.raises(OutOfBounds, match="table"):
        arm.move_j(shoulder_deg=-25)
    arm.move_j(shoulder_deg=40)
    assert arm.pose.z_mm > 0.0


def test_an_arm_that_stands_beyond_a_limit_may_come_back_but_go_no_further():
    arm = ready_arm()
    arm.reference.declare(OVER_THE_TABLE.replace(base=math.radians(89.0)))
    arm.move_motors(79, 0, 0, 0, 0, 0)  # knows no limits
    assert arm.joints.deg["base"] == pytest.approx(93.0, abs=0.1)
    for further_deg in (93.5, 170.0):
        with pytest.raises(OutOfBounds, match="nothing was moved"):
            arm.move_j(base_deg=further_deg)
    arm.move_j(base_deg=92.0)
    arm.move_j(base_deg=80.0)
    assert arm.joints.deg["base"] == pytest.approx(80.0, abs=0.1)


@pytest.mark.parametrize(
    ("dialect", "speed", "turn_deg"),
    [
        *(("teachmover", speed, 20) for speed in (1.0, 0.3, 0.04)),
        *(("grbl", 1.0, 10), ("grbl", 0.3, 10), ("grbl", 0.02, 3)),
    ],
)
def test_a_motion_is_never_faster_than_asked_and_not_much_slower(dialect, speed, turn_deg):
    arm = driven(arm_config(dialect))
    began_s = arm.status.time_s
    arm.move_j(base_deg=turn_deg, speed=speed)
    took_s, asked_s = arm.status.time_s - began_s, math.radians(turn_deg) / (0.37 * speed)
    bursts = dialect == "teachmover"
    assert asked_s <= took_s <= (asked_s * 2.2 + 1.0 if bursts else asked_s * 1.15 + 0.4)


# -- Other chains ----------------------------------------------------------------------------------

READY = (0.0, -60.0, 120.0, 10.0, 40.0, 0.0)


@pytest.fixture
def six(tmp_path):
    config = six_joints(tmp_path)
    arm = connected(replace(config, motion=MotionSettings(planned_burst_s=2.0)))
    here = Joints.of(*READY, names=config.model.arm.joint_names)
    world = arm.twin.world
    world.drive_to(world.body.transmission.to_motors(here))
    arm.reference.declare(here)
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
        arm.gripper.grasp,
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
    with pytest.raises(OutOfBounds, match="bend would turn to 120"):
        six.move_j(bend_deg=120)


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


def test_an_arm_without_a_gripper_motor_says_so(six):
    assert six.status.gripper_mm is None
    for call in (
        six.gripper.open,
        six.gripper.close,
        six.gripper.grasp,
        lambda: six.gripper.open(10),
        lambda: six.gripper.opening_mm,
        lambda: six.jog_j(gripper_mm=3),
    ):
        with pytest.raises(Refused, match="no gripper motor"):
            call()


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


# -- The gripper -----------------------------------------------------------------------------------

TAKE = Pose.of(x_mm=260, y_mm=0, z_mm=15, pitch_deg=-90)


def arm_around_a_block(width_mm, config=None):
    """An arm whose open fingers stand around a block."""
    block = TableBlock("A", 260.0, 0.0, 0.0, width_mm, 30.0)
    arm = sim_arm(config, at=OVER_THE_TABLE, blocks=[block])
    arm.gripper.open()
    arm.move_to(Pose.of(x_mm=260, y_mm=0, z_mm=80, pitch_deg=-90))
    arm.move_l(TAKE)
    return arm


@pytest.mark.parametrize(
    ("force_n", "width_mm"),
    [(4.0, 3.0), (8.9, 38.4), (20.0, 74.0)],
)
def test_a_grasp_measures_the_block_and_presses_as_asked(width_mm, force_n):
    arm = arm_around_a_block(width_mm)
    found = arm.run(GraspMove(force_n))
    assert found.holding
    assert found.width_mm == pytest.approx(width_mm, abs=0.3)
    assert arm.twin.world.grip_force_n == pytest.approx(force_n, abs=1.0)
    assert found.force_n == pytest.approx(arm.gripper.force_n)
    assert arm.gripper.force_n == pytest.approx(arm.twin.world.grip_force_n, abs=1.0)
    assert arm.gripper.opening_mm == found.width_mm  # the block keeps the fingers apart
    arm.move_l(Pose.of(x_mm=260, y_mm=0, z_mm=70, pitch_deg=-90))
    assert arm.twin.world.scene.blocks["A"].z_mm == pytest.approx(55.0, abs=1.0)
    arm.gripper.open()
    assert arm.gripper.force_n == 0.0


@pytest.mark.parametrize(
    ("trip_force_n", "width_mm"),
    [(2.2, 0.0), (3.5, 0.0), (5.0, pytest.approx(1.4, abs=0.1))],
    ids=["right", "a little too high", "far too high"],
)
def test_fingers_that_meet_within_a_millimetre_hold_nothing(trip_force_n, width_mm):
    """The arm file says at which force the switch trips; the simulated one trips at 2.2 N."""
    config = sim_config()
    gripper = replace(config.gripper, trip_force_n=trip_force_n)
    arm = sim_arm(replace(config, gripper=gripper), at=OVER_THE_TABLE)
    arm.gripper.open()
    found = arm.run(GraspMove())
    assert (found.width_mm, found.holding) == (width_mm, width_mm != 0.0)
    assert arm.gripper.opening_mm == width_mm


def test_the_force_grows_with_the_cable_pulled_in_behind_the_touch_until_they_open():
    config = sim_config()
    fingers = FingerState(config, config.model.transmission)
    assert fingers.force_n(20.0) == 0.0
    fingers.touch_mm = 30.0
    assert fingers.force_n(28.0) == pytest.approx(2.0 * fingers.force_n(29.0))
    assert fingers.seen_mm(28.0) == 30.0  # what they hold keeps them apart
    fingers.arrive(30.0)
    assert fingers.force_n(28.0) == 0.0
    assert fingers.seen_mm(28.0) == 28.0


@pytest.mark.parametrize(
    ("name", "gripping", "inputs"),
    [("teachmover", True, 5), ("robko01", None, 5), ("armdroid", None, None)],
)
def test_without_a_grip_switch_or_inputs_the_device_says_nothing_of_them(name, gripping, inputs):
    readings = DeviceReadings(dialect(name).abilities)
    readings.sense(Registers(Motors([0] * 6), 5, gripping=True, held=False))
    assert (readings.gripping, readings.inputs) == (gripping, inputs)
    assert (readings.sensed, readings.current) == (1, Current.OFF)


def test_a_grip_switch_that_is_already_closed_opens_before_the_grasp_measures():
    arm = arm_around_a_block(30.0)
    first = arm.gripper.grasp(force_n=25.0)
    assert arm.status.gripping
    again = arm.gripper.grasp(force_n=4.0)
    assert again == pytest.approx(first, abs=0.3)
    assert arm.twin.world.grip_force_n == pytest.approx(4.0, abs=1.0)


@pytest.mark.parametrize("after_s", [0.05, 0.6, 1.5, 2.2])
def test_a_stopped_grasp_stops_closing_within_the_stated_time(after_s):
    arm = arm_around_a_block(20.0)

    began_s, asked_s = arm.parts.engine.now_s, []

    def stop_later(data):
        if not asked_s and arm.parts.engine.now_s - began_s >= after_s:
            asked_s.append(arm.parts.engine.now_s)
            arm.request_stop()

    arm.twin.link.on_write = stop_later
    with pytest.raises(Stopped):
        arm.gripper.grasp(force_n=35.0)
    last_step_s = [at for at, line in arm.twin.link.sent if line.startswith(b"@STEP")][-1]
    assert last_step_s <= asked_s[0]
    assert arm.status.state is State.STANDBY
    assert not arm.twin.device.moving


@pytest.mark.parametrize(
    ("closed", "words"),
    [(False, "did not trip"), (True, "did not release")],
    ids=["never closes", "never opens"],
)
def test_a_grip_switch_that_is_stuck_is_reported_before_the_fingers_are_strained(closed, words):
    arm = sim_arm(at=OVER_THE_TABLE)
    arm.twin.device.set_input(3, closed)
    device = arm.config.device
    arm.parts.core.controller._settings = replace(device, grip_bit=3)
    with pytest.raises(DeviceFault, match=words):
        arm.gripper.grasp()
    assert arm.twin.world.grip_force_n <= 10.0
    assert arm.twin.world.opening_mm < 50.0
    assert arm.status.state is State.STANDBY
