"""The context of a motion task: requests, register checks, bursts, segments, and the motion mark.

A motion comes here from execute.py as bursts (`MotionContext.move`) or as a stream of segments
(`MotionContext.stream`). Either way, the same steps follow:

    _may_begin    the settings allow motion, the motion mark is on the disk, and no fault is latched
    pieces        (deviation.py) what is sent for some steps of the joints. If a motor first has to
                  take up its backlash, only that is sent, and the caller plans the rest again
    sends         the ledger counts the steps as commanded, before they are sent
    driven        the request and its reply; the loss of the link counts as lost in motion
    the reply     done: the goal is acknowledged. Halted: the registers say where the motors stand;
                  if that is not on the way, the position is suspect. Refused: a fault

The registers are compared now and then on the way (`BLIND_S`) and at the end (`verify`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from armdrive.abilities import segment_s
from armdrive.errors import (
    ArmError,
    DeviceFault,
    LinkLost,
    NoAnswer,
    PendantStop,
    PositionMismatch,
    Stopped,
)
from armdrive.motion.deviation import deviation_steps, lags, pieces
from armdrive.runtime.arm_state import EMERGENCY_STOP, Core, code_of
from armdrive.runtime.engine import Engine
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.stop_bounds import deviation_mm
from armdrive.status import Current, Evidence, State, Trust
from armdrive.tasks import (
    Done,
    Exchange,
    Halted,
    HomeDevice,
    Interrupted,
    MoveAlong,
    MoveBy,
    ReadPosition,
    Registers,
    Reply,
    Request,
    RequestRejected,
    SleepUntil,
    TaskBody,
    never,
)
from kinematics.spaces import Motors

QUIET_S = 0.3  # after this long without a byte, no more of a disturbed reply will come
FRESH_S = 0.05  # a position that was read this long ago needs no other look before it is used
BLIND_S = 2.0  # longest motion without comparing the position
TRIES = 3  # attempts to read the registers; reading moves nothing, so it may be repeated


class MotionContext:
    """What a motion task works with: requests, position readings, and motion."""

    def __init__(self, engine: Engine, core: Core) -> None:
        self.engine = engine
        self.core = core
        self.looked_s = -math.inf
        """Time of the latest reading of the registers."""
        self.deviation_mm = self.slow_s = self.total_s = 0.0

    @property
    def now_s(self) -> float:
        """The arm's time."""
        return self.engine.now_s

    @property
    def stopping(self) -> bool:
        """Whether a stop has been requested."""
        return self.engine.stop_asked

    def stopped(self, words: str) -> Stopped:
        """Return the error for a motion that a stop has ended, with the reason if it is known."""
        return Stopped(words + self.engine.stop_why)

    def request(self, request: Request) -> TaskBody[Reply]:
        """Send a request and return the reply. A timeout faults the arm."""
        try:
            reply: Reply = yield Exchange(request)
        except NoAnswer as error:
            moves = isinstance(request, MoveBy | MoveAlong | HomeDevice)
            self.core.learn(Evidence.ANSWER_LOST if moves else Evidence.SILENT, self.now_s)
            self.core.fault(error)
            raise
        return reply

    def ask_registers(self, *, midway: bool = False) -> TaskBody[Registers]:
        """Read the registers, repeating disturbed exchanges. Raises `DeviceFault`.

        The call limit applies, even in the middle of a motion.
        """
        with self.engine.limited():
            return (yield from self._ask_registers(ReadPosition(midway)))

    def _ask_registers(self, question: ReadPosition) -> TaskBody[Registers]:
        """Ask until one answer is certain.

        After a disturbance, an answer counts only if the line is quiet after it. Otherwise it may
        be the late answer to the previous attempt, and every later answer would be one request
        behind. After a timeout, counts of zero may mean that the controller restarted. A garbled
        answer is no timeout.
        """
        silence: NoAnswer | None = None
        mute = False
        for attempt in range(TRIES):
            if attempt:
                yield from self.quiet()
            asked_s = self.now_s
            try:
                reply: Reply = yield Exchange(question)
            except NoAnswer as error:
                silence, mute = error, mute or self.engine.received_s < asked_s
                continue
            if isinstance(reply, RequestRejected) and reply.reason:  # the device says why
                raise DeviceFault(reply.reason)
            received_s = self.engine.received_s
            if attempt and isinstance(reply, Registers):
                yield from self.quiet()
            alone = received_s == self.engine.received_s or self._beats
            if isinstance(reply, Registers) and alone:
                self.looked_s = self.now_s
                if mute and not reply.positions.largest:
                    self.core.learn(Evidence.SILENT, self.now_s)  # it may have restarted
                return reply
        raise silence or DeviceFault(
            f"the device on {self.engine.link.description} does not answer like this arm: "
            "check the cable, the port and the dialect"
        )

    def quiet(self) -> TaskBody[None]:
        """Wait for a quiet line, then discard what has arrived.

        If the device sends heartbeats, wait only as long as a late answer can take.
        """
        since_s = self.now_s
        while self.now_s < (end_s := self._quiet_from_s(since_s) + QUIET_S):
            if self.stopping:
                break
            yield SleepUntil(end_s)
        self.engine.controller.abandon()

    def _quiet_from_s(self, since_s: float) -> float:
        return since_s if self._beats else max(since_s, self.engine.received_s)

    @property
    def _beats(self) -> bool:
        return self.core.controller.abilities.beats

    def read(self, *, midway: bool = False) -> TaskBody[Motors]:
        """Read the registers; return their difference from the acknowledged ones.

        A difference counts once it is read twice, because the line has no checksum.
        """
        difference = yield from self._read_once(midway=midway)
        seen = None
        while difference.largest and difference != seen:
            seen = difference
            difference = yield from self._read_once(midway=midway)
        return difference

    def _read_once(self, *, midway: bool) -> TaskBody[Motors]:
        try:
            registers = yield from self.ask_registers(midway=midway)
        except DeviceFault as fault:
            self.core.learn(Evidence.SILENT, self.now_s)
            self.core.fault(fault)
            raise
        return self.core.position.compare(registers)

    def look(self) -> TaskBody[None]:
        """Read the position of an arm at rest; a change means that something else moved it."""
        weigh_difference(self, (yield from self.read()))

    def verify(self, *, midway: bool = False) -> TaskBody[None]:
        """Compare the registers with the acknowledged position; a difference is a fault."""
        difference = yield from self.read(midway=midway)
        if not difference.largest:
            return
        core = self.core
        core.learn(Evidence.READ_BACK_DIFFERS, self.now_s, f"by {tuple(difference)} steps")
        take_difference(core)
        raise self.fault(
            PositionMismatch(
                f"the registers differ by {tuple(difference)} steps from where the motion should "
                "have ended: a byte was lost, or the controller lost its power. Look at the arm, "
                "reset, then home"
            )
        )

    def fault(self, error: DeviceFault | PendantStop) -> DeviceFault | PendantStop:
        """Latch error-stop, and return the error, to be raised."""
        self.core.fault(error)
        return error

    def require_no_fault(self) -> None:
        """Raise the error that has latched error-stop, if one has."""
        if self.core.state is not State.ERROR_STOP:
            return
        error = self.core.error
        raise (Stopped if error.code == EMERGENCY_STOP else DeviceFault)(error.words)

    # -- motion -------------------------------------------------------------------------------

    def look_before_motion(self) -> TaskBody[None]:
        """Read the position and write the motion mark, unless the latest reading is fresh.

        If a slow disk makes the reading stale, the position is read again.
        """
        # Start the write first: the position is read while the disk works.
        self.core.memory.begin_mark()
        if self.now_s > self.looked_s + FRESH_S:
            yield from self.look()
        yield from leave_standstill(self)
        if self.now_s > self.looked_s + FRESH_S:
            yield from self.look()

    def move(
        self,
        target: Motors,
        rate_hz: float,
        there: ArmCoordinates | None,
        released: Callable[[], bool] = never,
    ) -> TaskBody[None]:
        """Send one burst towards an absolute target and wait until it has ended.

        It ends before the target if it only takes up backlash. A burst that has not started moving
        when `released()` becomes true is dropped.
        """
        core = self.core
        steps = target - core.position.acknowledged
        if not steps.largest:
            core.position.coordinates = there or core.position.coordinates
            return
        if not (yield from self._may_begin()):
            return
        core.position.stands()
        burst, *rest = pieces(core, steps, rate_hz, core.stops.burst_s, core.controller.duration_s)
        if rest:  # this one only takes up backlash
            there = core.position.coordinates
        else:
            self.note_deviation(deviation_steps(core, steps, rate_hz))
        yield from self._burst(replace(burst, released=released), there)

    def _burst(self, burst: MoveBy, there: ArmCoordinates | None) -> TaskBody[None]:
        """Send one burst and wait for its end."""
        core = self.core
        core.position.sends(burst.steps)
        reply = yield from self.driven(burst)
        if isinstance(reply, Halted | Interrupted):
            # anywhere from the start to the target is where a halt may leave a motor, and a device
            # that brakes with its own ramps may overshoot the target a little
            beyond = reply.beyond if isinstance(reply, Halted) else 0
            farthest = core.position.commanded + Motors(
                (step > 0) * beyond - (step < 0) * beyond for step in burst.steps
            )
            yield from self._ended(reply, way_between(core.position.acknowledged, farthest))
            return
        if isinstance(reply, RequestRejected):
            yield from self._refusal(reply)
        core.position.arrived(there)
        # an answer at an implausible time may be that of another request: the registers tell
        timely = isinstance(reply, Done) and reply.timely
        if not timely or self.now_s > self.looked_s + BLIND_S:
            yield from self.verify(midway=True)

    def driven(self, request: MoveBy | MoveAlong | HomeDevice) -> TaskBody[Reply]:
        """Send a motion and return the reply; the loss of the link counts as lost in motion."""
        try:
            return (yield from self.request(request))
        except LinkLost:
            self.core.lost_in_motion(self.now_s)
            raise

    def note_deviation(self, steps: Sequence[float]) -> None:
        """Take into account that each motor may deviate from its path by some steps."""
        here, _ = self.core.transmission.to_joints(self.core.position.acknowledged)
        self.deviation_mm = max(self.deviation_mm, deviation_mm(self.core.config, here, steps))

    def _may_begin(self) -> TaskBody[bool]:
        """Return whether a motion may be sent now; raises if settings or a fault forbid it.

        False means that the motion was stopped while the disk was slow.
        """
        self.core.require_settings()
        marked = yield from leave_standstill(self)
        self.require_no_fault()  # the device may have raised an alarm since the last burst
        return marked

    def stream(self, request: MoveAlong, course: StreamedCourse) -> TaskBody[bool]:
        """Stream segments to a device; return whether all were driven, or False if halted."""
        core = self.core
        if not (yield from self._may_begin()):
            return False
        core.position.stands()
        reply = yield from self.driven(request)
        self.deviation_mm = max(self.deviation_mm, course.deviation_mm)
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
        """Read where a stop left the motors; a stop at the pendant raises `PendantStop`."""
        yield from self.read()
        core = self.core
        # one reason is given: the first of these that explains where the arm stands now
        if isinstance(reply, Halted) and not reply.kept:
            core.learn(Evidence.STOPPED_DEAD, self.now_s)
        elif core.position.fell:
            core.learn(Evidence.CONTROLLER_RESTARTED, self.now_s)
        elif core.position.read_back is None or not passes(core.position.read_back):
            core.learn(Evidence.READ_BACK_DIFFERS, self.now_s)
        elif core.position.slack.vague:
            core.learn(Evidence.READ_BACK_DIFFERS, self.now_s, TURNING_ROUND)
        core.position.believe_registers()
        if isinstance(reply, Interrupted):
            raise self.fault(
                PendantStop(
                    "the STOP key of the pendant was pressed: look at the arm, then call `reset()`"
                )
            )

    def _refusal(self, reply: RequestRejected) -> TaskBody[None]:
        """Raise the fault of a refused motion, after reading what the motion left behind.

        The position stays trusted if the device is certain that it moved nothing. If an alert has
        already given a reason, the error uses its words.
        """
        core = self.core
        alert = core.error.words if core.state is State.ERROR_STOP else ""
        difference = yield from self.read()
        words = f": {reply.reason}" if reply.reason else ""
        # only a device that says so itself, and whose registers agree, has certainly not moved
        if not reply.moved and not difference.largest:
            core.position.believe_registers()
            raise self.fault(DeviceFault(alert or f"the controller refused the motion{words}"))
        evidence, why = refused_motion(reply)
        core.learn(evidence, self.now_s, reply.reason)
        take_difference(core)
        raise self.fault(DeviceFault(alert or f"{why}. Look at the arm, then call `reset()`"))


