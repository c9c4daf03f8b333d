"""Jacobians of chains: tip rates from joint rates, joint rates from tip rates, singularities.

Geometric: each column is the joint's axis z and z x (tip - axis) (Whitney, 1972; Craig, chapter 5).
Lengths in mm, angles in rad, rates per second of whatever the joint is measured in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from kinematics.chains.chain import Chain
from kinematics.chains.generated import Generated, generated
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError, finite, positive
from kinematics.frames.matrices import Singular, singular, times, transposed
from kinematics.frames.transforms import position_of
from kinematics.frames.vectors import cross, norm, subtract
from kinematics.spaces import Jacobian

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
    """Return the volume of the tip rates that unit joint rates give (Yoshikawa, 1985).

    The product of the singular values: |det J| of a square Jacobian, zero where the arm is
    singular. Its unit follows the rows'.
    """
    return math.prod(singular(jacobian).values)


# Joint rates from tip rates, damped near singularities so that no joint runs away.
#
# Source: Wampler (1986) and Nakamura and Hanafusa (1986), damped least squares. Each singular
# direction is damped by itself and only below a threshold e: there the gain 1/s becomes s/e^2,
# which is damping by e^2 - s^2, continuous at s = e and never more than 1/e.

DAMPED_BELOW = 0.05
"""Singular value, dimensionless, below which a direction is damped: joint rates in rad/s stay
under 20 times the tip's rate in lengths of the arm a second."""


