"""What befalls an arm while the desk is at it: its link is lost and comes back, it is paused."""

from __future__ import annotations

import time
from collections.abc import Callable

from armdrive.status import State, Status
from tui import panels
from tui.arm_port import DeskArm
from tui.keyboard import DEFAULT_KEYS, Keyboard
from tui.owner import Owner


class LinkedOwner(Owner):
    """Takes each status, and says what has changed that no key did."""

    def __init__(
        self,
        arm: DeskArm,
        *,
        braille: bool,
        clock: Callable[[], float] = time.monotonic,
        keys: Keyboard = DEFAULT_KEYS,
    ) -> None:
        super().__init__(arm, braille=braille, clock=clock, keys=keys)
        self._was_lost = False
        self.paused_here = False
        """Whether the arm waits because of this desk, and not of somebody outside."""

    def take(self, status: Status) -> None:
        """Take the latest status."""
        if self.status.paused and not status.paused:
            self.paused_here = False  # the next pause may be somebody else's
        self.status = status
        if self.lost:
            self._note_loss()
        elif self._was_lost:
            self._note_return()

    def pause_or_go_on(self) -> None:
        """Hold the arm up behind its next burst, or let it go on."""
        self.paused_here = not self.status.paused
        (self.arm.pause if self.paused_here else self.arm.resume)()

    @property
    def lost(self) -> bool:
        """Whether there is no link to the arm."""
        return self.status.state is State.DISCONNECTED

    def nobody_there(self) -> bool:
        """Say so where there is no link to an arm of which something could be asked."""
        if self.lost:
            self.say(
                f"there is no link to the arm, and no key moves it: {panels.look_for_it(self.keys)}"
            )
        return self.lost

    def _note_loss(self) -> None:
        """Let no key jog, and take away what was asked of an arm that is gone."""
        self.disarm("the link is lost")
        if not self._was_lost:
            self._was_lost = True
            self.message = ""  # what was said of a link that there was is of no use now
            self.close_dialogs()

    def _note_return(self) -> None:
        """Say what a link that came back has ended in; before that it has not proved itself."""
        if self.status.state in (State.ERROR_STOP, State.DISABLED):
            self._was_lost = False
            self.message = panels.link_back(self.status, self.keys)

    def action_reconnect(self) -> None:
        """Look for a lost link once, now. Moves nothing."""
        if self.lost:
            self.say("looking for the link ...")
        self.call(self.arm.reconnect, None)
