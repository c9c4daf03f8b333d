"""How far a jog may go on its way before a bound, and what bound that is, in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.planning import guard_error
from kinematics import Unreachable, first_violation

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from armdrive.jog_ways import Way
    from armdrive.whereabouts import Coordinates
    from kinematics import Joints
    from kinematics.guards.guards import Violation

HALVINGS = 9
"""How closely a bound is looked for: to a five-hundredth of what is looked ahead, leg by leg."""


@dataclass(frozen=True, slots=True)
class Ended:
    """Why a jog goes no further; `cause` gives the code of it in the catalogue, if it has one."""

    note: str
    cause: Exception | None = None


@dataclass(frozen=True, slots=True)
class Free:
    """How long a way is free at its speed: of the edge of the reach, and of the guards.

    `beyond_s` is a moment at which the nearer of the two is passed; none where all is free.
    """

    reach_s: float
    clear_s: float
    beyond_s: float = math.inf

    @property
    def free_s(self) -> float:
        """How long it is free of both."""
        return min(self.reach_s, self.clear_s)


class Bounds:
    """What bounds the jogs of one arm besides its limits: its reach and its guards.

    How far the arm may travel before a guard is broken is looked at once and then used up leg by
    leg; only where that does not suffice is the way itself proved (kinematics/guards/path.py).
    """

    def __init__(self, config: ArmConfig) -> None:
        self._arm = config.model.arm
        self._guards = config.model.guards
        self._transmission = config.model.transmission
        self._guarded = self._guards.over(self._arm)
        self._rounding_mm = self._most_rounding_mm()
        self._stands: Joints | None = None
        self._left_mm = 0.0
        self._looked = False

    def free(self, way: Way, here: Joints, look_s: float) -> Free:
        """Return how long a way from here is free, at most `look_s`."""
        reach_s, unreached_s = furthest(lambda time_s: way.at(time_s) is not None, look_s)

        def clear(time_s: float) -> bool:
            there = way.at(time_s)
            return there is not None and self.holds(here, there.joints)

        clear_s, unclear_s = furthest(clear, reach_s)
        return Free(reach_s, clear_s, min(unreached_s, unclear_s))

    def ended(self, way: Way, here: Joints, beyond_s: float) -> Ended:
        """Say what is passed at a moment."""
        there = way.at(beyond_s)
        if there is None:
            why = way.why(beyond_s)
            cause = why if isinstance(why, Exception) else None
            return _ended(why.reason if isinstance(why, Unreachable) else str(why), cause)
        broken = self._broken(here, there.joints)
        if broken is None:  # only rounding can bring this about
            return Ended("")
        return _ended(broken.sentence, guard_error(broken, 1.0))

    def went(self, here: Joints, there: Joints) -> None:
        """Hear that the arm goes there, which uses up some of the room."""
        if self._stands is here:
            self._left_mm -= self._way_mm(here, there)
            self._stands, self._looked = there, False

    def holds(self, here: Joints, there: Joints) -> bool:
        """Tell whether the way straight in joint space breaks no guard, or none deeper.

        Near a guard that holds as well for the whole steps on which the arm would come to rest.
        """
        way_mm = self._way_mm(here, there) + self._rounding_mm
        if not self._guards.sums and self._has_room(here, way_mm):
            return True
        return self._broken(here, there) is None

    def _broken(self, here: Joints, there: Joints) -> Violation | None:
        for way in ([here, there], [self._whole(here), self._whole(there)]):
            found = first_violation(self._arm, self._guards, way, way_out=True)
            if found is not None:
                return found[1]
        return None

    def _whole(self, joints: Joints) -> Joints:
        """Return the posture on whole steps that stands for another."""
        if self._transmission is None:
            return joints
        return self._transmission.to_joints(self._transmission.to_motors(joints))[0]

    def _has_room(self, here: Joints, way_mm: float) -> bool:
        known = self._stands is here
        if known and way_mm <= self._left_mm:
            return True
        if not (known and self._looked):
            self._stands, self._looked = here, True
            self._left_mm = min(self._guarded.room(here))
        return way_mm <= self._left_mm

    def _most_rounding_mm(self) -> float:
        """Return how far a point of the arm is off at most because motors stand on whole steps."""
        if self._transmission is None:
            return 0.0
        rows = self._transmission.inverse[: len(self._arm.limits)]
        return self._arm.travel_bound_mm([0.5 * math.fsum(map(abs, row)) for row in rows])

    def _way_mm(self, here: Joints, there: Joints) -> float:
        return self._arm.travel_bound_mm([b - a for a, b in zip(here, there, strict=True)])


def furthest(good: Callable[[float], bool], most: float) -> tuple[float, float]:
    """Return the furthest that is good, and something beyond it that is not; of 0 nothing is asked.

    The second is infinite where all is good.
    """
    if most <= 0.0 or good(most):
        return most, math.inf
    low, high = 0.0, most
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        if good(middle):
            low = middle
        else:
            high = middle
    return low, high


def at_limits(names: Sequence[str]) -> str:
    """Say which axes have stopped at the ends of their ranges, if any have."""
    return f"the {' and the '.join(names)} stopped at the limit" if names else ""


def between(config: ArmConfig, here: Coordinates, there: Coordinates) -> int:
    """Return how many steps the busiest motor makes from one point to another."""
    transmission = config.model.transmission
    if transmission is None:  # no such arm is driven
        return 0
    before = transmission.to_motors(here.joints, here.opening_mm)
    return (transmission.to_motors(there.joints, there.opening_mm) - before).largest


def _ended(words: str, cause: Exception | None) -> Ended:
    return Ended(f"the jog ended here: further on, {words}", cause)
