"""A drive's end of CiA 402: its states, and in profile position which target it drives to."""

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
    """A target that the drive was handed, in its own units."""

    target: int
    relative: bool
    at_once: bool


_BITS = {
    (False, False): NO_STATUS,
    (True, False): StatusBit.REACHED,
    (False, True): StatusBit.ACKNOWLEDGED,
    (True, True): StatusBit.REACHED | StatusBit.ACKNOWLEDGED,
}
"""The bits of the statusword, by whether the target is reached and the set-point acknowledged."""


class SetPoints:
    """Set-points of a drive since it was enabled: one that is driven to, and one that waits.

    `word` is the controlword that enabled it: a bit 4 that is up in it is no rising one.
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
        """What is driven to."""
        return self._active

    @property
    def halted(self) -> bool:
        """Whether it is to stand still."""
        return self._halted

    @property
    def bits(self) -> StatusBit:
        """Its bits of the statusword."""
        reached = self._stands if self._halted else self._active is None
        acknowledged = self._acknowledged or self._next is not None
        return _BITS[reached, acknowledged]

    def control(self, word: Controlword, target: int) -> SetPoint | None:
        """Take a controlword, and what 607A holds; returns what is driven to from now on.

        None where that has not changed: a set-point that waits comes out of `arrived`.
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
        """Say that the active target is reached; returns the one that waited, now active."""
        self._active, self._next = self._next, None
        self._stands = self._active is None
        return self._active

    def stood(self) -> None:
        """Say that the motor stands, after a halt."""
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


# A drive's end of CiA 402: controlwords in, its state, its set-points and its statusword out.
#
# What moves, how long a reaction or a quick stop takes, and what is wrong, its owner says.


class DriveDevice:
    """The machine of a simulated drive. It begins in NOT_READY, with nothing wrong."""

    def __init__(self, quick_stop: QuickStopOption = QuickStopOption.QUICK_RAMP) -> None:
        self.quick_stop = QuickStopOption(quick_stop)
        self._state = DriveState.NOT_READY
        self._faulty = False
        self._word = Controlword(0)
        self._points = SetPoints(self._word)

    @property
    def state(self) -> DriveState:
        """What the drive is."""
        return self._state

    @property
    def points(self) -> SetPoints:
        """Its set-points; of use while it is enabled."""
        return self._points

    def statusword(self, bits: StatusBit = NO_STATUS) -> Statusword:
        """Return what it says, with what its owner adds: voltage, warning, following error."""
        return _statusword(self._state, bits, self._points.bits)

    def control(
        self, word: Controlword, target: int = 0
    ) -> tuple[tuple[Transition, ...], SetPoint | None]:
        """Obey a controlword; returns what has changed, and what is driven to from now on."""
        rising = word.has(ControlBit.FAULT_RESET) and not self._word.has(ControlBit.FAULT_RESET)
        self._word = word
        taken: tuple[Transition, ...] = ()
        if word.command is not Command.FAULT_RESET or rising:
            taken = self._obey(word.command)
        if self._state is not DriveState.ENABLED or taken:
            return taken, None
        return taken, self._points.control(word, target)

    def happen(self, happening: Happening) -> Transition | None:
        """Take note of what happens in the drive; returns what it changes."""
        if happening is Happening.FAULT:
            self._faulty = True
        if happening is Happening.QUICK_STOPPED and self.quick_stop.stays:
            return None
        return self._change(happening)

    def mend(self) -> None:
        """Say that nothing is wrong any more: a fault can be reset from now on."""
        self._faulty = False

    def _obey(self, command: Command) -> tuple[Transition, ...]:
        taken = []
        while (row := self._change(command)) is not None:  # 3 is followed by 4
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
