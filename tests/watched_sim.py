"""A simulated arm in a process of its own, timed by its own clock.

A busy computer lets a test look late, and lets a program act late; neither changes when the
simulated arm did what it did. So bounds are held against the device's clock: from the moment by
which it has heard all that a program said to the moment at which it was last seen to move.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from waiting import looks, until

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from sim_process import SimProcess

QUIET_S = 0.3
"""An arm that was not seen to move for this long, on its own clock, stands."""

Look = Callable[[], tuple[float, dict[str, Any]]]
"""Returns the time on the device's clock, and its physical state then."""


class Watch:
    """What is seen of a simulated arm, and when it was so on the arm's own clock."""

    def __init__(self, look: Look) -> None:
        self._look = look

    @property
    def motors(self) -> list[int]:
        """Where the motors are now, physically."""
        return list(self._look()[1]["motors"])

    def wait_until_moving(self) -> None:
        """Wait until a motor turns."""
        until(lambda: self._look()[1]["moving"], "the simulated arm never began to move")

    def moves_by(self, steps: int) -> None:
        """Wait until a motor has turned by so many steps from where it is now."""
        start = self.motors
        until(
            lambda: max(abs(a - b) for a, b in zip(self.motors, start, strict=True)) >= steps,
            f"no motor turned by {steps} steps",
        )

    def heard_all_s(self) -> float:
        """Return a time by which the device has heard all that was written before this call.

        It may answer the first question before it reads what waits at its port, but reads that
        before it answers the second one.
        """
        self._look()
        return self._look()[0]

    def passes(self, time_s: float) -> None:
        """Wait until so much time has passed on the device's clock."""
        end_s = self._look()[0] + time_s
        until(lambda: self._look()[0] >= end_s, "the simulated arm's time stands still")

    def last_moved_s(self) -> float:
        """Wait until the arm stands; return when it was last seen away from there.

        It cannot have come to rest before that time, however late this process looks.
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
        """Wait until the arm stands; return where."""
        self.last_moved_s()
        return self.motors

    def stands_within(self, bound_s: float) -> None:
        """Check how long the arm moves on once it has heard the last of a program."""
        heard_s = self.heard_all_s()
        went_on_s = self.last_moved_s() - heard_s
        assert went_on_s <= bound_s, f"it moved on for {went_on_s:.3f} s, not {bound_s:.3f} s"


class WatchedSim(SimProcess):
    """`armdrive sim` as `SimProcess` runs it, watched by the device's own clock."""

    @property
    def watch(self) -> Watch:
        """What is seen of the arm."""
        return Watch(self.look)
