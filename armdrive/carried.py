"""How much a wire has carried, and how much of what it could carry that is."""

from __future__ import annotations

from dataclasses import dataclass

BITS_A_BYTE = 10
"""On a serial wire: eight of data, a start and a stop bit."""


@dataclass(frozen=True, slots=True)
class Carried:
    """Bytes that went out and came in since the beginning, and the wire's rate in baud."""

    sent: int = 0
    heard: int = 0
    baud: int = 0

    def load(self, earlier: Carried, for_s: float) -> float | None:
        """Return the share of the busier direction that was used since an earlier moment.

        0 to 1 and, where an operating system takes more than the wire can carry at once, above.
        None where the rate or the time is not known.
        """
        if self.baud <= 0 or for_s <= 0.0:
            return None
        busier = max(self.sent - earlier.sent, self.heard - earlier.heard)
        return max(busier, 0) * BITS_A_BYTE / (self.baud * for_s)