def without_reset(error: ArmError | str) -> str:
    """Return an error's text without the advice to reset, which is given later or not yet."""
    return str(error).rstrip(".").removesuffix(", then call `reset()`")


def weigh_difference(context: MotionContext, difference: Motors) -> None:
    """Apply the evidence of registers that changed although armdrive moved nothing."""
    core = context.core
    if not difference.largest:
        return
    zeroed = take_difference(core)
    evidence = Evidence.CONTROLLER_RESTARTED if zeroed else Evidence.MOVED_BY_OTHERS
    core.learn(evidence, context.now_s)
    core.report(evidence.value, code_of(evidence))


def take_difference(core: Core) -> bool:
    """Take the registers as the position; return whether they were zeroed, which moves nothing."""
    registers = core.position.counts
    zeroed = not registers.largest
    if zeroed and core.belief.trust is not Trust.UNKNOWN:
        core.position.rebase(registers)
        core.readings.current = Current.UNKNOWN
    else:
        core.position.believe_registers()
    return zeroed


# Waiting for the disk. The engine keeps running meanwhile, and a stop ends the wait. On simulated
# time the disk takes no time.

# poll often at first, because most disks need a few milliseconds, then less and less
FIRST_POLL_S = 0.001
LAST_POLL_S = 0.05
POLL_GROWTH = 1.5

