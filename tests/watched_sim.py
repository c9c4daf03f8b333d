"""A simulated arm in another thread or process, timed by its own clock.

On a busy computer a test looks late, and a program acts late. So bounds are checked by the clock of
the simulated device: from the moment by which it has received all that the program sent, to the
moment at which it was last seen to move.
"""

import math
from collections.abc import Callable
from typing import Any

from waiting import looks, until

QUIET_S = 0.3
"""An arm stands if it has not moved for this long, by its own clock."""

Look = Callable[[], tuple[float, dict[str, Any]]]
"""Returns the time on the device's clock, and its physical state then."""


class Watch:
    """Observes a simulated arm, with the times of the arm's own clock."""

    def __init__(self, look: Look) -> None:
        self._look = look

    @property
    def motors(self) -> list[int]:
        """Where the physical motors stand now."""
        return list(self._look()[1]["motors"])

    def wait_until_moving(self) -> None:
        """Wait until a motor turns."""
        until(lambda: self._look()[1]["moving"], "the simulated arm never began to move")

    def moves_by(self, steps: int) -> None:
        """Wait until a motor has turned by some steps from where it is now."""
        start = self.motors
        until(
            lambda: max(abs(a - b) for a, b in zip(self.motors, start, strict=True)) >= steps,
            f"no motor turned by {steps} steps",
        )

    def heard_all_s(self) -> float:
        """Return a time by which the device has received all that was written before this call.

        The device may answer the first query before it reads its port, but reads it before it
        answers the second one.
        """
        self._look()
        return self._look()[0]

    def passes(self, time_s: float) -> None:
        """Wait until some time has passed on the device's clock."""
        end_s = self._look()[0] + time_s
        until(lambda: self._look()[0] >= end_s, "the simulated arm's time stands still")

    def last_moved_s(self) -> float:
        """Wait until the arm stands; return when it was last seen somewhere else.

        The arm came to rest after that time, however late this process looks.
        """
        moved_s, (before_s, before) = -math.inf, self._look()
        still_s = before_s
        for _ in looks("the simulated arm never came to rest"):
            now_s, now = self._look()
            if now["motors"] != before["motors"]:
                moved_s, still_s = before_s, now_s
            elif now["moving"]:
                still_s = now_s
            elif now_s >= still_s + QUIET_S:
                break
            before_s, before = now_s, now
        return moved_s

    def rest(self) -> list[int]:
        """Wait until the arm stands; return where its motors are."""
        self.last_moved_s()
        return self.motors

    def stands_within(self, bound_s: float) -> None:
        """Check how long the arm moves on after it has received all that a program sent."""
        heard_s = self.heard_all_s()
        went_on_s = self.last_moved_s() - heard_s
        assert went_on_s <= bound_s, f"it moved on for {went_on_s:.3f} s, not {bound_s:.3f} s"
