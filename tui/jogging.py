"""Jogging at the desk: keys become jogs through the dead-man, at the settings on the screen."""

from __future__ import annotations

import time
from collections.abc import Callable

from textual import events

from armdrive.errors import ArmError
from armdrive.jog import Action, DeadMan, Disarm, Hold, Increment
from tui import panels
from tui.arm_port import DeskArm
from tui.base import ArmScreen
from tui.framework import Alarm
from tui.settings import Settings


class JoggingScreen(ArmScreen):
    """A screen with jog keys. They begin disarmed."""

    def __init__(
        self, arm: DeskArm, *, braille: bool, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(arm, braille=braille, clock=clock)
        self._deadman = DeadMan()
        self._alarm = Alarm(self, self.tick)
        self._active_s = clock()

    @property
    def armed(self) -> bool:
        """Whether jog keys have any effect."""
        return self._deadman.armed

    def action_jog(self, key: str) -> None:
        """Hand a jog key to the dead-man."""
        if self._settings.pair_of(key) is None:
            self._say(f"no axis of this arm is moved by the key {key}")
            return
        now_s = self._clock()
        if self.armed:
            self._active_s = now_s
        self._apply(self._deadman.press(key, now_s))

    def tick(self) -> None:
        """Let the dead-man's time pass."""
        self._apply(self._deadman.tick(self._clock()))

    def _apply(self, actions: tuple[Action, ...]) -> None:
        for action in actions:
            try:
                self._carry_out(action)
            except ArmError as error:
                self._say(str(error))
        self._alarm.after(self._deadman.next_s() - self._clock())

    def _carry_out(self, action: Action) -> None:
        speed = self._settings.speed
        if isinstance(action, Increment):
            self._arm.nudge(self._settings.increment_of(action.key), speed=speed)
        elif isinstance(action, Hold):
            for_s = action.until_s - self._clock()
            if for_s > 0:
                self._arm.hold(self._settings.direction_of(action.key), speed=speed, for_s=for_s)
        else:
            self._arm.release()
            if isinstance(action, Disarm):
                self._say(f"keys disarmed: {action.reason}")

    def action_arm_keys(self) -> None:
        """Let the jog keys have effect."""
        self._active_s = self._clock()
        if self._lost:
            self._say(f"there is no link to the arm: {panels.LOOK_FOR_IT}")
        elif self._deadman.arm(self._active_s):
            self._say("armed: tap a key for one increment, hold it to keep moving")
        else:
            self._say("keys are still arriving: let go of all keys, then press enter again")

    def on_app_blur(self) -> None:
        """Disarm when the terminal says that another window has the keyboard."""
        self._apply(self._deadman.disarm("the terminal lost the keyboard focus"))

    def on_paste(self, event: events.Paste) -> None:
        """Disarm on pasted text: it may be backlog that a multiplexer took for a paste."""
        event.stop()
        self._apply(self._deadman.disarm("text was pasted, and dropped"))

    def _set(self, settings: Settings) -> None:
        """Change settings. Whatever is held was meant with the old ones, so it ends."""
        self._apply(self._deadman.release_all(self._clock()))
        self._settings = settings
        self._show()

    def action_mode(self) -> None:
        """Switch between joint and Cartesian mode."""
        self._set(self._settings.other_mode())

    def action_frame(self) -> None:
        """Go on to the next frame in which the tip is jogged."""
        if not self._settings.cartesian:
            self._say("frames are for Cartesian mode: press m first")
            return
        self._set(self._settings.with_next_frame())

    def action_finer(self) -> None:
        """Make the increment smaller."""
        self._set(self._settings.with_increment(-1))

    def action_coarser(self) -> None:
        """Make the increment larger."""
        self._set(self._settings.with_increment(1))

    def action_slower(self) -> None:
        """Jog more slowly."""
        self._set(self._settings.with_speed(-1))

    def action_faster(self) -> None:
        """Jog faster."""
        self._set(self._settings.with_speed(1))
