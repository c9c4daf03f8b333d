"""Jacobians of chains: what the joints' rates make the tip do, and joint rates for the tip's.

Geometric: each column is the joint's axis z and z x (tip - axis) (Whitney, 1972; Craig, chapter 5).
Lengths in mm, angles in rad, rates per second of whatever the joint is measured in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from kinematics.chains.chain import Chain
from kinematics.chains.generated import Jacobian
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError, finite
from kinematics.frames.decompositions import Singular, singular
from kinematics.frames.matrices import times
from kinematics.frames.transforms import position_of
from kinematics.frames.vectors import cross, subtract

POSITION_ROWS = (0, 1, 2)
"""The rows of a geometric Jacobian that concern the tip's position."""

ALL_ROWS = (0, 1, 2, 3, 4, 5)


def geometric_jacobian(chain: Chain, values: Sequence[float]) -> Jacobian:
    """Return the geometric Jacobian: rows v along x, y, z, then turning about x, y, z.

    On any kind of number; `generated(chain).jacobian` is the same on floats, many times as fast.
    Raises as `Chain.fk` does.
    """
    tip = position_of(chain.fk(values))
    columns = []
    for kind, (point, axis) in zip(chain.kinds, chain.axes(values), strict=True):
        if kind is JointKind.REVOLUTE:
            columns.append((*cross(axis, subtract(tip, point)), *axis))
        else:
            columns.append((*axis, 0.0, 0.0, 0.0))
    return tuple(zip(*columns, strict=True))


def dimensionless(
    jacobian: Jacobian,
    length_mm: float,
    kinds: Sequence[JointKind] = (),
    position_rows: Sequence[int] = POSITION_ROWS,
) -> Jacobian:
    """Return a Jacobian whose mm are counted in a length, so that its entries compare.

    Rows of the position are divided by it, columns of slides (`kinds`, none by default)
    multiplied. Without it, singular values mix mm with rad and mean nothing.
    """
    columns = [
        length_mm if kind is JointKind.PRISMATIC else 1.0
        for kind in (kinds or [JointKind.REVOLUTE] * len(jacobian[0]))
    ]
    return tuple(
        tuple(
            entry * column / (length_mm if index in position_rows else 1.0)
            for entry, column in zip(row, columns, strict=True)
        )
        for index, row in enumerate(jacobian)
    )


def manipulability(jacobian: Jacobian) -> float:
    """Return the volume of what unit joint rates make the tip do (Yoshikawa, 1985).

    The product of the singular values: |det J| of a square Jacobian, zero where the arm is
    singular. Its unit follows the rows'.
    """
    return math.prod(singular(jacobian).values)


# Joint rates from tip rates, damped near singularities so that no joint runs away.
#
# Source: Wampler (1986) and Nakamura and Hanafusa (1986), damped least squares. Each singular
# direction is damped by itself and only below a threshold e: there the gain 1/s becomes s/e^2,
# which is damping by e^2 - s^2, continuous at s = e and never more than 1/e.

THRESHOLD = 0.05
"""Singular value, dimensionless, below which a direction is damped: joint rates in rad/s stay
under 20 times the tip's rate in lengths of the arm a second."""


@dataclass(frozen=True, slots=True)
class Rates:
    """Joint rates, and what they make of the tip's.

    `achieved` are the tip rates that the joints give to first order and `missed` what lacks of
    the wanted ones, zero where nothing is damped and the arm has the axes. `smallest` is the
    smallest singular value, dimensionless, and `damped` whether it lay below the threshold.
    """

    joints: tuple[float, ...]
    achieved: tuple[float, ...]
    missed: tuple[float, ...]
    smallest: float
    damped: bool


def joint_rates(
    jacobian: Jacobian,
    tip_rates: Sequence[float],
    *,
    length_mm: float,
    threshold: float = THRESHOLD,
) -> Rates:
    """Return joint rates for tip rates (mm/s and rad/s, in the order of the Jacobian's rows).

    The first three rows are the position's; `length_mm` (the arm's reach, say) makes mm compare
    with rad. Where the tip rates cannot be had exactly, these miss them least. The square root
    of the sum of the squared joint rates never exceeds that of the tip rates (mm counted in
    `length_mm`) divided by `threshold`. Raises `KinematicsError` for the wrong number of rates
    or a threshold or length that is not above zero.
    """
    if len(tip_rates) != len(jacobian):
        raise KinematicsError(f"{len(jacobian)} tip rates are needed, not {len(tip_rates)}")
    for name, value in (("length_mm", length_mm), ("threshold", threshold)):
        if finite(name, value) <= 0.0:
            raise KinematicsError(f"{name} must be above zero, not {value}")
    scales = [1.0 / length_mm if row < 3 else 1.0 for row in range(len(jacobian))]
    wanted = [
        finite("a tip rate", rate) * scale for rate, scale in zip(tip_rates, scales, strict=True)
    ]
    scaled = tuple(
        tuple(entry * scale for entry in row) for row, scale in zip(jacobian, scales, strict=True)
    )
    parts = singular(scaled)
    joints = _damped(parts, wanted, threshold, len(jacobian[0]))
    achieved = times(jacobian, joints)
    return Rates(
        joints,
        achieved,
        tuple(rate - got for rate, got in zip(tip_rates, achieved, strict=True)),
        parts.values[-1],
        parts.values[-1] < threshold,
    )


def _damped(
    parts: Singular, wanted: Sequence[float], threshold: float, count: int
) -> tuple[float, ...]:
    """Return the sum of gain * (left . wanted) * right over the singular values."""
    joints = [0.0] * count
    for value, left, right in zip(parts.values, parts.left, parts.right, strict=True):
        gain = 1.0 / value if value >= threshold else value / (threshold * threshold)
        share = gain * sum([a * b for a, b in zip(left, wanted, strict=True)])
        joints = [rate + share * part for rate, part in zip(joints, right, strict=True)]
    return tuple(joints)
