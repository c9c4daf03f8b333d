"""The laws that every named system of the textbook keeps."""

import math

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st
from systems_cases import gap, postures, same_goal, same_joints

from kinematics import Joints, Pose, preset
from kinematics.chains.links import JointKind
from kinematics.errors import OutOfReach, UnknownSystem
from kinematics.five_axis.closed_form import forward_frame
from kinematics.frames.orientations import RPY
from kinematics.frames.transforms import position_of, rotation_of
from kinematics.textbook.systems import (
    ALPHA_2,
    CYLINDRICAL,
    PUMA,
    REVOLUTE,
    SPHERICAL,
    SYSTEMS,
    THREE_LINK,
    TWO_LINK_1,
    TWO_LINK_2,
    TWO_LINK_3,
    TWO_LINK_4,
    TWO_LINK_5,
    system,
)
from kinematics.textbook.systems.mini_movers import own_angles, relative_angles
from kinematics.textbook.systems.named import ENDLESS

EACH = pytest.mark.parametrize("one", SYSTEMS.values(), ids=SYSTEMS)


@EACH
@given(data=st.data())
def test_the_formulas_undo_the_link_table(one, data):
    joints = data.draw(postures(one))
    tip = one.fk(joints)
    assert_every_branch_meets_the_goal(one, tip)
    assert_the_posture_is_among_the_branches(one, tip, joints)


def assert_every_branch_meets_the_goal(one, tip):
    goal = one.goal_of(tip)
    for branch in one.ik(goal):
        # An elbow that rounding bends beyond its limit is put on it, at no more than 1e-4 mm.
        mm, rad = (1e-4, 1e-6) if branch.degenerate else (1e-7, 1e-8)
        reached = one.fk(branch.joints)
        assert gap(position_of(reached), position_of(tip)) < mm
        # Three angles lose digits next to where they are degenerate; a frame does not.
        assert gap(reached, tip) < rad or same_goal(one, one.goal_of(reached), goal, rad, mm)
        if not branch.degenerate:  # the formulas alone, which check nothing, give the same
            assert same_joints(one, one.solution(goal, branch.name).joints, branch.joints)


def assert_the_posture_is_among_the_branches(one, tip, joints):
    found = one.ik(one.goal_of(tip), joints)
    kept = [each for each in found if each.within_limits and gap(one.fk(each.joints), tip) < 1e-4]
    assert kept
    # Rounding of a stretched Puma tilts the forearm by more than a wrist is from being straight.
    lost = one.name == "puma" and any("stretched" in each.degenerate for each in kept)
    assert lost or any(same_joints(one, each.joints, joints) for each in kept)


FAR = {  # a goal, and how near to it the system comes
    "two-link-1": ((300.0, 400.0), 500.0 - 350.0),
    "two-link-2": ((90.0, 0.0, 200.0), 150.0 - 90.0),
    "two-link-4": ((-151.0, 100.0), 1.0),
    "three-link": ((500.0, 0.0, 0.0), 500.0 - 430.0),
    "revolute": ((0.0, 500.0, 200.0), 500.0 - 320.0),
    "minimover5": ((600.0, 0.0, 195.0, 0.0, 0.0), 600.0 - 452.1),
    "alpha2-lecture": ((0.0, 600.0, 215.0, 0.0, 0.0), 600.0 - 485.1),
    "puma": ((1000.0, 149.09, 0.0, 0.0, math.pi / 2, 0.0), 1000.0 - 56.25 - 864.87),
}


@every_row("name", FAR)
def test_a_goal_out_of_reach_is_refused_with_the_nearest_that_is_reached(name):
    one, (goal, away_mm) = system(name), FAR[name]
    with pytest.raises(OutOfReach) as caught:
        one.ik(goal)
    error = caught.value
    assert error.system == name
    assert error.away_mm == pytest.approx(away_mm)
    assert math.dist(error.nearest, goal) == pytest.approx(away_mm)
    assert f"only to {error.away_mm:.3g} mm from it" in str(error)
    assert one.ik(error.nearest)


