"""The link to the arm as the desk sees it: the latest status, its loss and return, a pause."""

from __future__ import annotations

from collections.abc import Callable

from armdrive.status import State, Status
from tui.arm_port import DeskArm
from tui.keys.keyboard import Keyboard
from tui.panels import link_back, look_for_it


class ArmLink:
    """Holds the latest status. Once the link is lost, no key jogs and no question stays open."""

    def __init__(
        self,
        arm: DeskArm,
        keys: Keyboard,
        *,
        say: Callable[[str], None],
        disarm: Callable[[str], None],
        close_dialogs: Callable[[], None],
    ) -> None:
        self.status: Status = arm.status
        """The latest one."""
        self.paused_here = False
        """Whether this desk paused the arm, and not somebody outside."""
        self._arm = arm
        self._keys = keys
        self._say = say
        self._disarm = disarm
        self._close_dialogs = close_dialogs
        self._was_lost = False

    @property
    def lost(self) -> bool:
        """Whether there is no link to the arm."""
        return self.status.state is State.DISCONNECTED

    def says_lost(self) -> bool:
        """Return whether the link is lost, and if so say that no key reaches the arm."""
        if self.lost:
            how = look_for_it(self._keys)
            self._say(f"there is no link to the arm, and no key moves it: {how}")
        return self.lost

    def take(self, status: Status) -> None:
        """Take the latest status."""
        if self.status.paused and not status.paused:
            self.paused_here = False  # the next pause may be somebody else's
        self.status = status
        if self.lost:
            self._note_loss()
        elif self._was_lost:
            self._note_return()

    def switch_pause(self) -> None:
        """Pause the arm after its next burst, or let it go on."""
        self.paused_here = not self.status.paused
        (self._arm.pause if self.paused_here else self._arm.resume)()

    def _note_loss(self) -> None:
        """Let no key jog, and close the questions about an arm that is gone."""
        self._disarm("the link is lost")
        if not self._was_lost:
            self._was_lost = True
            self._say("")  # the last message was about a link that worked
            self._close_dialogs()

    def _note_return(self) -> None:
        """Say what the link came back to; in any other state the arm is still being asked."""
        if self.status.state in (State.ERROR_STOP, State.DISABLED):
            self._was_lost = False
            self._say(link_back(self.status, self._keys))
