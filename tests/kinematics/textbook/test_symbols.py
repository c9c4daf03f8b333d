"""Symbols: their value is what the same code gives on numbers, and they read as the notes do."""

import math
import operator

import pytest
from amounts import amount, every_row
from hypothesis import given, settings
from hypothesis import strategies as st
from systems_cases import symbolic_example_of, symbols_gap

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink, JointKind, a_matrix
from kinematics.frames import numbers
from kinematics.frames.rotations import multiply, rot_x, rot_y, rot_z
from kinematics.frames.transforms import compose
from kinematics.textbook.notation import (
    LATEX,
    PLAIN,
    definitions,
    matrix_text,
)
from kinematics.textbook.symbols import ONE, ZERO, as_symbol, coordinate, named
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.worked_example import (
    joint_symbols,
    symbolic_chain,
    symbolic_goal,
    symbolic_system,
)

QUARTER = math.pi / 2
NAMES = ("theta1", "theta2", "theta3", "l1", "l2")
THETA1, THETA2, THETA3, L1, L2 = map(named, NAMES)

values = st.fixed_dictionaries({name: st.floats(-3.0, 3.0) for name in NAMES})


def leaves():
    constants = st.sampled_from([0.0, 1.0, -1.0, 2.0, 0.5, QUARTER, -QUARTER, math.pi])
    return st.sampled_from(NAMES) | constants


def calculations():
    """Calculations as trees: an operator and what it works on."""
    return st.recursive(
        leaves(),
        lambda inner: (
            st.tuples(st.sampled_from(["add", "sub", "mul"]), inner, inner)
            | st.tuples(st.sampled_from(["cos", "sin", "neg", "root", "size", "arc"]), inner)
        ),
        max_leaves=12,
    )


def run(tree, of_name):
    """Run a calculation on numbers of any kind."""
    match tree:
        case str():
            return of_name(tree)
        case float():
            return tree
        case ("root", inner):
            below = run(inner, of_name)
            return numbers.sqrt(below * below + 1.0)
        case ("size", inner):
            return abs(run(inner, of_name))
        case ("arc", inner):
            value = run(inner, of_name)
            return numbers.atan2(value, value * value + 1.0)
        case ("neg", inner):
            return -run(inner, of_name)
        case (("cos" | "sin") as name, inner):
            return getattr(numbers, name)(run(inner, of_name))
        case (name, left, right):
            return getattr(operator, name)(run(left, of_name), run(right, of_name))
    raise AssertionError(tree)


@given(tree=calculations(), at=values, goal=st.booleans())
@settings(max_examples=amount(50, 1000))
def test_the_value_is_what_the_same_code_gives_on_numbers(tree, at, goal):
    symbol = as_symbol(run(tree, coordinate if goal else named))
    plain = run(tree, at.__getitem__)
    assert symbol.value(at) == pytest.approx(plain, rel=1e-6, abs=1e-6)
    assert symbol.names() <= set(NAMES)


C1, S1, C2, S2 = THETA1.cos(), THETA1.sin(), THETA2.cos(), THETA2.sin()
HYPOTENUSE = (L1 * L1 + L2 * L2).sqrt()

EQUAL = {
    "the addition theorems fold": (
        (C1 * C2 - S1 * S2, (THETA1 + THETA2).cos()),
        (S1 * C2 + C1 * S2, (THETA1 + THETA2).sin()),
        (C1 * C2 + S1 * S2, (THETA1 - THETA2).cos()),
        (C1 * S2 - S1 * C2, (THETA2 - THETA1).sin()),
        (C1 * C1 + S1 * S1, ONE),
        (L1 * C1 * C1 + L1 * S1 * S1, L1),
        (C1 * C1 - S1 * S1, (2.0 * THETA1).cos()),
    ),
    "quarter turns leave the angle": (
        ((THETA1 + QUARTER).cos(), -S1),
        ((THETA1 - QUARTER).cos(), S1),
        ((math.pi - THETA1).sin(), S1),
        (as_symbol(QUARTER).cos(), ZERO),
        ((-THETA1).sin(), -S1),
        ((-THETA1).cos(), C1),
    ),
    "zeros and ones are dropped, and what cancels is gone": (
        (0.0 * L1, ZERO),
        (1.0 * L1 + 0.0, L1),
        ((L1 + L2) - L2, L1),
        (0.1 * L1 + 0.2 * L1 - 0.3 * L1, ZERO),
    ),
    "roots of squares, and squares of roots": (
        (HYPOTENUSE * HYPOTENUSE, L1 * L1 + L2 * L2),
        ((4.0 * L1 * L1).sqrt(), 2.0 * abs(L1)),
        (abs(L1) * abs(L1), L1 * L1),
        (abs(-2.0 * L1 * L2), 2.0 * abs(L1) * abs(L2)),
    ),
}


