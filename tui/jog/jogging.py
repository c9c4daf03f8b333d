"""Jogging at the desk: keys become jogs through the dead-man, at the settings of the moment.

The mouse reports when a button is released, but a link that has stalled reports nothing. So what it
holds ends a while after its last event.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from armdrive import Arm
from armdrive.errors import ArmError
from armdrive.motion.dead_man import (
    HOLD_LONGEST_S,
    REPEAT_WITHIN_S,
    Action,
    DeadMan,
    Disarm,
    HeldKey,
    Increment,
)
from armdrive.moves import Jog
from tui.app import PASTED, HoldAlarm
from tui.settings import JogSettings

# Why keys disarm after a stop, whichever program asked for it.
STOPPED = "the arm was stopped"

NOT_ARMED = "jog keys move nothing before they are armed"

# Jog keys disarm after this time without one: the operator may have gone away.
IDLE_DISARMS_S = 60.0

# A hold ends this long after the last event of its mouse, also a small one.
#
# A hand on a mouse is hardly ever still for this long, and a link that has stalled reports no
# release.
MOUSE_HOLDS_S = 2.0

# Interval at which the mouse renews its hold: less than half of `HOLD_LONGEST_S`, after which the
# arm ends it by itself, so that one late renewal interrupts nothing.
MOUSE_RENEWS_S = 0.1


class DeskJogging:
    """Turns jog keys and buttons into jogs. The keys start disarmed. Knows no screen."""

    def __init__(
        self,
        arm: Arm,
        *,
        clock: Callable[[], float],
        say: Callable[[str], None],
        settings: JogSettings,
        age_s: Callable[[], float] = lambda: 0.0,
    ) -> None:
        """`age_s` returns the age of the key that is being handled."""
        self._arm = arm
        self._clock = clock
        self._say = say
        self.settings = settings
        self._age_s = age_s
        self._deadman = DeadMan()
        self._active_s = clock()
        self.held_button = ""
        """The jog key whose on-screen button is held; empty if nothing is held."""
        self._last_event_s = self._press_s = -math.inf
        self._renew_s = math.inf
        self._stops = arm.stops
        """The number of stops when the keys were armed."""
        self.alarm: HoldAlarm | None = None
        """Calls `tick` when something that is held has to be renewed or to end."""

    @property
    def armed(self) -> bool:
        """Whether jog keys have any effect."""
        return self._deadman.armed

    def next_s(self) -> float:
        """Return when `tick` has something to do; infinite while nothing is held."""
        return min(self._deadman.next_s(), self._renew_s)

    def press(self, key: str) -> None:
        """Hand a jog key to the dead-man."""
        if self.settings.pair_of(key) is None:
            self._say(f"this arm has no axis for the key {key}")
            return
        came_s = self._clock() - self._age_s()
        held, self._press_s = came_s - self._press_s < REPEAT_WITHIN_S, came_s
        if not self.armed and not held:  # repeats leave the reason why the keys were disarmed
            self._say(NOT_ARMED)
        if self.armed:
            self._active_s = came_s
        self.lift()
        self._apply(self._deadman.press(key, came_s))

    def key_up(self, key: str) -> None:
        """Take the release of a jog key, where the terminal reports it: what it holds ends now."""
        self._apply(self._deadman.key_up(key, self._clock()))

    def tick(self) -> None:
        """Let the dead-man's time pass, and the mouse's."""
        if self.held_button and self._clock() >= self._renew_s:
            self._renew()
        self._apply(self._deadman.tick(self._clock()))

    # -- on-screen buttons ----------------------------------------------------------------------

    def push(self, key: str) -> None:
        """Hold the on-screen button of a jog key until `lift`, or until the mouse is silent."""
        if not self.armed:
            self._say(NOT_ARMED)
            return
        self.release()
        self.held_button = key
        self.moved()
        self._renew()
        self._apply(())  # nothing of the dead-man's, but the alarm has to ring for this hold

    def moved(self) -> None:
        """Note an event of the mouse while it holds a button."""
        self._last_event_s = self._active_s = self._clock()

    def lift(self) -> None:
        """Let go of the button."""
        if self.held_button:
            self.held_button, self._renew_s = "", math.inf
            self._tell(self._arm.jogging.release)
            self._apply(())

    def _renew(self) -> None:
        now_s = self._clock()
        left_s = self._last_event_s + MOUSE_HOLDS_S - now_s
        if left_s <= 0.0:
            self.lift()
            self._say(f"jog ended: the mouse sent nothing for {MOUSE_HOLDS_S:.0f} s")
            return
        if self._was_stopped():
            return
        jog = self.settings.direction_of(self.held_button)
        self._renew_s = now_s + MOUSE_RENEWS_S
        # the last hold ends with the time that a silent mouse has, not a renewal after it
        self._tell(partial(self._hold, jog, min(HOLD_LONGEST_S, left_s)))

    # -- arming -------------------------------------------------------------------------------

    def arm_keys(self) -> bool:
        """Arm the jog keys; refused while keys are still arriving."""
        self._active_s, self._stops = self._clock(), self._arm.stops
        return self._deadman.arm(self._active_s)

    def _was_stopped(self) -> bool:
        """Disarm if there was a stop since the keys were armed, by any program; return whether.

        The desk sees a stop at its next poll, and a key that is held may repeat before that.
        """
        stopped = self._arm.stops != self._stops
        if stopped:
            self.disarm(STOPPED)
        return stopped

    def disarm(self, reason: str) -> None:
        """End what is held, and let no key have effect."""
        if self.armed or reason == PASTED:
            self._press_s = self._clock()  # the keys that follow may be those that it is about
        self.lift()
        self._apply(self._deadman.disarm(reason))

    def release(self) -> None:
        """End a held jog: it was begun with other settings."""
        self.lift()
        self._apply(self._deadman.release_all())

    def disarm_idle(self) -> None:
        """Disarm keys that have not been used for a while."""
        if self.armed and self._clock() - self._active_s >= IDLE_DISARMS_S:
            self.disarm(f"no key for {IDLE_DISARMS_S:.0f} s")

    def _apply(self, actions: tuple[Action, ...]) -> None:
        for action in actions:
            self._tell(partial(self.carry_out, action))
        if self.alarm is not None:
            self.alarm.after(self.next_s() - self._clock())

    def _tell(self, call: Callable[[], None]) -> None:
        try:
            call()
        except ArmError as error:
            self._say(str(error))

    def carry_out(self, action: Action) -> None:
        """Make the arm follow the dead-man switch."""
        settings = self.settings
        if isinstance(action, Increment | HeldKey) and self._was_stopped():
            return
        if isinstance(action, Increment):
            self._arm.jogging.nudge(settings.increment_of(action.key), speed=settings.speed)
        elif isinstance(action, HeldKey):
            for_s = action.until_s - self._clock()
            if for_s > 0:  # a busy desk may come too late to hold at all
                self._hold(settings.direction_of(action.key), for_s)
        else:
            self._arm.jogging.release()
            if isinstance(action, Disarm):
                self._say(f"keys disarmed: {action.reason}")

    def _hold(self, jog: Jog, for_s: float) -> None:
        self._arm.jogging.hold(jog, speed=self.settings.speed, for_s=for_s)
