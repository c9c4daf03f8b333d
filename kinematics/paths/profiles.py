"""Profiles from rest to rest: distance, speed and acceleration along a path at every time.

Distances are in any unit (mm, rad, a share of a path), times in s. A profile consists of phases of
constant jerk. `trapezoid` limits speed and acceleration, `jerk_limited` also the jerk; both return
the quickest profile within their limits. A limit may be infinite: an infinite jerk gives the
trapezoid, an infinite acceleration a jump in speed.

Source: the seven phases are those of Biagiotti and Melchiorri, Trajectory Planning for Automatic
Machines and Robots, section 3.4 (double S), here from rest to rest.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import accumulate
from operator import itemgetter
from typing import NamedTuple

from kinematics.errors import KinematicsError, not_negative, positive

# More rounds than Newton's method, kept in its bracket by halving, ever needs for a double.
NEWTON_ROUNDS = 60


class Phase(NamedTuple):
    """A period of constant jerk, and the state at its beginning."""

    duration_s: float
    distance: float
    speed: float
    acceleration: float
    jerk: float

    def state(self, since_s: float) -> tuple[float, float, float]:
        """Return distance, speed and acceleration at a time after the phase began."""
        _, distance, speed, acceleration, jerk = self
        half = 0.5 * since_s
        return (
            distance + since_s * (speed + half * (acceleration + since_s * jerk / 3.0)),
            speed + since_s * (acceleration + half * jerk),
            acceleration + since_s * jerk,
        )

    @property
    def steady(self) -> bool:
        """Whether the speed is constant."""
        return self.acceleration == 0.0 == self.jerk


class ProfileStep(NamedTuple):
    """A phase before it is joined to others: its duration and its initial acceleration."""

    duration_s: float
    acceleration: float
    jerk: float


@dataclass(frozen=True, slots=True)
class Profile:
    """Phases end to end over a distance, from rest to rest; it never runs backwards."""

    phases: tuple[Phase, ...]
    distance: float
    ends_s: tuple[float, ...] = field(init=False, repr=False, compare=False)
    """When each phase ends."""
    duration_s: float = field(init=False, compare=False)

    def __post_init__(self) -> None:
        ends = tuple(accumulate(map(_DURATION, self.phases)))
        object.__setattr__(self, "ends_s", ends)
        object.__setattr__(self, "duration_s", ends[-1] if ends else 0.0)

    def at(self, t_s: float) -> tuple[float, float, float]:
        """Return distance, speed and acceleration at a time; at the ends and beyond, rest."""
        if t_s <= 0.0:
            return 0.0, 0.0, 0.0
        if t_s >= self.duration_s:
            return self.distance, 0.0, 0.0
        index = bisect_right(self.ends_s, t_s)
        began_s = self.ends_s[index - 1] if index else 0.0
        distance, speed, acceleration = self.phases[index].state(t_s - began_s)
        following = index + 1
        far = self.phases[following].distance if following < len(self.phases) else self.distance
        return min(distance, far), max(speed, 0.0), acceleration

    def when(self, distance: float) -> float:
        """Return the time at which a distance is reached, within the profile's ends."""
        if distance <= 0.0:
            return 0.0
        if distance >= self.distance:
            return self.duration_s
        index = bisect_right(self.phases, distance, key=_PLACE) - 1
        began_s = self.ends_s[index - 1] if index else 0.0
        return began_s + since_s(self.phases[index], distance)


_DURATION, _PLACE = itemgetter(0), itemgetter(1)


def trapezoid(distance: float, speed: float, acceleration: float) -> Profile:
    """Return the quickest profile under a speed and an acceleration, of which one may be infinite.

    If the distance is too short to reach the speed, its shape is a triangle.
    """
    return jerk_limited(distance, speed, acceleration, math.inf)


