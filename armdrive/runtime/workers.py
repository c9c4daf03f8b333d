"""Threads in which an event loop has calls of an arm carried out, as a pace sees them.

A pace that is about to wait asks whether the thread is such a strand: one whose call was given up
must not wait on, and one that lives in simulated time hands its turn back to the loop meanwhile.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Protocol

from armdrive.runtime.clock import SimulatedClock


class WorkerEnded(BaseException):
    """The task that awaited this call was cancelled: it ends as by Ctrl-C, and stops the arm."""


class Worker(Protocol):
    """One call under way for an event loop."""

    @property
    def clock(self) -> SimulatedClock:
        """The simulated time of that loop, in which arms live that are given no other."""

    def check(self) -> None:
        """Raise `WorkerEnded` once where the call was given up."""

    def park(self, clock: SimulatedClock, done: Callable[[], bool], end_s: float) -> bool | None:
        """Wait in simulated time while the loop drives the clock; None where the caller drives.

        True when `done()`, False when the clock shows `end_s` first. Raises `WorkerEnded`.
        """


class _Here(threading.local):
    """What is known of the present thread alone."""

    strand: Worker | None = None


_HERE = _Here()


def present() -> Worker | None:
    """Return the strand that the present thread is."""
    return _HERE.strand


def become(strand: Worker) -> None:
    """Have the present thread be a strand from now on."""
    _HERE.strand = strand
