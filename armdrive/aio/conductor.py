"""Drives one simulated clock for an event loop, turn by turn, while strands wait on it.

Between two turns the loop does whatever else it has to do. It is a chain of callbacks and no
task, so that nobody can cancel it while arms have yet to be stopped.
"""

from __future__ import annotations

import asyncio
from typing import Any

from armdrive.aio.strand import ThreadStrand
from armdrive.clock import Progress, SimulatedClock
from armdrive.signals import SignalsBetweenSteps

SETTLING = 10
"""After a call has gone on, the loop goes round so often before time does: whoever awaited it, also
through `gather` and tasks within tasks, asks for its next call at the same simulated moment."""


class Conductor:
    """One clock, and the strands that wait on it in the order in which they came."""

    def __init__(self, clock: SimulatedClock, loop: asyncio.AbstractEventLoop) -> None:
        self._clock = clock
        self._loop = loop
        self._parked: list[ThreadStrand[Any]] = []
        self._progress = Progress(clock)
        self._settling = 0
        self._due = False

    def admit(self, strand: ThreadStrand[Any]) -> None:
        """Have a strand wait; called on the loop's thread."""
        self._parked.append(strand)
        self._progress = Progress(self._clock)
        self._go_on()

    def _go_on(self) -> None:
        if self._parked and not self._due:
            self._due = True
            self._loop.call_soon(self._turn)

    def _turn(self) -> None:
        self._due = False
        try:
            if self._settling:
                self._settling -= 1
            elif self._resumed():
                self._settling = SETTLING
            else:
                self._advance()
        except Exception as error:  # it is for those who wait, as it is without a loop
            for strand in self._taken():
                strand.resume(error)
        finally:
            self._go_on()

    def _resumed(self) -> bool:
        """Let run all whose wait is over, one after the other; tell whether there was any."""
        any_ready = False
        for strand in tuple(self._parked):
            if strand.ready():
                any_ready = True
                self._parked.remove(strand)
                strand.resume()
        return any_ready

    def _advance(self) -> None:
        """Have every arm do what is due; where nobody's wait is over, let time pass."""
        with SignalsBetweenSteps(), self._clock.lock:
            next_s = self._clock.advance()
            if not any(strand.ready() for strand in self._parked):
                self._progress.jump(next_s, min(each.waits_until_s for each in self._parked))

    def _taken(self) -> list[ThreadStrand[Any]]:
        taken, self._parked = self._parked, []
        return taken
