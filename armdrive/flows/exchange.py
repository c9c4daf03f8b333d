"""One request, and what each answer to it means for the arm."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from armdrive.controllers.requests import (
    Denied,
    Done,
    Halted,
    Interrupted,
    MoveAlong,
    MoveBy,
    ReadPosition,
    Registers,
    Reply,
    Request,
    never,
)
from armdrive.core import Core
from armdrive.engine import Ask, Flow, Until
from armdrive.errors import (
    DeviceFault,
    LinkLost,
    NoAnswer,
    PendantStop,
    PositionMismatch,
    Stopped,
)
from armdrive.flows.remembering import leave_standstill
from armdrive.flows.straying import strays_steps
from armdrive.flows.taking_up import pieces
from armdrive.status import Current, State, Trust
from armdrive.stopping import straying_mm
from armdrive.trust import Evidence
from armdrive.whereabouts import Coordinates

if TYPE_CHECKING:
    from armdrive.engine import Engine
    from armdrive.flows.streaming import Course
    from kinematics import Motors

QUIET_S = 0.3
"""A silence this long ends whatever a disturbed controller had still to say."""

TRIES = 3
"""How often the registers are asked for: reading moves nothing, so it may be repeated."""

FRESH_S = 0.05
"""A look at the registers this long ago still tells where a motion starts from."""

TURNING_ROUND = "it stopped as it turned round, with the backlash taken up or not yet"

BLIND_S = 2.0
"""A motion is compared with the registers at least this often."""


class Wire:
    """What a flow needs of the engine: the time, and whether somebody asked for a stop."""

    def __init__(self, engine: Engine, core: Core) -> None:
        self.engine = engine
        self.core = core
        self.straying_mm = 0.0
        self._looked_s = -math.inf

    @property
    def now_s(self) -> float:
        """The arm's time."""
        return self.engine.now_s

    @property
    def stopping(self) -> bool:
        """Whether a stop has been asked for."""
        return self.engine.stop_asked

    def stopped(self, words: str) -> Stopped:
        """Return the error of a motion that a stop ended, with the reason where one is known."""
        return Stopped(words + self.engine.stop_why)

    def request(self, request: Request, silence: Evidence = Evidence.SILENT) -> Flow[Reply]:
        """Send one request and return its reply; silence is a fault of the arm."""
        try:
            reply: Reply = yield Ask(request)
        except NoAnswer as error:
            self.core.learn(silence, self.now_s)
            self.core.fault(error)
            raise
        return reply

    def ask_registers(self) -> Flow[Registers]:
        """Read the registers, again where an exchange was disturbed. Raises `DeviceFault`.

        After a disturbance an answer counts only if the line falls silent behind it: else it
        may be the late one of the try before, and the next answer would be taken for another's.
        After a silence, counts of zero may be those of a controller that has begun anew; an answer
        that came, and that nobody could read, is none.
        """
        silence: NoAnswer | None = None
        mute = False
        for attempt in range(TRIES):
            if attempt:
                yield from self.quiet()
            asked_s = self.now_s
            try:
                reply: Reply = yield Ask(ReadPosition())
            except NoAnswer as error:
                silence, mute = error, mute or self.engine.heard_s < asked_s
                continue
            if isinstance(reply, Denied) and reply.reason:  # it is there, and says why not
                raise DeviceFault(reply.reason)
            heard_s = self.engine.heard_s
            if attempt and isinstance(reply, Registers):
                yield from self.quiet()
            if isinstance(reply, Registers) and heard_s == self.engine.heard_s:
                self._looked_s = self.now_s
                if mute and not reply.positions.largest:
                    self.core.learn(Evidence.SILENT, self.now_s)  # it may have begun anew
                return reply
        raise silence or DeviceFault(
            f"whatever is on {self.engine.link.description} does not answer as this arm does: "
            "check the cable, the port and the dialect"
        )

    def quiet(self) -> Flow[None]:
        """Wait until nothing has been heard for a while, and forget what was."""
        since_s = self.now_s
        while self.now_s < (end_s := max(since_s, self.engine.heard_s) + QUIET_S):
            if self.stopping:
                break
            yield Until(end_s)
        self.engine.controller.forget()

    def read(self) -> Flow[Motors]:
        """Read the registers; return how far they are from the acknowledged ones.

        A difference is believed when it is read twice: the line has no check bytes.
        """
        difference = yield from self._read_once()
        seen = None
        while difference.largest and difference != seen:
            seen = difference
            difference = yield from self._read_once()
        return difference

    def _read_once(self) -> Flow[Motors]:
        try:
            registers = yield from self.ask_registers()
        except DeviceFault as fault:
            self.core.learn(Evidence.SILENT, self.now_s)
            self.core.fault(fault)
            raise
        return self.core.compare(registers)

    def look(self) -> Flow[None]:
        """Weigh what the registers show of an arm that stands: somebody else may move it."""
        weigh_difference(self, (yield from self.read()))

    def look_before_motion(self) -> Flow[None]:
        """Look, unless that was done a moment ago, while the mark of motion is being written.

        A slow disk makes what was seen stale, so that the look comes after it once more.
        """
        self.core.memory.begin_mark()
        if self.now_s > self._looked_s + FRESH_S:
            yield from self.look()
        marked = yield from leave_standstill(self)
        if marked and self.now_s > self._looked_s + FRESH_S:
            yield from self.look()

    def move(
        self,
        target: Motors,
        rate_hz: float,
        there: Coordinates | None,
        let_go: Callable[[], bool] = never,
    ) -> Flow[None]:
        """Send one burst to an absolute target and wait until it has ended.

        A burst that has not begun to move when `let_go()` becomes true need not be made.
        """
        core = self.core
        steps = target - core.acknowledged
        if not steps.largest:
            core.coordinates = there or core.coordinates
            return
        if not (yield from self._may_begin(let_go)):
            return
        core.stands()
        *first, last = pieces(core, steps, rate_hz, core.burst_s, core.controller.duration_s)
        for piece in first:  # these move nothing but motors
            arrived = yield from self._burst(replace(piece, let_go=let_go), core.coordinates)
            if not arrived or self.stopping or let_go():
                return
            if not (yield from self._may_begin(let_go)):
                return
        self.note_straying(strays_steps(core, steps, rate_hz))
        yield from self._burst(replace(last, let_go=let_go), there)

    def _burst(self, burst: MoveBy, there: Coordinates | None) -> Flow[bool]:
        """Send one burst and wait until it has ended; False where a stop ended it early."""
        core = self.core
        core.sends(burst.steps)
        try:
            reply = yield from self.request(burst, Evidence.ANSWER_LOST)
        except LinkLost:
            core.lost_in_motion(self.now_s)
            raise
        if isinstance(reply, Halted | Interrupted):
            yield from self._ended(reply, way_between(core.acknowledged, core.commanded))
            return False
        if isinstance(reply, Denied):
            yield from self._refusal(reply)
        core.arrived(there)
        timely = isinstance(reply, Done) and reply.timely
        if not timely or self.now_s > self._looked_s + BLIND_S:
            yield from self.verify()
        return True

    def note_straying(self, steps: Sequence[float]) -> None:
        """Note that each motor may stray from its way by so many steps."""
        here, _ = self.core.transmission.to_joints(self.core.acknowledged)
        self.straying_mm = max(self.straying_mm, straying_mm(self.core.config, here, steps))

    def _may_begin(self, let_go: Callable[[], bool]) -> Flow[bool]:
        """Tell whether a motion may be sent now; raises where what happened meanwhile forbids it.

        False where it was stopped or let go while a slow disk was waited for.
        """
        core = self.core
        core.require_settings()
        marked = yield from leave_standstill(self, let_go)
        if core.state is State.ERROR_STOP:  # the device has raised an alarm since the last burst
            raise DeviceFault(core.error)
        return marked

    def verify(self) -> Flow[None]:
        """Compare the registers with what was acknowledged; a difference is a fault."""
        difference = yield from self.read()
        if not difference.largest:
            return
        core = self.core
        core.learn(Evidence.READ_BACK_DIFFERS, self.now_s, f"by {tuple(difference)} steps")
        take_difference(core)
        raise self._fault(
            PositionMismatch(
                f"the registers differ by {tuple(difference)} steps from where the motion should "
                "have ended: a byte was lost, or the controller lost its power. Look at the arm, "
                "reset, then home"
            )
        )

    def stream(self, request: MoveAlong, course: Course) -> Flow[bool]:
        """Have a device drive queued segments; True when all were driven, False when halted."""
        core = self.core
        if not (yield from self._may_begin(request.let_go)):
            return False
        core.stands()
        try:
            reply = yield from self.request(request, Evidence.ANSWER_LOST)
        except LinkLost:
            core.lost_in_motion(self.now_s)
            raise
        self.straying_mm = max(self.straying_mm, course.straying_mm)
        if isinstance(reply, Halted | Interrupted):
            yield from self._ended(reply, course.passes)
            return False
        if isinstance(reply, Denied):
            yield from self._refusal(reply)
        course.give_back(reply.unsent if isinstance(reply, Done) else 0)
        core.arrived(course.end)
        return True

    def _ended(self, reply: Halted | Interrupted, passes: Callable[[Motors], bool]) -> Flow[None]:
        """Take up where a stop left the motors: the registers counted it. The operator's raises."""
        yield from self.read()
        core = self.core
        if isinstance(reply, Halted) and not reply.kept:
            core.learn(Evidence.STOPPED_DEAD, self.now_s)
        elif core.fell:
            core.learn(Evidence.CONTROLLER_RESTARTED, self.now_s)
        elif core.read_back is None or not passes(core.read_back):
            core.learn(Evidence.READ_BACK_DIFFERS, self.now_s)
        elif core.slack.vague:
            core.learn(Evidence.READ_BACK_DIFFERS, self.now_s, TURNING_ROUND)
        core.believe_registers()
        core.commanded = core.acknowledged  # also where nothing had moved yet
        if isinstance(reply, Interrupted):
            raise self._fault(
                PendantStop("the STOP key of the pendant was pressed: look at the arm, then reset")
            )

    def _refusal(self, reply: Denied) -> Flow[None]:
        """Find out what a refused motion left behind: nothing, where the device is sure of it.

        Where an alert has said already why the motion ended, its words are the error's.
        """
        core = self.core
        told = core.error if core.state is State.ERROR_STOP else ""
        difference = yield from self.read()
        words = f": {reply.reason}" if reply.reason else ""
        if not reply.moved and not difference.largest:
            core.believe_registers()
            core.commanded = core.acknowledged
            raise self._fault(DeviceFault(told or f"the controller refused the motion{words}"))
        core.learn(Evidence.MOTION_REFUSED, self.now_s)
        take_difference(core)
        raise self._fault(
            DeviceFault(
                told
                or f"the controller refused a motion that it should have understood{words}; a byte "
                "may have been garbled. Look at the arm, then reset"
            )
        )

    def _fault(self, error: DeviceFault | PendantStop) -> DeviceFault | PendantStop:
        self.core.fault(error)
        return error


def weigh_difference(wire: Wire, difference: Motors) -> None:
    """Say what registers mean that changed while nothing was moved from here."""
    core = wire.core
    if not difference.largest:
        return
    zeroed = take_difference(core)
    evidence = Evidence.CONTROLLER_RESTARTED if zeroed else Evidence.MOVED_BY_OTHERS
    core.learn(evidence, wire.now_s)
    core.notify(core.belief.reason, evidence)


def take_difference(core: Core) -> bool:
    """Take the registers for where the arm is; True where they were zeroed, which moves nothing."""
    registers = core.counts
    zeroed = not registers.largest
    if zeroed and core.belief.trust is not Trust.UNKNOWN:
        core.count_anew(registers)
        core.current = Current.UNKNOWN
    else:
        core.believe_registers()
    return zeroed


def way_between(start: Motors, end: Motors) -> Callable[[Motors], bool]:
    """Return what tells whether every motor stands between where it started and was sent."""
    spans = [(min(pair), max(pair)) for pair in zip(start, end, strict=True)]
    return lambda at: all(
        low <= count <= high for count, (low, high) in zip(at, spans, strict=True)
    )