BENT_S = math.acos((180.0**2 + 220.0**2 - 140.0**2) / (2.0 * 180.0 * 220.0))
BENT_E = math.pi - math.acos((180.0**2 + 140.0**2 - 220.0**2) / (2.0 * 180.0 * 140.0))
"""Shoulder and elbow of links 180 and 140 mm that span 220 mm, by the cosine rule."""

ON_AXIS, STRETCHED, FOLDED = "base is free", "stretched", "folded"
DEGENERATE = [  # system, goal, seed; of each branch its name, joints, free joints, words
    (TWO_LINK_1.sized(200.0, 200.0), (0.0, 400.0), None,
     [("elbow up", (math.pi / 2, 0.0), (), STRETCHED)]),
    (TWO_LINK_1.sized(200.0, 200.0), (0.0, 0.0), (1.25, 0.0),
     [("elbow up", (1.25, math.pi), ("theta1",), FOLDED)]),
    (TWO_LINK_1.sized(200.0, 150.0), (50.0, 0.0), None,
     [("elbow up", (0.0, math.pi), (), FOLDED)]),
    (TWO_LINK_2.sized(200.0, 150.0), (0.0, 0.0, 350.0), (0.7, 0.0),
     [("base front", (0.7, math.pi / 2), ("theta1",), ON_AXIS)]),
    (TWO_LINK_3.sized(200.0), (0.0, 0.0), (0.7, 0.0),
     [("reaching forward", (0.7, 0.0), ("theta1",), ON_AXIS)]),
    (TWO_LINK_4.sized(150.0), (-150.0, 80.0), None, [("arm up", (80.0, math.pi), (), "level")]),
    (THREE_LINK.sized(150.0, 150.0, 80.0), (80.0, 0.0, 0.0), (0.4, 0.0, 0.0),
     [("elbow up", (0.4, math.pi, math.pi - 0.4), ("theta1",), FOLDED)]),
    (CYLINDRICAL, (0.0, 0.0, 90.0), (0.6, 0.0, 0.0),
     [("reaching forward", (0.6, 90.0, 0.0), ("theta",), ON_AXIS)]),
    (SPHERICAL, (0.0, 0.0, 0.0), (0.6, 0.2, 9.0),
     [("reaching forward", (0.6, 0.2, 0.0), ("phi", "theta"), "drawn in")]),
    (SPHERICAL, (0.0, 0.0, 50.0), (0.6, 0.2, 9.0),
     [("reaching forward", (0.6, math.pi / 2, 50.0), ("phi",), ON_AXIS),
      ("reaching backward", (0.6, -math.pi / 2, -50.0), ("phi",), ON_AXIS)]),
    (REVOLUTE.sized(200.0, 180.0, 140.0), (0.0, 0.0, 420.0), (0.6, 0.0, 0.0),
     [("base front, elbow up", (0.6, -BENT_S, BENT_E), ("theta1",), ON_AXIS),
      ("base front, elbow down", (0.6, BENT_S, -BENT_E), ("theta1",), ON_AXIS)]),
    (REVOLUTE.sized(200.0, 180.0, 140.0), (0.0, 0.0, 520.0), None,
     [("base front, elbow up", (0.0, 0.0, 0.0), ("theta1",), STRETCHED)]),
    (REVOLUTE.sized(200.0, 150.0, 150.0), (0.0, 0.0, 200.0), (0.6, 0.3, 0.0),
     [("base front, elbow up", (0.6, 0.3, math.pi), ("theta1", "theta2"), FOLDED)]),
]  # fmt: skip


@every_row("one, goal, seed, branches", DEGENERATE)
def test_a_degenerate_goal_is_named_and_its_free_joints_take_the_seed(one, goal, seed, branches):
    found = one.ik(goal, seed=seed)
    assert [(each.name, each.free) for each in found] == [
        (name, free) for name, _, free, _ in branches
    ]
    for each, (_, joints, _, words) in zip(found, branches, strict=True):
        assert same_joints(one, each.joints, joints, 1e-7)  # the root of rounding
        assert words in each.degenerate
        assert one.goal_of(one.fk(each.joints)) == pytest.approx(goal, abs=1e-7)


