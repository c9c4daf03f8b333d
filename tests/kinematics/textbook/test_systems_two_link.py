"""The two-link manipulators in three ways, the notes' own matrices, and their workspaces."""

import math

import pytest
from amounts import every_row
from chain_cases import gap
from hypothesis import given
from hypothesis import strategies as st
from systems_cases import postures

from kinematics.errors import OutOfReach
from kinematics.frames.orientations import RPY
from kinematics.frames.transforms import position_of, rotation_of
from kinematics.textbook.systems import (
    SYSTEMS,
    THREE_LINK,
    TWO_LINK_1,
    TWO_LINK_2,
    TWO_LINK_3,
    TWO_LINK_4,
    TWO_LINK_5,
)
from kinematics.textbook.systems.named import ENDLESS

UNEVEN = (
    TWO_LINK_1.sized(200.0, 150.0),
    TWO_LINK_1.sized(90.0, 90.0),
    TWO_LINK_2.sized(310.0, 120.0),
    TWO_LINK_3.sized(200.0, ranges=(ENDLESS, (0.0, 300.0))),
    TWO_LINK_3.sized(100.0, ranges=(ENDLESS, (50.0, 250.0))),
    TWO_LINK_4.sized(150.0, ranges=((0.0, 300.0), ENDLESS)),
    TWO_LINK_4.sized(80.0, ranges=((100.0, 120.0), ENDLESS)),
    TWO_LINK_5.sized(ranges=((10.0, 300.0), (20.0, 250.0))),
)
EACH = pytest.mark.parametrize("one", UNEVEN, ids=lambda one: one.name)
C30, S30 = math.sqrt(3.0) / 2.0, 0.5
DEG = math.pi / 180.0


TIPS = {  # the trigonometric solutions of sections 5 to 8
    "two-link-1": lambda l1, l2, a, b: (
        l1 * math.cos(a) + l2 * math.cos(a + b), l1 * math.sin(a) + l2 * math.sin(a + b), 0.0
    ),
    "two-link-2": lambda d1, l2, a, b: (
        l2 * math.cos(a) * math.cos(b), l2 * math.sin(a) * math.cos(b), d1 + l2 * math.sin(b)
    ),
    "two-link-3": lambda d1, a, d2: (d2 * math.sin(a), -d2 * math.cos(a), d1),
    "two-link-4": lambda l2, d1, b: (l2 * math.cos(b), 0.0, d1 + l2 * math.sin(b)),
    "two-link-5": lambda d1, d2: (0.0, -d2, d1),
}  # fmt: skip

ORIENTATIONS = {  # phi, theta and psi of section 8
    "two-link-1": lambda first, second: (first + second, 0.0, 0.0),
    "two-link-2": lambda first, second: (first, -second, 90 * DEG),
    "two-link-3": lambda first, _slide: (first, 0.0, 90 * DEG),
    "two-link-4": lambda _lift, second: (0.0, -second, 90 * DEG),
    "two-link-5": lambda _lift, _slide: (0.0, 0.0, 90 * DEG),
}


@EACH
@given(data=st.data())
def test_trigonometry_matrices_and_orientation_agree(one, data):
    joints = data.draw(postures(one))
    assert gap(position_of(one.fk(joints)), TIPS[one.name](*one.sizes, *joints)) < 1e-9
    hand = RPY(*ORIENTATIONS[one.name](*joints)).rotation()
    assert gap(hand, rotation_of(one.fk(joints))) < 2e-12  # angles are rounded to quarter turns


# Matrices as the notes print them, with their numbers: C30 and S30 are those of 30 degrees.


def test_type_2_first_matrix_as_section_6_prints_it():
    first, _ = TWO_LINK_2.sized(200.0, 150.0).chain().matrices((30 * DEG, 0.0))
    printed = (
        (C30, 0.0, S30, 0.0),
        (S30, 0.0, -C30, 0.0),
        (0.0, 1.0, 0.0, 200.0),
        (0.0, 0.0, 0.0, 1.0),
    )
    assert gap(first, printed) < 1e-12


@EACH
@given(data=st.data())
def test_the_workspace_holds_exactly_what_a_branch_within_limits_reaches(one, data):
    size = len(one.coordinates)
    anywhere = st.tuples(*[st.integers(-400, 400).map(float)] * size)
    reached = postures(one).map(lambda joints: one.goal_of(one.fk(joints)))
    goal = data.draw(anywhere | reached)
    try:
        branches = one.ik(goal)
    except OutOfReach:
        branches = ()
    assert one.holds(goal) == any(branch.within_limits for branch in branches)


@every_row(
    "name, told",
    [
        ("two-link-1", "a ring in the plane z = 0, 50 mm to 350 mm from the first joint"),
        ("two-link-2", "the surface of a sphere of 150 mm around (0, 0, 200)"),
        ("two-link-3", "a disc in the plane z = 200 mm, 0 mm to 300 mm from the axis"),
        ("two-link-4", "a strip in the plane y = 0: circles of 150 mm around (0, 0) to (0, 300)"),
        ("two-link-5", "a rectangle in the plane x = 0: y from -300 to 0 mm, z from 0 to 300 mm"),
    ],
)
def test_the_workspace_is_told_with_its_measures(name, told):
    one = SYSTEMS[name]
    assert one.space(one) == told


def test_the_three_link_arm_turns_its_hand_where_it_is_told():
    one = THREE_LINK.sized(200.0, 150.0, 80.0)
    up, down = one.ik((150.0, 280.0, math.pi / 2.0))  # third joint at (150, 200)
    for branch in (up, down):
        first, second, third = branch.joints
        assert first + second + third == pytest.approx(math.pi / 2.0)
    # The line to the third joint, 250 long, and the links 200 and 150 make a right angle.
    assert down.joints[1] == pytest.approx(math.pi / 2.0)
    assert down.joints[0] == pytest.approx(math.atan2(200.0, 150.0) - math.atan2(150.0, 200.0))
    assert up.joints[1] == pytest.approx(-math.pi / 2.0)
    assert up.joints[0] == pytest.approx(math.atan2(200.0, 150.0) + math.atan2(150.0, 200.0))
