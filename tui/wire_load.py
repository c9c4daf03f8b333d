"""The load of the wire over the last moments, from two statuses."""

from __future__ import annotations

from armdrive.status import Carried

OVER_S = 1.0
"""The load is that of at least so long, lest it flickers."""


class Load:
    """Remembers what the wire had carried a while ago."""

    def __init__(self) -> None:
        self._then: Carried | None = None
        self._then_s = 0.0
        self._load: float | None = None

    def of(self, now: Carried, now_s: float) -> float | None:
        """Return the share of the wire that is used; None where that cannot be known yet."""
        then = self._then
        if then is None or then.baud != now.baud or now.sent < then.sent:
            self._then, self._then_s, self._load = now, now_s, None  # another wire
        elif now_s - self._then_s >= OVER_S:
            self._load = now.load(then, now_s - self._then_s)
            self._then, self._then_s = now, now_s
        return self._load
