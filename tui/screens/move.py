"""The move screen: type a goal, see the motion before it begins, and confirm it."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll

from armdrive.draw.scene import Moment
from armdrive.errors import ArmError
from armdrive.status import State, Status
from kinematics import KinematicsError
from tui import move_words
from tui.errand import Progress, carried_out
from tui.framework import PlainText
from tui.goal_form import Ask
from tui.layout import bindings
from tui.screens.move_form import FormKeys
from tui.widgets.arm_view import SpaceView

if TYPE_CHECKING:
    from armdrive.flows.motion import Moved
    from armdrive.handle import Handle
    from armdrive.preview import Preview
    from tui.arm_port import DeskArm

Seen = tuple[Ask | None, Any, State, str]
"""What a preview was made of: it holds as long as none of it has changed."""


class MoveScreen(FormKeys):
    """Nothing here moves the arm but a goal that was seen, and confirmed by two presses."""

    place = "move"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)
    CSS = """
    #move-panel { width: 1fr; min-width: 42; padding: 0 0 0 1; scrollbar-size: 0 0; }
    #goal, #foreseen, #going { height: auto; }
    #going { text-style: bold; }
    .-wide #foreseen, .-wide #going { margin: 1 0 0 0; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._seen: Seen | None = None
        self._working = False
        self._progress: Progress | None = None

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: the arm with its ghost on the left, the goal on the right."""
        desk = self.desk
        with Horizontal():
            yield SpaceView(desk.arm.model, braille=desk.braille, id="space", clock=desk.clock)
            with VerticalScroll(id="move-panel", can_focus=False):
                for name in ("goal", "foreseen", "going"):
                    yield PlainText(id=name)

    def disarm(self, reason: str) -> None:  # noqa: ARG002 - as every screen
        """Take a first press back."""
        self.confirming.forget()

    # -- what is shown ------------------------------------------------------------------------

    def show_body(self, status: Status) -> None:
        """Show the goal, and what its motion would be as soon as that is worked out."""
        self._foresee(status)
        if self.confirming.due():
            self._go()
        present = self.present(status)
        fresh = self.preview if self._fresh(status) else None
        self.text("goal").show(move_words.form_text(self.form, present, self.desk.keys))
        self.text("foreseen").show(self._foreseen_text(fresh))
        self.text("going").show(self._going_text(status, fresh))
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

    def _foreseen_text(self, fresh: Preview | None) -> str:
        if self._progress is not None:
            return ""
        if wrong := self.form.wrong():
            return wrong
        if fresh is not None:
            return move_words.preview_text(fresh, self.desk.keys)
        return "working it out ..." if self._working else move_words.NOTHING_ASKED

    def _going_text(self, status: Status, fresh: Preview | None) -> str:
        if self._progress is not None:
            return move_words.progress_text(self._progress.seen(status.joints), self.desk.keys)
        if self.confirming.waiting:
            return move_words.again_text(self.desk.keys)
        return move_words.ready_text(fresh, self.desk.keys)

    # -- the preview --------------------------------------------------------------------------

    def _asked(self, status: Status) -> Seen:
        ask = self.form.ask(self.present(status))
        return ask, status.acknowledged, status.state, status.trust.value

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
            desk.say("there is nothing to confirm yet: type a goal, and look at what it would be")
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


def foreseen(arm: DeskArm, ask: Ask) -> Preview:
    """Return what a goal's motion would be."""
    if ask.pose is None:
        named: dict[str, Any] = dict(ask.joints_deg)
        return arm.preview(speed=ask.speed, **named)
    return arm.preview(ask.pose, line=ask.line, frame=ask.frame, speed=ask.speed)


def begun(arm: DeskArm, ask: Ask) -> Handle[Moved]:
    """Begin a goal's motion."""
    if ask.pose is None:
        named: dict[str, Any] = dict(ask.joints_deg)
        return arm.move_j(speed=ask.speed, wait=False, **named)
    move = arm.move_l if ask.line else arm.move_to
    return move(ask.pose, speed=ask.speed, frame=ask.frame, wait=False)
