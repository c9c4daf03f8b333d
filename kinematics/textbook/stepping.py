"""Jogging a model: one step of a joint, or of the hand, from a posture to the next.

No arm is connected, so a step ends at once. A message says which part of a step was impossible.
Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from operator import mul

from kinematics.chains.chain import Chain
from kinematics.chains.generated import generated
from kinematics.chains.jacobians import joint_rates, length_of, units_of
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError, OutOfReach
from kinematics.frames.transforms import Transform, position_of, rotation_of
from kinematics.frames.vectors import dot, subtract
from kinematics.text import significant
from kinematics.textbook.study import ROW_NAMES, Subject, study
from kinematics.textbook.systems.named import NamedBranch, System
from kinematics.textbook.worked_example import number_text, violation_text

# Following the Jacobian of a link table: a step of the hand in small ones, within the limits.
# Damped near singularities, so that no joint runs away (see `chains.jacobians`).

SLICES = 16
"""Small steps that make up one step of a jog key."""

POSITION, WHOLE = 3, 6
"""Rows of the geometric Jacobian that are followed: the tip alone, or the whole hand."""


@dataclass(frozen=True, slots=True)
class Followed:
    """The posture after a step by the Jacobian, and the deviation of the tip from the axis.

    `done` is how far it went along the axis, `deviation` its distance from the axis as a share of
    the step. `held` names the joints that reached a limit.
    """

    values: tuple[float, ...]
    done: float
    deviation: float
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
    """Move the hand by this many mm or rad along one row of the geometric Jacobian only."""
    chain, count = subject.chain, rows_followed(subject)
    rates = [by / SLICES if index == row else 0.0 for index in range(count)]
    made, length, at = generated(chain), length_of(chain), values
    units = units_of(chain)  # slides in lengths of the arm: in mm they would hardly be used
    held: set[str] = set()
    for _ in range(SLICES):
        rows = (map(mul, line, units) for line in made.jacobian(at)[:count])
        slopes = joint_rates(tuple(map(tuple, rows)), rates, length_mm=length).joints
        moved = [one + slope * unit for one, slope, unit in zip(at, slopes, units, strict=True)]
        held.update(one.joint for one in chain.violations(moved))
        at = chain.clamp(moved)
    before, after = made.fk(values), made.fk(at)
    named = tuple(name for name in chain.joint_names if name in held)
    return Followed(at, _gone(before, after, row), _deviation(chain, before, after, row, by), named)


def _gone(before: Transform, after: Transform, row: int) -> float:
    """Return how far the hand moved along an axis, or turned about it."""
    if row < POSITION:
        return position_of(after)[row] - position_of(before)[row]
    one, two = (row - 2) % 3, (row - 1) % 3  # the axes that a turn about this one carries along
    was, now = rotation_of(before), rotation_of(after)
    turned = dot(was[one], now[two]) - dot(was[two], now[one])
    return math.atan2(turned, dot(was[one], now[one]) + dot(was[two], now[two]))


def _deviation(chain: Chain, before: Transform, after: Transform, row: int, by: float) -> float:
    """Return how far the tip left its straight line, as a share of the step."""
    across = list(subtract(position_of(after), position_of(before)))
    if row < POSITION:
        across[row] = 0.0
    return math.hypot(*across) / (abs(by) * (1.0 if row < POSITION else length_of(chain)))


LEAP_RAD = math.pi / 4.0
"""The message names a joint that turns further than this in one step."""

NEGLIGIBLE_MISS = 0.02
"""A step that misses less than this share of itself needs no message."""

WORST_MISS = 0.5
"""A step that would miss more than this share of itself is not made at all."""


@dataclass(frozen=True, slots=True)
class Stepped:
    """The posture after a step, and a message if the step was not made in full."""

    values: tuple[float, ...]
    message: str = ""


def has_inverse(subject: Subject) -> bool:
    """Whether the hand is jogged by the closed form; else it is by the Jacobian.

    A system with fewer joints than coordinates leaves its surface at any step of one of them.
    """
    system = subject.system
    return system is not None and len(system.coordinates) <= len(subject.chain)


def axes_of(subject: Subject) -> tuple[str, ...]:
    """Return the axes along which the hand is jogged, by name."""
    if subject.system is not None and has_inverse(subject):
        return tuple(name.rpartition("_")[0] for name in subject.system.coordinates)
    return tuple(ROW_NAMES[row] for row in subject.rows if row < rows_followed(subject))


def axis_unit(axis: str) -> str:
    """Return the unit of an axis: mm or rad."""
    return "mm" if axis in ROW_NAMES[:POSITION] else "rad"


def step_joint(subject: Subject, values: tuple[float, ...], joint: int, by: float) -> Stepped:
    """Move one joint by this many rad or mm, or up to its limit."""
    chain = subject.chain
    moved = list(values)
    moved[joint] += by
    bounded = chain.clamp(moved)
    if bounded == tuple(moved):
        return Stepped(bounded)
    unit = chain.kinds[joint].unit
    bound = number_text(bounded[joint], unit)
    missed = number_text(abs(moved[joint] - bounded[joint]), unit)
    name = chain.joint_names[joint]
    return Stepped(bounded, f"{name} stands at its limit of {bound}: {missed} of the step are left")


def step_axis(subject: Subject, values: tuple[float, ...], axis: int, by: float) -> Stepped:
    """Move the hand by this many mm or rad along one of `axes_of`, or not at all."""
    system = subject.system
    if system is not None and has_inverse(subject):
        return _by_branch(subject, system, values, axis, by)
    return _by_jacobian(subject, values, axis, by)


def _by_branch(
    subject: Subject, system: System, values: tuple[float, ...], axis: int, by: float
) -> Stepped:
    """Solve for the next goal, and take the branch that the posture is on."""
    before = study(subject, values)
    goal = list(before.goal)
    goal[axis] += by
    try:
        found = system.ik(goal, values)
    except OutOfReach as error:
        return Stepped(
            values, f"out of reach: the hand stays {significant(error.away_mm)} mm short"
        )
    except KinematicsError as error:
        return Stepped(values, str(error))
    on = before.branches[before.here].name if before.here is not None else ""
    named = [branch for branch in found if branch.name == on]
    taken = min(named or found, key=lambda branch: _furthest(subject.chain, values, branch))
    if taken.violations:
        broken = "; ".join(map(violation_text, taken.violations))
        return Stepped(values, f"not within the limits on {taken.name}: {broken}")
    return Stepped(taken.joints, _leap(subject.chain, values, taken.joints))


def _furthest(chain: Chain, values: tuple[float, ...], branch: NamedBranch) -> float:
    pairs = zip(values, branch.joints, units_of(chain), strict=True)
    return max(abs(b - a) / unit for a, b, unit in pairs)


def _leap(chain: Chain, before: tuple[float, ...], after: tuple[float, ...]) -> str:
    """Say which joint turned far for so small a step, and why."""
    turns = [
        (abs(b - a), name)
        for a, b, name, kind in zip(before, after, chain.joint_names, chain.kinds, strict=True)
        if kind is JointKind.REVOLUTE
    ]
    far, name = max(turns, default=(0.0, ""))
    if far <= LEAP_RAD:
        return ""
    whole_turn = abs(far - math.tau) <= LEAP_RAD
    why = "its limit lets it go on only from a turn back" if whole_turn else "a singularity is near"
    return f"{name} turned by {number_text(far, 'rad')} at once: {why}"


def _by_jacobian(subject: Subject, values: tuple[float, ...], axis: int, by: float) -> Stepped:
    """Follow the Jacobian, and describe any shortfall."""
    row = [row for row in subject.rows if row < rows_followed(subject)][axis]
    went = follow(subject, values, row, by)
    missed = abs(by - went.done) / abs(by)
    name, unit = ROW_NAMES[row], "mm" if row < POSITION else "rad"
    most = max(missed, 0.0 if keeps_to_surface(subject) else went.deviation)
    if most > WORST_MISS:
        lacks = study(subject, values).condition.sentence
        held = f"{', '.join(went.held)} at the limit; " if went.held else ""
        return Stepped(values, f"no step along {name} from here: {held}{lacks}")
    if most > NEGLIGIBLE_MISS:
        done, asked = number_text(went.done, unit), number_text(by, unit)
        return Stepped(went.values, f"{_why(subject, went)}: {name} moved by {done}, not {asked}")
    return Stepped(went.values)


def _why(subject: Subject, went: Followed) -> str:
    """Say why a step by the Jacobian fell short."""
    if went.held:
        return f"{', '.join(went.held)} at the limit"
    return "the tip keeps to its surface" if keeps_to_surface(subject) else "near a singularity"
