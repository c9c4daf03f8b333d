"""The greeting of a GRBL board: whether it answers a reset of our own, or was said unasked.

A board that stands and is reset by 0x18 greets within milliseconds. One whose button was pressed,
or that had lost its power, takes longer: its loader comes first. Its counts are zero then, which
says nothing where they had been zero before; so the time has to.
"""

from __future__ import annotations

import math

GREETS_S = 0.4
"""How long a reset of our own takes a board that stood, and what it says on the wire."""


class Greeting:
    """What is expected: `awaited` from a reset of our own until its greeting comes."""

    def __init__(self) -> None:
        self.awaited = False
        self._by_s = math.inf

    def await_soon(self, now_s: float, asked_s: float) -> None:
        """Expect that of a board that stands; where it owes a report for long, none is credible."""
        self.awaited = True
        self._by_s = now_s + GREETS_S if asked_s > now_s - GREETS_S else -math.inf

    def await_late(self) -> None:
        """Expect that of a board whose motion is ended: it lets its motors go and raises an alarm.

        Its position is lost, whatever has reset it.
        """
        self.awaited = True
        self._by_s = math.inf

    def give_up(self) -> None:
        """Expect none any longer."""
        self.awaited = False

    def answers(self, now_s: float) -> bool:
        """Take in that one has come; tell whether it is the one that was awaited."""
        answers = self.awaited and now_s <= self._by_s
        self.awaited = False
        return answers
