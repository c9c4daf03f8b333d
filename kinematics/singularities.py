"""Singularities of any chain: how near, which direction is lost, and the nearest one.

A posture is singular where the Jacobian loses a rank: some direction of the tip cannot be moved
in, or some joints can move against each other with the tip at rest (McKerrow, chapter 4, section
12, "degeneracies"). Jacobians are made dimensionless by a length of the arm, so that singular
values and distances are in rad, and in lengths of the arm for slides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from kinematics.chains import Chain
from kinematics.errors import KinematicsError
from kinematics.frames import position_of
from kinematics.generated import Generated, Jacobian, generated
from kinematics.jacobians import ALL_ROWS, POSITION_ROWS, dimensionless
from kinematics.linear import singular, transposed
from kinematics.vectors import norm

SINGULAR = 1e-9
"""A dimensionless singular value below this is zero."""

SMALL_PART = 0.05
"""Components of a unit direction below this are left out of its description."""

_AXES = ("x", "y", "z")
_TURNS = (*_AXES, "the wrist's axis", "the hand's axis")


@dataclass(frozen=True, slots=True)
class Condition:
    """How well a posture can move.

    `singular_values` are dimensionless, largest first, and `manipulability` their product.
    `hardest` is the direction, in the rows looked at, that the tip moves in worst, of length 1;
    `idle` the joint rates, of length 1, that move the tip least. `sentence` says it in words.
    """

    singular_values: tuple[float, ...]
    manipulability: float
    hardest: tuple[float, ...]
    idle: tuple[float, ...]
    is_singular: bool
    sentence: str

    @property
    def smallest(self) -> float:
        """The smallest singular value: how far the tip moves, at worst, per rad of the joints."""
        return self.singular_values[-1]


def default_rows(chain: Chain) -> tuple[int, ...]:
    """Return the rows that a chain of this many joints is judged by: position alone up to three."""
    return POSITION_ROWS if len(chain) <= 3 else ALL_ROWS


def length_of(chain: Chain) -> float:
    """Return the length in mm that makes mm compare with rad: the longest reach, where it ends."""
    reach = chain.longest_reach_mm
    if math.isfinite(reach) and reach > 0.0:
        return reach
    lengths = [abs(link.a_mm) + abs(link.d_mm) for link in chain.links]
    return sum(lengths) + norm(position_of(chain.tool)) or 1.0


def condition(
    chain: Chain, values: Sequence[float], rows: Sequence[int] | None = None
) -> Condition:
    """Return how well a posture can move, and in words what is lost or nearly lost.

    `rows` are the rows of the geometric Jacobian that matter (0 to 2 the position, 3 to 5 the
    turning), by default `default_rows`. Raises as `Chain.fk` does.
    """
    chosen = default_rows(chain) if rows is None else tuple(rows)
    return condition_of(
        chain, scaled_rows(chain, generated(chain), chain.checked(values), chosen), chosen
    )


def in_words(rates: Sequence[float], rows: Sequence[int]) -> str:
    """Say a direction of the tip in words: move along these axes, turn about those.

    Rows 0 to 5 are those of a geometric Jacobian; 6 and 7 are pitch and roll of five-axis arms.
    """
    moves = _named(
        [(f"{_AXES[row]}", part) for row, part in zip(rows, rates, strict=True) if row < 3]
    )
    turns = _named(
        [(f"{_TURNS[row - 3]}", part) for row, part in zip(rows, rates, strict=True) if row >= 3]
    )
    said = [f"move along {moves}"] if moves else []
    said += [f"turn about {turns}"] if turns else []
    return " and ".join(said)


def condition_of(chain: Chain, jacobian: Jacobian, rows: Sequence[int]) -> Condition:
    """Return how well a posture can move by a dimensionless Jacobian; `rows` say what its rows are.

    They are numbered as for `in_words`.
    """
    parts = singular(jacobian)
    idle = parts.right[-1]
    if len(jacobian) <= len(chain):  # the left vector of a zero is found among the right ones
        hardest = singular(transposed(jacobian)).right[-1]
    else:
        hardest = parts.left[-1]
    is_singular = parts.values[-1] < SINGULAR
    return Condition(
        parts.values,
        math.prod(parts.values),
        hardest,
        idle,
        is_singular,
        _sentence(chain, parts.values[-1], hardest, idle, rows, is_singular),
    )


def _sentence(
    chain: Chain,
    smallest: float,
    hardest: Sequence[float],
    idle: Sequence[float],
    rows: Sequence[int],
    is_singular: bool,
) -> str:
    joints = _named(
        [(name.replace("_", " "), part) for name, part in zip(chain.joint_names, idle, strict=True)]
    )
    parts = []
    if len(rows) <= len(chain):
        parts.append(
            f"the tip {'cannot' if is_singular else 'can hardly'} {in_words(hardest, rows)}"
        )
    if len(rows) >= len(chain):
        still = "at rest" if is_singular else "almost at rest"
        parts.append(f"moving {joints} leaves the tip {still}")
    said = "; ".join(parts)
    if is_singular:
        return f"singular: {said}"
    return f"smallest singular value {smallest:.3g}; hardest: {said}"


def _named(parts: Sequence[tuple[str, float]]) -> str:
    """Say the larger components with their shares: "0.97 x - 0.24 z"."""
    kept = [(name, part) for name, part in parts if abs(part) >= SMALL_PART]
    if not kept:
        return ""
    if len(kept) == 1:
        return kept[0][0]
    first, *others = kept
    flip = -1.0 if first[1] < 0.0 else 1.0  # a direction and its opposite are the same
    text = f"{abs(first[1]):.2f} {first[0]}"
    for name, part in others:
        text += f" {'-' if part * flip < 0.0 else '+'} {abs(part):.2f} {name}"
    return text


def scaled_rows(
    chain: Chain, made: Generated, values: Sequence[float], rows: Sequence[int]
) -> Jacobian:
    """Return the dimensionless rows of the Jacobian."""
    if not rows or not set(rows) <= set(ALL_ROWS):
        raise KinematicsError(f"rows of a Jacobian are numbered 0 to 5, not {tuple(rows)}")
    whole = dimensionless(made.jacobian(values), length_of(chain), chain.kinds)
    return tuple(whole[row] for row in rows)
