"""Motion on a device that queues segments: a plan or a held jog, cut into segments as they go.

A segment is decided at the last moment: the controller draws it when it has room for it within
the announced time. What was drawn is remembered, so that a halt can be told from a lost position.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import chain

from armdrive.abilities import segment_s
from armdrive.errors import WrongState
from armdrive.motion.context import MotionContext, StreamedCourse, Way
from armdrive.runtime.overrides import LONGEST_PAUSE_S, SpeedOverride, given_up
from armdrive.runtime.position import MotionSegment
from armdrive.tasks import MoveAlong, SleepUntil, TaskBody, never

# Waiting in a pause: the arm stands, is looked at now and then, and goes on where it stopped.

LOOK_S = 0.05
"""How often a paused motion asks whether it may go on."""
NOT_THERE = "the arm is no longer where it was paused ({}): the motion does not go on, plan anew"


def wait_out_pause(wire: MotionContext) -> TaskBody[None]:
    """Wait until somebody resumes the arm, or stops it; returns at once where nobody has paused.

    The arm is remembered as standing meanwhile. Raises where that takes too long, and where
    the arm is no longer as it was: a motion that goes on from elsewhere has never been audited.
    """
    speed_override, core = wire.core.speed_override, wire.core
    if not speed_override.paused or wire.stopping:
        return
    yield from wire.verify()
    core.mark_still()
    stood, believed = core.position.acknowledged, core.belief
    poll_s = core.config.motion.idle_poll_s
    began_s = looked_s = wire.now_s
    speed_override.waits, speed_override.given_up = True, False
    try:
        while speed_override.paused and not wire.stopping:
            before_s = wire.now_s
            yield SleepUntil(before_s + LOOK_S)
            wire.require_no_fault()
            waited_s = wire.now_s - began_s
            if speed_override.given_up or waited_s >= LONGEST_PAUSE_S:
                raise given_up(waited_s)
            if poll_s and wire.now_s >= looked_s + poll_s:
                yield from wire.look()
                looked_s = wire.now_s
            speed_override.note_waited(wire.now_s - before_s)
    finally:
        speed_override.waits = False
    if wire.stopping:
        return
    yield from wire.look()  # however fresh the last one is: somebody may be about at the arm
    wire.require_no_fault()
    if core.position.acknowledged != stood or core.belief is not believed:
        raise WrongState(NOT_THERE.format(core.belief.reason))


def stream_legs(
    wire: MotionContext,
    legs: tuple[MotionSegment, ...],
    ahead_s: float,
    let_go: Callable[[], bool] | None,
) -> TaskBody[bool]:
    """Drive audited legs; True when all of it was driven, False when something ended it early.

    `let_go` makes it a jog, and tells when what is queued of it is given up.
    """
    jog = let_go is not None
    ways, speed_override = _slices(wire, legs, segment_s(ahead_s)), wire.core.speed_override
    while True:
        stretch = _Stretch(ways, speed_override)
        course = StreamedCourse(wire.core, stretch.ways())
        segments = course.segments()
        request = MoveAlong(segments, ahead_s, jog, let_go or never, held_back=_HeldBack(wire))
        driven = yield from wire.stream(request, course)
        if course.left is not None:
            ways = chain((course.left,), ways)
        elif stretch.exhausted:
            return driven
        if jog or not driven:
            return driven
        yield from wait_out_pause(wire)
        if wire.stopping:
            return False


class _Stretch:
    """What is driven of a motion until it is paused: no segment is drawn from then on."""

    def __init__(self, ways: Iterator[Way], speed_override: SpeedOverride) -> None:
        self.exhausted = False
        self._ways = ways
        self._speed_override = speed_override

    def ways(self) -> Iterator[Way]:
        """Give points for as long as nobody pauses the arm."""
        while not self._speed_override.paused:
            way = next(self._ways, None)
            if way is None:
                self.exhausted = True
                return
            yield way


class _HeldBack:
    """Tells a device whether somebody has paused the arm; how long it waits for that is noted."""

    def __init__(self, wire: MotionContext) -> None:
        self._wire = wire
        self._since_s = math.inf

    def __call__(self) -> bool:
        """Tell whether nothing more is to be sent for now."""
        speed_override, now_s = self._wire.core.speed_override, self._wire.now_s
        speed_override.note_waited(max(now_s - self._since_s, 0.0))
        self._since_s = now_s if speed_override.paused else math.inf
        return speed_override.paused


def stream_held(
    wire: MotionContext, ways: Iterator[Way], ahead_s: float, let_go: Callable[[], bool]
) -> TaskBody[bool]:
    """Drive a jog for as long as `ways` gives something to drive and nobody lets go."""
    course = StreamedCourse(wire.core, ways)
    request = MoveAlong(course.segments(), ahead_s, jog=True, let_go=let_go)
    return (yield from wire.stream(request, course))


def _slices(
    wire: MotionContext, legs: tuple[MotionSegment, ...], longest_s: float
) -> Iterator[Way]:
    """Cut legs into about equal parts that last `longest_s` at most; none after a stop."""
    speed_override = wire.core.speed_override
    for leg in legs:
        done = 0.0
        while done < 1.0:
            if wire.stopping:
                return
            left_s = speed_override.slowed_s(leg.duration_s) * (1.0 - done)
            count = max(1, math.ceil(left_s / longest_s - 1e-9))
            speed_override.note_slowed(leg.duration_s * (1.0 - done) / count)
            done = 1.0 if count == 1 else done + (1.0 - done) / count
            yield leg.start.towards(leg.end, done), left_s / count
