"""The master's end of profile position: the handshake by which a drive takes a target.

    WAITING    until the drive has room: bit 12 is 0
    ASKING     bit 4 is up, until the drive acknowledges: bit 12 is 1
    RELEASING  bit 4 is down, until the drive has seen that: bit 12 is 0
    UNDER_WAY  until the target is reached: bit 10 is 1
    HALTING    bit 8 is up, until the drive stands: bit 10 is 1

The target (607A) is to be written before `controlword` is sent. There is no clock: deadlines are
the owner's, and where a drive does not say that it has arrived, its position does. Statuswords are
to be fed in the order in which the drive said them, of one PDO or of SDO alone; repeated and lost
ones do no harm.
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
    """How far a set-point has come."""

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
    """The drive says that it is where it should be."""


@dataclass(frozen=True, slots=True)
class Stood:
    """The drive says that it stands, after a halt."""


@dataclass(frozen=True, slots=True)
class FollowingError:
    """The drive is farther from where it should be than its window (6065) allows."""


@dataclass(frozen=True, slots=True)
class Disabled:
    """The drive has left ENABLED, so the set-point is lost; None is a state that there is not."""

    state: DriveState | None


SetPointEvent: TypeAlias = Taken | Reached | Stood | FollowingError | Disabled

_IN_HANDSHAKE = (Phase.WAITING, Phase.ASKING, Phase.RELEASING)


class SetPointHost:
    """The machine that gives one drive its targets, while that is enabled.

    A halt ends a set-point: bit 8 stays up until the next one is acknowledged, which takes the
    place of the old, so that nothing goes on by itself when it comes down.
    """

    def __init__(self) -> None:
        self._phase = Phase.FREE
        self._bits = NO_CONTROL
        self._halted = False
        self._moved = False  # bit 10 was seen at 0 since the set-point was asked for
        self._following = False

    @property
    def phase(self) -> Phase:
        """How far the set-point has come."""
        return self._phase

    @property
    def controlword(self) -> Controlword:
        """What is to be sent now; to send it again changes nothing."""
        bits = self._bits
        if self._phase is Phase.ASKING:
            bits |= ControlBit.NEW_SET_POINT
        if self._halted:
            bits |= ControlBit.HALT
        return Controlword.of(Command.ENABLE_OPERATION, bits)

    def begin(self, *, at_once: bool = True, relative: bool = False) -> None:
        """Begin to hand over the target. Raises `LocalProtocolError` while one is handed over.

        `at_once` replaces what is under way, else the target comes behind it. Behind a halt it has
        to be at once.
        """
        if self._phase in (*_IN_HANDSHAKE, Phase.HALTING):
            raise LocalProtocolError(f"a set-point is {self._phase.value}: first wait or forget it")
        if self._halted and not at_once:
            raise LocalProtocolError("behind a halt a set-point is at once, or the old one goes on")
        self._bits = ControlBit.AT_ONCE if at_once else NO_CONTROL
        self._bits |= ControlBit.RELATIVE if relative else NO_CONTROL
        self._phase, self._moved = Phase.WAITING, False

    def halt(self) -> None:
        """Have the drive stand still and hold; at any time."""
        asked = self._phase not in (Phase.FREE, Phase.WAITING)
        self._halted = True
        self._phase = Phase.HALTING if asked else Phase.FREE

    def forget(self) -> None:
        """Wait no longer: for what did not come in time, or because the owner disables the drive.

        Whether the drive has taken the set-point is not known then. A halt stays.
        """
        self._phase = Phase.FREE

    def hear(self, word: Statusword) -> tuple[SetPointEvent, ...]:
        """Take what the drive says; returns what that means. Never raises."""
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
