"""Named systems run on symbols: the formulas have the values of the same code on numbers."""

import math
from functools import cache

import pytest
from amounts import every_row
from hypothesis import given, settings
from hypothesis import strategies as st
from systems_cases import symbolic_example_of, symbols_gap

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.textbook.notation import PLAIN, definitions, matrix_text
from kinematics.textbook.symbols import as_symbol
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.worked_example import (
    joint_symbols,
    symbolic_chain,
    symbolic_goal,
    symbolic_system,
)


def postures(system, low_rad=-3.0, high_rad=3.0):
    chain = system.chain()
    return st.tuples(
        *(
            st.floats(low_rad, high_rad) if kind is JointKind.REVOLUTE else st.floats(10, 300)
            for kind in chain.kinds
        )
    )


def named(symbols, numbers):
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
    values = named(symbols, joints)
    frame = symbolic_example_of(name).product
    assert symbols_gap(frame, system.fk(joints), values | system.lengths()) < 1e-9


@cache
def symbolic_solutions(name):
    """The joints of every branch as symbols."""
    system = SYSTEMS[name]
    symbolic, goal = symbolic_system(system), symbolic_goal(system.coordinates)
    return {branch: symbolic.solution(goal, branch).joints for branch in system.signs}


@pytest.mark.parametrize("name", SYSTEMS)
@given(data=st.data())
@settings(max_examples=8)
def test_symbolic_solutions_have_the_values_of_the_numeric_ones(name, data):
    system = SYSTEMS[name]
    goal = system.goal_of(system.fk(data.draw(postures(system, 0.2, 1.2))))
    symbols = symbolic_goal(system.coordinates)
    values = named(symbols, goal) | system.lengths()
    compared = 0
    for branch in {found.name for found in system.ik(goal)} & set(system.signs):
        plain = system.solution(goal, branch).joints
        made = symbolic_solutions(name)[branch]
        for symbol, number, kind in zip(made, plain, system.chain().kinds, strict=True):
            off = as_symbol(symbol).value(values) - number
            if kind is JointKind.REVOLUTE:
                off = math.remainder(off, math.tau)
            assert off == pytest.approx(0.0, abs=1e-5)
        compared += 1
    assert compared


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


def test_the_mini_movers_solution_reads_step_by_step():
    system = SYSTEMS["minimover5"]
    solved = symbolic_system(system).solution(
        symbolic_goal(system.coordinates), "base front, elbow up"
    )
    names = [PLAIN.write(symbol) for symbol in joint_symbols(system.chain())]
    steps = definitions(
        [
            *((each.symbol, each.value) for each in solved.workings),
            *zip(names, solved.joints, strict=True),
        ]
    )
    written = {step.name: PLAIN.write(step.symbol) for step in steps}
    assert written["r0"] == "sqrt(x^2 + y^2) - d5 C(pitch)"
    assert written["cos(bend)"] == "(r0^2 + z0^2 - a2^2 - a3^2) / (2 a2 a3)"
    assert written["theta2"] == "direction - lift"
    assert written["theta4"] == "atan2(S(pitch), C(pitch)) - theta2 - theta3"


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
        known = named(symbols, goal) | system.lengths()
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
