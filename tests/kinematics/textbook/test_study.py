"""Studying a model with no arm: postures against the textbook, steps against the Jacobian."""

import math
from pathlib import Path

import pytest
from amounts import every_row
from chain_cases import gap

from armdrive.config.link_model import read_model
from kinematics import preset
from kinematics.chains.arm import ChainArm
from kinematics.chains.chain import chain_of_rows
from kinematics.frames.rotations import determinant, multiply, transpose
from kinematics.frames.transforms import compose, position_of, rotation_of
from kinematics.textbook.pages import fixed, laid, sections, summary, symbol_sections
from kinematics.textbook.stepping import axes_of, axis_unit, has_inverse, step_axis, step_joint
from kinematics.textbook.study import (
    ROW_NAMES,
    chain_rows,
    example_posture,
    judged,
    named_singularities,
    named_subject,
    own_jacobian,
    own_rows,
    searched,
    study,
    subject_of_arm,
    subject_of_chain,
)
from kinematics.textbook.systems import MODEL_NAMES, SYSTEMS
from kinematics.textbook.worked_example import ExampleSection

EXAMPLES = Path(__file__).parents[3] / "examples"

SCARA = subject_of_chain(
    "scara",
    "A SCARA",
    "",
    chain_of_rows(
        [
            {"a_mm": 200.0, "low_deg": -150, "high_deg": 150},
            {"a_mm": 150.0, "alpha_deg": 180.0, "low_deg": -150, "high_deg": 150},
            {"kind": "prismatic", "low_mm": 0.0, "high_mm": 100.0},
            {"low_deg": -180, "high_deg": 180},
        ]
    ),
)


def read_subject(file):
    model = read_model(file)
    return subject_of_chain(model.name, model.title, model.source, model.chain)


def example(name):
    subject = named_subject(name)
    return subject, example_posture(subject.chain)


def text_of(of, width=60):
    return "\n".join(line for one in sections(of, width) for line in one.lines)


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


def test_the_study_of_the_two_link_arm_reads_as_section_7_prints_it():
    subject = named_subject("two-link-1")
    of = study(subject, (math.radians(30), math.radians(40)))
    c1, s12 = math.cos(math.radians(30)), math.sin(math.radians(70))
    x = 200 * c1 + 150 * math.cos(math.radians(70))
    text = text_of(of)
    assert "[ 0.866 -0.500 0.000 173.205 ]" in text
    assert fixed(s12) in text
    assert f"x {fixed(x)}" in text
    short = 350 - math.sqrt(200**2 + 150**2 + 2 * 200 * 150 * math.cos(math.radians(40)))
    assert f"40.0°, {short:.1f} mm away: elbow stretched" in text
    assert "> elbow down" in text
    assert "  elbow up" in text


def test_a_stretched_elbow_is_singular_in_the_summary():
    of = study(named_subject("two-link-1"), (0.3, 0.0))
    said = summary(of)
    assert said.startswith("manipulability 0.000, condition infinite: SINGULAR; singular 0.0°")
    assert of.conditioning == math.inf
    assert "singular: the tip cannot move along" in text_of(of, 200)


def test_a_jacobian_too_wide_is_shown_column_by_column():
    of = study(*example("minimover5"))
    narrow, wide = sections(of, 41), sections(of, 80)
    assert max(len(line) for one in narrow for line in one.lines) <= 46
    assert any("columns, a line each: x, y, z" in one.lines for one in narrow)
    assert any(line.startswith("pitch") for one in wide for line in one.lines)


