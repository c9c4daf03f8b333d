"""The move screen: type a goal, see the motion before it begins, and confirm it."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll

from armdrive.status import Status
from tui import move_words
from tui.errand import Ask
from tui.framework import PlainText
from tui.layout import bindings
from tui.screens.move_form import FormKeys
from tui.widgets.arm_view import SpaceView

if TYPE_CHECKING:
    from armdrive.motion.preview import Preview


class MoveScreen(FormKeys):
    """A form, and beside it the arm with the ghost of where it would go."""

    place = "move"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)
    CSS = """
    #move-panel { width: 1fr; min-width: 42; padding: 0 0 0 1; scrollbar-size: 0 0; }
    #goal, #foreseen, #going { height: auto; }
    #going { text-style: bold; }
    MoveScreen.-wide #foreseen, MoveScreen.-wide #going { margin: 1 0 0 0; }
    """

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: the arm with its ghost on the left, the goal on the right."""
        desk = self.desk
        with Horizontal():
            yield SpaceView(desk.arm.model, braille=desk.braille, id="space", clock=desk.clock)
            with VerticalScroll(id="move-panel", can_focus=False):
                for name in ("goal", "foreseen", "going"):
                    yield PlainText(id=name)

    def goal(self, status: Status) -> Ask | None:
        """Return what the form asks for."""
        return self.form.ask(self.present(status))

    def show_body(self, status: Status) -> None:
        """Show the goal, and what its motion would be as soon as that is worked out."""
        fresh = self.look_ahead(status)
        present = self.present(status)
        self.text("goal").show(move_words.form_text(self.form, present, self.desk.keys))
        self.text("foreseen").show(self.desk.spoken(self._foreseen_text(fresh)))
        self.text("going").show(self.going_text(status, fresh))

    def _foreseen_text(self, fresh: Preview | None) -> str:
        if self._progress is not None:
            return ""
        if wrong := self.form.wrong():
            return wrong
        if fresh is not None:
            return move_words.preview_text(fresh, self.desk.keys)
        return "working it out ..." if self._working else move_words.NOTHING_ASKED
