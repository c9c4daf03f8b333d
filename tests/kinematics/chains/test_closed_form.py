"""Closed forms of link tables: classes of real arms, and the laws that all of them keep."""

import math
from dataclasses import replace

import pytest
from amounts import every_row
from chain_cases import gap, turn_gap
from hypothesis import given, settings
from hypothesis import strategies as st
from named_arms import (
    AR4,
    ARMS,
    BESIDE_THE_BASE,
    COBOT_WITHOUT_WRIST,
    FIVE_ASKEW,
    KUKA_KR6,
    MINI_MOVER,
    NOTHING_MEETS_BUT_THE_WRIST,
    PARALLEL_AND_OFFSET,
    PUMA_560,
    SEVEN_JOINTS,
    THOR,
    UR5,
    calibrated,
)

from kinematics.chains.arm import ChainArm
from kinematics.chains.chain import Chain
from kinematics.chains.closed_form import closed_form, how_solved
from kinematics.chains.goals import HEADING_FREE, Goal, Part, frame_goal
from kinematics.chains.inverse import Reason, solve_frame_ik
from kinematics.chains.jacobians import condition
from kinematics.chains.links import DHLink, JointKind
from kinematics.frames.rotations import multiply, rot_x, rot_y, rot_z
from kinematics.frames.transforms import compose, position_of, rotation_of, transform, translation

any_arm = st.sampled_from(sorted(ARMS))
angles = st.floats(-3.1, 3.1)


def posture(chain, draw):
    return tuple(draw(angles) for _ in chain.links)


def regular(chain, values):
    """Whether a posture is far enough from singular ones to be told from others."""
    return condition(chain, values).smallest > 1e-3


WRIST = "spherical wrist: the last three axes meet in one point, axes 2 and 3 are parallel"
PARALLEL = "three parallel axes: 2, 3 and 4"


@every_row(
    "name, said",
    [
        ("Puma 560", WRIST),
        ("a wrist of other angles", WRIST),
        ("UR5", PARALLEL),
        ("Mini-mover", PARALLEL),
    ],
)
def test_the_class_of_an_arm_in_words(name, said):
    assert how_solved(ARMS[name]).structure == said


def with_link(chain, index, link):
    """The chain with another link in the place of one."""
    return replace(chain, links=(*chain.links[:index], link, *chain.links[index + 1 :]))


@every_row(
    "chain, why",
    [
        (COBOT_WITHOUT_WRIST, "nor do the last three axes meet in one point"),
        (NOTHING_MEETS_BUT_THE_WRIST, "axes 2 and 3 are not parallel"),
        (PARALLEL_AND_OFFSET, "while axes 5 and 6 meet"),
        (FIVE_ASKEW, "axes 2, 3 and 4 are not parallel"),
        (Chain(PUMA_560.links[:4]), "the classes are of five or six joints, not of 4"),
        (with_link(PUMA_560, 2, DHLink(kind=JointKind.PRISMATIC)), "a joint slides"),
        (with_link(PUMA_560, 0, DHLink(a_mm=200.0)), "(or axis 1 is too)"),
        (SEVEN_JOINTS, "the classes are of five or six joints, not of 7"),
    ],
)
def test_an_arm_without_a_closed_form_says_why(chain, why):
    assert closed_form(chain) is None
    assert why in how_solved(chain).structure
    assert "numerically" in how_solved(chain).solved


@settings(max_examples=100, deadline=None)
@given(any_arm, st.data())
def test_every_posture_meets_its_goal_and_the_posture_that_made_it_is_among_them(name, data):
    chain = ARMS[name]
    values = posture(chain, data.draw)
    frame = chain.fk(values)
    found = closed_form(chain).branches(frame_goal(frame), values)
    for one in found:
        assert gap(chain.fk(one), frame) < 2e-5
    if regular(chain, values):
        assert min(turn_gap(one, values) for one in found) < 1e-4


def test_a_goal_just_beyond_the_stretched_arm_is_not_met_by_it():
    stretched = MINI_MOVER.fk((0.3, 0.5, 0.0, -0.4, 0.2))
    out = (math.cos(0.3) * math.cos(0.5), math.sin(0.3) * math.cos(0.5), math.sin(0.5))
    beyond = transform(
        rotation_of(stretched),
        tuple(at + 3e-5 * way for at, way in zip(position_of(stretched), out, strict=True)),
    )
    assert closed_form(MINI_MOVER).branches(frame_goal(stretched), (0.0,) * 5)
    assert closed_form(MINI_MOVER).branches(frame_goal(beyond), (0.0,) * 5) == []


@every_row("chain", [PUMA_560, KUKA_KR6, AR4, THOR], ids=["puma", "kr6", "ar4", "thor"])
def test_a_straight_wrist_keeps_joint_4_of_the_present_posture(chain):
    values = (0.3, -0.8, 1.1, 0.4, 0.0, -0.5)
    frame = chain.fk(values)
    near = closed_form(chain).nearest(frame_goal(frame), values)
    assert near == pytest.approx(values, abs=1e-7)
    other = closed_form(chain).nearest(frame_goal(frame), (*values[:3], 0.9, 0.0, -1.0))
    assert other == pytest.approx((*values[:3], 0.9, 0.0, -1.0), abs=1e-7)


