"""A drive's end of profile position: which target it drives to, and which comes behind it."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol.canopen.drive_words import NO_STATUS, ControlBit, Controlword, StatusBit


@dataclass(frozen=True, slots=True)
class SetPoint:
    """A target that the drive was handed, in its own units."""

    target: int
    relative: bool
    at_once: bool


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
        bits = StatusBit.REACHED if reached else NO_STATUS
        return bits | StatusBit.ACKNOWLEDGED if acknowledged else bits

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
