"""One motion on the wire: a burst, or a course of segments, and what each answer to it means."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from armdrive.abilities import segment_s
from armdrive.errors import DeviceFault, LinkLost, PendantStop
from armdrive.motion.deviation import lags, pieces, strays_steps
from armdrive.runtime.arm_state import Core
from armdrive.runtime.engine import Engine
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.registers import RegisterReader, leave_standstill, take_difference
from armdrive.runtime.stop_bounds import straying_mm
from armdrive.status import Evidence, State
from armdrive.tasks import (
    Done,
    Halted,
    Interrupted,
    MoveAlong,
    MoveBy,
    RequestRejected,
    TaskBody,
    never,
)
from kinematics.spaces import Motors

FRESH_S = 0.05
"""A look at the registers this long ago still tells where a motion starts from."""

TURNING_ROUND = "it stopped as it turned round, with the backlash taken up or not yet"

BLIND_S = 2.0
"""A motion is compared with the registers at least this often."""


Way = tuple[ArmCoordinates, float]
"""An unrounded point, and how long the way there takes or longer."""


class StreamedCourse:
    """The segments of one motion: absolute targets, rounded once, and what was drawn of them.

    `left` is the rest of a way that was begun and, for a pause, not sent to its end. Of `total_s`
    of motion, `slow_s` is slower than the device can turn its motors without pauses.
    """

    def __init__(self, core: Core, ways: Iterator[Way]) -> None:
        self.end: ArmCoordinates | None = core.position.coordinates
        self.left: Way | None = None
        self.straying_mm = 0.0
        self.slow_s = self.total_s = 0.0
        self._core = core
        self._slowest_hz = core.controller.usable_rate_hz(0.0)
        self._ways = ways
        self._low = self._high = self._at = core.position.acknowledged
        self._before = core.position.commanded
        self._pending: Sequence[MoveBy] = ()

    def segments(self) -> Iterator[MoveBy]:
        """Give one segment after the other; its target is the commanded position from then on.

        Ways in which no motor makes a step lend their time to the next: a slow motion stays slow.
        """
        waited_s = 0.0
        for there, duration_s in self._ways:
            target = there.motors(self._core.transmission)
            steps, self.end = target - self._at, there
            if not steps.largest:
                waited_s += duration_s
                continue
            duration_s, waited_s = duration_s + waited_s, 0.0
            self._at = target
            self._low = Motors(map(min, self._low, target))
            self._high = Motors(map(max, self._high, target))
            yield from self._drawn(steps, steps.largest / duration_s)

    def _drawn(self, steps: Motors, rate_hz: float) -> Iterator[MoveBy]:
        """Give the segment of some steps, with the backlash of motors that reverse in it."""
        core = self._core
        longest_s = segment_s(core.stops.burst_s)
        found = pieces(core, steps, rate_hz, longest_s, lambda count, rate: count / rate)
        if len(found) == 1:
            here, _ = core.transmission.to_joints(core.position.commanded)
            beside_mm = straying_mm(core.config, here, lags(steps, found[0].steps))
            self.straying_mm = max(self.straying_mm, beside_mm)
        for index, piece in enumerate(found):
            self.total_s += piece.duration_s
            self.slow_s += piece.duration_s if piece.rate_hz < self._slowest_hz else 0.0
            self._before, self._pending = core.position.commanded, found[index:]
            core.position.sends(piece.steps)
            yield piece

    def give_back(self, unsent: int) -> None:
        """Take in that so many segments that were drawn last were not sent, one at most."""
        pending = self._pending if unsent else self._pending[1:]
        if not pending or self.end is None:
            return
        if unsent:
            self._core.position.takes_back(self._before)
        self.left = self.end, math.fsum(piece.duration_s for piece in pending)
        self.end = None

    def passes(self, position: Motors) -> bool:
        """Tell whether a position is within what has been drawn so far."""
        return all(
            low <= at <= high for low, at, high in zip(self._low, position, self._high, strict=True)
        )


class MotionContext(RegisterReader):
    """What a task needs of the engine: asking, and motion in bursts or queued segments."""

    def __init__(self, engine: Engine, core: Core) -> None:
        super().__init__(engine, core)
        self.straying_mm = self.slow_s = self.total_s = 0.0

    def look_before_motion(self) -> TaskBody[None]:
        """Look, unless that was done a moment ago, while the mark of motion is being written.

        A slow disk makes what was seen stale, so that the look comes after it once more.
        """
        self.core.memory.begin_mark()
        if self.now_s > self.looked_s + FRESH_S:
            yield from self.look()
        marked = yield from leave_standstill(self)
        if marked and self.now_s > self.looked_s + FRESH_S:
            yield from self.look()

    def move(
        self,
        target: Motors,
        rate_hz: float,
        there: ArmCoordinates | None,
        let_go: Callable[[], bool] = never,
    ) -> TaskBody[None]:
        """Send one burst to an absolute target and wait until it has ended.

        A burst that has not begun to move when `let_go()` becomes true need not be made.
        """
        core = self.core
        steps = target - core.position.acknowledged
        if not steps.largest:
            core.position.coordinates = there or core.position.coordinates
            return
        if not (yield from self._may_begin(let_go)):
            return
        core.position.stands()
        *first, last = pieces(core, steps, rate_hz, core.stops.burst_s, core.controller.duration_s)
        for piece in first:  # these move nothing but motors
            arrived = yield from self._burst(
                replace(piece, let_go=let_go), core.position.coordinates
            )
            if not arrived or self.stopping or let_go():
                return
            if not (yield from self._may_begin(let_go)):
                return
        self.note_straying(strays_steps(core, steps, rate_hz))
        yield from self._burst(replace(last, let_go=let_go), there)

    def _burst(self, burst: MoveBy, there: ArmCoordinates | None) -> TaskBody[bool]:
        """Send one burst and wait until it has ended; False where a stop ended it early."""
        core = self.core
        core.position.sends(burst.steps)
        try:
            reply = yield from self.request(burst, Evidence.ANSWER_LOST)
        except LinkLost:
            core.lost_in_motion(self.now_s)
            raise
        if isinstance(reply, Halted | Interrupted):
            beyond = reply.beyond if isinstance(reply, Halted) else 0
            farthest = core.position.commanded + Motors(
                (step > 0) * beyond - (step < 0) * beyond for step in burst.steps
            )
            yield from self._ended(reply, way_between(core.position.acknowledged, farthest))
            return False
        if isinstance(reply, RequestRejected):
            yield from self._refusal(reply)
        core.position.arrived(there)
        timely = isinstance(reply, Done) and reply.timely
        if not timely or self.now_s > self.looked_s + BLIND_S:
            yield from self.verify()
        return True

    def note_straying(self, steps: Sequence[float]) -> None:
        """Note that each motor may stray from its way by so many steps."""
        here, _ = self.core.transmission.to_joints(self.core.position.acknowledged)
        self.straying_mm = max(self.straying_mm, straying_mm(self.core.config, here, steps))

    def _may_begin(self, let_go: Callable[[], bool]) -> TaskBody[bool]:
        """Tell whether a motion may be sent now; raises where what happened meanwhile forbids it.

        False where it was stopped or let go while a slow disk was waited for.
        """
        core = self.core
        core.require_settings()
        marked = yield from leave_standstill(self, let_go)
        self.require_no_fault()  # the device may have raised an alarm since the last burst
        return marked

    def stream(self, request: MoveAlong, course: StreamedCourse) -> TaskBody[bool]:
        """Have a device drive queued segments; True when all were driven, False when halted."""
        core = self.core
        if not (yield from self._may_begin(request.let_go)):
            return False
        core.position.stands()
        try:
            reply = yield from self.request(request, Evidence.ANSWER_LOST)
        except LinkLost:
            core.lost_in_motion(self.now_s)
            raise
        self.straying_mm = max(self.straying_mm, course.straying_mm)
        self.slow_s, self.total_s = self.slow_s + course.slow_s, self.total_s + course.total_s
        if isinstance(reply, Halted | Interrupted):
            yield from self._ended(reply, course.passes)
            return False
        if isinstance(reply, RequestRejected):
            yield from self._refusal(reply)
        course.give_back(reply.unsent if isinstance(reply, Done) else 0)
        core.position.arrived(course.end)
        return True

    def _ended(
        self, reply: Halted | Interrupted, passes: Callable[[Motors], bool]
    ) -> TaskBody[None]:
        """Take up where a stop left the motors: the registers counted it. The operator's raises."""
        yield from self.read()
        core = self.core
        if isinstance(reply, Halted) and not reply.kept:
            core.learn(Evidence.STOPPED_DEAD, self.now_s)
        elif core.position.fell:
            core.learn(Evidence.CONTROLLER_RESTARTED, self.now_s)
        elif core.position.read_back is None or not passes(core.position.read_back):
            core.learn(Evidence.READ_BACK_DIFFERS, self.now_s)
        elif core.position.slack.vague:
            core.learn(Evidence.READ_BACK_DIFFERS, self.now_s, TURNING_ROUND)
        core.position.believe_registers()
        core.position.commanded = core.position.acknowledged  # also where nothing had moved yet
        if isinstance(reply, Interrupted):
            raise self.fault(
                PendantStop(
                    "the STOP key of the pendant was pressed: look at the arm, then call `reset()`"
                )
            )

    def _refusal(self, reply: RequestRejected) -> TaskBody[None]:
        """Find out what a refused motion left behind: nothing, where the device is sure of it.

        Where an alert has said already why the motion ended, its words are the error's.
        """
        core = self.core
        told = core.diagnostics.error if core.state is State.ERROR_STOP else ""
        difference = yield from self.read()
        words = f": {reply.reason}" if reply.reason else ""
        if not reply.moved and not difference.largest:
            core.position.believe_registers()
            core.position.commanded = core.position.acknowledged
            raise self.fault(DeviceFault(told or f"the controller refused the motion{words}"))
        core.learn(_evidence(reply), self.now_s, reply.reason)
        take_difference(core)
        raise self.fault(DeviceFault(told or _refused_words(reply)))


def _evidence(reply: RequestRejected) -> Evidence:
    """Return what a motion that was not made says of the position."""
    if reply.silent:
        return Evidence.SILENT
    return Evidence.BROKEN_OFF if reply.reason else Evidence.MOTION_REFUSED


def _refused_words(reply: RequestRejected) -> str:
    """Say that a motion was not made: by the device's reason, or else it understood nothing."""
    if reply.reason:
        return f"the motion was broken off: {reply.reason}. Look at the arm, then call `reset()`"
    return (
        "the controller refused a motion that it should have understood; a byte may have been "
        "garbled. Look at the arm, then call `reset()`"
    )


def way_between(start: Motors, end: Motors) -> Callable[[Motors], bool]:
    """Return what tells whether every motor stands between where it started and was sent."""
    spans = [(min(pair), max(pair)) for pair in zip(start, end, strict=True)]
    return lambda at: all(
        low <= count <= high for count, (low, high) in zip(at, spans, strict=True)
    )
