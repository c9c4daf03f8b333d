"""The link to the arm, and what keys ask of it on every screen: reference, motors, e-stop."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Protocol

from armdrive.errors import ArmError
from armdrive.moves import ParkMove
from armdrive.render.side_view import ArmScene
from armdrive.status import State, Status, Trust
from kinematics.errors import KinematicsError
from tui.arm_port import DeskArm, Done
from tui.arm_view import scene_of
from tui.conduct import after_reset, link_back, look_for_it
from tui.dialogs import STANDS_SO, Dialogs, PostureScreen
from tui.keys.keyboard import Keyboard


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
        self.paused_at = ""
        """The screen of this desk that paused the arm; empty if another program did."""
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
            self.paused_at = ""  # another program may make the next pause
        self.status = status
        if self.lost:
            self._note_loss()
        elif self._was_lost:
            self._note_return()

    def switch_pause(self, place: str) -> None:
        """Pause the arm after its next burst, or let it go on; `place` is the screen of the key."""
        self.paused_at = "" if self.status.paused else place
        (self._arm.pause if self.paused_at else self._arm.resume)()

    def _note_loss(self) -> None:
        """Let no key jog, and close the questions about an arm that is gone."""
        self._disarm("the link is lost")
        if not self._was_lost:
            self._was_lost = True
            self._say("")  # the last message was about a link that worked
            self._close_dialogs()

    def _note_return(self) -> None:
        """Say in which state the link came back; in other states the check still runs."""
        if self.status.state in (State.ERROR_STOP, State.DISABLED):
            self._was_lost = False
            self._say(link_back(self.status, self._keys))


class Calling(Protocol):
    """Makes calls that take a moment."""

    def __call__(self, call: Callable[[], object], done: Done) -> None:
        """Make the call in a thread, then say `done`."""


class ArmControl:
    """Makes these calls of the arm; those that move it or let it sag only after a question."""

    def __init__(
        self,
        arm: DeskArm,
        keys: Keyboard,
        link: ArmLink,
        dialogs: Dialogs,
        *,
        braille: bool,
        spoken: Callable[[str], str],
        say: Callable[[str], None],
        call: Calling,
        disarm: Callable[[str], None],
    ) -> None:
        """`spoken` puts a sentence into the words of the desk."""
        self._arm = arm
        self._keys = keys
        self._link = link
        self._dialogs = dialogs
        self._braille = braille
        self._spoken = spoken
        self._say = say
        self._call = call
        self._disarm = disarm

    def estop(self) -> None:
        """Stop and latch the error state."""
        self._arm.estop()
        self._disarm("emergency stop")

    def reset(self) -> None:
        """Leave the error state."""
        if not self._link.says_lost():
            self._call(self._arm.reset, partial(after_reset, keys=self._keys))

    def reconnect(self) -> None:
        """Look for a lost link once, now. Moves nothing."""
        if self._link.lost:
            self._say("looking for the link ...")
        self._call(self._arm.reconnect, None)

    def reference(self) -> None:
        """Ask whether the arm stands in its reference posture; a simulated one is brought there."""
        if self._link.says_lost():
            return
        arm = self._arm
        if arm.referencing.homes_by_switches:
            text = "THE ARM WILL MOVE: its controller seeks its switches."
            done = "homed by its own switches"
            self._ask(text, self._scene(), arm.home, done, asked="Is its way clear?")
            return
        if self._link.status.simulated:
            self._disarm("the simulated operator is at work")
            self._say("the simulated operator brings the arm to its reference posture ...")
            self._call(arm.home, "the simulated operator referenced the arm")
            return
        try:
            request = arm.reference_request()
        except (ArmError, KinematicsError) as error:
            self._say(str(error))
            return
        scene = scene_of(arm.model, request.joints, request.opening_mm)
        self._ask(str(request), scene, arm.confirm_reference)

    def confirm(self) -> None:
        """Ask whether the arm stands where the last program left it."""
        status = self._link.status
        if self._link.says_lost():
            return
        if status.trust is not Trust.RESTORED or status.joints is None:
            self._say(f"nothing to confirm: the position is {status.trust.value}")
            return
        text = f"Remembered ({status.trust_reason}): {status.joints}"
        self._ask(text, self._scene(), self._arm.confirm_restored)

    def park(self, speed: float) -> None:
        """Draw the park posture, and go there if the answer is yes."""
        if self._link.says_lost():
            return
        arm, move = self._arm, ParkMove(speed)
        try:
            preview = arm.preview(move)
        except (ArmError, KinematicsError) as error:
            self._say(str(error))
            return
        if preview.refusal is not None or preview.end is None:
            self._say(str(preview.refusal))
            return
        scene = scene_of(arm.model, preview.end, self._link.status.gripper_mm)
        text = f"THE ARM WILL MOVE to its park posture, drawn here, at {speed:.0%} of its speed."
        stops = arm.stops
        self._ask(
            text,
            scene,
            lambda: arm.start(move, stops=stops).wait(),
            "parked",
            asked="Is its way clear?",
        )

    def switch_motors(self) -> None:
        """Switch the motor current on; off only after a question, since the arm sags then."""
        if self._link.says_lost():
            return
        if self._link.status.state is State.DISABLED:
            self._call(self._arm.enable, "the motors are on: nothing was moved")
            return
        text = "The motors are switched off: THE ARM SAGS, and its position is lost."
        done = "the motors are off"
        self._ask(text, self._scene(), self._arm.disable, done, asked="Is it supported?")

    def _scene(self) -> ArmScene | None:
        """Return a drawing of the present posture; None while it is unknown."""
        status = self._link.status
        if status.joints is None:
            return None
        return scene_of(self._arm.model, status.joints, status.gripper_mm)

    def _ask(
        self,
        question: str,
        scene: ArmScene | None,
        agreed: Callable[[], object],
        done: Done = "confirmed: the position is referenced",
        *,
        asked: str = STANDS_SO,
    ) -> None:
        """Draw a posture with a question, and make the call if the answer to `asked` is yes."""

        def answered(yes: bool | None) -> None:
            if yes:
                self._call(agreed, done)
            else:
                self._say("not confirmed: nothing was changed")

        text = self._spoken(question)
        dialog = PostureScreen(text, scene, self._keys, braille=self._braille, asked=asked)
        self._dialogs.open(dialog, "a question is open", answered)