@every_row("name", ["Mini-mover", "SCORBOT"])
@every_row("hanging", [-math.pi / 2, math.pi / 2])
def test_five_joints_with_a_vertical_hand_are_found_from_anywhere(name, hanging):
    chain = ARMS[name]
    values = (0.4, 0.7, -0.9, hanging + 0.2, 0.3)
    found = closed_form(chain).branches(frame_goal(chain.fk(values)), (1.5,) * 5)
    assert min(turn_gap(one, values) for one in found) < 1e-6


@every_row("bent", [0.0, 1e-13, 1e-11, 1e-9, 1e-7, 1e-4, 1e-2])
def test_next_to_a_straight_wrist_no_digits_are_lost(bent):
    values = (0.3, -0.8, 1.1, 0.4, bent, -0.5)
    frame = PUMA_560.fk(values)
    for one in closed_form(PUMA_560).branches(frame_goal(frame), values):
        assert gap(PUMA_560.fk(one), frame) < 1e-9
        assert gap(rotation_of(PUMA_560.fk(one)), rotation_of(frame)) < 1e-12


def limited(chain, low, high):
    return chain.within([(low, high)] * len(chain))


@settings(max_examples=60, deadline=None)
@given(any_arm, st.data())
def test_the_nearest_posture_is_within_the_limits_and_the_nearest(name, data):
    chain = limited(ARMS[name], -1.5, 1.5)
    values = data.draw(st.tuples(*[st.floats(-1.45, 1.45)] * len(chain)))
    near = data.draw(st.tuples(*[st.floats(-3.0, 3.0)] * len(chain)))
    closed = closed_form(chain)
    goal = frame_goal(chain.fk(values))
    found = closed.nearest(goal, near)
    if found is None:
        assert not regular(chain, values)
        return
    assert not chain.violations(found)
    assert gap(chain.fk(found), goal.frame) < 1e-4
    kept = [one for one in closed.branches(goal, near) if not chain.violations(one)]
    nearest = min(math.dist(one, near) for one in kept)
    assert math.dist(found, near) == pytest.approx(nearest, abs=1e-6)


@settings(max_examples=40, deadline=None)
@given(st.tuples(*[st.floats(-2.0, 2.0)] * 5), st.floats(-3.0, 3.0))
def test_five_joints_find_the_heading_that_a_goal_leaves_free(values, turned):
    chain = BESIDE_THE_BASE
    frame = chain.fk(values)
    (nx, ny, nz), (ox, oy, oz) = ((*row[:3],) for row in frame[:2])
    c, s = math.cos(turned), math.sin(turned)
    about = (
        (c * nx - s * ox, c * ny - s * oy, c * nz - s * oz, frame[0][3]),
        (s * nx + c * ox, s * ny + c * oy, s * nz + c * oz, frame[1][3]),
        frame[2],
        frame[3],
    )
    goal = Goal(about, (1.0, 0.0, 0.0), HEADING_FREE)
    found = closed_form(chain).branches(goal, values)
    for one in found:
        assert gap(chain.fk(one)[2:], frame[2:]) < 2e-5
    if abs(math.hypot(frame[0][2], frame[1][2])) > 0.05 and abs(math.sin(values[2])) > 0.05:
        assert min(turn_gap(one, values) for one in found) < 1e-4


@settings(max_examples=10, deadline=None)
@given(
    st.sampled_from(
        [
            *(COBOT_WITHOUT_WRIST, NOTHING_MEETS_BUT_THE_WRIST, PARALLEL_AND_OFFSET, FIVE_ASKEW),
            *(calibrated(arm, 1e-3) for arm in (PUMA_560, AR4, UR5, MINI_MOVER)),
        ]
    ),
    st.data(),
)
def test_arms_without_a_closed_form_find_what_they_have_reached(chain, data):
    chain = limited(chain, -2.6, 2.2)
    values = tuple(data.draw(st.floats(-2.5, 2.1)) for _ in chain.links)
    arm = ChainArm(chain)
    pose = arm.fk(arm.joints_of(values))
    found = arm.ik(pose)
    assert not arm.violations(found)
    goal = arm.goal(pose)
    assert all(abs(miss) < 1e-6 for _, _, miss in goal.turn(chain.fk(found.angles_rad))[1])


def test_what_no_posture_meets_is_told_for_certain():
    far = compose(UR5.fk((0.3, -0.8, 1.1, 0.4, 0.7, -0.5)), translation(0.0, 0.0, 500.0))
    solution = solve_frame_ik(UR5, far)
    assert not solution.ok
    assert solution.reason is Reason.NO_POSTURE


# Goals: which turn leads from a hand to what is asked of it, and what is left free.


def test_the_misses_are_named_by_axes():
    level = transform(rot_y(math.pi / 2), (300.0, 0.0, 100.0))  # the hand points along x
    goal = frame_goal(level)
    for part, turn in (
        (Part.ROLL, rot_x(0.1)),
        (Part.PITCH, rot_y(0.1)),
        (Part.HEADING, rot_z(0.1)),
    ):
        now = transform(multiply(turn, rot_y(math.pi / 2)), (300.0, 0.0, 100.0))
        misses = {one: abs(miss) for one, _, miss in goal.turn(now)[1]}
        assert misses[part] == pytest.approx(0.1)
        assert sum(misses.values()) == pytest.approx(0.1)
