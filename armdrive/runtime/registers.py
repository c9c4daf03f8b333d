"""What a task waits for that moves nothing: replies, registers that are weighed, and the disk."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

from armdrive.errors import ArmError, DeviceFault, NoAnswer, PendantStop, PositionMismatch, Stopped
from armdrive.runtime.arm_state import Core
from armdrive.runtime.diagnostics import ALARM_VOUCHED, code_of
from armdrive.runtime.engine import Engine
from armdrive.status import Current, Evidence, State, Trust
from armdrive.tasks import (
    Alert,
    AlertKind,
    Exchange,
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

QUIET_S = 0.3
"""A silence this long ends whatever a disturbed controller had still to say."""

TRIES = 3
"""How often the registers are asked for: reading moves nothing, so it may be repeated."""


class RegisterReader:
    """What a task needs that moves nothing: the time, whether to stop, requests, registers."""

    def __init__(self, engine: Engine, core: Core) -> None:
        self.engine = engine
        self.core = core
        self.looked_s = -math.inf
        """When the registers were read last."""

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

    def request(self, request: Request, silence: Evidence = Evidence.SILENT) -> TaskBody[Reply]:
        """Send one request and return its reply; silence is a fault of the arm."""
        try:
            reply: Reply = yield Exchange(request)
        except NoAnswer as error:
            self.core.learn(silence, self.now_s)
            self.core.fault(error)
            raise
        return reply

    def ask_registers(self) -> TaskBody[Registers]:
        """Read the registers, again where an exchange was disturbed. Raises `DeviceFault`.

        It ends within the limit of a call, also in the middle of a motion.
        """
        with self.engine.limited():
            return (yield from self._ask_registers())

    def _ask_registers(self) -> TaskBody[Registers]:
        """Ask until one answer is sure.

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
                reply: Reply = yield Exchange(ReadPosition())
            except NoAnswer as error:
                silence, mute = error, mute or self.engine.heard_s < asked_s
                continue
            if isinstance(reply, RequestRejected) and reply.reason:  # it is there, and says why not
                raise DeviceFault(reply.reason)
            heard_s = self.engine.heard_s
            if attempt and isinstance(reply, Registers):
                yield from self.quiet()
            alone = heard_s == self.engine.heard_s or self._beats
            if isinstance(reply, Registers) and alone:
                self.looked_s = self.now_s
                if mute and not reply.positions.largest:
                    self.core.learn(Evidence.SILENT, self.now_s)  # it may have begun anew
                return reply
        raise silence or DeviceFault(
            f"whatever is on {self.engine.link.description} does not answer as this arm does: "
            "check the cable, the port and the dialect"
        )

    def quiet(self) -> TaskBody[None]:
        """Wait until nothing has been heard for a while, and forget what was.

        Of a device whose line is never quiet, as long as late answers take.
        """
        since_s = self.now_s
        while self.now_s < (end_s := self._quiet_from_s(since_s) + QUIET_S):
            if self.stopping:
                break
            yield SleepUntil(end_s)
        self.engine.controller.forget()

    def _quiet_from_s(self, since_s: float) -> float:
        return since_s if self._beats else max(since_s, self.engine.heard_s)

    @property
    def _beats(self) -> bool:
        return self.core.controller.abilities.beats

    def read(self) -> TaskBody[Motors]:
        """Read the registers; return how far they are from the acknowledged ones.

        A difference is believed when it is read twice: the line has no check bytes.
        """
        difference = yield from self._read_once()
        seen = None
        while difference.largest and difference != seen:
            seen = difference
            difference = yield from self._read_once()
        return difference

    def _read_once(self) -> TaskBody[Motors]:
        try:
            registers = yield from self.ask_registers()
        except DeviceFault as fault:
            self.core.learn(Evidence.SILENT, self.now_s)
            self.core.fault(fault)
            raise
        return self.core.position.compare(registers)

    def look(self) -> TaskBody[None]:
        """Weigh what the registers show of an arm that stands: somebody else may move it."""
        weigh_difference(self, (yield from self.read()))

    def verify(self) -> TaskBody[None]:
        """Compare the registers with what was acknowledged; a difference is a fault."""
        difference = yield from self.read()
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
        """Raise what has latched error-stop meanwhile."""
        if self.core.state is State.ERROR_STOP:
            raise DeviceFault(self.core.diagnostics.error)


