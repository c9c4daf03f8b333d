"""Motion of MKS drives whose firmware cannot be steered in flight: bursts with scaled speeds.

Each drive gets its own target and a speed in proportion to its way, so that all arrive together as
nearly as whole rpm allow. Where the firmware has the synchronous start, the orders are stored and
started by one frame; else each drive begins when its order has come.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import pairwise

from armdrive.dialects.mks.inquiry import MksInquiry
from armdrive.dialects.mks.motion import MksMotion
from armdrive.dialects.mks.steering import beyond
from armdrive.dialects.mks.stops import MksStops, shared_acc
from armdrive.dialects.mks.wire import Asking, MksWire, Script
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
"""Drives miss the start now and then: it is said once more, this much later."""
START_S = 0.003
"""How much later than the first the last drive starts by a frame of its own, at most."""


def speeds_rpm(steps: Motors, rate_hz: float) -> tuple[int, ...]:
    """Return whole speeds in proportion to the ways, the busiest at most at a rate.

    Rounded up, so that no drive takes longer than the busiest.
    """
    largest = steps.largest
    if not largest:
        return (1,) * len(steps)
    busiest = min(max(math.floor(rate_hz / COUNTS_S_PER_RPM + 1e-9), 1), SPEED_MAX_RPM)
    return tuple(max(1, math.ceil(busiest * abs(count) / largest - 1e-9)) for count in steps)


class MksBursts:
    """Drives one burst at a time."""

    def __init__(
        self, wire: MksWire, stops: MksStops, inquiry: MksInquiry, motion: MksMotion
    ) -> None:
        self._wire, self._stops, self._inquiry, self._motion = wire, stops, inquiry, motion

    def burst(self, steps: Motors, rate_hz: float, let_go: Callable[[], bool]) -> Script:
        """Send a burst and wait for its end."""
        wire = self._wire
        orders: dict[int, MoveAbsoluteAxis] = {}
        for drive, count, rpm in zip(wire.drives, steps, speeds_rpm(steps, rate_hz), strict=True):
            if not count:
                continue
            target = drive.goal + count
            if (refused := beyond(drive, target)) is not None:
                return refused
            acc = shared_acc(wire.settings.acceleration, abs(count) / steps.largest)
            orders[drive.node] = MoveAbsoluteAxis(target, rpm, acc)
        if not orders:
            return Done()
        if wire.stop_asked or let_go():
            return Halted()
        if wire.can(Ability.SYNCHRONOUS_START) and len(orders) > 1:
            ended = yield from self._together(orders, let_go)
            if ended is not None:
                return ended
        else:
            for node, order in orders.items():
                wire.send(node, order)
            yield wire.now_s
        return (yield from self._motion.arrive(self._lasts_s(steps, rate_hz), never))

    def _together(
        self, orders: Mapping[int, MoveAbsoluteAxis], let_go: Callable[[], bool]
    ) -> Asking[Halted | RequestRejected | None]:
        """Store each drive's order, and start them all by one frame; said twice."""
        wire = self._wire
        arming = dict.fromkeys(orders, ArmSynchronous(on=True))
        armed = yield from wire.ask(arming, text="ARM")
        stored: dict[int, Event] = {}
        if all(isinstance(armed.get(node), Taken) for node in orders):
            stored = yield from wire.ask(orders, tries=2, text="F5, stored")
        ready = all(isinstance(stored.get(node), StoredForStart) for node in orders)
        if not ready or wire.stop_asked or let_go():
            return (yield from self._disarm(orders, stored, ready))
        wire.broadcast(GoSynchronous(), "GO")
        for node, order in orders.items():
            wire.took(node, order)
        until_s = wire.now_s + GO_AGAIN_S
        yield from wire.hear(until_s, lambda _: False)
        wire.broadcast(GoSynchronous())
        for node in orders:  # or a stop would be stored as well
            wire.put(node, ArmSynchronous(on=False))
        return None

    def _disarm(
        self, orders: Mapping[int, MoveAbsoluteAxis], stored: Mapping[int, Event], ready: bool
    ) -> Asking[Halted | RequestRejected]:
        """Take back what was stored; a drive that began at once is stopped."""
        wire = self._wire
        began = [node for node in orders if isinstance(stored.get(node), Started)]
        unsure = [node for node in orders if node not in stored]
        yield from wire.ask(dict.fromkeys(orders, ArmSynchronous(on=False)))
        if began or unsure:
            for node in (*began, *unsure):
                wire.took(node, orders[node])
            yield from self._stops.halt((*began, *unsure))
        if ready:
            return Halted()
        wrong = next(node for node in orders if not isinstance(stored.get(node), StoredForStart))
        why = yield from self._inquiry.mode_words(wrong)
        if not why and (yield from self._inquiry.stalled((wrong,))):
            why = self._inquiry.stall_words(wrong)
        words = why or f"{wire.drive(wrong)} did not store its order for the common start"
        return RequestRejected(words, moved=bool(began or unsure))

    # -- numbers ------------------------------------------------------------------------------

    def _lasts_s(self, steps: Motors, rate_hz: float) -> float:
        """Return how long the slowest drive takes for a burst."""
        return max((way.end_s for way in self._trapezoids(steps, rate_hz)), default=0.0)

    def _trapezoids(self, steps: Motors, rate_hz: float) -> list[_Trapezoid]:
        acc, largest = self._wire.settings.acceleration, max(steps.largest, 1)
        return [
            _Trapezoid(
                abs(count), rpm * COUNTS_S_PER_RPM, slope_of(shared_acc(acc, abs(count) / largest))
            )
            for count, rpm in zip(steps, speeds_rpm(steps, rate_hz), strict=True)
        ]

    def strays_of(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:
        """Bound how far each drive is beside its share of a burst, by rpm, ramps and starts.

        Each goes by a trapezoid of its own; the straight way is that of the busiest. They are
        compared at the corners of both, between which their difference bends one way.
        """
        largest = steps.largest
        if not largest:
            return (0.0,) * len(steps)
        ways = self._trapezoids(steps, rate_hz)
        busiest = next(way for way in ways if way.way == largest)
        late_s = 0.0 if self._wire.can(Ability.SYNCHRONOUS_START) else START_S
        return tuple(
            way.beside(busiest) + late_s * way.speed + 1.0 if way.way else 0.0 for way in ways
        )


class _Trapezoid:
    """A way from rest to rest."""

    def __init__(self, way: float, speed: float, slope: float) -> None:
        self.way, self.slope = way, slope
        self.speed = speed if math.isinf(slope) else min(speed, math.sqrt(way * slope))
        self.ramp_s = 0.0 if math.isinf(slope) else self.speed / slope
        self.end_s = way / self.speed + self.ramp_s if way else 0.0

    def at(self, time_s: float) -> float:
        """Return how far it is."""
        if time_s >= self.end_s:
            return self.way
        back_s = self.end_s - time_s
        if time_s < self.ramp_s:
            return self.slope * time_s**2 / 2.0
        if back_s < self.ramp_s:
            return self.way - self.slope * back_s**2 / 2.0
        return self.speed * (time_s - self.ramp_s / 2.0)

    def corners(self) -> tuple[float, ...]:
        """Return the times at which its acceleration changes."""
        return (self.ramp_s, self.end_s - self.ramp_s, self.end_s)

    def beside(self, other: _Trapezoid) -> float:
        """Return how far this is from its share of another's way, at most."""
        share = self.way / other.way
        times = sorted({0.0, *self.corners(), *other.corners()})
        looks = [*times, *((a + b) / 2.0 for a, b in pairwise(times))]
        return max(abs(self.at(time_s) - share * other.at(time_s)) for time_s in looks)
