"""Whether somebody has paused the arm, and how fast it may go of what was asked.

Any thread may ask; the tasks look before each burst or segment. A stop, an error and a lost wire
end a pause together with the motion that waited in it. A motion that has waited too long is given
up, and the pause stays.
"""

from __future__ import annotations

import time

from armdrive.errors import BadRequest, WrongState
from kinematics.errors import finite

SLOWEST = 0.01
FULL = 1.0

DOUBT = 4.0
"""A slowed motion is waited for so many times longer than it should be slower."""

BREATH_S = 0.005
"""On simulated time a paused arm waits in real time, for somebody who lives in it."""

BREATHS = 1000
"""Some 5 s for another thread of this program to resume it. After that, simulated time runs on."""

LONGEST_PAUSE_S = 8 * 3600.0
"""A motion waits in a pause for a shift, and is given up then: nobody expects it any more."""

LONGEST_SIMULATED_PAUSE_S = 600.0
"""A call on simulated time waits no longer for a pause that only its own program can end."""

GIVEN_UP = (
    "the arm has been paused for {:.0f} s, so the motion was given up. The arm is still paused: "
    "call `resume()`, or run `armdrive resume` in another terminal, then ask for the motion again"
)


def given_up(waited_s: float) -> WrongState:
    """Return the error of what has waited in a pause for so long."""
    return WrongState(GIVEN_UP.format(waited_s))


class SpeedOverride:
    """What was asked of one arm by whoever watches it, and what that has cost in time."""

    def __init__(self) -> None:
        self.paused = False
        self.override = FULL
        self.was_slowed = False
        """Whether anything of the motion under way may have been sent slower than planned."""
        self.waits = False
        self.delay_s = 0.0
        self.waited_s = 0.0
        """How long motions have waited in pauses: a part of the delay."""
        self.given_up = False
        """Whether the motion that waits in the pause is given up; the pause stays."""
        self.others = False
        """Whether somebody else can resume the arm: in real time, or from another terminal."""
        self._breaths_left = BREATHS

    @property
    def longest_real_s(self) -> float:
        """How long somebody is waited for in real time, where no simulated time passes."""
        return LONGEST_PAUSE_S if self.others else BREATHS * BREATH_S

    def pause(self) -> None:
        """Have the motion under way wait behind its next burst or segment, and the next ones."""
        self._breaths_left = BREATHS
        self.paused = True

    def end_pause(self) -> None:
        """Let a waiting motion go on, where it has not been ended meanwhile."""
        self.paused = False

    def set_override(self, share: float) -> None:
        """Have what is sent next take 1/share of its time. Raises `BadRequest`."""
        self.override = override_share(share)
        self.was_slowed = self.was_slowed or self.override < FULL

    def begin(self) -> None:
        """Hear that a motion begins, of which nothing has been sent yet."""
        self.was_slowed = self.override < FULL

    def slowed_s(self, duration_s: float) -> float:
        """Return how long something takes now that should take so long at full speed."""
        return duration_s / self.override

    def note_slowed(self, nominal_s: float) -> None:
        """Note that something is sent now that should take so long at full speed."""
        self.delay_s += DOUBT * (self.slowed_s(nominal_s) - nominal_s)

    def note_waited(self, time_s: float) -> None:
        """Note how long a motion has waited in a pause."""
        self.delay_s += time_s
        self.waited_s += time_s

    def breathe(self, waited_s: float) -> None:
        """Let real time pass while a call waits in a pause on simulated time.

        `waited_s` is how much of that it has waited: where nobody else could end the pause, its
        motion is given up at last.
        """
        if not self.waits:
            return
        if self.others or self._breaths_left > 0:
            self._breaths_left -= 1
            time.sleep(BREATH_S)
        if waited_s >= LONGEST_SIMULATED_PAUSE_S and not self.others:
            self.given_up = True


def override_share(share: float) -> float:
    """Check a speed override: a share of the speed asked for, from 0.01 to 1."""
    value = finite("the speed override", share)
    if not SLOWEST <= value <= FULL:
        raise BadRequest(
            f"the speed override is a share of the speed from {SLOWEST:g} to {FULL:g} (1 to 100 "
            f"percent), not {share!r}"
        )
    return value