@every_row("pairs", EQUAL.values(), ids=EQUAL)
def test_calculations_are_simplified(pairs):
    for made, expected in pairs:
        assert made == expected


def type_1_product():
    return compose(a_matrix(THETA1, 0.0, L1, 0.0), a_matrix(THETA2, 0.0, L2, 0.0))


@pytest.mark.parametrize(
    ("product", "rows"),
    [
        (multiply(rot_x(THETA1), rot_y(THETA2)),
         ["C2|0|S2", "S1 S2|C1|-S1 C2", "-C1 S2|S1|C1 C2"]),
        (multiply(rot_y(THETA2), rot_x(THETA1)),
         ["C2|S1 S2|C1 S2", "0|C1|-S1", "-S2|S1 C2|C1 C2"]),
        (multiply(rot_z(THETA1), rot_z(THETA2), rot_z(THETA3)),
         ["C123|-S123|0", "S123|C123|0", "0|0|1"]),
    ],
    ids=["2.25", "2.26", "2.24"],
)  # fmt: skip
def test_products_of_rotations_read_as_in_equations_2_24_to_2_26(product, rows):
    assert ["|".join(map(PLAIN.write, row)) for row in product] == rows


def test_too_wide_a_matrix_is_listed_by_entries():
    frame = type_1_product()
    long = sum((named(f"length{n}") for n in range(12)), ZERO)
    wide = ((long, *frame[0][1:]), *frame[1:])
    lines = matrix_text(wide).splitlines()
    assert len(lines) == 12
    assert lines[0].startswith("x_x = length0 + length1 + ")
    assert lines[-3] == "p_x = l1 C1 + l2 C12"


@every_row(
    "symbol, text, latex",
    [
        (named("phi").cos(), "C(phi)", r"C\left(\phi\right)"),
        ((THETA1 - THETA2).sin(), "S(theta1 - theta2)", r"S\left(\theta_{1} - \theta_{2}\right)"),
        (
            (THETA1 + math.radians(30.0)).cos(),
            "C(theta1 + 30°)",
            r"C\left(\theta_{1} + 30^{\circ}\right)",
        ),
        (L1 * L1 / L2, "l1^2 / l2", r"\frac{l_{1}^{2}}{l_{2}}"),
        (L1 / (2.0 * THETA1 * L2), "0.5 l1 / (l2 theta1)", r"\frac{0.5 l_{1}}{l_{2} \theta_{1}}"),
        (
            (L1 + L2) / (2.0 * L1 * L2),
            "(l1 + l2) / (2 l1 l2)",
            r"\frac{l_{1} + l_{2}}{2 l_{1} l_{2}}",
        ),
        (
            L1 * ((L1 + L2) / L2),
            "l1 ((l1 + l2) / (l2))",
            r"l_{1} \left(\frac{l_{1} + l_{2}}{l_{2}}\right)",
        ),
        ((L1 + L2).sqrt(), "sqrt(l1 + l2)", r"\sqrt{l_{1} + l_{2}}"),
        (abs(L1), "|l1|", r"\left|l_{1}\right|"),
        (numbers.atan2(0.0, L1), "atan2(0, l1)", r"\operatorname{atan2}\left(0, l_{1}\right)"),
        (QUARTER - THETA1, "pi/2 - theta1", r"\pi/2 - \theta_{1}"),
        (3.0 * QUARTER + THETA1, "3 pi/2 + theta1", r"3 \pi/2 + \theta_{1}"),
        (named("cos(bend)"), "cos(bend)", r"\cos(\mathrm{bend})"),
        (named("l2 C2") ** 2, "(l2 C2)^2", r"\left(l_{2} C_{2}\right)^{2}"),
        (named("tool_pitch"), "tool_pitch", r"\mathrm{tool\_pitch}"),
    ],
)
def test_how_symbols_are_written(symbol, text, latex):
    assert PLAIN.write(symbol) == text
    assert LATEX.write(symbol) == latex


def test_a_solution_is_written_by_its_named_steps():
    x, y = coordinate("x"), coordinate("y")
    span = (x * x + y * y).sqrt()
    aim = numbers.atan2(y, x)
    steps = definitions(
        [("theta1", aim - THETA2), ("D", span), ("direction", aim), ("c", span / L1), ("z", y)]
    )
    assert [f"{step.name} = {PLAIN.write(step.symbol)}" for step in steps] == [
        "D = sqrt(x^2 + y^2)",
        "direction = atan2(y, x)",
        "theta1 = direction - theta2",
        "c = D / l1",
        "z = y",
    ]


# Named systems run on symbols: the formulas have the values of the same code on numbers.


def postures(system, low_rad=-3.0, high_rad=3.0):
    chain = system.chain()
    return st.tuples(
        *(
            st.floats(low_rad, high_rad) if kind is JointKind.REVOLUTE else st.floats(10, 300)
            for kind in chain.kinds
        )
    )