def without_reset(error: ArmError) -> str:
    """Return what an error says, without the reset that there is no arm for yet."""
    return str(error).rstrip(".").removesuffix(", then call `reset()`")


def weigh_difference(wire: RegisterReader, difference: Motors) -> None:
    """Say what registers mean that changed while nothing was moved from here."""
    core = wire.core
    if not difference.largest:
        return
    zeroed = take_difference(core)
    evidence = Evidence.CONTROLLER_RESTARTED if zeroed else Evidence.MOVED_BY_OTHERS
    core.learn(evidence, wire.now_s)
    core.diagnostics.notify(core.belief.reason, evidence)


def take_difference(core: Core) -> bool:
    """Take the registers for where the arm is; True where they were zeroed, which moves nothing."""
    registers = core.position.counts
    zeroed = not registers.largest
    if zeroed and core.belief.trust is not Trust.UNKNOWN:
        core.position.count_anew(registers)
        core.readings.current = Current.UNKNOWN
    else:
        core.position.believe_registers()
    return zeroed


# Waiting for the disk, while the engine goes on listening and a stop ends the wait.
#
# On simulated time the disk takes no time, and nothing here waits.

FIRST_LOOK_S = 0.001
LAST_LOOK_S = 0.05
SLOWER = 1.5
"""The disk is looked at often at first, as most need a few milliseconds, then less and less."""

LONGEST_S = 5.0
"""A reference is good without its record: a disk that takes longer is not waited for."""


def leave_standstill(wire: RegisterReader, let_go: Callable[[], bool] = never) -> TaskBody[bool]:
    """Wait until the mark of motion is on the disk; raises `StateFileError` where it cannot be.

    False where a stop was asked for meanwhile, or `let_go()` became true: nothing may move then.
    """
    memory = wire.core.memory
    memory.begin_mark()
    look_s = FIRST_LOOK_S
    while not memory.mark_stands():
        if wire.stopping or let_go():
            return False
        yield SleepUntil(wire.now_s + look_s)
        look_s = min(look_s * SLOWER, LAST_LOOK_S)
    return True


def be_remembered(wire: RegisterReader) -> TaskBody[None]:
    """Wait until what was asked for is on the disk or has failed, which the notice tells then."""
    end_s = wire.now_s + LONGEST_S
    look_s = FIRST_LOOK_S
    while not (wire.core.memory.settled or wire.stopping or wire.now_s >= end_s):
        yield SleepUntil(wire.now_s + look_s)
        look_s = min(look_s * SLOWER, LAST_LOOK_S)
    wire.core.hear_memory()


# What a device says unasked, and what that does to trust and state: one table.

EVIDENCE: Mapping[AlertKind, Evidence | None] = MappingProxyType(
    {
        AlertKind.RESTARTED: Evidence.RESTARTED,
        AlertKind.ALARM: None,
        AlertKind.ALARM_LOST: Evidence.ALARM,
        AlertKind.SWITCHED_OFF: Evidence.SWITCHED_OFF,
        AlertKind.ASTRAY: Evidence.OFF_THE_PATH,
    }
)
"""What each alert says about the position; None where the device vouches for it."""


def alerted(core: Core, alert: Alert, now_s: float) -> None:
    """Latch error-stop with the device's words, and weigh what they mean for the position."""
    evidence = EVIDENCE[alert.kind]
    if evidence is not None:
        core.learn(evidence, now_s, alert.text)
        core.told_early = core.told_early or (evidence, alert.text)
    if alert.kind in (AlertKind.RESTARTED, AlertKind.SWITCHED_OFF):
        core.readings.current = Current.UNKNOWN
    code = ALARM_VOUCHED if evidence is None else code_of(evidence)
    core.fault(f"{alert.text}. Look at the arm, then call `reset()`", code)