@EACH
def test_a_figure_with_the_lengths(one):
    figure = one.figure()
    assert all(f"{name} = {value:g} mm" in figure for name, value in one.lengths().items())
    assert len(figure.splitlines()) > 5
    assert max(map(len, figure.splitlines())) <= 79


def test_a_system_is_found_by_its_name_or_a_likely_one_is_suggested():
    assert system("puma") is SYSTEMS["puma"]
    with pytest.raises(UnknownSystem, match="did you mean 'spherical'"):
        system("sperical")
    with pytest.raises(UnknownSystem) as caught:
        system("0")
    assert caught.value.nearest is None
    assert "two-link-1" in str(caught.value)


@EACH
def test_another_size_of_a_build_keeps_its_laws(one):
    longer = one.sized(*(size + 20.0 for size in one.sizes))
    joints = tuple(0.3 if kind is JointKind.REVOLUTE else 50.0 for kind in one.chain().kinds)
    goal = longer.goal_of(longer.fk(joints))
    assert any(same_joints(one, branch.joints, joints) for branch in longer.ik(goal, joints))
    assert (longer == one) is (not one.sizes)


# The two-link manipulators in three ways, the notes' own matrices, and their workspaces.

UNEVEN = (
    TWO_LINK_1.sized(200.0, 150.0),
    TWO_LINK_1.sized(90.0, 90.0),
    TWO_LINK_2.sized(310.0, 120.0),
    TWO_LINK_3.sized(200.0, ranges=(ENDLESS, (0.0, 300.0))),
    TWO_LINK_3.sized(100.0, ranges=(ENDLESS, (50.0, 250.0))),
    TWO_LINK_4.sized(150.0, ranges=((0.0, 300.0), ENDLESS)),
    TWO_LINK_4.sized(80.0, ranges=((100.0, 120.0), ENDLESS)),
    TWO_LINK_5.sized(ranges=((10.0, 300.0), (20.0, 250.0))),
    CYLINDRICAL,
    SPHERICAL,
)
DEG = math.pi / 180.0


TIPS = {  # the trigonometric solutions of sections 5 to 8, and equations 2.28 to 2.30 and 2.33
    "two-link-1": lambda l1, l2, a, b: (
        l1 * math.cos(a) + l2 * math.cos(a + b), l1 * math.sin(a) + l2 * math.sin(a + b), 0.0
    ),
    "two-link-2": lambda d1, l2, a, b: (
        l2 * math.cos(a) * math.cos(b), l2 * math.sin(a) * math.cos(b), d1 + l2 * math.sin(b)
    ),
    "two-link-3": lambda d1, a, d2: (d2 * math.sin(a), -d2 * math.cos(a), d1),
    "two-link-4": lambda l2, d1, b: (l2 * math.cos(b), 0.0, d1 + l2 * math.sin(b)),
    "two-link-5": lambda d1, d2: (0.0, -d2, d1),
    "cylindrical": lambda theta, up, r: (r * math.cos(theta), r * math.sin(theta), up),
    "spherical": lambda phi, theta, r: (
        r * math.cos(theta) * math.cos(phi), r * math.cos(theta) * math.sin(phi),
        r * math.sin(theta),
    ),
}  # fmt: skip

ORIENTATIONS = {  # phi, theta and psi of section 8
    "two-link-1": lambda first, second: (first + second, 0.0, 0.0),
    "two-link-2": lambda first, second: (first, -second, 90 * DEG),
    "two-link-3": lambda first, _slide: (first, 0.0, 90 * DEG),
    "two-link-4": lambda _lift, second: (0.0, -second, 90 * DEG),
    "two-link-5": lambda _lift, _slide: (0.0, 0.0, 90 * DEG),
}


@pytest.mark.parametrize("one", UNEVEN, ids=lambda one: one.name)
@given(data=st.data())
def test_trigonometry_matrices_and_orientation_agree(one, data):
    joints = data.draw(postures(one))
    assert gap(position_of(one.fk(joints)), TIPS[one.name](*one.sizes, *joints)) < 1e-9
    if one.name not in ORIENTATIONS:
        return  # a transporter positions, and does not turn
    hand = RPY(*ORIENTATIONS[one.name](*joints)).rotation()
    assert gap(hand, rotation_of(one.fk(joints))) < 2e-12  # angles are rounded to quarter turns


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


