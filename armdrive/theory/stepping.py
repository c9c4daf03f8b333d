"""Jogging a model: one step of a joint, or of the hand, from a posture to the next.

Nothing is connected, so that a step is done at once; what it could not do it says in words.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from operator import mul

from armdrive.theory.study import study
from armdrive.theory.subject import Subject
from kinematics.chains import Chain
from kinematics.errors import KinematicsError, OutOfReach
from kinematics.frames import Transform, position_of, rotation_of
from kinematics.generated import generated
from kinematics.links import JointKind
from kinematics.own_jacobian import ROW_NAMES
from kinematics.rates import joint_rates
from kinematics.singularities import length_of
from kinematics.systems import NamedBranch, System
from kinematics.vectors import dot, subtract
from kinematics.worked_text import number_text, violation_text

LEAP_RAD = math.pi / 4.0
"""A joint that turns further than this in one step is spoken of."""

SLICES = 16
"""A step by the Jacobian is made of so many small ones."""

POSITION, WHOLE = 3, 6
"""Rows of the geometric Jacobian that are followed: the tip alone, or the whole hand."""

MET = 0.02
"""A step that misses less than this share of itself is as good as asked."""

REFUSED = 0.5
"""A step that misses more than this share of itself is not made at all."""


@dataclass(frozen=True, slots=True)
class Stepped:
    """The posture after a step, and what it could not do; empty where it did all of it."""

    values: tuple[float, ...]
    said: str = ""


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
    return tuple(ROW_NAMES[row] for row in subject.rows if row < _followed(subject))


def axis_unit(axis: str) -> str:
    """Return the unit of an axis: mm or rad."""
    return "mm" if axis in ROW_NAMES[:POSITION] else "rad"


def step_joint(subject: Subject, values: tuple[float, ...], joint: int, by: float) -> Stepped:
    """Move one joint by so many rad or mm, as far as its limits let it."""
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
    """Move the hand along one of `axes_of` by so many mm or rad; it stays where it cannot."""
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
        return Stepped(values, f"out of reach: {_beyond(error)}")
    except KinematicsError as error:
        return Stepped(values, str(error))
    on = before.branches[before.here].name if before.here is not None else ""
    named = [branch for branch in found if branch.name == on]
    taken = min(named or found, key=lambda branch: _furthest(subject.chain, values, branch))
    if taken.violations:
        broken = "; ".join(map(violation_text, taken.violations))
        return Stepped(values, f"not within the limits on {taken.name}: {broken}")
    return Stepped(taken.joints, _leap(subject.chain, values, taken.joints))


def _beyond(error: OutOfReach) -> str:
    return (
        f"{error.quantity} would be {error.value:.1f} mm, {error.excess:.3g} mm beyond "
        f"{error.bound:.1f} mm"
    )


def _furthest(chain: Chain, values: tuple[float, ...], branch: NamedBranch) -> float:
    units = [length_of(chain) if kind is JointKind.PRISMATIC else 1.0 for kind in chain.kinds]
    return max(abs(b - a) / unit for a, b, unit in zip(values, branch.joints, units, strict=True))


def _leap(chain: Chain, before: tuple[float, ...], after: tuple[float, ...]) -> str:
    """Say which joint turned far for so small a step: a singularity is near."""
    turns = [
        (abs(b - a), name)
        for a, b, name, kind in zip(before, after, chain.joint_names, chain.kinds, strict=True)
        if kind is JointKind.REVOLUTE
    ]
    far, name = max(turns, default=(0.0, ""))
    if far <= LEAP_RAD:
        return ""
    return f"{name} turned by {number_text(far, 'rad')} at once: a singularity is near"


def _followed(subject: Subject) -> int:
    """Return how many rows of the geometric Jacobian are followed.

    The whole hand where there are joints enough for all that can move, else the tip alone.
    """
    return WHOLE if len(subject.rows) <= len(subject.chain) else POSITION


def _by_jacobian(subject: Subject, values: tuple[float, ...], axis: int, by: float) -> Stepped:
    """Follow the Jacobian in small steps, damped near singularities, within the limits."""
    chain, count = subject.chain, _followed(subject)
    row = [row for row in subject.rows if row < count][axis]
    rates = [by / SLICES if index == row else 0.0 for index in range(count)]
    made, length, at = generated(chain), length_of(chain), values
    units = [length if kind is JointKind.PRISMATIC else 1.0 for kind in chain.kinds]
    for _ in range(SLICES):  # slides counted in lengths of the arm, or they would hardly be used
        rows = (map(mul, line, units) for line in made.jacobian(at)[:count])
        slopes = joint_rates(tuple(map(tuple, rows)), rates, length_mm=length).joints
        moved = zip(at, slopes, units, strict=True)
        at = chain.clamp([one + slope * unit for one, slope, unit in moved])
    before, after = made.fk(values), made.fk(at)
    done = _gone(before, after, row)
    missed = max(abs(by - done) / abs(by), _astray(before, after, row, by, length))
    name, unit = ROW_NAMES[row], "mm" if row < POSITION else "rad"
    if missed > REFUSED:
        lacks = study(subject, values).condition.sentence
        return Stepped(values, f"no step along {name} from here: {lacks}")
    if missed > MET:
        went, asked = number_text(done, unit), number_text(by, unit)
        return Stepped(at, f"near a singularity or a limit: {name} moved by {went}, not {asked}")
    return Stepped(at)


def _gone(before: Transform, after: Transform, row: int) -> float:
    """Return how far the hand went along an axis, or turned about it."""
    if row < POSITION:
        return position_of(after)[row] - position_of(before)[row]
    one, two = (row - 2) % 3, (row - 1) % 3  # the axes that a turn about this one carries along
    was, now = rotation_of(before), rotation_of(after)
    turned = dot(was[one], now[two]) - dot(was[two], now[one])
    return math.atan2(turned, dot(was[one], now[one]) + dot(was[two], now[two]))


def _astray(before: Transform, after: Transform, row: int, by: float, length_mm: float) -> float:
    """Return how far beside its way the tip came, as a share of the step."""
    beside = list(subtract(position_of(after), position_of(before)))
    if row < POSITION:
        beside[row] = 0.0
    return math.hypot(*beside) / (abs(by) * (1.0 if row < POSITION else length_mm))
