"""Chains against another library's: the Robotics Toolbox for Python, where it is installed."""

import warnings

import pytest
from amounts import every_row
from chain_cases import MINI_MOVER, PUMA, chains_and_values, gap
from hypothesis import given

from kinematics.chains.chain import Chain
from kinematics.chains.generated import generated
from kinematics.chains.inverse import solve_frame_ik
from kinematics.chains.links import Convention, JointKind

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # the library's own imports warn
    toolbox = pytest.importorskip(
        "roboticstoolbox", reason="the oracle roboticstoolbox-python is not installed"
    )
    spatialmath = pytest.importorskip("spatialmath", reason="spatialmath-python is not installed")


def its_robot(chain: Chain):
    """The same chain in the toolbox; it has the table's zero in the offset."""
    standard = chain.convention is Convention.STANDARD
    links = []
    for link in chain.links:
        theta, d, a, alpha = link.parameters(0.0)
        if link.kind is JointKind.REVOLUTE:
            make = toolbox.RevoluteDH if standard else toolbox.RevoluteMDH
            links.append(make(d=d, a=a, alpha=alpha, offset=theta))
        else:
            make = toolbox.PrismaticDH if standard else toolbox.PrismaticMDH
            links.append(make(theta=theta, a=a, alpha=alpha, offset=d))
    return toolbox.DHRobot(
        links,
        base=spatialmath.SE3(chain.base, check=False),
        tool=spatialmath.SE3(chain.tool, check=False),
    )


@given(chains_and_values(most=6))
def test_the_toolbox_gives_the_same_transform(case):
    chain, values = case
    theirs = its_robot(chain).fkine(values).A
    assert gap(chain.fk(values), theirs) < 1e-6
    assert gap(generated(chain).fk(values), theirs) < 1e-6


@given(chains_and_values(most=6))
def test_the_toolbox_gives_the_same_jacobian(case):
    chain, values = case
    assert gap(generated(chain).jacobian(values), its_robot(chain).jacob0(values)) < 1e-6


@every_row("chain", [PUMA, MINI_MOVER], ids=lambda chain: chain.name)
def test_the_toolbox_confirms_what_is_solved_by_numbers(chain):
    values = (0.3, 0.5, -0.9, 0.4, 0.6, -0.2)[: len(chain)]
    goal = its_robot(chain).fkine(values).A
    solution = solve_frame_ik(chain, tuple(map(tuple, goal.tolist())))
    assert solution.ok
    assert gap(its_robot(chain).fkine(solution.joints).A, goal) < 1e-3