def jerk_limited(distance: float, speed: float, acceleration: float, jerk: float) -> Profile:
    """Return the quickest profile under a speed, an acceleration and a jerk.

    Seven phases, fewer if the distance is too short to reach the speed or the acceleration. Limits
    are above 0 and may be infinite, but not all of them.
    """
    length = not_negative("a profile's distance", distance)
    for name, limit in (("speed", speed), ("acceleration", acceleration), ("jerk", jerk)):
        positive(f"a profile's {name}", limit, endless=True)
    if math.inf == speed == acceleration == jerk:
        raise KinematicsError("speed, acceleration and jerk must not all be infinite")
    if length == 0.0:
        return Profile((), 0.0)
    if acceleration == math.inf == jerk:
        return Profile((Phase(length / speed, 0.0, speed, 0.0, 0.0),), length)
    build_s, hold_s, top = _ramp(length, speed, acceleration, jerk)
    steady_s = max(length / top - (2.0 * build_s + hold_s), 0.0)
    if jerk == math.inf:
        peak, jerk = acceleration, 0.0
    else:
        peak = jerk * build_s
    up = (
        ProfileStep(build_s, 0.0, jerk),
        ProfileStep(hold_s, peak, 0.0),
        ProfileStep(build_s, peak, -jerk),
    )
    down = (
        ProfileStep(build_s, 0.0, -jerk),
        ProfileStep(hold_s, -peak, 0.0),
        ProfileStep(build_s, -peak, jerk),
    )
    return joined(length, (*up, ProfileStep(steady_s, 0.0, 0.0), *down))


def _ramp(length: float, speed: float, acceleration: float, jerk: float) -> tuple[float, ...]:
    """Return how long acceleration builds up and holds, and the speed reached.

    A ramp from rest to a speed has half that speed on average, so ramps up and down together cover
    the speed times the time of one ramp; this gives the speed that a short distance allows.
    """
    build_s = 0.0 if jerk == math.inf else acceleration / jerk
    reached = speed if acceleration == math.inf else _peak_speed(length, acceleration, build_s)
    top = min(speed, reached)
    if acceleration < math.inf and top >= acceleration * build_s:
        return build_s, top / acceleration - build_s, top
    build_s = math.sqrt(speed / jerk)
    build_s = min(build_s, math.cbrt(length / (2.0 * jerk)))
    return build_s, 0.0, jerk * build_s * build_s


def _peak_speed(length: float, acceleration: float, build_s: float) -> float:
    """Return the solution v of v (v / a + build-up) = length."""
    return 2.0 * length / (build_s + math.sqrt(build_s * build_s + 4.0 * length / acceleration))


def joined(length: float, steps: Iterable[ProfileStep]) -> Profile:
    """Return the profile of consecutive steps from rest; empty steps are left out."""
    phases = []
    distance = speed = 0.0
    for step in steps:
        if step.duration_s > 0.0:
            phase = Phase(step.duration_s, distance, speed, step.acceleration, step.jerk)
            phases.append(phase)
            distance, speed, _ = phase.state(step.duration_s)
            distance, speed = min(distance, length), max(speed, 0.0)
    return Profile(tuple(phases), length)


def since_s(phase: Phase, distance: float) -> float:
    """Return how long after its start a phase reaches a distance, at most the phase's duration."""
    duration_s, start, speed, acceleration, jerk = phase
    ahead = distance - start
    if jerk == 0.0:
        root = math.sqrt(max(speed * speed + 2.0 * acceleration * ahead, 0.0))
        under = speed + root
        return min(2.0 * ahead / under, duration_s) if under > 0.0 else duration_s
    low, high = 0.0, duration_s
    guess = 0.5 * duration_s
    for _ in range(NEWTON_ROUNDS):
        here, slope, _ = phase.state(guess)
        miss = here - distance
        if miss > 0.0:
            high = guess
        else:
            low = guess
        better = guess - miss / slope if slope > 0.0 else low
        if not low < better < high:
            better = 0.5 * (low + high)
        if abs(better - guess) <= 1e-15 * duration_s:
            return better
        guess = better
    return guess
