"""What the screens have in common on which a planned motion is seen, confirmed twice and begun."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmError
from armdrive.render.scene import Moment
from armdrive.status import State, Status
from kinematics import KinematicsError
from tui import move_words
from tui.errand import Ask, Progress, Twice, begun, carried_out, foreseen
from tui.screens.base import DeskScreen
from tui.widgets.arm_view import SpaceView

if TYPE_CHECKING:
    from armdrive.motion.preview import Preview

Seen = tuple[Ask | None, Any, State, str]
"""What a preview was made of: it holds as long as none of it has changed."""


class ErrandScreen(DeskScreen):
    """Nothing here moves the arm but what was seen, and confirmed by two presses."""

    def __init__(self) -> None:
        super().__init__()
        self.confirming = Twice(self.desk.clock)
        self.preview: Preview | None = None
        """What the goal would lead to, as soon as that is worked out."""
        self._seen: Seen | None = None
        self._working = False
        self._progress: Progress | None = None

    def goal(self, status: Status) -> Ask | None:
        """Return what is asked for now; None where nothing is."""
        raise NotImplementedError

    def disarm(self, reason: str) -> None:  # noqa: ARG002 - as every screen
        """Take a first press back."""
        self.confirming.forget()

    def look_ahead(self, status: Status) -> Preview | None:
        """Work out what has changed, go where that was confirmed, and draw it.

        Return the preview, if it is that of the present goal and place.
        """
        self._foresee(status)
        if self.confirming.due():
            self._go()
        fresh = self.preview if self._fresh(status) else None
        shown = self.preview if self._progress is not None else fresh
        self.query_one(SpaceView).show(
            Moment(
                status.joints,
                status.gripper_mm,
                goal=shown.end if shown else None,
                goal_opening_mm=status.gripper_mm,
                planned=shown.path if shown else (),
            )
        )
        return fresh

    def going_text(self, status: Status, fresh: Preview | None) -> str:
        """Say how the motion is begun, confirmed or stopped."""
        if self._progress is not None:
            return move_words.progress_text(self._progress.seen(status.joints), self.desk.keys)
        if self.confirming.waiting:
            return move_words.again_text(self.desk.keys)
        return move_words.ready_text(fresh, self.desk.keys)

    # -- the preview --------------------------------------------------------------------------

    def _asked(self, status: Status) -> Seen:
        return self.goal(status), status.acknowledged, status.state, status.trust.value

    def _fresh(self, status: Status) -> bool:
        return self._seen == self._asked(status) and not self._working

    def _foresee(self, status: Status) -> None:
        """Have a preview worked out where something has changed, one at a time, not in motion."""
        asked = self._asked(status)
        if self._working or self._progress is not None or asked == self._seen:
            return
        if status.state in (State.MOVING, State.HOMING, State.STOPPING):
            return
        self.confirming.forget()
        if asked[0] is None:
            self._seen, self.preview = asked, None
            return
        self._working = True
        work = partial(self._work_out, asked)
        self.run_worker(work, thread=True, exit_on_error=False, group="preview")

    def _work_out(self, asked: Seen) -> None:
        ask, said = asked[0], ""
        preview: Preview | None = None
        try:
            if ask is not None:
                preview = foreseen(self.desk.arm, ask)
        except (ArmError, KinematicsError) as error:
            said = str(error)
        finally:
            self.app.call_from_thread(self._keep, asked, preview, said)

    def _keep(self, asked: Seen, preview: Preview | None, said: str) -> None:
        self._working, self._seen, self.preview = False, asked, preview
        if said:
            self.desk.message = said
        self.desk.show()

    # -- going --------------------------------------------------------------------------------

    def action_press_go(self) -> None:
        """Take one press of the two that move the arm."""
        desk = self.desk
        if desk.nobody_there():
            return
        if self._progress is not None:
            desk.say("the arm is on its way: space stops it")
        elif self.preview is None or not self._fresh(desk.status):
            self.confirming.forget()
            desk.say("there is nothing to confirm yet: choose a goal, and look at what it would be")
        elif self.preview.refusal is not None:
            self.confirming.forget()
            desk.say(str(self.preview.refusal))
        else:
            self.confirming.press()
            desk.show()

    def _go(self) -> None:
        """Move as it is shown, unless what is shown is no longer so."""
        preview, desk = self.preview, self.desk
        ask = self._seen[0] if self._seen is not None else None
        if preview is None or ask is None or not self._fresh(desk.status):
            desk.message = "something has changed meanwhile: look at it, and confirm again"
            return
        self._progress = Progress(preview)
        stops = desk.arm.stops
        desk.message = ""
        desk.call(partial(self._carry_out, ask, stops), move_words.arrived)

    def _carry_out(self, ask: Ask, stops: int) -> None:
        try:
            carried_out(self.desk.arm, partial(begun, self.desk.arm, ask), stops)
        finally:
            self._progress = None