def test_symbols_are_shown_where_numbers_were():
    of = study(*example("two-link-1"))
    text = "\n".join(line for one in symbol_sections(of, 60) for line in one.lines)
    assert "C1" in text
    assert "theta2 = " in text


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_step_along_each_axis_of_the_hand_goes_that_far_and_nowhere_else(name):
    subject, values = example(name)
    before = study(subject, values)
    for index, axis in enumerate(axes_of(subject)):
        by = -1.0 if axis_unit(axis) == "mm" else -0.01
        stepped = step_axis(subject, values, index, by)
        assert (stepped.message == "") == has_inverse(subject), (axis, stepped.message)
        after = study(subject, stepped.values)
        if has_inverse(subject):
            wanted = list(before.goal)
            wanted[index] += by
            assert after.goal == pytest.approx(wanted, abs=1e-6)
            assert after.branches[after.here].name == before.branches[before.here].name


def test_a_table_without_closed_form_follows_its_jacobian():
    assert axes_of(SCARA) == ("x", "y", "z", "about z")
    values = example_posture(SCARA.chain)
    x, y, z = position_of(SCARA.chain.fk(values))
    stepped = step_axis(SCARA, values, 0, -20.0)
    assert stepped.message == ""
    assert position_of(SCARA.chain.fk(stepped.values)) == pytest.approx((x - 20.0, y, z), abs=0.2)
    turned = step_axis(SCARA, values, 3, math.radians(10))
    assert turned.message == ""
    assert position_of(SCARA.chain.fk(turned.values)) == pytest.approx((x, y, z), abs=0.2)
    assert turned.values[3] - values[3] == pytest.approx(-math.radians(10), abs=1e-3)


@pytest.mark.parametrize("name", ["scara", "stanford"])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_hand_of_an_example_table_goes_along_every_axis_and_stays_beside_it(name, sense):
    subject = read_subject(EXAMPLES / f"{name}.toml")
    values = example_posture(subject.chain)
    x, y, z = position_of(subject.chain.fk(values))
    for index, axis in enumerate(axes_of(subject)):
        by = sense * (5.0 if axis_unit(axis) == "mm" else math.radians(5.0))
        stepped = step_axis(subject, values, index, by)
        assert stepped.message == "", axis
        wanted = [x, y, z]
        if axis in ("x", "y", "z"):
            wanted[index] += by
        assert position_of(subject.chain.fk(stepped.values)) == pytest.approx(wanted, abs=0.1)


def test_a_table_with_a_closed_form_has_all_its_solutions():
    table = subject_of_chain("six", "Six joints", "", SYSTEMS["puma"].chain())
    values = example_posture(table.chain)
    found = study(table, values)
    assert [branch.name for branch in found.branches] == [f"solution {n}" for n in range(1, 9)]
    assert found.branches[found.here].joints == pytest.approx(values)
    for branch in found.branches:
        assert gap(table.chain.fk(branch.joints), found.frame) < 1e-5
        assert branch.violations == table.chain.violations(branch.joints)
    text = text_of(found, 200)
    assert "class: spherical wrist: the last three axes meet in one point" in text
    assert "> solution" in text
    without = study(SCARA, example_posture(SCARA.chain))
    assert (without.branches, without.here) == ((), None)
    text = text_of(without, 200)
    assert "class: none: a joint slides, and the classes are of turning joints" in text
    assert "solved numerically, from many starts" in text


BENT = tuple(map(math.radians, (0, 40, -60, -89, 0)))
NOT_MADE = {
    # the subject and its posture, the step, and what is said
    "a table that is stretched": (
        SCARA, (0.0, 0.0, 50.0, 0.0), "x", 20.0, "no step along x from here: singular"),
    "a slide at its end": (
        SCARA, (0.2, 0.8, 100.0, 0.0), "z", -3.0,
        "no step along z from here: joint_3 at the limit; "),
    "a goal out of reach": (*example("two-link-1"), "x", 500.0, "out of reach: "),
    "a joint that would go beyond its limit": (
        named_subject("minimover5"), BENT, "pitch", math.radians(-5),
        "not within the limits on base front, elbow up: wrist_pitch 5.61° beyond its limit"),
}  # fmt: skip


