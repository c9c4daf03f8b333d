"""The desk itself: it polls the arm's status, stops it, and gets a lost link back."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from armdrive.errors import ArmError
from armdrive.status import State
from tui import panels
from tui.arm_port import DeskArm
from tui.asking import AskingScreen
from tui.framework import on_ending_signals

POLL_S = 0.05
IDLE_DISARMS_S = 60.0
LEAVE_KEY = "q"
"""Leaves the desk once the link is lost; before that it is a jog key like the others."""
LEAVE_AFTER_QUIET_S = 1.0
"""So long the loss has been shown, and no jog key came.

One that is still held repeats within less. The repeats that a suspended desk finds when it wakes
come before anybody can have read of the loss.
"""

_SIGNAL_EXIT = 128  # a shell's way to say which signal ended a program


class Desk(AskingScreen):
    """One arm on one screen. Starts disarmed; every way out of it stops the arm."""

    def __init__(
        self,
        arm: DeskArm,
        *,
        braille: bool,
        clock: Callable[[], float] = time.monotonic,
        handle_signals: bool = False,
    ) -> None:
        super().__init__(arm, braille=braille, clock=clock)
        self._handle_signals = handle_signals
        self._jogged_s = -math.inf
        self._lost_s = -math.inf
        self._was_lost = False

    def on_mount(self) -> None:
        """Begin to watch the arm."""
        if self._handle_signals:
            on_ending_signals(self._end_by_signal)
        self.set_interval(POLL_S, self.poll)
        self.call_after_refresh(self.poll)

    def on_resize(self) -> None:
        """Fit the texts to the new width."""
        self.call_after_refresh(self.poll)

    def poll(self) -> None:
        """Take the latest status and show what changed."""
        self._status = self._arm.status
        if self._lost:
            self._note_loss()
        elif self._was_lost:
            self._note_return()
        elif self.armed and self._clock() - self._active_s >= IDLE_DISARMS_S:
            self._apply(self._deadman.disarm(f"no key for {IDLE_DISARMS_S:.0f} s"))
        self._show()

    # -- a lost link --------------------------------------------------------------------------

    def _note_loss(self) -> None:
        """Let no key jog, and take away what was asked of an arm that is gone."""
        self._apply(self._deadman.disarm("the link is lost"))
        if not self._was_lost:
            self._was_lost = True
            self._lost_s = self._clock()
            self._close_dialogs()

    def _note_return(self) -> None:
        """Say what a link that came back has ended in; before that it has not proved itself."""
        if self._status.state in (State.ERROR_STOP, State.DISABLED):
            self._was_lost = False
            self._message = panels.link_back(self._status)

    def action_reconnect(self) -> None:
        """Look for a lost link once, now. Moves nothing."""
        if self._lost:
            self._say("looking for the link ...")
        self._in_thread(self._arm.reconnect, None)

    def action_jog(self, key: str) -> None:
        """Hand a jog key to the dead-man; a lost link makes one of them leave."""
        now_s = self._clock()
        quiet_s, self._jogged_s = now_s - max(self._jogged_s, self._lost_s), now_s
        if not self._lost:
            super().action_jog(key)
        elif key == LEAVE_KEY and quiet_s >= LEAVE_AFTER_QUIET_S:
            self.action_leave()
        else:
            self._say(f"there is no link to the arm, and no key jogs it: {panels.LOOK_FOR_IT}")

    # -- stopping and ending ------------------------------------------------------------------

    def action_stop_arm(self) -> None:
        """Stop the arm before anything else, then disarm and show the desk."""
        self._arm.request_stop()
        self._apply(self._deadman.disarm("stopped"))
        self._message = "STOP was asked for; the keys are disarmed"
        self._close_dialogs()
        self._show()

    def action_estop(self) -> None:
        """Stop and latch the error state."""
        self._arm.estop()
        self._apply(self._deadman.disarm("emergency stop"))

    def action_reset(self) -> None:
        """Leave the error state."""
        if not self._nobody_there():
            self._in_thread(self._arm.reset, panels.after_reset)

    def action_leave(self) -> None:
        """Stop the arm and end the desk."""
        self._arm.request_stop()
        self.exit(0)

    def on_unmount(self) -> None:
        """Stop the arm, whatever it was that ended the desk."""
        self._arm.request_stop()

    def _end_by_signal(self, number: int) -> None:
        """Leave the arm standing and closed before the framework tidies up."""
        self._arm.request_stop()
        try:
            self._arm.close()
        except ArmError:
            self._arm.request_stop()  # it would not confirm that it stands; nobody is there to tell
        self.exit(_SIGNAL_EXIT + number, return_code=_SIGNAL_EXIT + number)
