"""The program's own heartbeat, which drives on a bus mind: they stop when it is missing.

It is said by the loop that also steers, so that a program that was suspended, or hangs, falls
silent. Beats that were missed are not made up for.
"""

from __future__ import annotations

import math

from firmware_protocol.canopen import Heartbeat, NodeState
from firmware_protocol.frames import pack


class Beats:
    """When the next heartbeat is due. Seconds."""

    def __init__(self, node: int, period_s: float) -> None:
        self.period_s = period_s
        self.due_s = math.inf
        self.said_s = math.inf
        """When it was said last; infinity before the first."""
        self._data = pack(Heartbeat(node, NodeState.OPERATIONAL).frame)

    @property
    def on(self) -> bool:
        """Whether it beats."""
        return math.isfinite(self.due_s)

    def begin(self, now_s: float) -> None:
        """Beat from now on."""
        if not self.on:
            self.due_s = now_s

    def end(self) -> None:
        """Beat no more."""
        self.due_s = self.said_s = math.inf

    def say(self, now_s: float) -> bytes:
        """Return a heartbeat if it is due."""
        if now_s < self.due_s - 1e-9:
            return b""
        self.due_s = max(self.due_s, now_s - self.period_s / 2.0) + self.period_s
        self.said_s = now_s
        return self._data
