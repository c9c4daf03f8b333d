"""Singularities: found, said in words, and how far away the nearest one is."""

import math

import numpy as np
import pytest
from amounts import every_row
from chain_cases import MINI_MOVER, PUMA, chains_and_values, columns_by_differences, gap
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from kinematics_cases import TEACHMOVER, arm_and_posture

from kinematics import Joints, KinematicsError
from kinematics.chains.chain import Chain
from kinematics.chains.generated import generated
from kinematics.chains.jacobians import (
    DAMPED_BELOW,
    SINGULAR,
    condition,
    dimensionless,
    geometric_jacobian,
    in_words,
    joint_rates,
    length_of,
    manipulability,
    nearest_singularity,
)
from kinematics.chains.links import DHLink, JointKind
from kinematics.five_axis.rates import task_jacobian
from kinematics.frames.matrices import singular, transposed
from kinematics.textbook.study import named_singularities, study, subject_of_system
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.systems.mini_movers import (
    ELBOW_FOLDED,
    ELBOW_STRAIGHT,
    TIP_OVER_BASE,
    with_arm,
)

TWO_LINK = Chain((DHLink(a_mm=200.0), DHLink(a_mm=100.0)))


def test_a_puma_s_straight_wrist_is_named_by_the_joints_that_oppose_each_other():
    found = condition(PUMA, (0.1, 0.2, -0.3, 0.4, 0.0, 0.6))
    assert found.is_singular
    assert found.smallest < SINGULAR
    assert found.manipulability == pytest.approx(0.0, abs=1e-9)
    assert "moving 0.71 joint 4 - 0.71 joint 6 leaves the tip at rest" in found.sentence
    assert found.sentence.startswith("singular: the tip cannot")


def test_a_stretched_two_link_arm_cannot_move_outwards():
    found = condition(TWO_LINK, (math.pi / 2, 0.0), rows=(0, 1))
    assert "the tip cannot move along y" in found.sentence
    assert [abs(part) for part in found.hardest] == pytest.approx([0.0, 1.0], abs=1e-12)


@pytest.mark.parametrize(
    ("elbow", "words"),
    [
        (1.5, ("smallest singular value", "is slowest to move", "moves it least")),
        (0.01, ("smallest singular value", "can hardly move", "leaves the tip almost at rest")),
        (0.0, ("singular: ", "cannot move", "leaves the tip at rest")),
    ],
)
def test_only_a_posture_near_a_singular_one_is_said_to_move_hardly(elbow, words):
    found = condition(TWO_LINK, (0.2, elbow), rows=(0, 1))
    assert found.is_singular == (elbow == 0.0)
    for word in words:
        assert word in found.sentence


@pytest.mark.parametrize("name", ["two-link-5", "cartesian"])
def test_an_arm_of_slides_at_right_angles_has_no_hardest_direction(name):
    system = SYSTEMS[name]
    found = study(subject_of_system(system), (50.0,) * len(system.joint_names)).condition
    assert found.sentence == "the tip moves as easily in every direction: all singular values are 1"


@given(st.floats(-3.0, 3.0), st.floats(-1.5, 1.5))
def test_the_nearest_singularity_of_two_links_is_the_straight_elbow(base, elbow):
    found = nearest_singularity(TWO_LINK, (base, elbow))
    assert found is not None
    assert found.distance == pytest.approx(abs(elbow), abs=1e-6)
    assert found.condition.is_singular


@pytest.mark.parametrize("bend", [0.05, -0.3])
def test_the_nearest_singularity_of_a_puma_is_the_wrist_when_it_is_nearly_straight(bend):
    found = nearest_singularity(PUMA, (0.1, 0.9, -0.4, 0.4, bend, 0.6))
    assert found.distance <= abs(bend) + 1e-6
    assert found.condition.is_singular


def test_a_straight_elbow_of_the_mini_mover_is_found():
    found = nearest_singularity(MINI_MOVER, (0.1, 0.5, -0.3, -0.2, 0.2))
    assert found.distance == pytest.approx(0.3, abs=1e-6)
    assert "0.82 elbow" in found.condition.sentence


@settings(max_examples=15)
@given(chains_and_values(most=4))
def test_what_is_found_is_singular_and_as_far_as_said(case):
    chain, values = case
    found = nearest_singularity(chain, values)
    if found is None:
        return
    assert found.condition.smallest < 10 * SINGULAR
    units = [length_of(chain) if kind is JointKind.PRISMATIC else 1.0 for kind in chain.kinds]
    moved = [(a - b) / u for a, b, u in zip(found.values, values, units, strict=True)]
    assert found.distance == pytest.approx(math.hypot(*moved), abs=1e-9)


def test_slides_alone_are_never_singular():
    cartesian = SYSTEMS["cartesian"].chain()
    assert condition(cartesian, (10.0, 20.0, 30.0)).smallest == pytest.approx(1.0)
    assert nearest_singularity(cartesian, (10.0, 20.0, 30.0)) is None


