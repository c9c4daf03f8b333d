"""Pause and speed override of one arm.

Any thread may set them; tasks check them before each burst or segment. A stop, an error and a lost
link end a pause together with the motion that waits in it. After too long a pause the motion is
given up; the arm stays paused.
"""

from __future__ import annotations

import time

from armdrive.errors import BadRequest, WrongState
from kinematics.errors import finite

# The bounds of a speed override, as a share of the requested speed.
LEAST_OVERRIDE, FULL = 0.01, 1.0

# On simulated time, a paused arm waits in real time so that another thread can resume it: up to
# 5 s in short naps. Then simulated time runs on.
NAP_S = 0.005
NAPS = 1000  # 5 s in all

LONGEST_PAUSE_S = 8 * 3600.0  # a working shift: no operator expects a motion after that
LONGEST_SIMULATED_WAIT_S = 600.0  # limit on simulated time if only the caller could end a wait

GIVEN_UP = (
    "the arm has been paused for {:.0f} s, so this call was cancelled. The arm is still paused: "
    "call `resume()`, or run `armdrive resume` in another terminal, then repeat it"
)


def given_up(waited_s: float) -> WrongState:
    """Return the error of a call that was cancelled after waiting in a pause."""
    return WrongState(GIVEN_UP.format(waited_s))


class SpeedOverride:
    """The pause and the speed override of one arm."""

    def __init__(self) -> None:
        self.paused = False
        self.override = FULL
        self.was_slowed = False
        """Whether any part of the current motion may have been sent slower than planned."""
        self.waits = False
        """Whether a motion is waiting in the pause."""
        self.others = False
        """Whether another program or thread can resume the arm."""
        self._naps_left = NAPS

    @property
    def longest_s(self) -> float:
        """How long, on the arm's clock, a motion or a call waits for the end of a pause."""
        return LONGEST_PAUSE_S if self.others else LONGEST_SIMULATED_WAIT_S

    @property
    def longest_real_s(self) -> float:
        """How long, in real time, a paused arm waits while no simulated time passes."""
        return LONGEST_PAUSE_S if self.others else NAPS * NAP_S

    def is_paused(self) -> bool:
        """Return whether the arm is paused, as a condition for a device."""
        return self.paused

    def pause(self) -> None:
        """Make motions wait after their current burst or segment."""
        self._naps_left = NAPS
        self.paused = True

    def end_pause(self) -> None:
        """Let a waiting motion continue, unless it has been ended."""
        self.paused = False

    def set_override(self, share: float) -> None:
        """Slow the motion sent from now on to a share of its speed. Raises `BadRequest`."""
        self.override = override_share(share)
        self.was_slowed = self.was_slowed or self.override < FULL

    def begin(self) -> None:
        """Start a motion: nothing of it has been sent yet."""
        self.was_slowed = self.override < FULL

    def slowed_s(self, duration_s: float) -> float:
        """Return the duration under the override, given the duration at full speed."""
        return duration_s / self.override

    def breathe(self) -> None:
        """Let real time pass in a pause on simulated time: another thread may end the pause."""
        if self.others or self._naps_left > 0:
            self._naps_left -= 1
            time.sleep(NAP_S)


def override_share(share: float) -> float:
    """Return a valid speed override: a share of the requested speed, 0.01 to 1.

    Raises `BadRequest` for any other number.
    """
    value = finite("the speed override", share)
    if not LEAST_OVERRIDE <= value <= FULL:
        raise BadRequest(
            f"the speed override is a share of the speed from {LEAST_OVERRIDE:g} to {FULL:g} "
            f"(1 to 100 percent), not {share!r}"
        )
    return value
