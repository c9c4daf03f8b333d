"""Jogging a model: one step of a joint, or of the hand, from a posture to the next.

No arm is connected, so a step ends at once. The hand is moved as `explain --goal` solves: by the
formulas of a named system, or by the solver of any link table. A message says which part of a step
was impossible. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinematics.chains.chain import Chain
from kinematics.chains.goals import ALL_PARTS, Part
from kinematics.chains.inverse import solve_frame_ik
from kinematics.chains.jacobians import units_of
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError, OutOfReach
from kinematics.text import significant
from kinematics.textbook.study import FRAME_COORDINATES, Subject, study
from kinematics.textbook.systems.named import NamedBranch, System, frame_coordinates
from kinematics.textbook.worked_example import frame_of, number_text

# The message names a joint that turns further than this in one step.
LEAP_RAD = math.pi / 4.0


@dataclass(frozen=True, slots=True)
class Stepped:
    """The posture after a step, and a message if the step was not made in full."""

    values: tuple[float, ...]
    message: str = ""


def coordinates_of(subject: Subject) -> tuple[str, ...]:
    """Return the coordinates by which the hand is jogged, with their units.

    Those of a named system; of a link table the place, and with six joints the turn of the hand.
    """
    if subject.system is not None:
        return subject.system.coordinates
    return FRAME_COORDINATES if len(subject.chain) >= len(FRAME_COORDINATES) else PLACE


PLACE = FRAME_COORDINATES[:3]


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
    """Move the hand by this many mm or rad along one of `coordinates_of`, or not at all."""
    system = subject.system
    if system is not None:
        return _by_branch(subject, system, values, axis, by)
    goal = list(frame_coordinates(subject.chain.fk(values))[: len(coordinates_of(subject))])
    goal[axis] += by
    parts = ALL_PARTS if len(goal) > len(PLACE) else frozenset({Part.POSITION})
    found = solve_frame_ik(subject.chain, frame_of(goal), values, parts=parts)
    if not found.ok:
        return Stepped(values, found.sentence)
    return Stepped(found.joints, _leap(subject.chain, values, found.joints))


def _by_branch(
    subject: Subject, system: System, values: tuple[float, ...], axis: int, by: float
) -> Stepped:
    """Solve for the next goal, and take the branch nearest to the posture.

    A system with fewer joints than coordinates has its tip on a surface, and goes to the place of
    the surface nearest to the goal.
    """
    before, message = study(subject, values), ""
    goal = list(before.goal)
    goal[axis] += by
    try:
        found = system.ik(goal, values)
    except OutOfReach as error:
        if len(system.coordinates) <= len(subject.chain):
            away = significant(error.away_mm)
            return Stepped(values, f"out of reach: the hand stays {away} mm short")
        message = f"the tip keeps to its surface, {significant(error.away_mm)} mm from that goal"
        found = system.ik(error.nearest, values)
    except KinematicsError as error:
        return Stepped(values, str(error))
    taken = min(found, key=lambda branch: _furthest(subject.chain, values, branch))
    if taken.violations:
        broken = "; ".join(map(str, taken.violations))
        return Stepped(values, f"not within the limits on {taken.name}: {broken}")
    return Stepped(taken.joints, _leap(subject.chain, values, taken.joints) or message)


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