def by_name(symbols, numbers):
    """Numbers by the names of symbols."""
    return {next(iter(one.names())): number for one, number in zip(symbols, numbers, strict=True)}


@every_row("name", SYSTEMS)
def test_no_entry_holds_what_rounding_left_of_a_right_angle(name):
    example = symbolic_example_of(name)
    for frame in (*example.matrices, example.product):
        for entry in (as_symbol(entry) for row in frame for entry in row):
            assert all(abs(factor) == 1.0 for _, factor in entry.terms), PLAIN.write(entry)


@pytest.mark.parametrize("name", SYSTEMS)
@given(data=st.data())
@settings(max_examples=8)
def test_symbolic_forward_kinematics_has_the_values_of_the_numeric_one(name, data):
    system = SYSTEMS[name]
    joints, symbols = data.draw(postures(system)), joint_symbols(system.chain())
    values = by_name(symbols, joints)
    frame = symbolic_example_of(name).product
    assert symbols_gap(frame, system.fk(joints), values | system.lengths()) < 1e-9


def test_the_revolute_transporters_end_point_reads_as_equation_2_35():
    system = SYSTEMS["revolute"]
    frame = symbolic_system(system).fk(joint_symbols(system.chain()))
    assert [PLAIN.write(row[3]) for row in frame[:3]] == [
        "S1 (L2 S2 + L3 S23)",
        "-C1 (L2 S2 + L3 S23)",
        "L1 + L2 C2 + L3 C23",
    ]


@every_row(
    "name, lines",
    [
        (
            "two-link-1",
            [
                "[ C12  -S12  0  l1 C1 + l2 C12 ]",
                "[ S12  C12   0  l1 S1 + l2 S12 ]",
                "[ 0    0     1  0              ]",
                "[ 0    0     0  1              ]",
            ],
        ),
        (
            "two-link-2",
            [
                "[ C1 C2  -C1 S2  S1   l2 C1 C2   ]",
                "[ S1 C2  -S1 S2  -C1  l2 S1 C2   ]",
                "[ S2     C2      0    d1 + l2 S2 ]",
                "[ 0      0       0    1          ]",
            ],
        ),
        (
            "two-link-3",
            [
                "[ C1  0  S1   d2 S1  ]",
                "[ S1  0  -C1  -d2 C1 ]",
                "[ 0   1  0    d1     ]",
                "[ 0   0  0    1      ]",
            ],
        ),
        (
            "two-link-4",
            [
                "[ C2  -S2  0   l2 C2      ]",
                "[ 0   0    -1  0          ]",
                "[ S2  C2   0   d1 + l2 S2 ]",
                "[ 0   0    0   1          ]",
            ],
        ),
        (
            "two-link-5",
            ["[ 1  0  0   0   ]", "[ 0  0  -1  -d2 ]", "[ 0  1  0   d1  ]", "[ 0  0  0   1   ]"],
        ),
    ],
)
def test_manipulator_transforms_read_as_the_notes_print_them(name, lines):
    system = SYSTEMS[name]
    frame = symbolic_system(system).fk(joint_symbols(system.chain()))
    assert matrix_text(frame).splitlines() == lines


@every_row("name", SYSTEMS)
def test_following_the_written_steps_leads_to_the_joint_values(name):
    system = SYSTEMS[name]
    posture = [
        angle if kind is JointKind.REVOLUTE else 130.0
        for angle, kind in zip((0.4, 0.7, 0.9, 0.5, 0.6, 0.8), system.chain().kinds, strict=False)
    ]
    goal = system.goal_of(system.fk(posture))
    for branch in symbolic_example_of(name).branches:
        if branch.name not in {found.name for found in system.ik(goal)}:
            continue
        symbols = symbolic_goal(system.coordinates)
        known = by_name(symbols, goal) | system.lengths()
        for step in branch.steps:
            known[step.name] = step.symbol.value(known)
        joints = [known[next(iter(one.names()))] for one in joint_symbols(system.chain())]
        for found, plain in zip(joints, system.solution(goal, branch.name).joints, strict=True):
            assert found == pytest.approx(plain, abs=1e-7)


def test_a_chains_lengths_are_named_by_link():
    links = (DHLink(a_mm=5.0, d_mm=7.0), DHLink(kind=JointKind.PRISMATIC, d_mm=3.0, alpha_rad=0.1))
    standard = symbolic_chain(Chain(links))
    assert [PLAIN.write(link.a_mm) for link in standard.links] == ["a1", "0"]
    assert [PLAIN.write(link.d_mm) for link in standard.links] == ["d1", "D2"]
    craig = symbolic_chain(Chain((DHLink(), DHLink(a_mm=5.0)), Convention.CRAIG))
    assert PLAIN.write(craig.links[1].a_mm) == "a1"
    assert [PLAIN.write(one) for one in joint_symbols(Chain(links))] == ["theta1", "d2"]
