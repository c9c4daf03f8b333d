"""The master's end of profile position mode: the handshake that hands a target to a drive.

    WAITING    until the drive has room: bit 12 is 0
    ASKING     bit 4 is set, until the drive acknowledges: bit 12 is 1
    RELEASING  bit 4 is clear, until the drive has seen that: bit 12 is 0
    UNDER_WAY  until the target is reached: bit 10 is 1
    HALTING    bit 8 is set, until the drive is at rest: bit 10 is 1

Write the target (607A) before sending `controlword`. There is no clock: the owner keeps deadlines,
and checks the position if a drive does not report its arrival. Pass statuswords in the order in
which the drive sent them, from a single PDO or from SDO only; lost and repeated ones do no harm.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

from firmware_protocol.canopen.drives import (
    NO_CONTROL,
    Command,
    ControlBit,
    Controlword,
    DriveState,
    StatusBit,
    Statusword,
)
from firmware_protocol.errors import LocalProtocolError


class Phase(Enum):
    """A phase of the handshake."""

    FREE = "free"
    WAITING = "waiting"
    ASKING = "asking"
    RELEASING = "releasing"
    UNDER_WAY = "under way"
    HALTING = "halting"


@dataclass(frozen=True, slots=True)
class Taken:
    """The drive has acknowledged the set-point."""


@dataclass(frozen=True, slots=True)
class Reached:
    """The drive reports that it has reached the target."""


@dataclass(frozen=True, slots=True)
class Stood:
    """The drive reports that it is at rest after a halt."""


@dataclass(frozen=True, slots=True)
class FollowingError:
    """The drive's following error exceeds its window (6065)."""


@dataclass(frozen=True, slots=True)
class Disabled:
    """The drive has left ENABLED and lost the set-point; `state` None is an undefined state."""

    state: DriveState | None


SetPointEvent: TypeAlias = Taken | Reached | Stood | FollowingError | Disabled

_IN_HANDSHAKE = (Phase.WAITING, Phase.ASKING, Phase.RELEASING)


class SetPointHost:
    """Hands targets to one enabled drive.

    A halt ends a set-point: bit 8 stays set until the next set-point is acknowledged. That one
    replaces the old, so that the halted motion never resumes when bit 8 is cleared.
    """

    def __init__(self) -> None:
        self._phase = Phase.FREE
        self._bits = NO_CONTROL
        self._halted = False
        self._moved = False  # bit 10 has been 0 since the set-point was requested
        self._following = False

    @property
    def phase(self) -> Phase:
        """The phase of the handshake."""
        return self._phase

    @property
    def controlword(self) -> Controlword:
        """The controlword to send now; repeating it changes nothing."""
        bits = self._bits
        if self._phase is Phase.ASKING:
            bits |= ControlBit.NEW_SET_POINT
        if self._halted:
            bits |= ControlBit.HALT
        return Controlword.of(Command.ENABLE_OPERATION, bits)

    def begin(self, *, at_once: bool = True, relative: bool = False) -> None:
        """Begin to hand over the target. Raises `LocalProtocolError` during a handover.

        With `at_once` the target replaces the active one; otherwise it follows it. After a halt,
        `at_once` is required.
        """
        if self._phase in (*_IN_HANDSHAKE, Phase.HALTING):
            raise LocalProtocolError(f"a set-point is {self._phase.value}: first wait or forget it")
        if self._halted and not at_once:
            raise LocalProtocolError("behind a halt a set-point is at once, or the old one goes on")
        self._bits = ControlBit.AT_ONCE if at_once else NO_CONTROL
        self._bits |= ControlBit.RELATIVE if relative else NO_CONTROL
        self._phase, self._moved = Phase.WAITING, False

    def halt(self) -> None:
        """Stop the drive and hold; allowed at any time."""
        asked = self._phase not in (Phase.FREE, Phase.WAITING)
        self._halted = True
        self._phase = Phase.HALTING if asked else Phase.FREE

    def forget(self) -> None:
        """Stop waiting, after a timeout or because the owner disables the drive.

        The drive may or may not have accepted the set-point. A halt stays in force.
        """
        self._phase = Phase.FREE

    def hear(self, word: Statusword) -> tuple[SetPointEvent, ...]:
        """Process a statusword; return the events. Never raises."""
        if word.state is not DriveState.ENABLED:
            idle, self._phase = self._phase is Phase.FREE, Phase.FREE
            self._following = False
            return () if idle else (Disabled(word.state),)
        return (*self._follow(word), *self._step(word))

    def _follow(self, word: Statusword) -> tuple[SetPointEvent, ...]:
        before, self._following = self._following, word.has(StatusBit.FOLLOWING_ERROR)
        return (FollowingError(),) if self._following and not before else ()

    def _step(self, word: Statusword) -> tuple[SetPointEvent, ...]:
        acknowledged, reached = word.has(StatusBit.ACKNOWLEDGED), word.has(StatusBit.REACHED)
        if self._phase is not Phase.WAITING and not reached:
            self._moved = True
        match self._phase:
            case Phase.WAITING if not acknowledged:
                self._phase = Phase.ASKING
            case Phase.ASKING if acknowledged:
                self._phase, self._halted = Phase.RELEASING, False
                return (Taken(),)
            case Phase.RELEASING if not acknowledged:
                self._phase = Phase.UNDER_WAY
                return self._arrive(reached)
            case Phase.UNDER_WAY:
                return self._arrive(reached)
            case Phase.HALTING if reached and self._moved:
                self._phase = Phase.FREE
                return (Stood(),)
        return ()

    def _arrive(self, reached: bool) -> tuple[SetPointEvent, ...]:
        if not reached:
            return ()
        self._phase = Phase.FREE
        return (Reached(),)
