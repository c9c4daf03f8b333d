"""The timer of what is held: it is moved, and where it is late takes in first what came before."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from textual.timer import Timer

    from tui.framework import FirstKeys

BUSY_S = 0.02
"""A timer that is so much later than it should be found the app busy."""

SETTLE_S = 0.03
"""What came while the app was busy has gone through its queues after this."""


class Alarm:
    """One timer that is moved to another time instead of being joined by a second one.

    Where the app was too busy to ring in time, what came meanwhile is taken in before it rings.
    """

    def __init__(self, app: FirstKeys, call: Callable[[], None]) -> None:
        self._app = app
        self._call = call
        self._timer: Timer | None = None
        self._due_s = math.inf

    def after(self, delay_s: float) -> None:
        """Ring once after this delay; infinite means never."""
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if delay_s != math.inf:
            delay_s = max(delay_s, 0.001)
            self._due_s = time.monotonic() + delay_s
            self._timer = self._app.set_timer(delay_s, self._ring)

    def _ring(self) -> None:
        self._app.alive()  # what was held when this program was suspended is held no more
        if time.monotonic() - self._due_s > BUSY_S:
            self.after(SETTLE_S)
        else:
            self._call()