def test_a_direction_in_words():
    assert in_words((0.0, 0.0, 1.0, 0.0, 0.0, 0.0), range(6)) == "move along z"
    assert in_words((-0.6, 0.8), (0, 3)) == "move along x and turn about x"
    assert in_words((0.6, 0.0, -0.8), (0, 1, 2)) == "move along 0.60 x - 0.80 z"


def singularities(arm, joints):
    """Return by their words the ways in which an arm of the Mini-mover's build is singular."""
    found = named_singularities(with_arm(SYSTEMS["minimover5"], arm), joints)
    return {one.reason: one for one in found}


@given(arm_and_posture)
def test_the_singularities_are_where_the_task_jacobian_loses_a_rank(case):
    arm, joints = case
    size = manipulability(task_jacobian(arm, joints))
    found = singularities(arm, joints)
    radius, bend = found[TIP_OVER_BASE].distance_mm, found[ELBOW_STRAIGHT].distance_rad
    expected = radius * arm.upper_arm_mm * arm.forearm_mm * math.sin(bend)
    assert size == pytest.approx(expected, rel=1e-6, abs=1e-1)


def test_the_zero_posture_is_stretched():
    found = singularities(TEACHMOVER, Joints.of(0, 0, 0, 0, 0))
    nearest = min(found.values(), key=lambda one: one.distance_rad)
    assert nearest.reason == ELBOW_STRAIGHT
    assert nearest.distance_rad == 0.0
    assert nearest.distance_mm == pytest.approx(0.0, abs=1e-9)


def test_a_folded_elbow_is_half_a_turn_from_a_straight_one():
    joints = Joints.of(0, 90, -140, 0, 0)
    found = singularities(TEACHMOVER, joints)
    straight, folded = found[ELBOW_STRAIGHT], found[ELBOW_FOLDED]
    assert straight.distance_rad + folded.distance_rad == pytest.approx(math.pi)
    assert straight.distance_mm + folded.distance_mm == pytest.approx(2 * 177.8)


@given(arm_and_posture)
def test_the_way_over_the_base_is_no_longer_than_the_shoulder_s(case):
    arm, joints = case
    over = singularities(arm, joints)[TIP_OVER_BASE]
    pose = arm.fk(joints)
    height = pose.z_mm - arm.base_height_mm
    alone = math.atan2(math.hypot(pose.x_mm, pose.y_mm), abs(height))
    assert over.distance_rad <= alone + 1e-9
    slope = arm.upper_arm_mm + 2 * arm.forearm_mm + 3 * arm.hand_mm  # no move is worth more
    assert over.distance_rad * slope >= over.distance_mm - 1e-6


def test_a_nearly_flat_slope_leads_nowhere():
    stretched = Joints.of(0.0, 1e-7, -2e-7, 1e-7, 0.0)
    over = singularities(TEACHMOVER, stretched)[TIP_OVER_BASE]
    assert over.distance_rad == pytest.approx(math.pi / 2, abs=1e-3)


# Jacobians against small moves, joint rates with damping, singular values without numpy.


@given(chains_and_values(most=6))
def test_the_geometric_jacobian_is_what_small_moves_do(case):
    chain, values = case
    columns = transposed(geometric_jacobian(chain, values))
    assert gap(columns, columns_by_differences(chain, values)) < 1e-4


@given(chains_and_values())
def test_the_generated_jacobian_is_the_geometric_one(case):
    chain, values = case
    made = generated(chain).jacobian(values)
    assert gap(made, geometric_jacobian(chain, values)) < 1e-8


def wrapped(angle):
    return math.remainder(angle, math.tau)


@given(arm_and_posture)
def test_the_task_jacobian_is_the_derivative_of_the_pose(case):
    arm, joints = case
    pose = arm.fk(joints)
    assume(math.hypot(pose.x_mm, pose.y_mm) > 1.0)
    columns = []
    for name in joints.names:
        ends = [arm.fk(joints.replace(**{name: joints[name] + step})) for step in (1e-5, -1e-5)]
        columns.append(
            [(getattr(ends[0], f"{axis}_mm") - getattr(ends[1], f"{axis}_mm")) / 2e-5
             for axis in "xyz"]
            + [wrapped(getattr(ends[0], f"{turn}_rad") - getattr(ends[1], f"{turn}_rad")) / 2e-5
               for turn in ("pitch", "roll")]
        )  # fmt: skip
    assert gap(transposed(task_jacobian(arm, joints)), columns) < 1e-4


matrices = st.tuples(st.integers(1, 6), st.integers(1, 6)).flatmap(
    lambda size: st.lists(
        st.lists(
            st.sampled_from([0.0, 1.0, -2.0, 1e-7, 300.0]), min_size=size[1], max_size=size[1]
        ).map(tuple),
        min_size=size[0],
        max_size=size[0],
    ).map(tuple)
)


