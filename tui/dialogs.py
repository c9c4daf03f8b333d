"""The dialogs that lie over any screen: help, questions, what to know at first, the palette."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Iterator
from functools import partial
from typing import ClassVar

from textual import events, on
from textual.app import ComposeResult, SystemCommand
from textual.binding import BindingType
from textual.command import CommandPalette
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Input

from armdrive.registry import DIALECTS
from armdrive.render.scene import Moment, posture_cameras
from armdrive.status import Status
from kinematics.presets import ArmModel
from kinematics.text import folded
from tui.arm_view import SpaceView
from tui.keys.keyboard import Keyboard, bindings, label
from tui.keys.table import DeskKey, JogPair
from tui.safety import bound_text
from tui.settings import LOOKS
from tui.widgets import PlainText, text_of

LEAST_WIDTH = 60
"""The width of a text until its dialog has been laid out."""


class TextDialog(ModalScreen[bool]):
    """A dialog of nothing but text, which is broken again for each new width."""

    text_id = ""
    short = False
    """Whether the dialog is as high as its text; else it has all the room."""

    def words(self, width: int) -> str:
        """Return the text for this width."""
        raise NotImplementedError

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with VerticalScroll(classes="dialog short" if self.short else "dialog"):
            yield PlainText(id=self.text_id)

    @on(events.Mount)
    @on(events.Resize)
    def _fill_soon(self) -> None:
        """Show the text once the width is known."""
        self.call_after_refresh(self._fill)

    def _fill(self) -> None:
        text = self.query_one(PlainText)
        text.show(self.words(text.content_size.width or LEAST_WIDTH))

    def action_close(self) -> None:
        """Go back to the desk: the text was read."""
        self.dismiss(result=True)


class HelpScreen(TextDialog):
    """All keys, from the table."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("help")
    text_id = "help-text"

    def __init__(self, keys: Keyboard, place: str, pairs: tuple[JogPair, ...]) -> None:
        super().__init__()
        self._keys = keys
        self._place = place
        self._pairs = pairs

    def words(self, width: int) -> str:
        """List the keys."""
        closes = " or ".join(label(key) for key in self._keys.of("help-close")[:2])
        stops = " and ".join(label(key) for key in self._keys.of("stop")[:2])
        head = f"Keys ({closes} closes; {stops} also stop the arm)"
        lines = (head, "", *self._keys.help(self._place, self._pairs))
        return "\n".join(row for line in lines for row in folded(line, width))


class FirstScreen(TextDialog):
    """Three facts to know before the first motion; shown until a user has read them."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("first")
    text_id = "first-text"
    short = True

    def __init__(self, keys: Keyboard, status: Status) -> None:
        super().__init__()
        self._keys = keys
        self._status = status

    def words(self, width: int) -> str:  # noqa: ARG002 - its lines are short
        """Say the three facts."""
        close = f"{self._keys.label('understood')}: understood"
        facts = first_facts(self._keys, self._status)
        return "\n".join(("Before you move anything", "", *facts, "", close))


class PostureScreen(ModalScreen[bool]):
    """A posture, drawn and in words, with a yes and a no. Enter is neither."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("question")

    def __init__(
        self,
        description: str,
        model: ArmModel,
        posture: Moment,
        keys: Keyboard,
        asked: str,
        *,
        braille: bool,
    ) -> None:
        super().__init__()
        self._description = description
        self._model = model
        self._posture = posture
        self._keys = keys
        self._asked = asked
        self._braille = braille

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with Vertical(classes="dialog"):
            yield PlainText(id="posture-text")
            with Horizontal():
                for camera in posture_cameras(self._posture.joints):
                    yield SpaceView(self._model, braille=self._braille, camera=camera)
            yield PlainText(id="posture-question")

    def on_mount(self) -> None:
        """Draw the posture and put the question."""
        text_of(self, "posture-text").show(self._description)
        text_of(self, "posture-question").show(
            f"{self._asked}   {self._keys.label('yes')} yes   {self._keys.label('no')} no"
        )
        for view in self.query(SpaceView):
            view.show(self._posture)

    def action_answer(self, answer: bool) -> None:
        """Close the dialog with this answer."""
        self.dismiss(result=answer)


def first_facts(keys: Keyboard, status: Status) -> tuple[str, str, str]:
    """Return the three facts to know before the first motion."""
    stop, reference = label(keys.of("stop")[0]).upper(), keys.label("reference")
    late = bound_text(status.stop_distance_mm, status.stop_time_s)
    row = DIALECTS.get(status.dialect)
    encoders = row is not None and row.abilities.encoders
    feels = "It feels only blocked motors" if encoders else "The arm feels nothing"
    return (
        f"1 {stop} stops the arm from anywhere, but is no emergency switch.",
        f"2 {feels}, and stops late: {late}. Hands off.",
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
