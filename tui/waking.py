"""Noticing that this program did not run, and which keys had been waiting for it. Pure.

A program that is suspended hears nothing, but its keyboard goes on, and all that was typed meets
it at once when it goes on; or in pieces, from a link that kept it back as well. What comes then is
old until there was a silence. Times are in s, on any one clock.
"""

from __future__ import annotations

import math

SILENCE_S = 0.3
"""So long without any key, and the next one is new. A key that is held repeats sooner."""


class Waking:
    """Looks at two clocks, and takes the system's word for it where it has one."""

    def __init__(self) -> None:
        self._looked_s = math.inf
        self._busy_s = 0.0
        self._told = False
        self._old_s = -math.inf

    def tell(self) -> None:
        """Hear from the system that this program was suspended; safe in a signal handler."""
        self._told = True

    def look(self, now_s: float, busy_s: float) -> tuple[float, bool]:
        """Return for how long this program did nothing since the last look, and whether told so.

        `busy_s` is the processor time of the thread that looks: what it worked was no absence.
        """
        absent_s = (now_s - self._looked_s) - (busy_s - self._busy_s)
        self._looked_s, self._busy_s = now_s, busy_s
        told, self._told = self._told, False
        return max(absent_s, 0.0), told

    def wake(self, now_s: float) -> None:
        """Take whatever comes from now on for old, until there is a silence."""
        self._old_s = now_s

    def is_old(self, came_s: float, *, of_keyboard: bool = True) -> bool:
        """Tell whether what came then may have waited; a key that did lets the next one wait too.

        A mouse says so much that it would never be silent: it is old as long as the keys are.
        """
        if came_s - self._old_s >= SILENCE_S:
            return False
        if of_keyboard:
            self._old_s = max(self._old_s, came_s)
        return True
