"""Symbols: their value is what the same code gives on numbers, and they read as the notes do."""

import math
import operator

import pytest
from amounts import amount, every_row
from hypothesis import given, settings
from hypothesis import strategies as st
from systems_cases import symbols_gap

from kinematics.chains.links import Convention, a_matrix
from kinematics.errors import KinematicsError
from kinematics.frames import numbers
from kinematics.frames.rotations import multiply, rot_x, rot_y, rot_z
from kinematics.frames.transforms import compose
from kinematics.textbook.notation import (
    LATEX,
    PLAIN,
    definitions,
    matrix_latex,
    matrix_text,
    renamed,
)
from kinematics.textbook.symbols import ONE, ZERO, as_symbol, coordinate, named

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


@given(at=values, d=st.floats(-2.0, 2.0).filter(lambda d: abs(d) > 1e-3))
def test_quotients_keep_their_value(at, d):
    at = {**at, "d": d}
    under = named("d")
    for over in (L1, L1 + L2, L1 * L2, 3.0, under, 2.0 * under):
        made = over / under
        plain = (over if isinstance(over, float) else over.value(at)) / d
        assert made.value(at) == pytest.approx(plain)
    assert (L1 / (under * under + 1.0)).value(at) == pytest.approx(at["l1"] / (d * d + 1.0))
    assert under / under == ONE
    assert ZERO / under == ZERO
    assert (under**-2).value(at) == pytest.approx(d**-2)


@given(
    twists=st.tuples(*[st.sampled_from([-QUARTER, 0.0, QUARTER, 0.4])] * 3),
    at=values,
    convention=st.sampled_from(Convention),
)
def test_products_of_a_matrices_have_the_values_of_the_numeric_ones(twists, at, convention):
    def product(first, second, third, one, two):
        return compose(
            a_matrix(first, one, 0.0, twists[0], convention),
            a_matrix(second, 0.0, two, twists[1], convention),
            a_matrix(third + QUARTER, 0.0, one, twists[2], convention),
        )

    symbolic = product(THETA1, THETA2, THETA3, L1, L2)
    numeric = product(*(at[name] for name in NAMES))
    assert symbols_gap(symbolic, numeric, at) < 1e-9


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


@every_row(
    "calculate, error, words",
    [
        (lambda: (L1 + L2).value({"l1": 1.0}), KinematicsError, "no value is given for l2"),
        (lambda: min(L1, L2), TypeError, "not supported between"),
        (lambda: L1 / 0.0, ZeroDivisionError, "zero"),
    ],
)
def test_what_cannot_be_calculated_is_refused(calculate, error, words):
    with pytest.raises(error, match=words):
        calculate()


def type_1_product():
    return compose(a_matrix(THETA1, 0.0, L1, 0.0), a_matrix(THETA2, 0.0, L2, 0.0))


def test_the_type_1_product_in_latex():
    assert matrix_latex(type_1_product()).splitlines() == [
        r"\begin{bmatrix}",
        r"C_{12} & -S_{12} & 0 & l_{1} C_{1} + l_{2} C_{12} \\",
        r"S_{12} & C_{12} & 0 & l_{1} S_{1} + l_{2} S_{12} \\",
        r"0 & 0 & 1 & 0 \\",
        r"0 & 0 & 0 & 1",
        r"\end{bmatrix}",
    ]


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


def test_sums_of_a_goals_coordinates_stay_whole_as_factors():
    x, height = coordinate("x"), named("d1")
    assert PLAIN.write((x - height) * (x - height)) == "(d1 - x)^2"
    assert (x - height) * (height - x) == -((x - height) ** 2)
    assert ((x - height) * (height - x)).value({"x": 5.0, "d1": 2.0}) == -9.0


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


@given(at=values)
def test_naming_parts_keeps_the_value(at):
    part = THETA1 - THETA2
    root = (L1 * L1 + 1.0).sqrt()
    whole = (THETA3 - part).cos() * root + (THETA2 - THETA1)
    written = renamed(whole, {part: "p", root: "r"})
    assert written.names() == {"theta3", "p", "r"}
    with_names = {**at, "p": part.value(at), "r": root.value(at)}
    assert written.value(with_names) == pytest.approx(whole.value(at))