@dataclass(frozen=True, slots=True)
class Rates:
    """Joint rates, and the tip rates that they give.

    `achieved` are the tip rates to first order and `missed` the rest of the wanted ones: zero if
    nothing is damped and the arm has enough axes. `smallest` is the smallest singular value,
    dimensionless, and `damped` whether it is below the threshold.
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
    threshold: float = DAMPED_BELOW,
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
    positive("length_mm", length_mm)
    positive("threshold", threshold)
    wanted = [
        finite("a tip rate", rate) / (length_mm if row in POSITION_ROWS else 1.0)
        for row, rate in enumerate(tip_rates)
    ]
    parts = singular(dimensionless(jacobian, length_mm))
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


# Singularities of any chain: how near, which direction is lost, and the nearest one.
#
# A posture is singular where the Jacobian loses a rank: some direction of the tip cannot be moved
# in, or some joints can move against each other with the tip at rest (McKerrow, chapter 4, section
# 12, "degeneracies"). Jacobians are made dimensionless by a length of the arm, so that singular
# values and distances are in rad, and in lengths of the arm for slides.

SINGULAR = 1e-9
"""A dimensionless singular value below this is zero."""

EQUAL_SHARE = 1e-6
"""Singular values no further apart than this share are one: no direction is the hardest."""

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
        chain, scaled_rows(chain, generated(chain), chain.directions(values), chosen), chosen
    )


def in_words(rates: Sequence[float], rows: Sequence[int]) -> str:
    """Describe a direction of the tip: move along these axes, turn about those.

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
        _sentence(chain, parts.values, hardest, idle, rows),
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
    is_singular, is_near = smallest < SINGULAR, smallest < DAMPED_BELOW
    joints = _named(
        [(name.replace("_", " "), part) for name, part in zip(chain.joint_names, idle, strict=True)]
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


def scaled_rows(
    chain: Chain, made: Generated, values: Sequence[float], rows: Sequence[int]
) -> Jacobian:
    """Return the dimensionless rows of the Jacobian."""
    if not rows or not set(rows) <= set(ALL_ROWS):
        raise KinematicsError(f"rows of a Jacobian are numbered 0 to 5, not {tuple(rows)}")
    whole = dimensionless(made.jacobian(values), length_of(chain), chain.kinds)
    return tuple(whole[row] for row in rows)


# The nearest singular posture of a chain: which joints must move how far to get there.
#
# Distances are in rad, and in lengths of the arm for slides, as singular values are.

_STEP = 1e-6
_ROUNDS = 40
_FLAT = 1e-18
"""Squared slope below which a singular value goes nowhere."""


@dataclass(frozen=True, slots=True)
class NearestSingularity:
    """A singular posture near a given one, found by descent: none nearer was met, one may exist.

    `distance` is the root of the sum of the squared joint moves, in rad (slides in lengths of
    the arm); `condition` is that of the singular posture.
    """

    values: tuple[float, ...]
    distance: float
    condition: Condition


def nearest_singularity(
    chain: Chain, values: Sequence[float], rows: Sequence[int] | None = None
) -> NearestSingularity | None:
    """Return the nearest singular posture that descent finds; None where it finds none.

    Each of the smallest three singular values is followed to zero, by the shortest joint move
    (Newton's method on the value, its gradient being left . dJ . right); joint limits are not
    looked at. What is found is an upper bound of the distance.
    """
    chosen = default_rows(chain) if rows is None else tuple(rows)
    start = chain.checked(values)
    found = [
        end
        for which in range(1, min(3, len(chosen), len(chain)) + 1)
        if (end := _descend(chain, start, chosen, which)) is not None
    ]
    if not found:
        return None
    units = units_of(chain)
    best = min(found, key=lambda end: _move(start, end, units))
    return NearestSingularity(best, _move(start, best, units), condition(chain, best, chosen))


def units_of(chain: Chain) -> tuple[float, ...]:
    """Return what one dimensionless unit of each joint is, in rad or mm."""
    length = length_of(chain)
    return tuple(length if kind is JointKind.PRISMATIC else 1.0 for kind in chain.kinds)


def _move(start: Sequence[float], end: Sequence[float], units: Sequence[float]) -> float:
    return math.hypot(*((b - a) / u for a, b, u in zip(start, end, units, strict=True)))


def _descend(
    chain: Chain, start: Sequence[float], rows: Sequence[int], which: int
) -> tuple[float, ...] | None:
    """Follow one singular value, counted from the smallest, to zero by the shortest move."""
    made, units = generated(chain), units_of(chain)
    values = tuple(start)
    for _ in range(_ROUNDS):
        jacobian = scaled_rows(chain, made, values, rows)
        parts = singular(jacobian)
        index = -which if parts.values[-1] >= SINGULAR else -1
        size = parts.values[index]
        if size < SINGULAR:
            return values
        gradient = _gradient(chain, made, values, rows, parts.left[index], parts.right[index])
        steep = sum(slope * slope for slope in gradient)
        if steep < _FLAT:
            return None
        back = [(a - b) / u for a, b, u in zip(start, values, units, strict=True)]
        shift = size + sum(slope * way for slope, way in zip(gradient, back, strict=True))
        target = [
            a - slope * shift / steep * u
            for a, slope, u in zip(start, gradient, units, strict=True)
        ]
        values = _limited(values, target, units)
    return None


def _gradient(
    chain: Chain,
    made: Generated,
    values: Sequence[float],
    rows: Sequence[int],
    left: Sequence[float],
    right: Sequence[float],
) -> list[float]:
    """Return how a singular value changes with each joint, by central differences of J alone."""
    slopes = []
    for joint, unit in enumerate(units_of(chain)):
        ends = []
        for sign in (1.0, -1.0):
            moved = list(values)
            moved[joint] += sign * _STEP * unit
            jacobian = scaled_rows(chain, made, moved, rows)
            ends.append(
                sum(
                    a * sum(entry * b for entry, b in zip(row, right, strict=True))
                    for a, row in zip(left, jacobian, strict=True)
                )
            )
        slopes.append((ends[0] - ends[1]) / (2.0 * _STEP))
    return slopes


def _limited(
    values: Sequence[float], target: Sequence[float], units: Sequence[float]
) -> tuple[float, ...]:
    """Return the target, or a point half a unit on the way there if it is further."""
    far = _move(values, target, units)
    share = min(1.0, 0.5 / far) if far > 0.0 else 1.0
    return tuple(a + share * (b - a) for a, b in zip(values, target, strict=True))
