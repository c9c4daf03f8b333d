"""The course of a held jog by itself: ramps, bounds, singularities, frames. No arm, no wire."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from amounts import every_row

from armdrive.connect.target import simulated_config
from armdrive.motion.frames import axes_of
from armdrive.motion.jog.bounds import JogEnded, furthest
from armdrive.motion.jog.course import JogCourse, JogProposal, Wish, stride
from armdrive.motion.plan import SpeedLimits
from armdrive.moves import Jog
from armdrive.runtime.position import ArmCoordinates
from kinematics import Joints, Pose
from kinematics.frames.user_frame import UserFrame

LEG_S = 0.05
OVER_THE_TABLE = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)
CONFIG = simulated_config("grbl")
ARM = CONFIG.model.arm
RAMP_S = CONFIG.motion.jog_ramp_s


class Driven:
    """An arm that is wherever its course has led."""

    def __init__(
        self,
        joints=OVER_THE_TABLE,
        config=CONFIG,
        run_on_s=0.0,
        queued=True,
        hz=1e9,
        bounded=True,
    ):
        model = config.model
        self.config = config
        self.speeds = SpeedLimits(
            model.joint_speeds_rad_s, model.gripper_speed_mm_s, hz, model.transmission
        )
        self.bounded = bounded
        self.course = JogCourse(config, self.speeds, queued=queued, run_on_s=run_on_s)
        self.here = ArmCoordinates(joints, 30.0)
        self.ended = None

    @property
    def pose(self):
        return self.config.model.arm.fk(self.here.joints)

    def leg(self, jog, speed=1.0):
        found = self.course.propose(Wish(jog, speed, self.bounded), self.here, LEG_S)
        if isinstance(found, JogEnded):
            self.ended = found
            return None
        self.course.take(found)
        self.here = found.leg.end
        return found

    def hold(self, jog, legs=400, **wish):
        """Return the legs until the jog ends, or so many."""
        found = []
        while len(found) < legs and (one := self.leg(jog, **wish)) is not None:
            found.append(one)
        return found


def rates(found, joint=0):
    return [
        (one.leg.end.joints[joint] - one.leg.start.joints[joint]) / one.leg.duration_s
        for one in found
    ]


def tip_speeds(found):
    ends = [(ARM.fk(one.leg.start.joints), ARM.fk(one.leg.end.joints)) for one in found]
    ways = [math.dist(tip(a), tip(b)) for a, b in ends]
    return [way / one.leg.duration_s for way, one in zip(ways, found, strict=True)]


def tip(pose):
    return pose.x_mm, pose.y_mm, pose.z_mm


BASE_RAD_S = CONFIG.model.joint_speeds_rad_s[0]


def test_a_jog_reaches_full_speed_by_its_ramp_and_no_sooner():
    speeds = rates(Driven().hold(Jog.joint(base=1.0), legs=8))
    assert speeds == sorted(speeds)
    for index, speed in enumerate(speeds):
        assert speed <= BASE_RAD_S * ((index + 1) * LEG_S / RAMP_S) + 1e-9
    assert speeds[4:] == pytest.approx([BASE_RAD_S] * 4)


def test_turning_round_goes_through_zero_by_the_ramp():
    arm = Driven()
    arm.hold(Jog.joint(base=1.0), legs=8)
    back = rates(arm.hold(Jog.joint(base=-1.0), legs=10))
    assert back == sorted(back, reverse=True)
    assert back[0] > 0.0
    steps = [a - b for a, b in pairwise(back)]
    assert max(steps) <= BASE_RAD_S * LEG_S / RAMP_S + 1e-9
    assert back[-1] == pytest.approx(-BASE_RAD_S)


def test_a_device_that_stands_between_bursts_turns_round_at_once():
    arm = Driven(queued=False)
    forwards = rates(arm.hold(Jog.joint(base=1.0), legs=3))
    assert forwards == pytest.approx([BASE_RAD_S] * 3)
    back = rates(arm.hold(Jog.joint(base=-1.0), legs=3))
    assert back == pytest.approx([-BASE_RAD_S] * 3)


def test_from_joints_to_a_line_the_arm_comes_to_rest_between():
    arm = Driven()
    arm.hold(Jog.joint(base=1.0), legs=8)
    turns = rates(arm.hold(Jog.cartesian(z=1.0), legs=4))
    assert turns == sorted(turns, reverse=True)
    assert turns[-1] > 0.0
    turned = arm.here.joints[0]
    arm.hold(Jog.cartesian(z=1.0), legs=6)
    assert arm.here.joints[0] == pytest.approx(turned, abs=1e-9)


def test_after_standing_still_the_ramp_starts_from_zero():
    arm = Driven()
    arm.hold(Jog.joint(base=1.0), legs=8)
    arm.course.stand()
    assert rates(arm.hold(Jog.joint(base=1.0), legs=1))[0] < BASE_RAD_S / 4.0


@every_row("way", [1.0, -1.0])
@every_row("joint", [0, 1, 3, 4])
def test_a_joint_slides_up_to_its_limit_and_stops_on_it(joint, way):
    config = replace(CONFIG, model=replace(CONFIG.model, guards=no_guards()))
    name, bounds = ARM.joint_names[joint], ARM.limits[joint]
    limit = bounds.high_rad if way > 0 else bounds.low_rad
    full = config.model.joint_speeds_rad_s[joint]
    arm = Driven(OVER_THE_TABLE.replace(**{name: limit - way * 0.5 * full}), config)
    found = arm.hold(Jog.joint(**{name: way}))
    assert arm.ended.note == f"the {name} stopped at the limit"
    assert arm.here.joints[joint] == pytest.approx(limit, abs=1e-5)
    assert all(ARM.violations(one.leg.end.joints) == () for one in found)
    speeds = rates(found, joint)
    for speed, one in zip(speeds, found, strict=True):
        left = abs(limit - one.leg.end.joints[joint])
        assert speed * speed <= 2.0 * full / RAMP_S * left + 1e-6


def no_guards():
    return replace(
        CONFIG.model.guards,
        table=False,
        inner_radius_mm=None,
        outer_radius_mm=None,
        hand_wrist_radius_mm=None,
    )


def test_a_joint_at_its_limit_leaves_the_others_alone_and_all_of_them_keep_step():
    arm = Driven(OVER_THE_TABLE.replace(base=math.radians(88.0)))
    found = arm.hold(Jog.joint(base=1.0, wrist_roll=0.5, gripper=1.0), legs=40)
    assert arm.here.joints.deg["base"] == pytest.approx(90.0, abs=1e-3)
    assert found[-1].note == "the base stopped at the limit"
    full = CONFIG.model.joint_speeds_rad_s[4]
    assert rates(found, 4)[-1] == pytest.approx(0.5 * full, rel=1e-4)
    assert arm.here.opening_mm > 45.0


@pytest.mark.parametrize("run_on_s", [0.0, 0.25])
def test_a_line_ends_on_the_table_and_the_arm_could_always_stop_before_it(run_on_s):
    arm = Driven(run_on_s=run_on_s)
    bound = -CONFIG.model.guards.tolerance_mm
    found = arm.hold(Jog.cartesian(z=-1.0), legs=2000)
    assert "table" in arm.ended.note
    assert arm.ended.cause.name == "table"
    assert bound <= arm.pose.z_mm < bound + 0.6
    for speed, one in zip(tip_speeds(found), found, strict=True):
        z_mm = ARM.fk(one.leg.end.joints).z_mm
        assert z_mm - speed * run_on_s >= bound - 0.6 or z_mm < bound + 1.0
    start = ARM.fk(OVER_THE_TABLE)
    assert (arm.pose.x_mm, arm.pose.y_mm) == pytest.approx((start.x_mm, start.y_mm), abs=1e-6)


def test_a_jog_parallel_to_the_table_keeps_its_speed():
    low = ARM.ik(Pose.of(x_mm=250, y_mm=0, z_mm=2, pitch_deg=-90), OVER_THE_TABLE)
    high = ARM.ik(Pose.of(x_mm=250, y_mm=0, z_mm=60, pitch_deg=-90), OVER_THE_TABLE)
    jog = Jog.cartesian(y=1.0)
    slow, fast = (tip_speeds(Driven(q, run_on_s=0.3).hold(jog, legs=12)) for q in (low, high))
    assert slow == pytest.approx(fast, rel=0.05)


def test_a_line_slows_towards_the_edge_of_the_reach_and_ends_there():
    arm = Driven(OVER_THE_TABLE.replace(elbow=math.radians(-50.0)))
    found = arm.hold(Jog.cartesian(x=1.0), legs=2000)
    assert "178" in arm.ended.note or "355.6" in arm.ended.note
    assert arm.here.joints[2] == pytest.approx(0.0, abs=0.02)
    fastest = [
        max(abs(rates([one], joint)[0]) / full for joint, full in enumerate(limits()))
        for one in found
    ]
    assert max(fastest) <= 1.0 + 1e-6
    back = arm.hold(Jog.cartesian(x=-1.0), legs=4)
    assert abs(rates(back, 2)[-1]) > 0.5 * limits()[2]


def limits():
    return CONFIG.model.joint_speeds_rad_s


def test_past_the_base_axis_the_base_turns_at_its_limit_and_the_tip_goes_on():
    config = replace(CONFIG, model=replace(CONFIG.model, guards=no_guards()))
    start = ARM.ik(Pose.of(x_mm=40, y_mm=-60, z_mm=480, pitch_deg=0), OVER_THE_TABLE)
    arm = Driven(start, config)
    found = arm.hold(Jog.cartesian(y=1.0), legs=120)
    turns = rates(found)
    assert max(turns) == pytest.approx(limits()[0], rel=0.1)
    assert max(turns) <= limits()[0] * 1.001
    assert min(tip_speeds(found)[3:]) > 5.0
    assert arm.pose.x_mm == pytest.approx(40.0, abs=1e-6)


@pytest.mark.parametrize("speed", [1.0, 0.3])
def test_no_motor_is_asked_for_more_than_its_rate(speed):
    arm = Driven(hz=300.0)
    jog = Jog.joint(shoulder=-1.0, elbow=-1.0, wrist_pitch=-1.0, wrist_roll=1.0)
    for one in arm.hold(jog, legs=10, speed=speed):
        before = CONFIG.model.transmission.to_exact(one.leg.start.joints, 30.0)
        behind = CONFIG.model.transmission.to_exact(one.leg.end.joints, 30.0)
        steps = max(abs(b - a) for a, b in zip(before, behind, strict=True))
        assert steps / one.leg.duration_s <= 300.0 * speed * 1.001


@every_row("axis", ["x", "y", "z"])
def test_in_the_tools_frame_the_tip_goes_along_the_axes_of_the_hand(axis):
    joints = Joints.of(30.0, 60.0, -70.0, -20.0, 40.0)
    arm = Driven(joints)
    before = arm.pose
    arm.hold(Jog.cartesian(frame="tool", **{axis: 1.0}), legs=2)  # so short that the hand stays
    way = [b - a for a, b in zip(tip(before), tip(arm.pose), strict=True)]
    along = axes_of(CONFIG, joints, "tool")["xyz".index(axis)]
    assert [part / math.hypot(*way) for part in way] == pytest.approx(along, abs=0.02)
    assert along[2] == pytest.approx(math.sin(before.pitch_rad)) or axis != "z"
    assert arm.pose.pitch_rad == pytest.approx(before.pitch_rad, abs=1e-9)


def test_a_frame_of_the_arm_file_turns_the_line():
    board = UserFrame.turned((300.0, 0.0, 0.0), yaw_rad=math.radians(90.0))
    arm = Driven(config=replace(CONFIG, frames={"board": board}))
    before = arm.pose
    arm.hold(Jog.cartesian(frame="board", x=1.0), legs=10)
    assert arm.pose.y_mm > before.y_mm + 10.0
    assert (arm.pose.x_mm, arm.pose.z_mm) == pytest.approx((before.x_mm, before.z_mm), abs=1e-6)


def test_a_jog_with_no_direction_ends_at_once_without_a_note():
    arm = Driven()
    assert arm.leg(Jog.joint(base=0.0)) is None
    assert arm.ended == JogEnded("")


def test_without_a_known_position_there_are_no_bounds():
    arm = Driven(OVER_THE_TABLE.replace(base=math.radians(89.9)), bounded=False)
    arm.hold(Jog.joint(base=1.0), legs=20)
    assert arm.here.joints.deg["base"] > 92.0


def test_an_arm_that_rounding_has_put_beyond_a_limit_can_leave_it_on_a_line():
    arm = Driven(OVER_THE_TABLE.replace(base=math.radians(90.0) + 2e-4))
    assert arm.leg(Jog.cartesian(y=-1.0, x=0.3)) is not None
    assert isinstance(arm.leg(Jog.cartesian(x=0.3)), JogProposal)


def test_an_increment_of_the_tip_is_no_faster_than_a_held_jog():
    arm = Driven()
    made = stride(CONFIG, arm.speeds, Jog.cartesian(y=50.0), 0.5, arm.here, known=True)
    takes_s = sum(leg.duration_s for leg in made.legs)
    assert takes_s >= 50.0 / (0.5 * CONFIG.motion.tip_speed_mm_s) - 1e-9
    assert made.ended.note == ""


def test_the_furthest_good_is_found_and_something_beyond_it():
    low, high = furthest(lambda value: value <= 0.3, 1.0)
    assert low <= 0.3 < high
    assert high - low < 3e-3
    assert furthest(lambda _: True, 2.0) == (2.0, math.inf)
