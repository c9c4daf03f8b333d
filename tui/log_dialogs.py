"""The log's dialogs: a line in full, the text that lines must have, and every error there is."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical, VerticalScroll
from textual.screen import ModalScreen

from armdrive.errors.table import Entry, found
from armdrive.trace.log import LogLine
from tui import log_words
from tui.framework import PlainText
from tui.keyboard import Keyboard
from tui.layout import bindings

LONGEST = 40
"""Characters of a search."""


class LineScreen(ModalScreen[None]):
    """One line in full, with cause and remedy where it is an error."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("line")

    def __init__(self, keys: Keyboard, line: LogLine) -> None:
        super().__init__()
        self._keys = keys
        self._line = line

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with VerticalScroll(classes="dialog"):
            yield PlainText(id="line-text")

    def on_mount(self) -> None:
        """Say all of it as soon as the width is known."""
        self.call_after_refresh(self._fill)

    def on_resize(self) -> None:
        """Fit it to another width."""
        self.call_after_refresh(self._fill)

    def _fill(self) -> None:
        text = self.query_one("#line-text", PlainText)
        close = f"{self._keys.label('line-close')} closes"
        text.show(f"{log_words.whole(self._line, text.content_size.width, self._keys)}\n\n{close}")

    def action_close(self) -> None:
        """Go back to the log."""
        self.dismiss()


class Typing(ModalScreen[None]):
    """A dialog into which a text is typed. The space bar never comes here: it stops the arm."""

    text = ""

    def on_key(self, event: events.Key) -> None:
        """Take a character; other keys go on to the table of keys."""
        if event.is_printable and event.character is not None and len(self.text) < LONGEST:
            event.stop()
            event.prevent_default()
            self.typed(self.text + event.character)

    def action_erase(self) -> None:
        """Take the last character away."""
        self.typed(self.text[:-1])

    def action_clear(self) -> None:
        """Take all characters away."""
        self.typed("")

    def action_close(self) -> None:
        """Go back to the log."""
        self.dismiss()

    def typed(self, text: str) -> None:
        """Take the text as it is now."""
        self.text = text


class FindScreen(Typing):
    """The text that every line must have; the log behind it follows as it is typed."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("find")
    CSS = "FindScreen { align: center bottom; }"

    def __init__(self, keys: Keyboard, text: str, use: Callable[[str], None]) -> None:
        super().__init__()
        self._keys = keys
        self._use = use
        self.text = text

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with Vertical(classes="dialog short"):
            yield PlainText(id="find-text")

    def on_mount(self) -> None:
        """Show what was typed before."""
        self.typed(self.text)

    def typed(self, text: str) -> None:
        """Show the text, and have the log follow it."""
        super().typed(text)
        done = f"{self._keys.label('find-done')}: done"
        said = log_words.asked_text("only lines with", text)
        self.query_one("#find-text", PlainText).show(f"{said}\n{done}")
        self._use(text)


class CatalogueScreen(Typing):
    """Every error of the catalogue, found by words; the chosen one in full."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("catalogue")

    def __init__(self, keys: Keyboard, text: str = "") -> None:
        super().__init__()
        self._keys = keys
        self._at = 0
        self._rows: tuple[Entry, ...] = ()
        self.text = text

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with Vertical(classes="dialog", id="catalogue"):
            yield PlainText(id="catalogue-find")
            yield PlainText(id="catalogue-text")

    def on_mount(self) -> None:
        """Show it as soon as the size is known."""
        self.call_after_refresh(self.typed, self.text)

    def on_resize(self) -> None:
        """Fit it to another size."""
        self.call_after_refresh(self._fill)

    def typed(self, text: str) -> None:
        """Find the errors with this text."""
        super().typed(text)
        self._rows, self._at = found(text), 0
        self._fill()

    def action_choose(self, by: int) -> None:
        """Choose another error."""
        self._at = min(max(self._at + by, 0), max(len(self._rows) - 1, 0))
        self._fill()

    def _fill(self) -> None:
        width, height = self.query_one("#catalogue").content_size
        close = self._keys.label("catalogue-close")
        said = f"{log_words.asked_text('errors with', self.text)}\n{close}: close"
        self.query_one("#catalogue-find", PlainText).show(said)
        room = height - 1 - said.count("\n") - 1
        listed = log_words.catalogue(self._rows, self._at, width, room, self._keys)
        self.query_one("#catalogue-text", PlainText).show(f"\n{listed}")