# The five-axis arms.


def test_the_alpha_ii_stands_straight_on_in_its_home_position():
    drawn = (
        (0.0, 0.0, 1.0, 177.8 + 177.8 + 129.5),
        (0.0, -1.0, 0.0, 0.0),
        (1.0, 0.0, 0.0, 215.0),
        (0.0, 0.0, 0.0, 1.0),
    )
    assert gap(ALPHA_2.fk((0.0, 0.0, 0.0, -math.pi / 2.0, 0.0)), drawn) < 1e-9


FIVE = [one for one in SYSTEMS.values() if one.arm is not None]


@pytest.mark.parametrize("one", FIVE, ids=lambda one: one.name)
@given(data=st.data())
def test_five_axis_systems_are_the_driver_s_arms(one, data):
    joints = data.draw(postures(one))
    relative = Joints(relative_angles(one, joints))
    assert own_angles(one, relative_angles(one, joints)) == pytest.approx(joints)
    assert gap(one.fk(joints), forward_frame(relative.angles_rad, one.arm.lengths)) < 1e-9
    pose = one.arm.fk(relative)
    assert one.arm == preset(one.name.removesuffix("-lecture")).arm
    goal = (pose.x_mm, pose.y_mm, pose.z_mm, pose.pitch_rad, pose.roll_rad)
    ours = one.ik(goal)
    if any(branch.degenerate for branch in ours):
        return  # two names of one posture
    theirs = one.arm.branches(Pose(*goal))
    assert {(b.within_limits, b.name) for b in ours} == {(b.within_limits, b.name) for b in theirs}


# The Puma: eight branches of any lengths, its textbook posture, and every degenerate one.

HALF = math.pi / 2.0
SIMPLE = PUMA
_, _, _, UPPER, _, FORE, _ = SIMPLE.sizes


def solved(arm, frame, seed=None):
    return arm.ik(arm.goal_of(frame), seed)


def test_the_textbook_posture_of_fu_gonzalez_and_lee():
    posture = (HALF, 0.0, HALF, 0.0, 0.0, 0.0)
    printed = (
        (0.0, -1.0, 0.0, -149.09),
        (0.0, 0.0, 1.0, 921.12),
        (-1.0, 0.0, 0.0, 20.32),
        (0.0, 0.0, 0.0, 1.0),
    )
    assert gap(PUMA.sized(a3=-20.32).fk(posture), printed) < 1e-9
    assert gap(position_of(SIMPLE.fk(posture)), (-149.09, 921.12, 0.0)) < 1e-9


@given(postures(SIMPLE))
def test_the_names_say_where_base_elbow_and_wrist_are(joints):
    frame = SIMPLE.fk(joints)
    for branch in solved(SIMPLE, frame):
        if branch.degenerate:
            continue
        _, second, third, _, fifth, _ = branch.joints
        out = UPPER * math.cos(second) + FORE * math.sin(second + third)
        up = -UPPER * math.sin(second) + FORE * math.cos(second + third)
        # The elbow against the line from the shoulder to the wrist, seen outwards.
        above = (-UPPER * math.sin(second)) * out - UPPER * math.cos(second) * up
        assert ("base front" in branch.name) == (out > 0.0)
        assert ("elbow up" in branch.name) == (above * math.copysign(1.0, out) > 0.0)
        assert ("wrist plain" in branch.name) == (math.sin(fifth) > 0.0)


@every_row(
    "arm, joints, free, words",
    [
        (SIMPLE, (0.3, -0.5, 1.0, 0.5, 0.0, 0.2), ("theta4",), "joint 5 is straight"),
        (SIMPLE, (0.3, -0.5, HALF, 0.5, 0.8, 0.2), (), "elbow stretched"),
        (PUMA.sized(a2=500.0), (0.3, -0.5, -HALF, 0.5, 0.8, 0.2), (), "elbow folded"),
    ],
)
def test_degenerate_postures_say_what_they_lose(arm, joints, free, words):
    (found,) = [
        one for one in solved(arm, arm.fk(joints), joints) if same_joints(arm, one.joints, joints)
    ]
    assert words in found.degenerate
    assert found.free == free
