"""Studying a model with no arm: postures and steps against the textbook."""

import math
from pathlib import Path

import pytest
from amounts import every_row
from chain_cases import gap

from armdrive.config.link_model import read_model
from kinematics.chains.chain import Chain
from kinematics.chains.jacobians import condition_of
from kinematics.chains.links import DHLink, JointKind
from kinematics.frames.rotations import multiply, transpose
from kinematics.frames.transforms import compose, position_of, rotation_of
from kinematics.textbook.stepping import coordinates_of, step_axis, step_joint
from kinematics.textbook.study import (
    example_posture,
    named_singularities,
    own_jacobian,
    own_rows,
    study,
    subject_of_chain,
    subject_of_system,
)
from kinematics.textbook.systems import MODEL_NAMES, SYSTEMS, system
from kinematics.textbook.systems.named import frame_coordinates

EXAMPLES = Path(__file__).parents[3] / "examples"

SCARA = subject_of_chain(
    "scara",
    "A SCARA",
    "",
    Chain(
        (
            DHLink(a_mm=200.0, low=-2.6, high=2.6),
            DHLink(a_mm=150.0, alpha_rad=math.pi, low=-2.6, high=2.6),
            DHLink(kind=JointKind.PRISMATIC, low=0.0, high=100.0),
            DHLink(low=-math.pi, high=math.pi),
        )
    ),
)


def read_subject(file):
    model = read_model(file)
    return subject_of_chain(model.name, model.title, model.source, model.chain)


def example(name):
    subject = subject_of_system(system(name))
    return subject, example_posture(subject.chain)


@every_row("name", MODEL_NAMES)
def test_every_name_has_its_matrices_their_product_and_the_posture_among_its_solutions(name):
    subject, values = example(name)
    found, chain = study(subject, values), subject.chain
    assert len(found.matrices) == len(chain) == len(found.jacobian[0])
    assert not found.violations
    assert gap(found.frame, subject.system.fk(values)) < 1e-9
    assert gap(found.frame, compose(chain.base, *found.matrices, chain.tool)) < 1e-9
    assert found.branches[found.here].joints == pytest.approx(values)
    for branch in found.branches:
        assert found.comes_to(branch) == pytest.approx(found.goal, abs=1e-9)


SUBJECTS = {name: example(name)[0] for name in MODEL_NAMES} | {
    "a table with a closed form": subject_of_chain("six", "", "", SYSTEMS["puma"].chain()),
    **{name: read_subject(EXAMPLES / f"{name}.toml") for name in ("scara", "stanford")},
}


def goal_at(subject, values):
    found = study(subject, values)
    return found.goal or frame_coordinates(found.frame)[: len(coordinates_of(subject))]


@every_row("name", [name for name in SUBJECTS if name != "two-link-2"])
@every_row("sense", [1.0, -1.0])
def test_a_step_along_each_axis_of_the_hand_goes_that_far_and_nowhere_else(name, sense):
    subject = SUBJECTS[name]
    values = example_posture(subject.chain)
    before = study(subject, values)
    for index, coordinate in enumerate(coordinates_of(subject)):
        by = sense * (1.0 if coordinate.endswith("_mm") else 0.01)
        stepped = step_axis(subject, values, index, by)
        assert stepped.message == "", coordinate
        wanted = list(goal_at(subject, values))
        wanted[index] += by
        assert goal_at(subject, stepped.values) == pytest.approx(wanted, abs=1e-4)
        after = study(subject, stepped.values)
        if subject.system is not None:
            assert after.branches[after.here].name == before.branches[before.here].name


BENT = tuple(map(math.radians, (0, 40, -60, -89, 0)))
NOT_MADE = {
    # the subject and its posture, the step, and what is said
    "a table that is stretched": (
        SCARA, (0.0, 0.0, 50.0, 0.0), "x_mm", 20.0, "missed: position by 20 mm"),
    "a slide at its end": (
        SCARA, (0.2, 0.8, 100.0, 0.0), "z_mm", -3.0,
        "missed: position by 3 mm; without the joint limits the goal is met"),
    "a goal out of reach": (*example("two-link-1"), "x_mm", 500.0, "out of reach: "),
    "a joint that would go beyond its limit": (
        SUBJECTS["minimover5"], BENT, "pitch_rad", math.radians(-5),
        "not within the limits on base front, elbow up: wrist pitch 5.6° beyond its limit"),
}  # fmt: skip


