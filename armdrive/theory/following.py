"""Following the Jacobian of a link table: a step of the hand in small ones, within the limits.

Damped near singularities, so that no joint runs away (see `kinematics.rates`). Lengths in mm,
angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from operator import mul

from armdrive.theory.subject import Subject
from kinematics.chains import Chain
from kinematics.frames import Transform, position_of, rotation_of
from kinematics.generated import generated
from kinematics.links import JointKind
from kinematics.rates import joint_rates
from kinematics.singularities import length_of
from kinematics.vectors import dot, subtract

SLICES = 16
"""A step is made of so many small ones."""

POSITION, WHOLE = 3, 6
"""Rows of the geometric Jacobian that are followed: the tip alone, or the whole hand."""


@dataclass(frozen=True, slots=True)
class Followed:
    """Where following led: how far along the axis, and how far beside it as a share of the step.

    `held` names the joints that a limit held back.
    """

    values: tuple[float, ...]
    done: float
    astray: float
    held: tuple[str, ...]


def rows_followed(subject: Subject) -> int:
    """Return how many rows of the geometric Jacobian are followed.

    The whole hand where there are joints enough for all that can move, else the tip alone.
    """
    return WHOLE if len(subject.rows) <= len(subject.chain) else POSITION


def keeps_to_surface(subject: Subject) -> bool:
    """Whether the joints are too few for the tip to go straight in every direction that it has."""
    rows = [row for row in subject.rows if row < rows_followed(subject)]
    return len(rows) > len(subject.chain)


def follow(subject: Subject, values: tuple[float, ...], row: int, by: float) -> Followed:
    """Follow one row of the geometric Jacobian by so many mm or rad, the other rows at rest."""
    chain, count = subject.chain, rows_followed(subject)
    rates = [by / SLICES if index == row else 0.0 for index in range(count)]
    made, length, at = generated(chain), length_of(chain), values
    # slides are counted in lengths of the arm: in mm they would hardly be used
    units = [length if kind is JointKind.PRISMATIC else 1.0 for kind in chain.kinds]
    held: set[str] = set()
    for _ in range(SLICES):
        rows = (map(mul, line, units) for line in made.jacobian(at)[:count])
        slopes = joint_rates(tuple(map(tuple, rows)), rates, length_mm=length).joints
        moved = [one + slope * unit for one, slope, unit in zip(at, slopes, units, strict=True)]
        held.update(one.joint for one in chain.violations(moved))
        at = chain.clamp(moved)
    before, after = made.fk(values), made.fk(at)
    named = tuple(name for name in chain.joint_names if name in held)
    return Followed(at, _gone(before, after, row), _astray(chain, before, after, row, by), named)


def _gone(before: Transform, after: Transform, row: int) -> float:
    """Return how far the hand went along an axis, or turned about it."""
    if row < POSITION:
        return position_of(after)[row] - position_of(before)[row]
    one, two = (row - 2) % 3, (row - 1) % 3  # the axes that a turn about this one carries along
    was, now = rotation_of(before), rotation_of(after)
    turned = dot(was[one], now[two]) - dot(was[two], now[one])
    return math.atan2(turned, dot(was[one], now[one]) + dot(was[two], now[two]))


def _astray(chain: Chain, before: Transform, after: Transform, row: int, by: float) -> float:
    """Return how far beside its way the tip came, as a share of the step."""
    beside = list(subtract(position_of(after), position_of(before)))
    if row < POSITION:
        beside[row] = 0.0
    return math.hypot(*beside) / (abs(by) * (1.0 if row < POSITION else length_of(chain)))
