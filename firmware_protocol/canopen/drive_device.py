"""The drive's end of CiA 402: the state machine, and the set-points of profile position mode."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from firmware_protocol.canopen.drives import (
    NO_STATUS,
    RESETS,
    RESUMES,
    Cause,
    Command,
    ControlBit,
    Controlword,
    DriveState,
    Happening,
    QuickStopOption,
    StatusBit,
    Statusword,
    Transition,
    transition,
)
from firmware_protocol.errors import BadField


@dataclass(frozen=True, slots=True)
class SetPoint:
    """A target that the drive has received, in the drive's units."""

    target: int
    relative: bool
    at_once: bool


_BITS = {
    (False, False): NO_STATUS,
    (True, False): StatusBit.REACHED,
    (False, True): StatusBit.ACKNOWLEDGED,
    (True, True): StatusBit.REACHED | StatusBit.ACKNOWLEDGED,
}
"""Statusword bits for (target reached, set-point acknowledged)."""


class SetPoints:
    """The set-points of an enabled drive: an active one and a pending one.

    `word` is the controlword that enabled the drive; if its bit 4 is set, that is no rising edge.
    """

    def __init__(self, word: Controlword) -> None:
        self._active: SetPoint | None = None
        self._next: SetPoint | None = None
        self._asked = word.has(ControlBit.NEW_SET_POINT)
        self._acknowledged = False
        self._halted = word.has(ControlBit.HALT)
        self._stands = True

    @property
    def active(self) -> SetPoint | None:
        """The target that the drive is moving to."""
        return self._active

    @property
    def halted(self) -> bool:
        """Whether a halt is commanded."""
        return self._halted

    @property
    def bits(self) -> StatusBit:
        """The statusword bits for the set-points."""
        reached = self._stands if self._halted else self._active is None
        acknowledged = self._acknowledged or self._next is not None
        return _BITS[reached, acknowledged]

    def control(self, word: Controlword, target: int) -> SetPoint | None:
        """Process a controlword and the target in 607A; return the new active set-point.

        None if the active set-point has not changed; `arrived` returns a pending one.
        """
        asked = word.has(ControlBit.NEW_SET_POINT)
        rising, self._asked = asked and not self._asked, asked
        self._halt(word.has(ControlBit.HALT))
        if not asked:
            self._acknowledged = False
        if not rising:
            return None
        at_once = word.has(ControlBit.AT_ONCE)
        return self._take(SetPoint(target, word.has(ControlBit.RELATIVE), at_once))

    def arrived(self) -> SetPoint | None:
        """Report that the active target is reached; return the pending set-point, now active."""
        self._active, self._next = self._next, None
        self._stands = self._active is None
        return self._active

    def stood(self) -> None:
        """Report that the motor is at rest after a halt."""
        self._stands = True

    def _halt(self, halted: bool) -> None:
        if halted != self._halted:
            self._halted, self._stands = halted, self._active is None

    def _take(self, point: SetPoint) -> SetPoint | None:
        if self._active is not None and not point.at_once:
            if self._next is None:
                self._next, self._acknowledged = point, True
            return None
        self._active, self._next, self._acknowledged = point, None, True
        self._stands = self._stands and self._halted
        return point


# The drive's end of CiA 402: controlwords in; state, set-points and statusword out.
#
# The owner simulates the motion, the duration of a fault reaction or quick stop, and faults.


class DriveDevice:
    """The state machine of a simulated drive. It begins in NOT_READY, without a fault."""

    def __init__(self, quick_stop: QuickStopOption = QuickStopOption.QUICK_RAMP) -> None:
        self.quick_stop = QuickStopOption(quick_stop)
        self._state = DriveState.NOT_READY
        self._faulty = False
        self._word = Controlword(0)
        self._points = SetPoints(self._word)

    @property
    def state(self) -> DriveState:
        """The drive's state."""
        return self._state

    @property
    def points(self) -> SetPoints:
        """The drive's set-points; meaningful while the drive is enabled."""
        return self._points

    def statusword(self, bits: StatusBit = NO_STATUS) -> Statusword:
        """Return the statusword, with bits from the owner: voltage, warning, following error."""
        return _statusword(self._state, bits, self._points.bits)

    def control(
        self, word: Controlword, target: int = 0
    ) -> tuple[tuple[Transition, ...], SetPoint | None]:
        """Obey a controlword; return the transitions and the new active set-point."""
        rising = word.has(ControlBit.FAULT_RESET) and not self._word.has(ControlBit.FAULT_RESET)
        self._word = word
        taken: tuple[Transition, ...] = ()
        if word.command is not Command.FAULT_RESET or rising:
            taken = self._obey(word.command)
        if self._state is not DriveState.ENABLED or taken:
            return taken, None
        return taken, self._points.control(word, target)

    def happen(self, happening: Happening) -> Transition | None:
        """Process an event inside the drive; return the transition that it causes."""
        if happening is Happening.FAULT:
            self._faulty = True
        if happening is Happening.QUICK_STOPPED and self.quick_stop.stays:
            return None
        return self._change(happening)

    def mend(self) -> None:
        """Report that the cause of the fault is gone, so that the fault can be reset."""
        self._faulty = False

    def _obey(self, command: Command) -> tuple[Transition, ...]:
        taken = []
        while (row := self._change(command)) is not None:  # transition 3 leads on to 4
            taken.append(row)
        at_once = self.quick_stop is QuickStopOption.DISABLE
        if self._state is DriveState.QUICK_STOP and taken and at_once:
            taken += filter(None, (self._change(Happening.QUICK_STOPPED),))
        return tuple(taken)

    def _change(self, cause: Cause) -> Transition | None:
        row = transition(self._state, cause)
        if row is None or (row.number == RESETS and self._faulty):
            return None
        if row.number == RESUMES and not self.quick_stop.stays:
            return None
        self._state = row.end
        self._points = SetPoints(self._word)
        return row


@lru_cache(maxsize=256)
def _statusword(state: DriveState, bits: StatusBit, of_points: StatusBit) -> Statusword:
    if bits & _BITS[True, True]:
        raise BadField("bits", bits, "none of those that are the set-points'")
    return Statusword.of(state, bits | StatusBit.REMOTE | of_points)