LONGEST_S = 5.0  # a reference is valid without its record, so do not wait longer for a slow disk


def leave_standstill(context: MotionContext) -> TaskBody[bool]:
    """Wait until the motion mark is on the disk; raises `StateFileError` if it cannot be written.

    Return False if a stop was requested: nothing may move then.
    """
    memory = context.core.memory
    memory.begin_mark()
    pauses_s = _pauses_s()
    while not memory.mark_stands():
        if context.stopping:
            return False
        yield SleepUntil(context.now_s + next(pauses_s))
    return True


def be_remembered(context: MotionContext) -> TaskBody[None]:
    """Wait until the requested writes have ended; the notice reports a failure."""
    end_s = context.now_s + LONGEST_S
    pauses_s = _pauses_s()
    while not (context.core.memory.settled or context.stopping or context.now_s >= end_s):
        yield SleepUntil(context.now_s + next(pauses_s))
    context.core.report_write_errors()


def _pauses_s() -> Iterator[float]:
    """Yield the pauses between two polls."""
    pause_s = FIRST_POLL_S
    while True:
        yield pause_s
        pause_s = min(pause_s * POLL_GROWTH, LAST_POLL_S)


# The segments of one motion.

TURNING_ROUND = "the arm stopped while reversing, so the backlash may or may not be taken up"


