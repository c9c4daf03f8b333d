"""What the Jacobian of a posture says of how well the hand can move, and of singularities.

A posture is singular where the Jacobian loses a rank: some direction of the tip cannot be moved
in, or some joints can move against each other with the tip at rest (McKerrow, chapter 4, section
12, "degeneracies"). Lengths in mm, angles in rad. Before singular values are compared, mm are
counted in a length of the arm, for slides too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from kinematics.chains.chain import Chain
from kinematics.chains.evaluation import evaluator
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError
from kinematics.frames.transforms import position_of
from kinematics.frames.vectors import norm
from kinematics.spaces import Jacobian
from kinematics.text import shown_name

# The rows of a geometric Jacobian that concern the tip's position.
POSITION_ROWS = (0, 1, 2)

ALL_ROWS = (0, 1, 2, 3, 4, 5)

# Below this dimensionless singular value a direction is nearly lost.
NEARLY_SINGULAR = 0.05

# A dimensionless singular value below this is zero.
SINGULAR = 1e-9

# Singular values no further apart than this share are one: no direction is the hardest.
EQUAL_SHARE = 1e-6

# Components of a unit direction below this are left out of its description.
SMALL_PART = 0.05

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
    if not chosen or not set(chosen) <= set(ALL_ROWS):
        raise KinematicsError(f"rows of a Jacobian are numbered 0 to 5, not {chosen}")
    whole = evaluator(chain).jacobian(chain.directions(values))
    return condition_of(chain, tuple(whole[row] for row in chosen), chosen)


def in_words(rates: Sequence[float], rows: Sequence[int]) -> str:
    """Describe a direction of the tip: move along these axes, turn about those.

    Rows 0 to 5 are those of a geometric Jacobian; 6 and 7 are pitch and roll of five-axis arms.
    """
    parts = tuple(zip(rows, rates, strict=True))
    moves = _named([(_AXES[row], part) for row, part in parts if row < 3])
    turns = _named([(_TURNS[row - 3], part) for row, part in parts if row >= 3])
    said = [f"move along {moves}"] if moves else []
    said += [f"turn about {turns}"] if turns else []
    return " and ".join(said)


def condition_of(chain: Chain, jacobian: Jacobian, rows: Sequence[int]) -> Condition:
    """Return how well a posture can move by rows of a Jacobian in mm and rad.

    `rows` say what they are, numbered as for `in_words`.
    """
    length, units = length_of(chain), units_of(chain)
    jacobian = tuple(
        tuple(
            entry * unit / (length if row in POSITION_ROWS else 1.0)
            for entry, unit in zip(entries, units, strict=True)
        )
        for row, entries in zip(rows, jacobian, strict=True)
    )
    import numpy as np  # not loaded by arms that are only driven

    left, values, right = np.linalg.svd(jacobian)
    last = len(values) - 1
    hardest, idle = tuple(map(float, left[:, last])), tuple(map(float, right[last]))
    sizes = tuple(map(float, values))
    return Condition(
        sizes,
        math.prod(sizes),
        hardest,
        idle,
        sizes[last] < SINGULAR,
        _sentence(chain, sizes, hardest, idle, rows),
    )


def _sentence(
    chain: Chain,
    singular_values: Sequence[float],
    hardest: Sequence[float],
    idle: Sequence[float],
    rows: Sequence[int],
) -> str:
    """Describe the direction that is lost, nearly lost, or the hardest."""
    largest, smallest = singular_values[0], singular_values[-1]
    if smallest >= (1.0 - EQUAL_SHARE) * largest > SINGULAR:
        return f"the tip moves as easily in every direction: all singular values are {smallest:.3g}"
    is_singular, is_near = smallest < SINGULAR, smallest < NEARLY_SINGULAR
    joints = _named(
        [(shown_name(name), part) for name, part in zip(chain.joint_names, idle, strict=True)]
    )
    parts = []
    if len(rows) <= len(chain):
        able = "cannot" if is_singular else "can hardly" if is_near else "is slowest to"
        parts.append(f"the tip {able} {in_words(hardest, rows)}")
    if len(rows) >= len(chain):
        still = "leaves the tip at rest" if is_singular else "moves it least"
        if is_near and not is_singular:
            still = "leaves the tip almost at rest"
        parts.append(f"moving {joints} {still}")
    said = "; ".join(parts)
    return f"singular: {said}" if is_singular else f"smallest singular value {smallest:.3g}: {said}"


def _named(parts: Sequence[tuple[str, float]]) -> str:
    """List the larger components with their shares: "0.97 x - 0.24 z"."""
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


def units_of(chain: Chain) -> tuple[float, ...]:
    """Return what one dimensionless unit of each joint is, in rad or mm."""
    length = length_of(chain)
    return tuple(length if kind is JointKind.PRISMATIC else 1.0 for kind in chain.kinds)
