"""Motion on a device that queues segments: a plan or a held jog, cut into segments as they go.

A segment is decided at the last moment: the controller draws it when it has room for it within
the announced time. What was drawn is remembered, so that a halt can be told from a lost position.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from armdrive.controllers.requests import MoveAlong, MoveBy
from armdrive.flows.pausing import wait_out_pause
from kinematics import Motors

if TYPE_CHECKING:
    from armdrive.core import Coordinates, Core
    from armdrive.engine import Flow
    from armdrive.flows.exchange import Wire
    from armdrive.planning import Leg
    from armdrive.tempo import Tempo

SEGMENTS_AHEAD = 3
"""A segment is this share of the time that is sent ahead: a device slows where it sees no next."""

Way = tuple["Coordinates", float]
"""An unrounded point, and how long the way there takes or longer."""


class Course:
    """The segments of one motion: absolute targets, rounded once, and what was drawn of them."""

    def __init__(self, core: Core, ways: Iterator[Way]) -> None:
        self.end = core.coordinates
        self._core = core
        self._ways = ways
        self._low = self._high = self._at = core.acknowledged

    def segments(self) -> Iterator[MoveBy]:
        """Give one segment after the other; its target is the commanded position from then on.

        Ways in which no motor makes a step lend their time to the next: a slow motion stays slow.
        """
        waited_s = 0.0
        for there, duration_s in self._ways:
            target = self._core.transmission.to_motors(there.joints, there.opening_mm)
            steps, self.end = target - self._at, there
            if not steps.largest:
                waited_s += duration_s
                continue
            duration_s, waited_s = duration_s + waited_s, 0.0
            self._at = target
            self._low = Motors(map(min, self._low, target))
            self._high = Motors(map(max, self._high, target))
            self._core.goes_to(target)
            yield MoveBy(steps, steps.largest / duration_s)

    def passes(self, position: Motors) -> bool:
        """Tell whether a position is within what has been drawn so far."""
        return all(
            low <= at <= high for low, at, high in zip(self._low, position, self._high, strict=True)
        )


def stream_legs(wire: Wire, legs: tuple[Leg, ...], ahead_s: float, *, jog: bool) -> Flow[bool]:
    """Drive audited legs; True when all of it was driven, False when a stop ended it early."""
    ways = _slices(wire, legs, ahead_s / SEGMENTS_AHEAD)
    while True:
        stretch = _Stretch(ways, wire.core.tempo)
        course = Course(wire.core, stretch.ways())
        driven = yield from wire.stream(MoveAlong(course.segments(), ahead_s, jog), course)
        if stretch.exhausted or jog or not driven:
            return driven
        yield from wait_out_pause(wire)
        if wire.stopping:
            return False


class _Stretch:
    """What is driven of a motion until it is paused: no segment is drawn from then on."""

    def __init__(self, ways: Iterator[Way], tempo: Tempo) -> None:
        self.exhausted = False
        self._ways = ways
        self._tempo = tempo

    def ways(self) -> Iterator[Way]:
        """Give points for as long as nobody pauses the arm."""
        while not self._tempo.paused:
            way = next(self._ways, None)
            if way is None:
                self.exhausted = True
                return
            yield way


def stream_held(
    wire: Wire, ways: Iterator[Way], ahead_s: float, let_go: Callable[[], bool]
) -> Flow[bool]:
    """Drive a jog for as long as `ways` gives something to drive and nobody lets go."""
    course = Course(wire.core, ways)
    request = MoveAlong(course.segments(), ahead_s, jog=True, let_go=let_go)
    return (yield from wire.stream(request, course))


def _slices(wire: Wire, legs: tuple[Leg, ...], longest_s: float) -> Iterator[Way]:
    """Cut legs into about equal parts that last `longest_s` at most; none after a stop."""
    tempo = wire.core.tempo
    for leg in legs:
        done = 0.0
        while done < 1.0:
            if wire.stopping:
                return
            left_s = tempo.slowed_s(leg.duration_s) * (1.0 - done)
            count = max(1, math.ceil(left_s / longest_s - 1e-9))
            tempo.note_slowed(leg.duration_s * (1.0 - done) / count)
            done = 1.0 if count == 1 else done + (1.0 - done) / count
            yield leg.start.towards(leg.end, done), left_s / count
