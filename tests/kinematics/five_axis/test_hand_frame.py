"""Goals given as a full frame: met, or flagged with the angle by which five axes miss them."""

import math
import random

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from kinematics_cases import HALF_TURNS, TEACHMOVER, UNEVEN, arm_and_posture

from kinematics import FiveAxisArm, JointRange, Joints
from kinematics.five_axis.closed_form import ON_MANIFOLD_RAD, forward_frame, inverse, solve_frame
from kinematics.frames.rotations import multiply, rot_x, rot_y, rot_z, transpose
from kinematics.frames.transforms import Transform, compose, position_of, rotation_of, transform
from kinematics.geometry import AXIS_MM

HALF = math.pi / 2


def turn_of(matrix):
    """The angle of a rotation, exact for small ones too."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return math.atan2(math.hypot(h - f, c - g, d - b), a + e + i - 1.0)


def apart(a, b):
    """Distance in mm and angle in rad between two frames."""
    turn = multiply(transpose(rotation_of(a)), rotation_of(b))
    return math.dist(position_of(a), position_of(b)), turn_of(turn)


@given(arm_and_posture, st.floats(-1.5, 1.5))
def test_a_hand_turned_out_of_the_plane_is_flagged_with_the_angle(case, turn):
    arm, joints = case
    level = arm.transform(joints.replace(wrist_pitch=-joints[1] - joints[2]))
    assume(math.hypot(*position_of(level)[:2]) > 1.0)
    normal_turn = multiply(rot_z(joints[0]), rot_z(turn), rot_z(-joints[0]))
    goal = transform(multiply(normal_turn, rotation_of(level)), position_of(level))
    found = arm.solve_transform(goal, joints)
    assert found.off_manifold_rad == pytest.approx(abs(turn), abs=1e-7)
    assert found.on_manifold == (found.off_manifold_rad <= ON_MANIFOLD_RAD)
    if found.joints is not None:
        distance, missed = apart(arm.transform(found.joints), goal)
        assert distance < 1e-4
        assert missed == pytest.approx(abs(turn), abs=1e-5)


@given(
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.floats(100.0, 300.0),
    st.floats(-3.0, 3.0),
    st.floats(0.0, 300.0),
)
def test_no_other_pitch_or_roll_is_nearer_to_a_frame_off_the_manifold(turns, r, base, z):
    a, b, c = turns
    place = r * math.cos(base), r * math.sin(base), z
    goal = transform(multiply(rot_z(a), rot_y(b), rot_x(c)), place)
    found = UNEVEN.solve_transform(goal)
    assume(found.joints is not None and found.off_manifold_rad < 1.5)
    _, least = apart(UNEVEN.transform(found.joints), goal)
    nudges = [(d, e) for d in (-0.01, 0.0, 0.01) for e in (-0.01, 0.0, 0.01)]
    for pitch, roll in nudges:
        q = found.joints.angles_rad
        frame = UNEVEN.transform(Joints((*q[:3], q[3] + pitch, q[4] + roll)))
        turned = multiply(transpose(rotation_of(frame)), rotation_of(goal))
        assert turn_of(turned) >= least - 1e-7


def test_on_the_base_axis_the_hand_gives_the_base():
    _, upper, fore, hand = TEACHMOVER.lengths
    steep = Joints.of(37, 120, -50, 0, 20)
    wrist_r = upper * math.cos(steep[1]) + fore * math.cos(steep[1] + steep[2])
    steep = steep.replace(wrist_pitch=math.acos(-wrist_r / hand) - steep[1] - steep[2])
    goal = TEACHMOVER.transform(steep)
    assert math.hypot(*position_of(goal)[:2]) < 1e-9
    found = TEACHMOVER.solve_transform(goal)
    assert found.met
    assert not found.base_free
    assert apart(TEACHMOVER.transform(found.joints), goal) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_a_vertical_hand_on_the_base_axis_takes_the_seeds_base():
    goal = TEACHMOVER.transform(Joints.of(0, 90, 0, 0, 30))
    found = TEACHMOVER.solve_transform(goal, Joints.of(40, 80, -10, 10, 0))
    assert found.met
    assert found.base_free
    assert found.joints.deg["base"] == pytest.approx(40)
    assert apart(TEACHMOVER.transform(found.joints), goal) == pytest.approx((0.0, 0.0), abs=1e-4)


def test_out_of_reach_is_no_posture_and_still_says_the_pose():
    found = TEACHMOVER.solve_transform(transform(rot_y(HALF), (900.0, 0.0, 100.0)))
    assert found.joints is None
    assert not found.met
    assert found.pose.x_mm == 900.0


# Goals of every kind: no answer is wrong and not flagged, and none is missed.

NEAR_MM, NEAR_RAD = 1e-4, 1e-5
GOALS = 120

NO_HAND = FiveAxisArm(150.0, 120.0, 90.0, 0.0, (JointRange.of(-180, 180),) * 5)
ARMS = {
    "teachmover": TEACHMOVER,
    "uneven": UNEVEN,
    "equal links, half turns": HALF_TURNS,
    "no hand": NO_HAND,
}


def tiny(chance):
    """Nothing, or anything from rounding to a micron's worth."""
    return chance.choice((0.0, 1.0, -1.0)) * 10.0 ** chance.uniform(-16.0, -5.0)


