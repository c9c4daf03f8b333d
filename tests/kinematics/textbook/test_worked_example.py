"""Worked examples: what is said of a posture is what the solvers say, in words and numbers."""

import math

from amounts import every_row
from systems_cases import symbolic_example_of

from kinematics.chains.chain import Chain
from kinematics.chains.links import DHLink, JointKind
from kinematics.textbook.study import subject_of_chain, subject_of_system
from kinematics.textbook.systems import SYSTEMS, system
from kinematics.textbook.worked_example import (
    sections,
    symbolic_sections,
    work,
)

DEG = math.pi / 180.0


def whole_text(example):
    return "\n".join(line for each in sections(example) for line in [each.title, *each.lines])


@every_row("name", SYSTEMS)
def test_the_text_names_every_joint_branch_and_step(name):
    example = work(named(name))
    text = whole_text(example)
    for expected in (
        *example.subject.chain.joint_names,
        *(branch.name for branch in example.branches),
        *(step.formula for step in example.subject.system.notes.derivation),
        *(f"A{number}: " for number in range(1, len(example.subject.chain) + 1)),
    ):
        assert expected in text


def test_the_readers_own_numbers_are_used():
    text = whole_text(work(named("two-link-1"), (30 * DEG, 40 * DEG)))
    assert "theta1 30°, theta2 40°" in text
    assert "reach: a ring in the plane z = 0, 50 mm to 350 mm from the first joint" in text
    assert "[  0.342  -0.9397  0  224.51 ]" in text
    assert "orientation RPY: phi 70°, theta 0°, psi 0°" in text
    short = 350 - math.sqrt(200**2 + 150**2 + 2 * 200 * 150 * math.cos(math.radians(40)))
    assert f"40°, {short:.2f} mm away: elbow stretched" in text
    assert "  theta1 [ -240.95  224.51 ]" in text
    assert "  theta2 [ -140.95    51.3 ]" in text
    assert "D = 329.34 mm, cos(bend) = 0.766, direction = 47.02°, lift = -17.02°" in text


def test_degenerate_cases_are_said_in_words():
    stretched = whole_text(work(named("two-link-1"), goal=(350.0, 0.0)))
    assert "1 solution, 1 within the joint limits" in stretched
    assert "degenerate: elbow stretched" in stretched
    on_axis = whole_text(work(named("two-link-3"), goal=(0.0, 0.0)))
    assert "free: theta1; any value serves" in on_axis
    assert "degenerate: the tip is on the base axis" in on_axis


def named(name):
    return subject_of_system(system(name))


def own(chain=None):
    return subject_of_chain("own", "My arm", "my bench", chain or OWN)


LINKS = (
    DHLink(d_mm=100.0, alpha_rad=math.pi / 2, low=-3.0, high=3.0),
    DHLink(a_mm=200.0, low=-0.5, high=2.0),
    DHLink(kind=JointKind.PRISMATIC, low=10.0, high=90.0),
)
OWN = Chain(LINKS, name="own")


def test_any_chain_is_solved_by_numbers():
    example = work(own())
    assert example.branches == ()
    assert example.here is None
    assert example.solution.ok
    assert example.frame == OWN.fk(example.values)
    text = whole_text(example)
    assert "the goal is met" in text
    assert "Inverse kinematics, by numbers" in text


def test_a_chain_with_a_closed_form_shows_all_its_solutions():
    chain = system("puma").chain()
    example = work(own(chain))
    text = whole_text(example)
    assert "All solutions, in closed form" in text
    assert "class: spherical wrist: the last three axes meet in one point" in text
    assert "solved in closed form: all postures" in text
    for branch in example.branches:
        assert branch.name in text
        assert branch.within_limits or "not within the limits: " in text
    asked = work(own(chain), goal=example.goal)
    assert len(asked.branches) == len(example.branches) == 8
    assert work(own(chain), goal=example.goal[:3]).branches == ()


def test_a_goal_that_a_chain_misses_is_accounted_for():
    example = work(own(), goal=(900.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert not example.solution.ok
    assert "missed: position by" in whole_text(example)


def test_a_system_in_symbols_shows_matrices_product_and_solutions():
    example = symbolic_example_of("two-link-1")
    lines = [line for each in symbolic_sections(example) for line in each.lines]
    assert "A1 =" in lines
    assert "T = A1 A2 =" in lines
    assert "[ C12  -S12  0  l1 C1 + l2 C12 ]" in lines
    assert "  theta1 = direction - lift" in lines
    assert "  as elbow up, but" in lines
