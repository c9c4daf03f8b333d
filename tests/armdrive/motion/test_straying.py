"""Arms without coordination: how far they leave the path, and shorter bursts near guards."""

import math

import pytest
from faults import OVER_THE_TABLE, arm_config, driven
from hypothesis import given
from hypothesis import strategies as st

from armdrive.connect.target import simulated_config
from armdrive.motion.deviation import SMALL_STEPS, Corridor, has_room, turns
from armdrive.registry import DIALECTS, dialect
from armdrive.runtime.arm_state import Core
from armdrive.runtime.position import joints_between
from kinematics import Joints, Motors, Pose

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


@pytest.mark.parametrize("name", UNCOORDINATED)
@pytest.mark.parametrize("limit_mm", [2.0, 5.0, 20.0])
def test_the_tip_stays_within_the_announced_distance_of_the_line(name, limit_mm):
    arm = standing(name, straying_mm=limit_mm)
    seen = postures_of(arm)
    goal = Joints.of(10.0, 48.0, -90.0, -30.0, 12.0)
    moved = arm.move_j(**{f"{joint}_deg": turn for joint, turn in goal.deg.items()})
    assert len(seen) > 10
    points = arm.model.arm.points
    way = [points(joints_between(OVER_THE_TABLE, goal, share / 75))[-1] for share in range(76)]
    left_mm = max(min(math.dist(points(there)[-1], one) for one in way) for there in seen[::3])
    rounding_mm = 1.0
    assert left_mm <= moved.straying_mm + rounding_mm
    assert moved.straying_mm <= max(limit_mm, FEW_STEPS_MM)


@pytest.mark.parametrize("name", UNCOORDINATED)
def test_a_burst_is_shorter_where_a_guard_is_near(name):
    high, low = (standing(name, straying_mm=100.0) for _ in range(2))
    low.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=1.0, pitch_deg=-60))
    target = Motors((90, -60, 80, 40, 70, 0))
    rate_hz = high.speeds.motor_hz
    assert has_room(high.core, high.core.position.acknowledged + target, rate_hz)
    assert not has_room(low.core, low.core.position.acknowledged + target, rate_hz)
    few = Motors((SMALL_STEPS, -3, 2, 1, 1, 0))
    assert has_room(low.core, low.core.position.acknowledged + few, rate_hz)


@pytest.mark.parametrize("name", UNCOORDINATED)
def test_a_path_just_above_the_table_never_enters_it(name):
    low = Pose.of(x_mm=220, y_mm=-30, z_mm=2.0, pitch_deg=-70)
    arm = standing(name, simulated_config(name).model.arm.ik(low))
    arm.move_to(Pose.of(x_mm=240, y_mm=35, z_mm=2.0, pitch_deg=-60))
    assert arm.twin.world.incidents == []


def beyond_deg(arm, joints):
    """How far a posture is beyond the limits."""
    return max(
        (math.degrees(each.excess_rad) for each in arm.model.arm.violations(joints)), default=0
    )


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


@pytest.mark.parametrize("name", UNCOORDINATED)
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
        for a, b in zip(*map(arm.core.transmission.to_motors, (start, there.joints)), strict=True)
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


ONE = simulated_config("robko01")


@given(
    start=st.tuples(*[st.integers(-600, 600)] * 5, st.just(0)),
    steps=st.tuples(*[st.integers(-SMALL_STEPS, SMALL_STEPS)] * 5, st.just(0)),
)
def test_turns_lead_to_the_target_and_stay_in_the_corridor(start, steps):
    core = Core(ONE, dialect("robko01").controller(ONE))
    start, target = Motors(start), Motors(start) + Motors(steps)
    corridor = Corridor(core, start, target)
    ends = turns(corridor, start, target)
    if not any(steps):
        assert ends == ()
        return
    assert ends, "motors that take turns find a way between two postures"
    assert ends[-1] == target
    at = start
    for end in ends:
        assert corridor.holds(at, end)
        assert all(b in (a, c) for a, b, c in zip(at, end, target, strict=True))
        at = end
