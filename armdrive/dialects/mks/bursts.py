"""Move MKS drives whose firmware takes no new target in motion: bursts with scaled speeds.

Each drive gets a target and a speed in proportion to its distance, so that all arrive together as
nearly as whole rpm allow. Firmware with a synchronous start stores the orders, and one frame starts
them all. Otherwise each drive starts when its order arrives.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import pairwise

from armdrive.dialects.bus.observer import ObservedDrive
from armdrive.dialects.bus.paths import Trapezoid
from armdrive.dialects.mks.contact import MksInquiry
from armdrive.dialects.mks.exchange import MksExchange, MksScript, Script
from armdrive.dialects.mks.motion import MksMotion
from armdrive.dialects.mks.steering import beyond
from armdrive.dialects.mks.stops import MksStops, shared_acc
from armdrive.tasks import Done, Halted, RequestRejected, never
from firmware_protocol.mks import (
    COUNTS_S_PER_RPM,
    SPEED_MAX_RPM,
    Ability,
    ArmSynchronous,
    Event,
    GoSynchronous,
    MoveAbsoluteAxis,
    Started,
    StoredForStart,
    slope_of,
)
from firmware_protocol.mks import Done as Taken
from kinematics.spaces import Motors

GO_AGAIN_S = 0.001
"""A drive may miss the start, so it is sent again this much later."""
START_S = 0.003
"""Without a synchronous start, the last drive starts at most this much after the first."""


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

    def __init__(
        self, io: MksExchange, stops: MksStops, inquiry: MksInquiry, motion: MksMotion
    ) -> None:
        self._io, self._stops, self._inquiry, self._motion = io, stops, inquiry, motion

    def burst(self, steps: Motors, rate_hz: float, released: Callable[[], bool]) -> Script:
        """Send a burst and wait for its end."""
        io = self._io
        orders: dict[ObservedDrive, MoveAbsoluteAxis] = {}
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
        if io.can(Ability.SYNCHRONOUS_START) and len(orders) > 1:
            ended = yield from self._together(orders, released)
            if ended is not None:
                return ended
        else:
            for drive, order in orders.items():
                io.send(drive, order)
            yield io.now_s
        return (yield from self._motion.arrive(self._lasts_s(steps, rate_hz), never))

    def _together(
        self, orders: Mapping[ObservedDrive, MoveAbsoluteAxis], released: Callable[[], bool]
    ) -> MksScript[Halted | RequestRejected | None]:
        """Store each drive's order, then start all of them by one frame, sent twice."""
        io = self._io
        arming = dict.fromkeys(orders, ArmSynchronous(on=True))
        armed = yield from io.ask(arming, text="ARM")
        stored: dict[ObservedDrive, Event] = {}
        if all(isinstance(armed.get(drive), Taken) for drive in orders):
            stored = yield from io.ask(orders, tries=2, text="F5, stored")
        ready = all(isinstance(stored.get(drive), StoredForStart) for drive in orders)
        if not ready or io.stop_asked or released():
            return (yield from self._disarm(orders, stored, ready))
        io.broadcast(GoSynchronous(), "GO")
        for drive, order in orders.items():
            io.note_order(drive, order)
        until_s = io.now_s + GO_AGAIN_S
        yield from io.wait_for(until_s, lambda _: False)
        io.broadcast(GoSynchronous())
        for drive in orders:  # else a stop would be stored as well
            io.put(drive, ArmSynchronous(on=False))
        return None

    def _disarm(
        self,
        orders: Mapping[ObservedDrive, MoveAbsoluteAxis],
        stored: Mapping[ObservedDrive, Event],
        ready: bool,
    ) -> MksScript[Halted | RequestRejected]:
        """Discard the stored orders, and stop the drives that may have started already."""
        io = self._io
        silent = [drive for drive in orders if drive not in stored]
        moved = [each for each, reply in stored.items() if isinstance(reply, Started)] + silent
        yield from io.ask(dict.fromkeys(orders, ArmSynchronous(on=False)))
        if moved:
            for drive in moved:
                io.note_order(drive, orders[drive])
            yield from self._stops.halt(moved)
        if ready:
            return Halted()
        wrong = next(each for each in orders if not isinstance(stored.get(each), StoredForStart))
        alert = yield from self._inquiry.obstructed(wrong)
        unknown = f"{wrong} did not store its order for the common start"
        return RequestRejected(alert.text if alert else unknown, moved=bool(moved))

    # -- numbers ------------------------------------------------------------------------------

    def _lasts_s(self, steps: Motors, rate_hz: float) -> float:
        """Return how long the slowest drive takes for a burst."""
        return max((each.duration_s for each in self._trapezoids(steps, rate_hz)), default=0.0)

    def _trapezoids(self, steps: Motors, rate_hz: float) -> list[Trapezoid]:
        acc, largest = self._io.settings.acceleration, max(steps.largest, 1)
        return [
            Trapezoid.of(
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
        late_s = 0.0 if self._io.can(Ability.SYNCHRONOUS_START) else START_S
        return tuple(
            _deviation(each, busiest) + late_s * each.speed + 1.0 if each.distance else 0.0
            for each in trapezoids
        )


def _deviation(one: Trapezoid, other: Trapezoid) -> float:
    """Return the greatest distance of a motion from its share of another one."""
    share = one.distance / other.distance
    times = sorted({0.0, *one.corners_s(), *other.corners_s()})
    looks = [*times, *((a + b) / 2.0 for a, b in pairwise(times))]
    return max(abs(one.at(time_s) - share * other.at(time_s)) for time_s in looks)
