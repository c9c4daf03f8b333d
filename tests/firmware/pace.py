"""How well a simulated board keeps real time, and the error of a board that cannot be started."""

from __future__ import annotations


class NoSimulator(Exception):
    """Something that a simulated board needs is missing; the message says what to do."""


MIN_RUN_S = 1.0
"""The ratio of simulated to real time is meaningless over a shorter time."""


class Pace:
    """Measures how well simulated processors keep real time."""

    def __init__(self) -> None:
        self._sim_s = self._run_s = 0.0

    def add(self, sim_s: float, run_s: float) -> None:
        """Add how long a processor ran, and how long it should have run."""
        self._sim_s += sim_s
        self._run_s += run_s

    def taken(self) -> float | None:
        """Return simulated seconds per second since the last call; None if that is too short."""
        if self._run_s < MIN_RUN_S:
            return None
        ratio = self._sim_s / self._run_s
        self._sim_s = self._run_s = 0.0
        return ratio
