"""The laws that every named system of the textbook keeps."""

import math

import pytest
from amounts import every_row
from chain_cases import gap
from hypothesis import given
from hypothesis import strategies as st
from kinematics_cases import Dual
from systems_cases import postures, same_goal, same_joints

from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError, OutOfReach, UnknownSystem
from kinematics.frames.transforms import position_of
from kinematics.textbook.systems import (
    CYLINDRICAL,
    REVOLUTE,
    SPHERICAL,
    SYSTEMS,
    THREE_LINK,
    TWO_LINK_1,
    TWO_LINK_2,
    TWO_LINK_3,
    TWO_LINK_4,
    system,
)

EACH = pytest.mark.parametrize("one", SYSTEMS.values(), ids=SYSTEMS)


@EACH
@given(data=st.data())
def test_the_formulas_undo_the_link_table(one, data):
    joints = data.draw(postures(one))
    tip = one.fk(joints)
    assert_every_branch_meets_the_goal(one, tip)
    assert_the_posture_is_among_the_branches(one, tip, joints)
    assert_numbers_that_cannot_be_compared_give_the_same(one, tip, joints)


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


def values_of(numbers):
    return tuple(Dual.of(number).value for number in numbers)


def assert_numbers_that_cannot_be_compared_give_the_same(one, tip, joints):
    seen = one.fk([Dual(value) for value in joints])
    assert gap([values_of(row) for row in seen], list(tip)) < 1e-9
    goal = one.goal_of(tip)
    for name in one.signs:
        plain = one.solution(goal, name)
        other = one.solution([Dual(value) for value in goal], name)
        assert same_joints(one, values_of(other.joints), plain.joints)
        assert [q.symbol for q in other.workings] == [q.symbol for q in plain.workings]


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


@EACH
def test_the_derivation_tells_forward_and_inverse(one):
    derivation = one.notes.derivation
    assert len(derivation) >= 2
    assert all(step.title and step.formula for step in derivation)
    text = " ".join(step.formula for step in derivation)
    assert any(name in text for name in (one.joint_names[0], "theta1", "d1"))
    assert one.notes.source
    assert one.name in SYSTEMS


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
    with pytest.raises(KinematicsError, match=f"the lengths of {one.name} are"):
        one.sized(height=3.0)
    with pytest.raises(KinematicsError, match=f"the lengths of {one.name} are"):
        one.sized(*one.sizes, 1.0)