@given(matrices)
def test_singular_values_are_those_of_numpy(matrix):
    parts = singular(matrix)
    expected = np.linalg.svd(np.array(matrix), compute_uv=False)
    assert parts.values == pytest.approx(tuple(expected), rel=1e-9, abs=1e-9)


@given(matrices)
def test_the_singular_parts_make_up_the_matrix(matrix):
    parts = singular(matrix)
    rebuilt = sum(
        value * np.outer(left, right)
        for value, left, right in zip(parts.values, parts.left, parts.right, strict=True)
    )
    assert np.abs(rebuilt - np.array(matrix)).max() < 1e-9


def test_small_singular_values_keep_their_digits():
    matrix = tuple(tuple(1.0 / (row + column + 1) for column in range(6)) for row in range(6))
    assert singular(matrix).values[-1] == pytest.approx(1.082799484566e-07, rel=1e-9)  # Hilbert


def test_mm_are_counted_in_a_length():
    rows = ((200.0, 1.0), (0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    kinds = (JointKind.REVOLUTE, JointKind.PRISMATIC)
    assert dimensionless(rows, 100.0, kinds)[0] == (2.0, 1.0)
    assert dimensionless(rows, 100.0, kinds)[3] == (1.0, 0.0)
    assert dimensionless(rows, 100.0)[0] == (2.0, 0.01)


rates_of_six = st.tuples(*[st.floats(-200.0, 200.0)] * 3, *[st.floats(-2.0, 2.0)] * 3)
postures_of_six = st.tuples(*[st.floats(-3.0, 3.0)] * 6)


@given(postures_of_six, rates_of_six)
def test_rates_are_exact_away_from_singularities_and_bounded_at_them(values, wanted):
    length = PUMA.longest_reach_mm
    found = joint_rates(generated(PUMA).jacobian(values), wanted, length_mm=length)
    size = math.hypot(*(rate / length for rate in wanted[:3]), *wanted[3:])
    assert math.hypot(*found.joints) <= size / DAMPED_BELOW + 1e-9
    assert found.damped == (found.smallest < DAMPED_BELOW)
    if not found.damped:
        assert max(map(abs, found.missed)) < 1e-9 * max(1.0, size) * length
    total = [a + m for a, m in zip(found.achieved, found.missed, strict=True)]
    assert total == pytest.approx(wanted, abs=1e-9)


def test_a_straight_elbow_damps_only_the_direction_that_is_lost():
    two_link = generated(Chain((DHLink(a_mm=200.0), DHLink(a_mm=100.0))))
    stretched = two_link.jacobian((0.0, 0.0))[:2]
    along_and_across = joint_rates(stretched, (30.0, 60.0), length_mm=300.0)
    assert along_and_across.damped
    assert along_and_across.achieved == pytest.approx((0.0, 60.0), abs=1e-9)
    assert along_and_across.missed == pytest.approx((30.0, 0.0), abs=1e-9)


@given(postures_of_six, rates_of_six, st.floats(1e-6, 1e-4))
def test_damping_sets_in_continuously(values, wanted, step):
    jacobian = generated(PUMA).jacobian(values)
    smallest = joint_rates(jacobian, wanted, length_mm=1000.0).smallest
    assume(smallest > 1e-3)
    below, above = (
        joint_rates(jacobian, wanted, length_mm=1000.0, threshold=smallest * (1.0 + sign * step))
        for sign in (1, -1)
    )
    assert below.damped
    assert not above.damped
    change = math.dist(below.joints, above.joints)
    assert change <= 3.0 * step * math.hypot(*above.joints) + 1e-12


def test_five_axes_miss_what_they_have_no_axis_for():
    jacobian = generated(MINI_MOVER).jacobian((0.0, 0.6, -1.0, 0.2, 0.0))
    found = joint_rates(jacobian, (0, 0, 0, 1.0, 0, 0.0), length_mm=450.0)
    assert math.hypot(*found.missed) > 0.01
    assert not found.damped or found.smallest < DAMPED_BELOW


@every_row(
    "rates, options, message",
    [
        ((1.0,), {}, "6 tip rates are needed, not 1"),
        ((0.0,) * 6, {"length_mm": 0.0}, "length_mm must be more than 0"),
        ((0.0,) * 6, {"threshold": -1.0}, "threshold must be more than 0"),
        ((math.nan,) * 6, {}, "a tip rate must be a finite number"),
    ],
)
def test_rates_that_make_no_sense_are_refused(rates, options, message):
    jacobian = generated(PUMA).jacobian((0.1,) * 6)
    with pytest.raises(KinematicsError, match=message):
        joint_rates(jacobian, rates, **{"length_mm": 900.0, **options})
