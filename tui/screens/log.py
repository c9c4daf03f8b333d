"""The log screen: what passes between the arm and the desk, in words, as it comes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical

from armdrive.errors import ArmError
from armdrive.status import Status
from armdrive.trace.log import LogBook, LogLine, Sieve, Topic
from tui import log_words
from tui.framework import PlainText
from tui.layout import bindings
from tui.log_dialogs import CatalogueScreen, FindScreen, LineScreen
from tui.log_window import Window
from tui.screens.base import DeskScreen
from tui.widgets.log_list import LogList

if TYPE_CHECKING:
    from collections.abc import Sequence

    from armdrive.trace.log import LogReader

PORTION = 100
"""So many lines are made at a poll, which is 2000 a second, and keeps a stop waiting some 5 ms."""

GLANCE_S = 0.2
"""Lines that keep coming are painted so often: nobody reads faster, and each time all of them move.

A key is answered at once."""

STYLES = {Topic.ERRORS: "bold $error", Topic.INTENTS: "bold", Topic.REQUESTS: "dim"}
"""Beside the marks and words that say the same."""


class LogScreen(DeskScreen):
    """Shows, and moves nothing. What has come since the last poll is read, and no more."""

    place = "log"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)
    CSS = """
    #log-head { height: 2; }
    #log-lines { height: 1fr; }
    """

    def __init__(self) -> None:
        super().__init__()
        self.book = LogBook()
        self.window = Window()
        self.held = False
        self._reader: LogReader | None = None
        self._lines: Sequence[LogLine] = ()
        self._saved: Path | None = None
        self._painted_s = -math.inf

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: what is shown of how much, and the lines."""
        with Vertical():
            yield PlainText(id="log-head")
            yield LogList(id="log-lines")

    # -- what is shown ------------------------------------------------------------------------

    def show_body(self, status: Status) -> None:  # noqa: ARG002 - the log says it itself
        """Take what has come, and show it."""
        hurried = not self.held and self._take()
        if not hurried or self.desk.clock() >= self._painted_s + GLANCE_S:
            self._paint()

    def _take(self) -> bool:
        """Read what is new, and tell whether there was anything."""
        try:
            if self._reader is None:
                self._reader = self.desk.arm.log()
            new = self._reader.read(PORTION)
        except ArmError as error:
            self.desk.message = str(error)
            return False
        if new:
            self.book.take(new)
            self._lines = tuple(self.book.lines)
        return bool(new)

    def _paint(self) -> None:
        self._painted_s = self.desk.clock()
        following, keys = self.window.chosen is None, self.desk.keys
        head = log_words.head(self.book, keys, following=following, held=self.held)
        self.text("log-head").show(head)
        listed = self.query_one(LogList)
        width, height = listed.content_size
        chosen = self.window.line(self._lines)
        rows = [
            (
                log_words.row(line, width, chosen=line is chosen and not following),
                STYLES.get(line.topic, ""),
            )
            for line in self.window.visible(self._lines, height)
        ]
        if not rows:
            rows = [(log_words.nothing(self.book.sieve), "")]
        listed.show(rows)

    def sieve(self, sieve: Sieve) -> None:
        """Have other lines in sight."""
        self.book.choose(sieve)
        self._lines = tuple(self.book.lines)
        self._answer()

    # -- keys ---------------------------------------------------------------------------------

    def _answer(self) -> None:
        """Show what a key has done, whatever keeps coming."""
        self._painted_s = -math.inf
        self.desk.show()

    def action_topic(self, topic: str) -> None:
        """Show a topic, or leave it out."""
        self.sieve(self.book.sieve.turned(Topic(topic)))

    def action_all(self) -> None:
        """Show everything again, and follow it."""
        self.held = False
        self.window = Window()
        self.sieve(Sieve())

    def action_find(self) -> None:
        """Type what all lines must have."""
        self.desk.push_screen(FindScreen(self.desk.keys, self.book.sieve.text, self._find))

    def _find(self, text: str) -> None:
        self.sieve(Sieve(self.book.sieve.topics, text))

    def action_pause(self) -> None:
        """Hold the lines still, or let them come again."""
        self.held = not self.held
        self._answer()

    def action_go(self, by: int) -> None:
        """Choose another line."""
        self.window.go(self._lines, by)
        self._answer()

    def action_page(self, by: int) -> None:
        """Choose a line a page away."""
        self.action_go(by * max(self.query_one(LogList).content_size.height - 1, 1))

    def action_first(self) -> None:
        """Choose the oldest line."""
        self.action_go(-len(self._lines))

    def action_last(self) -> None:
        """Follow the newest line again."""
        self.window = Window()
        self._answer()

    def action_open_line(self) -> None:
        """Show all of the chosen line, or of the newest one."""
        line = self.window.line(self._lines)
        if line is None:
            self.desk.say("there is no line to be opened")
        else:
            self.window.chosen = line.number
            self.desk.push_screen(LineScreen(self.desk.keys, line))

    def action_catalogue(self) -> None:
        """Show all errors."""
        line = self.window.line(self._lines)
        code = line.code if line is not None else ""
        self.desk.push_screen(CatalogueScreen(self.desk.keys, code))

    def action_save(self) -> None:
        """Write the recording, and say where it is."""
        self.desk.say("writing ...")
        self.desk.call(self._save, lambda _: f"written: {self._saved}")

    def _save(self) -> None:
        self._saved = self.desk.arm.save_recording()
