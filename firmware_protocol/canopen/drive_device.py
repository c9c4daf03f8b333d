"""A drive's end of CiA 402: controlwords in, its state, its set-points and its statusword out.

What moves, how long a reaction or a quick stop takes, and what is wrong, its owner says.
"""

from __future__ import annotations

from firmware_protocol.canopen.drive_modes import QuickStopOption
from firmware_protocol.canopen.drive_states import (
    RESETS,
    RESUMES,
    Cause,
    Happening,
    Transition,
    transition,
)
from firmware_protocol.canopen.drive_words import (
    NO_STATUS,
    Command,
    ControlBit,
    Controlword,
    DriveState,
    StatusBit,
    Statusword,
)
from firmware_protocol.canopen.set_point_device import SetPoint, SetPoints
from firmware_protocol.errors import BadField


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
        if bits & (StatusBit.REACHED | StatusBit.ACKNOWLEDGED):
            raise BadField("bits", bits, "none of those that are the set-points'")
        return Statusword.of(self._state, bits | StatusBit.REMOTE | self._points.bits)

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
