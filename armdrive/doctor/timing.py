"""How punctually this computer wakes a thread: measured, while nothing is opened or moved."""

from __future__ import annotations

import time

from armdrive.doctor.findings import Finding, note, ok
from armdrive.lateness import Lateness, Wakes

PERIOD_S = 0.01
DEADLINES = 60

LATE_S = 5e-3
"""Later than this now and then is worth a word: a burst is some 100 ms long."""


def measure(deadlines: int = DEADLINES, period_s: float = PERIOD_S) -> Wakes:
    """Return how late a thread woke for so many deadlines that were set beforehand."""
    lateness = Lateness()
    due_s = time.perf_counter()
    for _ in range(deadlines):
        due_s += period_s
        time.sleep(max(due_s - time.perf_counter(), 0.0))
        lateness.add(time.perf_counter() - due_s)
    return lateness.view()


def finding(wakes: Wakes) -> Finding:
    """Say whether it is punctual enough to drive an arm smoothly."""
    what = f"this computer's punctuality: {wakes}"
    if wakes.p99_s <= LATE_S:
        return ok(what)
    return note(
        what,
        "other programs keep it busy: bursts then come late and motion stutters, though nothing "
        "runs away. Close some, or set a longer motion.planned_burst_s",
    )
