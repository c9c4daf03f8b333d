"""Move MKS drives whose firmware takes no new target in motion: bursts with scaled speeds.

Each drive gets a target and a speed in proportion to its distance, so that all arrive together as
nearly as whole rpm allow. Each starts when its order arrives. Firmware from 1.0.8 on could store
the orders (4A) until one frame starts them all (4B). That gains 3 ms, was never seen to work, and
4A is a configuration, which may be written into a memory that wears out.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

from armdrive.dialects.mks.drive import MksDrive
from armdrive.dialects.mks.exchange import MksExchange, Script
from armdrive.dialects.mks.motion import MksMotion
from armdrive.dialects.mks.steering import beyond
from armdrive.dialects.mks.stops import shared_acc
from armdrive.tasks import Done, Halted
from firmware_protocol.mks import (
    COUNTS_S_PER_RPM,
    SPEED_MAX_RPM,
    MoveAbsoluteAxis,
    slope_of,
)
from kinematics.paths.profiles import Profile, trapezoid
from kinematics.spaces import Motors

# The last drive starts at most this much after the first.
START_S = 0.003


def speeds_rpm(steps: Motors, rate_hz: float) -> tuple[int, ...]:
    """Return whole speeds in proportion to the distances, the greatest at most `rate_hz`.

    They are rounded up, so that no drive takes longer than the busiest.
    """
    largest = steps.largest
    if not largest:
        return (1,) * len(steps)
    busiest = min(max(math.floor(rate_hz / COUNTS_S_PER_RPM + 1e-9), 1), SPEED_MAX_RPM)
    return tuple(max(1, math.ceil(busiest * abs(count) / largest - 1e-9)) for count in steps)


class MksBursts:
    """Sends one burst at a time."""

    def __init__(self, io: MksExchange, motion: MksMotion) -> None:
        self._io, self._motion = io, motion

    def burst(self, steps: Motors, rate_hz: float, released: Callable[[], bool]) -> Script:
        """Send a burst and wait for its end."""
        io = self._io
        orders: dict[MksDrive, MoveAbsoluteAxis] = {}
        for drive, count, rpm in zip(io.drives, steps, speeds_rpm(steps, rate_hz), strict=True):
            if not count:
                continue
            target = drive.goal + count
            if (refused := beyond(drive, target)) is not None:
                return refused
            acc = shared_acc(io.settings.acceleration, abs(count) / steps.largest)
            orders[drive] = MoveAbsoluteAxis(target, rpm, acc)
        if not orders:
            return Done()
        if io.stop_asked or released():
            return Halted()
        for drive, order in orders.items():
            io.send(drive, order)
        yield io.now_s
        return (yield from self._motion.arrive(self._lasts_s(steps, rate_hz)))

    # -- numbers ------------------------------------------------------------------------------

    def _lasts_s(self, steps: Motors, rate_hz: float) -> float:
        """Return how long the slowest drive takes for a burst."""
        return max((each.duration_s for each in self._trapezoids(steps, rate_hz)), default=0.0)

    def _trapezoids(self, steps: Motors, rate_hz: float) -> list[Profile]:
        acc, largest = self._io.settings.acceleration, max(steps.largest, 1)
        return [
            trapezoid(
                abs(count), rpm * COUNTS_S_PER_RPM, slope_of(shared_acc(acc, abs(count) / largest))
            )
            for count, rpm in zip(steps, speeds_rpm(steps, rate_hz), strict=True)
        ]

    def deviations_of(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:
        """Bound each drive's deviation from the straight path, due to rpm, ramps and starts.

        Each drive follows its own trapezoid, and the busiest one defines the straight path. The two
        are compared at the corners of both, since their difference bends one way in between.
        """
        largest = steps.largest
        if not largest:
            return (0.0,) * len(steps)
        trapezoids = self._trapezoids(steps, rate_hz)
        busiest = next(each for each in trapezoids if each.distance == largest)
        return tuple(
            _deviation(each, busiest) + START_S * _peak_speed(each) + 1.0 if each.distance else 0.0
            for each in trapezoids
        )


def _peak_speed(profile: Profile) -> float:
    return max(phase.speed for phase in profile.phases)


def _deviation(one: Profile, other: Profile) -> float:
    """Return the greatest distance of a motion from its share of another one."""
    share = one.distance / other.distance
    times = sorted({0.0, *one.ends_s, *other.ends_s})
    looks = [*times, *((a + b) / 2.0 for a, b in pairwise(times))]
    return max(abs(one.at(time_s)[0] - share * other.at(time_s)[0]) for time_s in looks)