# An unrounded point, and the least time to get there.
Way = tuple[ArmCoordinates, float]

# The longest way without a step that is drawn at once.
#
# Of a motion that is slower, the way to the next step may take hours: to draw all of it would keep
# the engine busy for seconds.
LONGEST_STILL_S = 0.5


class StreamedCourse:
    """The segments of one motion: absolute targets, rounded once, drawn as the device has room.

    A pause ends the segments. `exhausted` is true if the whole way was drawn before that, and
    `left` is the rest of a segment that the pause has interrupted. A way of `LONGEST_STILL_S`
    without a step ends them too: then the caller waits for `still_s`, and goes on. `slow_s` of the
    `total_s` of motion are slower than the device can turn its motors without stopping in between.
    """

    def __init__(self, core: Core, ways: Iterator[Way]) -> None:
        self.end: ArmCoordinates | None = core.position.coordinates
        self.left: Way | None = None
        self.exhausted = False
        self.still_s = 0.0
        self.deviation_mm = 0.0
        self.slow_s = self.total_s = 0.0
        self._core = core
        self._slowest_hz = core.controller.usable_rate_hz(0.0)
        self._ways = ways
        self._low = self._high = self._at = core.position.acknowledged
        self._before = core.position.commanded
        self._pending: Sequence[MoveBy] = ()

    def segments(self) -> Iterator[MoveBy]:
        """Yield the segments; the target of a drawn segment is the commanded position.

        If no motor makes a step on the way to a point, its time is added to the next segment, so
        that a slow motion stays slow.
        """
        waited_s = 0.0
        while not self._core.speed_override.paused:
            way = next(self._ways, None)
            if way is None:
                self.exhausted = True
                return
            there, duration_s = way
            target = there.motors(self._core.transmission)
            steps, self.end = target - self._at, there
            if not steps.largest:
                waited_s += duration_s
                if waited_s > LONGEST_STILL_S:
                    self.still_s = waited_s
                    self.slow_s, self.total_s = self.slow_s + waited_s, self.total_s + waited_s
                    return
                continue
            duration_s, waited_s = duration_s + waited_s, 0.0
            self._at = target
            self._low = Motors(map(min, self._low, target))
            self._high = Motors(map(max, self._high, target))
            yield from self._drawn(steps, steps.largest / duration_s)

    def _drawn(self, steps: Motors, rate_hz: float) -> Iterator[MoveBy]:
        """Yield the segment for some steps, with the backlash of reversing motors."""
        core = self._core
        longest_s = segment_s(core.stops.burst_s)
        found = pieces(core, steps, rate_hz, longest_s, lambda count, rate: count / rate)
        if len(found) == 1:
            here, _ = core.transmission.to_joints(core.position.commanded)
            beside_mm = deviation_mm(core.config, here, lags(steps, found[0].steps))
            self.deviation_mm = max(self.deviation_mm, beside_mm)
        for index, piece in enumerate(found):
            self.total_s += piece.duration_s
            self.slow_s += piece.duration_s if piece.rate_hz < self._slowest_hz else 0.0
            self._before, self._pending = core.position.commanded, found[index:]
            core.position.sends(piece.steps)
            yield piece

    def give_back(self, unsent: int) -> None:
        """Take back the latest segment if it was drawn but not sent (`unsent` is 0 or 1)."""
        # what is left of the way: the pieces that follow the latest one, and that one if unsent
        pending = self._pending if unsent else self._pending[1:]
        if not pending or self.end is None:
            return
        if unsent:
            self._core.position.takes_back(self._before)
        self.left = self.end, math.fsum(piece.duration_s for piece in pending)
        self.end = None

    def passes(self, position: Motors) -> bool:
        """Return whether a position lies within the segments drawn so far."""
        return way_between(self._low, self._high)(position)


def refused_motion(reply: RequestRejected) -> tuple[Evidence, str]:
    """Return the evidence of a refused motion about the position, and what has happened."""
    if not reply.reason:
        evidence = Evidence.SILENT if reply.silent else Evidence.MOTION_REFUSED
        return evidence, "the controller refused a valid motion; a byte may have been corrupted"
    evidence = Evidence.SILENT if reply.silent else Evidence.BROKEN_OFF
    return evidence, f"the motion was aborted: {reply.reason}"


def way_between(start: Motors, end: Motors) -> Callable[[Motors], bool]:
    """Return a test whether every motor is between its start and its target."""
    spans = [(min(pair), max(pair)) for pair in zip(start, end, strict=True)]
    return lambda at: all(
        low <= count <= high for count, (low, high) in zip(at, spans, strict=True)
    )
