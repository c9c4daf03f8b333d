"""The Jacobian of a named system in its own coordinates, and its singularities with reasons.

A planar arm has no z and a five-axis one no yaw: judged by all six rows of the geometric Jacobian
the first is always singular, and the second never where its tip is over the base. Lengths in mm,
angles in rad, rates per second of whatever the joint is measured in.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from kinematics.chains.chain import Chain
from kinematics.chains.generated import Jacobian, generated
from kinematics.chains.jacobians import ALL_ROWS, dimensionless
from kinematics.chains.singularities import Condition, condition_of, default_rows, length_of
from kinematics.textbook.systems.mini_movers import own_jacobian as five_axis_jacobian
from kinematics.textbook.systems.named import Lost, System
from kinematics.textbook.worked_example import example_posture

PITCH_ROW, ROLL_ROW = 6, 7
"""Rows that no geometric Jacobian has: those of the five-axis build's own angles."""

ROW_NAMES = ("x", "y", "z", "about x", "about y", "about z", "pitch", "roll")
"""What each row's number stands for."""

_STILL = 1e-9
"""An entry below this moves nothing, in mm or rad a unit of the joint."""

_ROWS: Mapping[str, int] = MappingProxyType(
    {
        "x_mm": 0,
        "y_mm": 1,
        "z_mm": 2,
        "phi_rad": 3,
        "theta_rad": 4,
        "psi_rad": 5,
        "pitch_rad": PITCH_ROW,
        "roll_rad": ROLL_ROW,
    }
)
_IN_THE_PLANE = 5
"""The only angle of a planar arm is about z."""


def own_rows(system: System) -> tuple[int, ...]:
    """Return the numbers of the rows that a system's own coordinates stand for.

    The three angles of a whole orientation stand for turning about x, y and z.
    """
    rows = tuple(_ROWS[name] for name in system.coordinates)
    angles = [row for row in rows if row >= 3]
    planar = angles == [_ROWS["phi_rad"]]
    return (*(row for row in rows if row < 3), *((_IN_THE_PLANE,) if planar else angles))


def own_jacobian(system: System, values: Sequence[float]) -> Jacobian:
    """Return the rows of `own_rows`, a column a joint. Raises as `System.fk` does.

    Pitch and roll of the five-axis build are those of `task_jacobian`, with the roll in the hand.
    """
    checked = system.chain().checked(values)
    if system.arm is not None:
        return five_axis_jacobian(system, checked)
    whole = generated(system.chain()).jacobian(checked)
    return tuple(whole[row] for row in own_rows(system))


def chain_rows(chain: Chain) -> tuple[int, ...]:
    """Return the rows that a chain is judged by: `default_rows`, without those it never moves in.

    A planar arm leaves some out; two postures tell which, as good as any others.
    """
    made = generated(chain)
    first = example_posture(chain)
    postures = (first, tuple(0.7 * value for value in first))
    seen = [made.jacobian(posture) for posture in postures]
    return tuple(
        row
        for row in default_rows(chain)
        if any(abs(entry) > _STILL for one in seen for entry in one[row])
    )


def chain_jacobian(
    chain: Chain, values: Sequence[float], rows: Sequence[int] = ALL_ROWS
) -> Jacobian:
    """Return some rows of the geometric Jacobian. Raises as `Chain.fk` does."""
    whole = generated(chain).jacobian(chain.checked(values))
    return tuple(whole[row] for row in rows)


def judged(chain: Chain, jacobian: Jacobian, rows: Sequence[int]) -> Condition:
    """Return how well a posture can move by these rows, mm counted in the length of the arm."""
    positions = [index for index, row in enumerate(rows) if row < 3]
    scaled = dimensionless(jacobian, length_of(chain), chain.kinds, positions)
    return condition_of(chain, scaled, rows)


def named_singularities(system: System, values: Sequence[float]) -> tuple[Lost, ...]:
    """Return every singularity of a named system, in a fixed order; joint limits not looked at.

    They are where the system's Jacobian in its own coordinates loses a rank, and nowhere else: the
    determinants are products of these measures. Sources: McKerrow, chapter 4, section 12; Craig,
    chapter 5. Empty for a system that has none (all slides). Raises as `System.fk` does.
    """
    return tuple(system.losses(system, system.chain().checked(values)))
