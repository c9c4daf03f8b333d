"""The move screen: type a goal, see the motion before it begins, and confirm it."""

from __future__ import annotations

from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll

from armdrive.motion.preview import Preview
from armdrive.status import Status
from tui.arm_view import SpaceView
from tui.keys.keyboard import bindings
from tui.move import text as move_text
from tui.move.entry import GoalEntry
from tui.move.form import DIGITS
from tui.painting import PlainText
from tui.screens import DeskScreen


class MoveScreen(DeskScreen):
    """A form, and beside it the arm with the ghost of where it would go.

    Nothing here moves the arm but what was seen, and confirmed by two presses.
    """

    place = "move"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)
    CSS = """
    #move-panel { width: 1fr; min-width: 42; padding: 0 0 0 1; scrollbar-size: 0 0; }
    #goal, #foreseen, #going { height: auto; }
    #going { text-style: bold; }
    MoveScreen.-wide #foreseen, MoveScreen.-wide #going { margin: 1 0 0 0; }
    """

    def __init__(self) -> None:
        super().__init__()
        self.entry = GoalEntry(self.desk)
        self.planned = self.entry.planned

    def disarm(self, reason: str) -> None:  # noqa: ARG002 - as every screen
        """Take a first press back."""
        self.planned.forget_press()

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: the arm with its ghost on the left, the goal on the right."""
        desk = self.desk
        with Horizontal():
            yield SpaceView(desk.arm.model, braille=desk.braille, id="space", clock=desk.clock)
            with VerticalScroll(id="move-panel", can_focus=False):
                for name in ("goal", "foreseen", "going"):
                    yield PlainText(id=name)

    def show_body(self, status: Status) -> None:
        """Show the goal, and what its motion would be as soon as that is worked out."""
        fresh = self.planned.follow(status)
        self.query_one(SpaceView).show(self.planned.moment(status, fresh))
        form, present = self.entry.form, self.entry.present(status)
        self.text("goal").show(move_text.form_text(form, present, self.desk.keys))
        self.text("foreseen").show(self.desk.spoken(self._foreseen_text(fresh)))
        self.text("going").show(self.planned.text(status, fresh))

    def _foreseen_text(self, fresh: Preview | None) -> str:
        if self.planned.under_way:
            return ""
        if wrong := self.entry.form.wrong():
            return wrong
        if fresh is not None:
            return move_text.preview_text(fresh, self.desk.keys)
        return "working it out ..." if self.planned.working else move_text.NOTHING_ASKED

    def on_key(self, event: events.Key) -> None:
        """Type into the field; other keys go on to the table of keys."""
        if event.character is not None and event.character in DIGITS:
            event.stop()
            event.prevent_default()
            self.entry.type(event.character)

    def on_screen_resume(self) -> None:
        """Take up a goal that another screen has left for this one."""
        left, self.desk.goal = self.desk.goal, None
        if left is not None:
            self.entry.start_at(left)
