"""The log screen: what passes between the arm and the desk, in words, as it comes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen

from armdrive.errors import BadRequest
from armdrive.errors.printable import printable
from armdrive.errors.table import CatalogueEntry, found
from armdrive.status import Status
from armdrive.trace.entries import Topic
from armdrive.trace.log import LogLine
from tui.app import TypedText
from tui.desk import DeskScreen
from tui.dialogs import TextDialog
from tui.keys.keyboard import Keyboard, bindings
from tui.log.lines import (
    LogView,
    asked_text,
    catalogue_text,
    log_head,
    log_row,
    nothing_text,
    whole_line,
)
from tui.widgets import PlainText, panels

# The dialogs: a line in full, the text that lines must have, and every error there is.


class LineScreen(TextDialog):
    """One line in full, with cause and remedy where it is an error."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("line")
    text_id = "line-text"

    def __init__(self, keys: Keyboard, line: LogLine) -> None:
        super().__init__()
        self._keys = keys
        self._line = line

    def words(self, width: int) -> str:
        """Say all that is known of the line."""
        close = f"{self._keys.label('line-close')} closes"
        return f"{whole_line(self._line, width, self._keys)}\n\n{close}"


LONGEST = 40
"""Characters of a text that is looked for."""


class SearchDialog(ModalScreen[None]):
    """A dialog into which a text is typed."""

    def __init__(self, keys: Keyboard, text: str) -> None:
        super().__init__()
        self._keys = keys
        self.typing = TypedText(text, longest=LONGEST, changed=self.show)

    def show(self, text: str) -> None:
        """Show the text as it is now, and what is found with it."""
        raise NotImplementedError

    def action_close(self) -> None:
        """Go back to the log."""
        self.dismiss()


class FindScreen(SearchDialog):
    """The text that every line must have; the log behind it follows as it is typed."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("find")

    def __init__(self, keys: Keyboard, text: str, use: Callable[[str], None]) -> None:
        super().__init__(keys, text)
        self._use = use

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with Vertical(classes="dialog short"):
            yield PlainText(id="find-text")

    def on_mount(self) -> None:
        """Show what was typed before."""
        self.show(self.typing.text)

    def show(self, text: str) -> None:
        """Show the text, and have the log follow it."""
        done = f"{self._keys.label('find-done')}: done"
        prompt = asked_text("only lines with", text)
        self.query_one("#find-text", PlainText).show(f"{prompt}\n{done}")
        self._use(text)


class CatalogueScreen(SearchDialog):
    """Every error of the catalogue, found by words; the chosen one in full."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("catalogue")

    def __init__(self, keys: Keyboard, text: str = "") -> None:
        super().__init__(keys, text)
        self._at = 0
        self._rows: tuple[CatalogueEntry, ...] = ()

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with Vertical(classes="dialog", id="catalogue"):
            yield PlainText(id="catalogue-find")
            yield PlainText(id="catalogue-text")

    def on_mount(self) -> None:
        """Show it as soon as the size is known."""
        self.call_after_refresh(self.show, self.typing.text)

    def on_resize(self) -> None:
        """Fit it to another size."""
        self.call_after_refresh(self._fill)

    def show(self, text: str) -> None:
        """Find the errors with this text."""
        self._rows, self._at = found(text), 0
        self._fill()

    def action_choose(self, by: int) -> None:
        """Choose another error."""
        self._at = min(max(self._at + by, 0), max(len(self._rows) - 1, 0))
        self._fill()

    def _fill(self) -> None:
        width, height = self.query_one("#catalogue").content_size
        close = self._keys.label("catalogue-close")
        prompt = f"{asked_text('errors with', self.typing.text)}\n{close}: close"
        self.query_one("#catalogue-find", PlainText).show(prompt)
        room = height - 1 - prompt.count("\n") - 1
        listed = catalogue_text(self._rows, self._at, width, room, self._keys)
        self.query_one("#catalogue-text", PlainText).show(f"\n{listed}")


GLANCE_S = 0.2
"""Lines that keep coming are painted at this interval, which is as fast as people read.

A key has its effect at once."""

STYLES = {Topic.ERRORS: "bold $error", Topic.INTENTS: "bold", Topic.REQUESTS: "dim"}
"""In addition to the marks and words that say the same."""


class LogScreen(DeskScreen):
    """Shows, and moves nothing. What has come since the last poll is read, and no more."""

    place = "log"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        self.log_view = LogView(self.desk, self._show_now)
        self._painted_s = -math.inf

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: what is shown of how much, and the lines."""
        with Vertical():
            yield from panels(**{"log-head": "What is shown", "log-lines": "Log"})

    def show_body(self, status: Status) -> None:  # noqa: ARG002 - the log says it itself
        """Take what has come, and show it."""
        hurried = self.log_view.read()
        if not hurried or self.desk.clock() >= self._painted_s + GLANCE_S:
            self._paint()

    def _show_now(self) -> None:
        """Show what a key has done, whatever keeps coming."""
        self._painted_s = -math.inf
        self.desk.show()

    def _paint(self) -> None:
        self._painted_s = self.desk.clock()
        view, keys = self.log_view, self.desk.keys
        head = log_head(view.book, keys, following=view.following, held=view.held)
        self.text("log-head").show(head)
        listed = self.text("log-lines")
        width, height = listed.content_size
        chosen = None if view.following else view.line
        rows = [
            (log_row(line, width, chosen=line is chosen), STYLES.get(line.topic, ""))
            for line in view.visible(height)
        ]
        if not rows:
            rows = [(nothing_text(view.book.filter), "")]
        # cut once more: an escape is longer than what it stands for
        listed.show_lines((printable(text)[: len(text)], style) for text, style in rows)

    # -- keys ---------------------------------------------------------------------------------

    def action_find(self) -> None:
        """Type what all lines must have."""
        view = self.log_view
        self.app.push_screen(FindScreen(self.desk.keys, view.book.filter.text, view.find))

    def action_open_line(self) -> None:
        """Show all of the chosen line, or of the newest one."""
        line = self.log_view.line
        if line is None:
            raise BadRequest("there is no line to be opened")
        self.log_view.choose(line)
        self.app.push_screen(LineScreen(self.desk.keys, line))

    def action_catalogue(self) -> None:
        """Show all errors."""
        line = self.log_view.line
        code = line.code if line is not None else ""
        self.app.push_screen(CatalogueScreen(self.desk.keys, code))

    def action_save(self) -> None:
        """Write the recording, and say where it is."""
        self.desk.say("writing ...")
        self.desk.calls.make(lambda: f"written: {self.desk.arm.save_recording()}")