@pytest.mark.parametrize("what", NOT_MADE)
def test_a_step_that_cannot_be_made_leaves_the_model_where_it_is_and_says_why(what):
    subject, values, axis, by, said = NOT_MADE[what]
    stepped = step_axis(subject, values, axes_of(subject).index(axis), by)
    assert stepped.values == values
    assert stepped.message.startswith(said)


def test_a_table_at_a_limit_names_the_joint_that_is_held():
    values = (0.2, 0.8, 98.0, 0.0)
    assert step_axis(SCARA, values, 2, 1.0).message == ""  # up: the slide draws in
    stepped = step_axis(SCARA, values, 2, -3.0)
    assert stepped.values[2] == pytest.approx(100.0)
    assert stepped.message == "joint_3 at the limit: z moved by -2 mm, not -3 mm"


def test_a_tip_that_keeps_to_a_sphere_goes_as_far_as_it_can():
    subject, values = example("two-link-2")
    before = position_of(subject.chain.fk(values))
    stepped = step_axis(subject, values, 0, 5.0)
    after = position_of(subject.chain.fk(stepped.values))
    assert stepped.message.startswith("the tip keeps to its surface: x moved by ")
    assert 2.5 < after[0] - before[0] < 5.0


def test_a_roll_that_turns_back_at_its_limit_is_no_singularity():
    subject = named_subject("minimover5")
    values = tuple(math.radians(one) for one in (0, 40, -60, -20, 358))
    stepped = step_axis(subject, values, axes_of(subject).index("roll"), math.radians(5))
    assert stepped.message.startswith("wrist_roll turned by 355° at once: its limit")


def test_the_singularity_of_a_table_is_found_by_searching():
    values = (0.2, 0.5, 50.0, 0.0)
    (found,) = searched(SCARA, values)
    assert found.distance_rad == pytest.approx(0.5, abs=1e-3)
    assert "28.6° away: singular" in "\n".join(
        line for one in sections(study(SCARA, values), 200, (found,)) for line in one.lines
    )
    assert "searching" in text_of(study(SCARA, values))


def test_a_joint_stops_at_its_limit_and_says_how_much_is_left():
    subject = named_subject("two-link-3")
    stepped = step_joint(subject, (0.0, 295.0), 1, 20.0)
    assert stepped.values == (0.0, 300.0)
    assert stepped.message == "d2 stands at its limit of 300 mm: 15 mm of the step are left"
    assert step_joint(subject, (0.0, 295.0), 0, 0.5).values == (0.5, 295.0)


def test_the_theory_of_an_arm_that_is_driven():
    arm = preset("teachmover").arm
    subject = subject_of_arm("bench", arm)
    assert subject.system.arm is arm
    chain = SYSTEMS["puma"].chain()
    assert subject_of_arm("six", ChainArm(chain)).system is None
    assert ROW_NAMES[subject.rows[3]] == "pitch"


def test_columns_hold_every_line_in_order_and_none_is_too_high():
    parts = [
        ExampleSection(f"part {n}", tuple(f"{n}.{i}" for i in range(n))) for n in (3, 9, 2, 30, 1)
    ]
    columns = laid(parts, 20, 12)
    assert all(len(column) <= 12 for column in columns)
    lines = [line for column in columns for line in column]
    assert [line for line in lines if "." in line] == [one for p in parts for one in p.lines]
    assert columns[1][0].startswith("── part 9 ───")
    assert laid(parts, 20, 12, plain=True)[0][0] == "-- part 3 ----------"


# Jacobians in a system's own coordinates, and the singularities that have names.


STEP = 1e-6
NAMES = list(SYSTEMS)


def condition_at(system, values):
    return judged(system.chain(), own_jacobian(system, values), own_rows(system))


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


