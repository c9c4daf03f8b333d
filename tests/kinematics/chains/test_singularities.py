"""Singularities: found, and said in words."""

import math

import numpy as np
import pytest
from amounts import every_row
from chain_cases import PUMA, chains_and_values, columns_by_differences, gap
from hypothesis import assume, given
from kinematics_cases import arm_and_posture

from kinematics.chains.chain import Chain
from kinematics.chains.evaluation import evaluator
from kinematics.chains.jacobians import (
    SINGULAR,
    condition,
    in_words,
)
from kinematics.chains.links import DHLink
from kinematics.textbook.study import named_singularities, own_jacobian
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.systems.mini_movers import (
    ELBOW_STRAIGHT,
    TIP_OVER_BASE,
    with_arm,
)


def task_jacobian(arm, joints):
    return own_jacobian(with_arm(SYSTEMS["minimover5"], arm), joints.angles_rad)


TWO_LINK = Chain((DHLink(a_mm=200.0), DHLink(a_mm=100.0)))


def test_a_puma_s_straight_wrist_is_named_by_the_joints_that_oppose_each_other():
    found = condition(PUMA, (0.1, 0.2, -0.3, 0.4, 0.0, 0.6))
    assert found.is_singular
    assert found.smallest < SINGULAR
    assert found.manipulability == pytest.approx(0.0, abs=1e-9)
    assert "moving 0.71 joint 4 - 0.71 joint 6 leaves the tip at rest" in found.sentence
    assert found.sentence.startswith("singular: the tip cannot")


@every_row(
    "elbow, words",
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
    size = math.prod(np.linalg.svd(task_jacobian(arm, joints), compute_uv=False))
    found = singularities(arm, joints)
    radius, bend = found[TIP_OVER_BASE].distance_mm, found[ELBOW_STRAIGHT].distance_rad
    expected = radius * arm.upper_arm_mm * arm.forearm_mm * math.sin(bend)
    assert size == pytest.approx(expected, rel=1e-6, abs=1e-1)


# Jacobians against small moves.


@given(chains_and_values(most=6))
def test_the_geometric_jacobian_is_what_small_moves_do(case):
    chain, values = case
    columns = list(zip(*evaluator(chain).jacobian(values), strict=True))
    assert gap(columns, columns_by_differences(chain, values)) < 1e-4


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
    assert gap(list(zip(*task_jacobian(arm, joints), strict=True)), columns) < 1e-4
