"""The dialogs over the desk: help, and the question whether the arm stands as drawn."""

from __future__ import annotations

import textwrap
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical, VerticalScroll
from textual.screen import ModalScreen

from armdrive.render.side_view import ArmScene, side_view, top_view
from armdrive.status import Status
from tui.framework import PlainText
from tui.keyboard import KEYS_WIDTH, Keyboard, label
from tui.keys import JogPair
from tui.layout import bindings
from tui.views import ArmView

STANDS_SO = "Does the arm stand exactly so?"
"""What is mostly asked beside a posture."""

LEAST_WIDTH = 60
"""Of the help's lines, until the dialog has been laid out."""


class HelpScreen(ModalScreen[bool]):
    """All keys, from the table."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("help")

    def __init__(self, keys: Keyboard, place: str, pairs: tuple[JogPair, ...]) -> None:
        super().__init__()
        self._keys = keys
        self._place = place
        self._pairs = pairs

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with VerticalScroll(classes="dialog"):
            yield PlainText(id="help-text")

    def on_mount(self) -> None:
        """Fill in the keys."""
        self._fill()

    def on_resize(self) -> None:
        """Break the lines anew, once their width is known."""
        self.call_after_refresh(self._fill)

    def _fill(self) -> None:
        text = self.query_one("#help-text", PlainText)
        closes = " or ".join(label(key) for key in self._keys.of("help-close")[:2])
        stops = " and ".join(label(key) for key in self._keys.of("stop")[:2])
        lines = (
            f"Keys ({closes} closes; {stops} also stop the arm)",
            "",
            *self._keys.help(self._place, self._pairs),
        )
        width = text.content_size.width or LEAST_WIDTH
        text.show("\n".join(broken for line in lines for broken in _broken(line, width)))

    def action_close(self) -> None:
        """Go back to the desk."""
        self.dismiss(result=False)


class PostureScreen(ModalScreen[bool]):
    """A posture, drawn and in words, with a yes and a no. Enter is neither."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("question")

    def __init__(
        self,
        description: str,
        scene: ArmScene | None,
        keys: Keyboard,
        *,
        braille: bool,
        asked: str,
    ) -> None:
        super().__init__()
        self._keys = keys
        self._description = description
        self._asked = asked
        self._scene = scene
        self._braille = braille

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with Vertical(classes="dialog"):
            yield PlainText(id="posture-text")
            yield ArmView("side", side_view, braille=self._braille, id="posture-side")
            yield ArmView("above", top_view, braille=self._braille, id="posture-top")
            yield PlainText(id="posture-question")

    def on_mount(self) -> None:
        """Draw the posture and put the question."""
        self.query_one("#posture-text", PlainText).show(self._description)
        self.query_one("#posture-question", PlainText).show(
            f"{self._asked}   {self._keys.label('yes')} yes   {self._keys.label('no')} no"
        )
        for view in self.query(ArmView):
            view.show(self._scene)

    def action_answer(self, answer: bool) -> None:
        """Give the answer to whoever asked."""
        self.dismiss(result=answer)


class FirstScreen(ModalScreen[bool]):
    """What somebody has to know before the first motion, in three lines; shown until it is read."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("first")

    def __init__(self, keys: Keyboard, status: Status) -> None:
        super().__init__()
        self._keys = keys
        self._status = status

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with Vertical(classes="dialog short"):
            yield PlainText(id="first-text")

    def on_mount(self) -> None:
        """Say it."""
        lines = ("Before you move anything", "", *safety(self._keys, self._status), "")
        close = f"{self._keys.label('understood')}: understood"
        self.query_one("#first-text", PlainText).show("\n".join((*lines, close)))

    def action_close(self) -> None:
        """Go to the desk."""
        self.dismiss(result=True)


def _broken(line: str, width: int) -> list[str]:
    """Break a line of the help; what goes on stands under the words, not under the keys."""
    if len(line) <= width:
        return [line]
    keys, words = line[:KEYS_WIDTH], line[KEYS_WIDTH:]
    if keys.rstrip() == keys:  # a line of words alone, or keys that need more room
        keys, words = "", line
    indent = " " * KEYS_WIDTH
    return textwrap.wrap(
        words, width, initial_indent=keys, subsequent_indent=indent if keys else "",
        break_on_hyphens=False,
    )  # fmt: skip


def safety(keys: Keyboard, status: Status) -> tuple[str, str, str]:
    """Return the three facts, each of them one line."""
    stop, reference = label(keys.of("stop")[0]).upper(), keys.label("reference")
    way = f"{status.stop_time_s:.2f} s, {status.stop_distance_mm:.0f} mm"
    return (
        f"1 {stop} stops the arm from anywhere, but is no emergency switch.",
        f"2 The arm feels nothing, and stops late: {way}. Hands off.",
        f"3 Its numbers hold only after a reference ({reference}): look at the arm.",
    )
