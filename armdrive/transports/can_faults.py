"""What a CAN bus does to whole frames, as rules for the fault lanes: one is lost, or overtaken.

A single wrong bit is no fault here: a frame's CRC finds it, and its controller sends it again.
"""

from __future__ import annotations

from armdrive.sim.wire_faults import Amount, Rule


def frame_lost(frame: bytes, amount: Amount) -> tuple[bytes, float]:
    """Lose whole frames: an adapter's or a drive's buffer was full."""
    return (b"" if amount.strikes(len(frame)) else frame), 0.0


def overtaken(amount: Amount) -> Rule:
    """Return the rule that has frames come after the next one; without a next one they are lost."""
    holding = _Holding(amount)
    return Rule(holding.passed, holding)


class _Holding(Amount):
    """Holds a frame back; it is spent when its amount is, and nothing is held any more."""

    def __init__(self, amount: Amount) -> None:
        self._amount = amount
        self._held = b""

    def strike(self, length: int) -> tuple[int, ...]:
        """Ask the amount."""
        return self._amount.strike(length)

    def passed(self, frame: bytes, _: Amount) -> tuple[bytes, float]:
        """Hold a frame that is struck, and let it go behind the next one."""
        if self._held:
            frame, self._held = frame + self._held, b""
            self.spent = self._amount.spent
        elif self._amount.strikes(len(frame)):
            frame, self._held = b"", frame
        return frame, 0.0
