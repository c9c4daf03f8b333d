"""What the desk asks a person before it is done: references, confirmed postures, the motors."""

from __future__ import annotations

from collections.abc import Callable

from armdrive.draw.armview import ArmScene
from armdrive.errors import ArmError
from armdrive.status import State, Trust
from kinematics import KinematicsError
from tui import panels
from tui.dialogs import HelpScreen, PostureScreen
from tui.jogging import JoggingScreen
from tui.views import scene_of


class AskingScreen(JoggingScreen):
    """A screen with dialogs over it; whatever they lead to is done in a thread."""

    def action_help(self) -> None:
        """Show all keys."""
        self._apply(self._deadman.release_all(self._clock()))
        self.push_screen(HelpScreen(self._settings.pairs))

    def action_reference(self) -> None:
        """Ask whether the arm stands in its reference posture; a simulated one is brought there."""
        if self._nobody_there():
            return
        if self._arm.homes_by_switches:
            text = "THE ARM WILL MOVE: its controller seeks its switches. Is its way clear?"
            self._ask(text, self._scene(), self._arm.home, "homed by its own switches")
            return
        if self._status.simulated:
            self._apply(self._deadman.disarm("the simulated operator is at work"))
            self._in_thread(self._arm.home, "the simulated operator referenced the arm")
            return
        try:
            request = self._arm.reference_request()
        except (ArmError, KinematicsError) as error:
            self._say(str(error))
            return
        scene = scene_of(self._arm.model, request.joints, request.opening_mm)
        self._ask(str(request), scene, self._arm.confirm_reference)

    def action_confirm(self) -> None:
        """Ask whether the arm stands where it is remembered to."""
        status = self._status
        if self._nobody_there():
            return
        if status.trust is not Trust.RESTORED or status.joints is None:
            self._say(f"nothing to confirm: the position is {status.trust.value}")
            return
        scene = scene_of(self._arm.model, status.joints, status.gripper_mm)
        text = f"Remembered ({status.trust_reason}): {status.joints}"
        self._ask(text, scene, self._arm.confirm_restored)

    def action_motors(self) -> None:
        """Switch the motor current on; off only after a question, since the arm sags then."""
        if self._nobody_there():
            return
        if self._status.state is State.DISABLED:
            self._in_thread(self._arm.enable, "the motors are on: nothing was moved")
            return
        text = "Switch the motors off? THE ARM SAGS, and its position is lost. Is it supported?"
        self._ask(text, self._scene(), self._arm.disable, "the motors are off")

    def _nobody_there(self) -> bool:
        """Say so where there is no link to an arm of which something could be asked."""
        if self._lost:
            self._say(f"there is no link to the arm: {panels.LOOK_FOR_IT}")
        return self._lost

    def _ask(
        self,
        description: str,
        scene: ArmScene | None,
        agreed: Callable[[], object],
        done: str = "confirmed: the position is referenced",
    ) -> None:
        """Draw a posture with a question, and make the call if the answer is yes."""
        self._apply(self._deadman.disarm("a question is open"))

        def answered(stands: bool | None) -> None:
            if stands:
                self._in_thread(agreed, done)
            else:
                self._say("not confirmed: nothing was changed")

        self.push_screen(PostureScreen(description, scene, braille=self._braille), answered)

    def _close_dialogs(self) -> None:
        while len(self.screen_stack) > 1:
            self.pop_screen()
