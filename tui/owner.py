"""An app that owns an arm: its latest status, what is said, calls in threads, and questions."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import cast

from armdrive.errors import ArmError
from armdrive.render.side_view import ArmScene
from armdrive.status import Status
from kinematics import Joints, KinematicsError
from tui.arm_port import DeskArm
from tui.dialogs import STANDS_SO, PostureScreen
from tui.framework import FirstKeys
from tui.goal_form import Manner
from tui.keyboard import DEFAULT_KEYS, Keyboard
from tui.keys import jog_pairs, spoken
from tui.screens.base import DeskScreen
from tui.settings import Settings
from tui.views import scene_of
from tui.watch_words import at_work

Done = str | Callable[[Status], str] | None


class Owner(FirstKeys):
    """What a screen may use of the desk, but for the desk's own keys."""

    def __init__(
        self,
        arm: DeskArm,
        *,
        braille: bool,
        clock: Callable[[], float] = time.monotonic,
        keys: Keyboard = DEFAULT_KEYS,
    ) -> None:
        super().__init__()
        self.arm = arm
        self.braille = braille
        self.clock = clock
        self.keys = keys
        geometry = arm.model.arm
        pairs = jog_pairs(geometry.joint_names, has_yaw=geometry.has_yaw)
        self._joint_names = geometry.joint_names
        self.settings = Settings(pairs=pairs, frames=arm.frames)
        self.message = ""
        """What was said last; each screen has a hint of its own for when nothing was."""
        self.status: Status = arm.status
        self.manner = Manner()
        """How the move screen's goals are given and gone to."""
        self.goal: Joints | None = None
        """A posture that one screen has left for the move screen."""

    @property
    def place(self) -> DeskScreen:
        """The screen that the desk is at; dialogs may lie over it."""
        return cast("DeskScreen", self.screen_stack[0])

    @property
    def armed(self) -> bool:
        """Whether keys move the arm at once."""
        return self.place.armed

    @property
    def at_work(self) -> str:
        """The program or sequence that the arm is at work on, and how far it is, in few words."""
        program = self.arm.program
        return "" if program is None else at_work(program())

    def show(self) -> None:
        """Show the latest status on the current screen."""
        if self.is_running and self.screen_stack:  # else they are already being taken down
            self.place.show(self.status)

    def say(self, message: str) -> None:
        """Say something on whatever screen is shown."""
        self.message = message
        self.show()

    def spoken(self, text: str) -> str:
        """Return a text in the words of the desk, with the joints as people write them."""
        return spoken(self.keys.presented(text), self._joint_names)

    def scene(self) -> ArmScene | None:
        """Return what is to be drawn of the arm as it stands; None while that is not known."""
        joints = self.status.joints
        if joints is None:
            return None
        return scene_of(self.arm.model, joints, self.status.gripper_mm)

    def disarm(self, reason: str) -> None:
        """Let go of what the current screen holds, and let no key of it move the arm."""
        if self.screen_stack:  # else they are already being taken down
            self.place.disarm(reason)

    def call(self, call: Callable[[], object], done: Done) -> None:
        """Make a call that takes a moment, without keeping the stop key waiting.

        `done` is said when it has gone well, or what it says of the status then; without it the
        status speaks for itself.
        """
        self.run_worker(partial(self._called, call, done), thread=True, exit_on_error=False)

    def _called(self, call: Callable[[], object], done: Done) -> None:
        try:
            call()
            said = done(self.arm.status) if callable(done) else done
        except (ArmError, KinematicsError) as error:
            said = str(error)
        except Exception as flaw:  # said, not swallowed: the desk and its stop key live on
            said = f"a flaw of armdrive, please report it: {type(flaw).__name__}: {flaw}"
        if said is not None:
            self.call_from_thread(self.say, said)

    def ask(
        self,
        question: str,
        scene: ArmScene | None,
        agreed: Callable[[], object],
        done: Done = "confirmed: the position is referenced",
        *,
        asked: str = STANDS_SO,
    ) -> None:
        """Draw a posture with a question, and make the call if the answer to `asked` is yes."""
        self.disarm("a question is open")

        def answered(stands: bool | None) -> None:
            if stands:
                self.call(agreed, done)
            else:
                self.say("not confirmed: nothing was changed")

        self.push_screen(
            PostureScreen(
                self.spoken(question), scene, self.keys, braille=self.braille, asked=asked
            ),
            answered,
        )

    def close_dialogs(self) -> None:
        """Take away whatever lies over the current screen; no question in it is answered."""
        while len(self.screen_stack) > 1:
            self.pop_screen()
