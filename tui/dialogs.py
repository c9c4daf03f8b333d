"""The dialogs that lie over any screen: help, questions, what to know at first, the palette."""

from __future__ import annotations

import textwrap
from collections.abc import Awaitable, Callable, Iterable, Iterator
from functools import partial
from typing import ClassVar, TypeVar

from textual.app import App, ComposeResult, SystemCommand
from textual.binding import BindingType
from textual.command import CommandPalette
from textual.containers import Vertical, VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Input

from armdrive.render.side_view import ArmScene, side_view, top_view
from armdrive.status import Status
from tui.arm_view import ArmView
from tui.keys.keyboard import KEYS_WIDTH, Keyboard, bindings, label
from tui.keys.rows import DeskKey
from tui.keys.table import JogPair
from tui.look import LOOKS
from tui.painting import PlainText

STANDS_SO = "Does the arm stand exactly so?"
"""The usual question about a drawn posture."""

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
        """Break the lines again for the new width."""
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
        """Close the dialog with this answer."""
        self.dismiss(result=answer)


class FirstScreen(ModalScreen[bool]):
    """Three facts to know before the first motion; shown until a user has read them."""

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
        """Show the three facts."""
        lines = ("Before you move anything", "", *safety(self._keys, self._status), "")
        close = f"{self._keys.label('understood')}: understood"
        self.query_one("#first-text", PlainText).show("\n".join((*lines, close)))

    def action_close(self) -> None:
        """Go to the desk."""
        self.dismiss(result=True)


def _broken(line: str, width: int) -> list[str]:
    """Break a line of the help; further lines are indented to the words."""
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


# The command palette: what can be done at this place and everywhere, from the tables.

NOT_LISTED = ("palette",)


class StillPalette(CommandPalette):
    """The framework's, with a cursor that does not blink.

    A blinking cursor would repaint all the time, and appear in only one of two pictures.
    """

    def on_mount(self) -> None:
        """Hold the cursor still."""
        self.query_one(Input).cursor_blink = False


def commands(
    rows: Iterable[DeskKey],
    run: Callable[[str], Awaitable[object]],
    put_on: Callable[[str], None],
) -> Iterator[SystemCommand]:
    """Yield the entries of the palette: rows, which `run` takes by their ids, and the looks.

    Keys that jog are not among them: a motion that a key holds cannot be chosen from a list.
    """
    for row in rows:
        if (row.description or row.also) and row.id not in NOT_LISTED:
            title, more = _title_of(row)
            yield SystemCommand(title, more, partial(run, row.id))
    for look in LOOKS:
        yield SystemCommand(f"look: {look.name}", look.summary, partial(put_on, look.name))


def _title_of(row: DeskKey) -> tuple[str, str]:
    """Return what the palette searches: name, key, first sentence and other words; and the rest."""
    first, _, rest = row.tooltip.partition(". ")
    also = f" (also: {row.also})" if row.also else ""
    name = row.description or row.id
    return f"{name} ({label(row.keys[0])}): {first.removesuffix('.')}{also}", rest


Answer = TypeVar("Answer")


class Dialogs:
    """Opens dialogs over the current screen, whose keys then move no arm."""

    def __init__(
        self,
        app: App[int],
        keys: Keyboard,
        pairs: tuple[JogPair, ...],
        *,
        place: Callable[[], str],
        disarm: Callable[[str], None],
    ) -> None:
        """`place` returns the id of the current screen, `disarm` lets no key of it move the arm."""
        self._app = app
        self._keys = keys
        self._pairs = pairs
        self._place = place
        self._disarm = disarm

    def open(
        self,
        dialog: ModalScreen[Answer],
        reason: str,
        answered: Callable[[Answer | None], None] | None = None,
    ) -> None:
        """Open a dialog. `reason` is why no key moves the arm now."""
        self._disarm(reason)
        self._app.push_screen(dialog, answered)

    def help(self) -> None:
        """Show all keys."""
        self.open(HelpScreen(self._keys, self._place(), self._pairs), "the help is shown")

    def palette(self) -> None:
        """Show the command palette."""
        self._disarm("the commands are shown")
        if not isinstance(self._app.screen, StillPalette):
            self._app.push_screen(StillPalette())
