"""Whether a program may be taken up where it was interrupted: only where the arm stands there.

The interrupted act is done once more, from wherever it broke off. So the arm has to stand where
that act began, on its way, or at its end; and its position has to be one that can be trusted.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from armdrive.calls.moving import PARK_RISE_MM, raised
from armdrive.errors import ArmError, Refused
from armdrive.foresight import postures_along
from armdrive.goals import Goal, Ground, LineGoal, PoseGoal
from armdrive.planning import speed_fraction
from armdrive.programs.acts import Act, Fingers, Go, Grasp, Home, Ready
from armdrive.programs.performing import joints_of, place_of
from armdrive.whereabouts import Coordinates
from kinematics import Joints
from kinematics.errors import KinematicsError

if TYPE_CHECKING:
    from armdrive.arm import Arm
    from armdrive.programs.journal import Entry, Standing

NEAR_RAD = math.radians(3.0)
"""A posture whose joints are all as near as this is on the way: motors may stray between bursts."""

NEAR_MM = 2.0
"""Fingers as near as this are where they should be."""


def require_same_program(entry: Entry, sha256: str, path: str) -> None:
    """Raise `Refused` where a program is not the one that was interrupted."""
    if entry.sha256 != sha256:
        changed = entry.program == path
        raise Refused(
            f"{path} was changed since it was interrupted in line {entry.line}: begin it anew"
            if changed
            else f"the program that was interrupted is {entry.program}, in line {entry.line}, and "
            f"not {path}: resume that one, or begin this one anew"
        )


def require_place(
    arm: Arm, entry: Entry, act: Act, how: str, *, move: str = "armdrive move"
) -> None:
    """Raise `Refused` unless the arm stands where an interrupted act can be done once more.

    `how` is the command that takes the program up, `move` the one that moves this arm.
    Raises `NotReferenced` for a position that is not to be trusted. Sends nothing.
    """
    if isinstance(act, Home):
        return
    arm.core.require_reference()
    if entry.began is None:
        return  # nobody knew, so nothing but looks and words can have come before
    with arm.pace.lock:
        here = arm.core.coordinates
    began = Coordinates(joints_of(entry.began.joints_deg, arm), entry.began.opening_mm)
    on_way = any(_near(here.joints, each) for each in _way(arm, began, act))
    if not on_way or not _fingers_fit(arm, here, began, act):
        raise Refused(_elsewhere(here, entry.began, how, move))


def _near(here: Joints, there: Joints) -> bool:
    return all(abs(a - b) <= NEAR_RAD for a, b in zip(here, there, strict=True))


def _way(arm: Arm, began: Coordinates, act: Act) -> Iterator[Joints]:
    """Give the postures that an act leads through, the one in which it began first."""
    yield began.joints
    for goals in _ways(arm, began, act):
        here = began
        for goal in goals:
            ground = Ground(arm.config, arm.speeds, here)
            try:
                plan = goal.plan(ground, speed_fraction(1.0))
            except (ArmError, KinematicsError):
                break  # there is no such way: the act itself is refused then
            yield from postures_along(arm.model.arm, plan)
            here = plan.end


def _ways(arm: Arm, began: Coordinates, act: Act) -> Iterator[tuple[Goal, ...]]:
    if isinstance(act, Go):
        yield (arm.goal_of(place_of(act, arm), line=act.line),)
    elif isinstance(act, Ready):
        park = PoseGoal(arm.config.park or arm.above_mark())
        yield (park,)
        rise = LineGoal(raised(arm.model.arm.fk(began.joints), PARK_RISE_MM))
        yield (rise, park)


def _fingers_fit(arm: Arm, here: Coordinates, began: Coordinates, act: Act) -> bool:
    """Tell whether the fingers are where they were, or on their way to where the act has them."""
    if not arm.core.transmission.has_gripper:
        return True  # a servo goes where it is told
    goal_mm = _goal_mm(arm, act)
    ends = (began.opening_mm, began.opening_mm if goal_mm is None else goal_mm)
    return min(ends) - NEAR_MM <= here.opening_mm <= max(ends) + NEAR_MM


def _goal_mm(arm: Arm, act: Act) -> float | None:
    """Return where an act brings the fingers; None where it leaves them as they are."""
    if isinstance(act, Grasp):
        return 0.0
    if isinstance(act, Fingers):
        return arm.model.gripper_range_mm[1] if act.opening_mm is None else act.opening_mm
    return act.opening_mm if isinstance(act, Go) else None


def _elsewhere(here: Coordinates, began: Standing, how: str, move: str) -> str:
    now = here.joints.deg
    apart = [
        f"{name} {now[name]:.1f}° instead of {angle:.1f}°"
        for name, angle in began.joints_deg.items()
        if abs(now[name] - angle) > math.degrees(NEAR_RAD)
    ]
    if abs(here.opening_mm - began.opening_mm) > NEAR_MM:
        apart.append(f"fingers {here.opening_mm:.0f} mm instead of {began.opening_mm:.0f} mm")
    joints = " ".join(f"--joint {name}={angle:.2f}" for name, angle in began.joints_deg.items())
    return (
        f"the arm does not stand where the program was interrupted ({', '.join(apart)}): bring it "
        f"back with `{move} {joints} --gripper {began.opening_mm:.1f}`, look whether what "
        f"it held is still there, then `{how}`; or begin the program anew"
    )