@every_row("what", NOT_MADE)
def test_a_step_that_cannot_be_made_leaves_the_model_where_it_is_and_says_why(what):
    subject, values, axis, by, said = NOT_MADE[what]
    stepped = step_axis(subject, values, coordinates_of(subject).index(axis), by)
    assert stepped.values == values
    assert stepped.message.startswith(said)


def test_a_tip_that_keeps_to_a_sphere_goes_as_far_as_it_can():
    subject, values = example("two-link-2")
    before = position_of(subject.chain.fk(values))
    stepped = step_axis(subject, values, 0, 5.0)
    after = position_of(subject.chain.fk(stepped.values))
    assert stepped.message.startswith("the tip keeps to its surface, ")
    assert 1.0 < after[0] - before[0] < 5.0


def test_a_joint_stops_at_its_limit_and_says_how_much_is_left():
    subject = SUBJECTS["two-link-3"]
    stepped = step_joint(subject, (0.0, 295.0), 1, 20.0)
    assert stepped.values == (0.0, 300.0)
    assert stepped.message == "d2 stands at its limit of 300 mm: 15 mm of the step are left"
    assert step_joint(subject, (0.0, 295.0), 0, 0.5).values == (0.5, 295.0)


# Jacobians in a system's own coordinates, and the singularities that have names.


STEP = 1e-6
NAMES = list(SYSTEMS)


def condition_at(system, values):
    return condition_of(system.chain(), own_jacobian(system, values), own_rows(system))


def turned(system, one, other):
    """Return the small turn from one posture's hand to another's, about x, y and z."""
    by = multiply(rotation_of(system.fk(other)), transpose(rotation_of(system.fk(one))))
    return by[2][1], by[0][2], by[1][0]


@every_row("name", NAMES)
def test_the_jacobian_is_what_a_small_move_of_each_joint_does(name):
    system = SYSTEMS[name]
    here = example_posture(system.chain())
    columns = zip(*own_jacobian(system, here), strict=True)
    for joint, column in enumerate(columns):
        after, before = list(here), list(here)
        after[joint] += STEP
        before[joint] -= STEP
        ends = [system.goal_of(system.fk(tuple(one))) for one in (before, after)]
        done = [(b - a) / (2 * STEP) for a, b in zip(*ends, strict=True)]
        if name == "puma":  # its angles are no rates of turning
            done[3:] = [part / (2 * STEP) for part in turned(system, before, after)]
        assert column == pytest.approx(done, abs=2e-6 * max(1.0, *map(abs, done)))


AT = {
    "two-link-1": [(0.3, 0.0), (0.3, math.pi)],
    "two-link-2": [(0.3, math.pi / 2)],
    "two-link-3": [(0.3, 0.0)],
    "two-link-4": [(100.0, math.pi)],
    "three-link": [(0.3, 0.0, 0.5), (0.3, math.pi, 0.5)],
    "cylindrical": [(0.3, 100.0, 0.0)],
    "spherical": [(0.3, math.pi / 2, 100.0), (0.3, 0.4, 0.0)],
    "revolute": [(0.3, 0.4, 0.0), (0.3, 0.4, math.pi), (0.3, 0.0, 0.0)],
    "puma": [
        (0.3, 0.4, math.pi / 2, 0.5, 0.6, 0.7),
        (0.3, 0.4, -math.pi / 2, 0.5, 0.6, 0.7),
        (0.3, 0.4, 0.5, 0.5, 0.0, 0.7),
    ],
}
"""Postures that stand in the singularities of each system, in the order that they are listed."""


@every_row("name, index", [(n, i) for n, at in AT.items() for i in range(len(at))])
def test_where_a_named_singularity_is_the_jacobian_loses_a_rank(name, index):
    system, values = SYSTEMS[name], AT[name][index]
    lost = named_singularities(system, values)[index]
    away = lost.distance_mm if lost.distance_rad is None else lost.distance_rad
    assert away == pytest.approx(0.0, abs=1e-9)
    assert condition_at(system, values).smallest < 1e-7