def anywhere(arm, q, chance):
    return q


def stretched(arm, q, chance):
    return [q[0], q[1], arm.limits[2].clamp(tiny(chance)), *q[3:]]


def folded(arm, q, chance):
    return [q[0], q[1], arm.limits[2].low_rad, *q[3:]]


def vertical(arm, q, chance):
    return [*q[:3], math.pi / 2.0 - q[1] - q[2] + tiny(chance), q[4]]


def over_the_axis(arm, q, chance):
    _, upper, fore, hand = arm.lengths
    r = upper * math.cos(q[1]) + fore * math.cos(q[1] + q[2]) + 1e3 * tiny(chance)
    if abs(r) > hand or hand == 0.0:
        return q
    return [*q[:3], chance.choice((1.0, -1.0)) * math.acos(-r / hand) - q[1] - q[2], q[4]]


def at_a_limit(arm, q, chance):
    joint = chance.randrange(5)
    bounds = arm.limits[joint]
    return [*q[:joint], chance.choice((bounds.low_rad, bounds.high_rad)), *q[joint + 1 :]]


KINDS = (anywhere, stretched, folded, vertical, over_the_axis, at_a_limit)


def postures(arm, kind, chance):
    for _ in range(GOALS):
        q = [chance.uniform(bounds.low_rad, bounds.high_rad) for bounds in arm.limits]
        yield tuple(kind(arm, q, chance))


def assert_honest(arm, goal, near):
    """Everything that is offered for a goal holds it; return whether anything is offered."""
    found = solve_frame(goal, arm, near)
    met = found.angles is not None and found.off_manifold_rad <= ON_MANIFOLD_RAD
    offered = []
    on_axis = math.hypot(*position_of(goal)[:2]) <= AXIS_MM  # where poses leave the base free
    if found.off_manifold_rad <= ON_MANIFOLD_RAD and not on_axis:
        offered += [angles for _, _, angles in inverse(found.goal, arm.lengths, near)]
    if met:
        assert offered or on_axis, "the branches lack what the nearest one has"
        assert all(
            bounds.low_rad <= angle <= bounds.high_rad
            for bounds, angle in zip(arm.limits, found.angles, strict=True)
        )
        offered.append(found.angles)
    for angles in offered:
        distance, turn = apart(forward_frame(angles, arm.lengths), goal)
        assert distance <= NEAR_MM
        assert turn <= NEAR_RAD
    return met


def within(arm, q):
    return all(b.low_rad <= angle <= b.high_rad for b, angle in zip(arm.limits, q, strict=True))


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_what_a_posture_holds_is_met_and_what_is_offered_holds(arm, kind):
    chance = random.Random(7)
    made = list(postures(arm, kind, chance))
    goals = [forward_frame(q, arm.lengths) for q in made]
    for q, goal in zip(made, goals, strict=True):
        near = tuple(bounds.clamp(chance.uniform(-2.0, 2.0)) for bounds in arm.limits)
        assert assert_honest(arm, goal, near) or not within(arm, q)


def turned_anyhow(goal: Transform, chance) -> Transform:
    size = 10.0 ** chance.uniform(-9.0, 0.5)
    a, b, c = (size * chance.uniform(-1.0, 1.0) for _ in range(3))
    return compose(goal, transform(multiply(rot_z(a), rot_y(b), rot_x(c)), (0.0, 0.0, 0.0)))


def moved_anyhow(goal: Transform, chance) -> Transform:
    x, y, z = (at + chance.uniform(-500.0, 500.0) for at in position_of(goal))
    return transform(rotation_of(goal), (x, y, z))


def brought_to_the_axis(goal: Transform, chance) -> Transform:
    x, y, z = position_of(goal)
    share = 10.0 ** chance.uniform(-14.0, 0.0)
    return transform(rotation_of(goal), (share * x, share * y, z))


@pytest.mark.parametrize("change", [turned_anyhow, moved_anyhow, brought_to_the_axis])
@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_of_goals_that_are_no_posture_s_nothing_false_is_offered(arm, change):
    chance = random.Random(8)
    held = [forward_frame(q, arm.lengths) for q in postures(arm, anywhere, chance)]
    goals = [change(goal, chance) for goal in held]
    met = [assert_honest(arm, goal, (0.0,) * 5) for goal in goals]
    assert not all(met)