@pytest.mark.parametrize(
    ("name", "values", "product"),
    [
        ("two-link-1", (30, 40), lambda q: 200 * 150 * math.sin(q[1])),
        ("three-link", (10, 20, 30), lambda q: 200 * 150 * math.sin(q[1])),
        ("two-link-4", (100, 30), lambda q: 150 * math.sin(q[1])),
    ],
)
def test_the_determinant_is_the_textbooks(name, values, product):
    system = SYSTEMS[name]
    joints = tuple(
        math.radians(one) if kind.unit == "rad" else float(one)
        for one, kind in zip(values, system.chain().kinds, strict=True)
    )
    rows = own_jacobian(system, joints)
    (a, b), (c, d) = rows[0][:2], rows[1][:2]
    size = determinant(rows) if len(rows) == 3 else a * d - b * c
    lengths = system.lengths()
    assert set(lengths.values()) <= {200.0, 150.0, 80.0}
    assert abs(size) == pytest.approx(abs(product(joints)))


AT = {
    "two-link-1": [(0.3, 0.0), (0.3, math.pi)],
    "two-link-2": [(0.3, math.pi / 2)],
    "two-link-3": [(0.3, 0.0)],
    "two-link-4": [(100.0, math.pi)],
    "three-link": [(0.3, 0.0, 0.5), (0.3, math.pi, 0.5)],
    "cylindrical": [(0.3, 100.0, 0.0)],
    "spherical": [(0.3, math.pi / 2, 100.0), (0.3, 0.4, 0.0)],
    "revolute": [(0.3, 0.4, 0.0), (0.3, 0.4, math.pi), (0.3, 0.0, 0.0)],
    "minimover5": [(0.3, 0.4, -math.pi, 0.2, 0.1), (0.3, 0.4, 0.0, 0.2, 0.1)],
    "alpha2-lecture": [(0.3, 0.4, math.pi, 0.2, 0.1), (0.3, 0.4, 0.0, 0.2, 0.1)],
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
    if name in ("minimover5", "alpha2-lecture"):
        index = ("folded", "straight")[index]
        lost = next(one for one in named_singularities(system, values) if index in one.reason)
    else:
        lost = named_singularities(system, values)[index]
    away = lost.distance_mm if lost.distance_rad is None else lost.distance_rad
    assert away == pytest.approx(0.0, abs=1e-9)
    assert condition_at(system, values).smallest < 1e-7


@every_row("name", NAMES)
def test_away_from_them_nothing_is_lost(name):
    system = SYSTEMS[name]
    here = example_posture(system.chain())
    found = named_singularities(system, here)
    assert not condition_at(system, here).is_singular
    for one in found:
        assert (one.distance_mm if one.distance_rad is None else one.distance_rad) > 1e-3
    assert bool(found) == (name not in ("two-link-5", "cartesian"))


def test_a_puma_over_its_base_is_singular_too():
    puma = SYSTEMS["puma"]
    # with the forearm hanging back over the shoulder: a2 cos(t2) + d4 sin(t2 + t3) = 0
    second = 0.4
    upper, forearm = puma.lengths()["a2"], puma.lengths()["d4"]
    third = math.asin(-upper * math.cos(second) / forearm) - second
    values = (0.3, second, third, 0.5, 0.6, 0.7)
    assert named_singularities(puma, values)[3].distance_mm == pytest.approx(0.0, abs=1e-9)
    assert condition_at(puma, values).smallest < 1e-7


def test_a_five_axis_arm_over_its_base_says_what_it_cannot_do():
    system = SYSTEMS["minimover5"]
    goal = (0.0, 0.0, 450.0, 0.3, 0.0)
    posture = system.ik(goal)[0].joints
    found = condition_at(system, posture)
    assert found.is_singular
    assert "moving base" in found.sentence


def test_a_planar_table_is_judged_in_its_plane():
    planar = chain_of_rows([{"a_mm": 200.0}, {"a_mm": 150.0}, {"a_mm": 80.0}])
    assert chain_rows(planar) == (0, 1)
    assert chain_rows(SCARA.chain) == (0, 1, 2, 5)
