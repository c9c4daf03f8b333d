"""The dialogs that lie over any screen: help, questions, what to know at first, the palette."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import ClassVar

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
from tui.keys.presses import Confirmation
from tui.keys.table import DeskKey, JogPair
from tui.safety import bound_text
from tui.widgets import PlainText, TypedText, text_of

# Characters of a text that is typed into a dialog.
LONGEST = 40

# Returns the text of a dialog for a width.
DialogWords = Callable[[int], str]


class DialogText(PlainText):
    """The text of a dialog, which is made as soon as its width is known."""

    def __init__(self, fill: Callable[[], None]) -> None:
        super().__init__(id="dialog-text")
        self._fill = fill

    def on_resize(self) -> None:
        """Make the text for another width."""
        self._fill()


class TextDialog(ModalScreen[None]):
    """A dialog of text, which is made again for each new width and whenever a key changes it.

    With `typed` there is a line that is typed into, whose text is passed to that function.
    """

    BINDINGS: ClassVar[list[BindingType]] = bindings("dialog")

    def __init__(
        self,
        words: DialogWords,
        *,
        short: bool = False,
        text: str = "",
        typed: Callable[[str], None] | None = None,
    ) -> None:
        """`short` makes the dialog as high as its text."""
        super().__init__(classes="search" if typed else "")
        self._words = words
        self._short = short
        self._typed = typed
        self.typing: TypedText | None = None
        if typed is not None:
            self.typing = TypedText(text, longest=LONGEST, changed=self._take)

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with VerticalScroll(classes="dialog short" if self._short else "dialog"):
            yield DialogText(self._fill)

    def _fill(self) -> None:
        text = text_of(self, "dialog-text")
        if width := text.content_size.width:
            text.show(self._words(width))

    def _take(self, text: str) -> None:
        if self._typed is not None:
            self._typed(text)
        self._fill()

    def action_clear(self) -> None:
        """Delete the whole text that was typed."""
        if self.typing is not None:
            self.typing.clear()

    def action_close(self) -> None:
        """Go back to the desk: the text was read."""
        self.dismiss()


def help_dialog(keys: Keyboard, place: str, pairs: Sequence[JogPair]) -> TextDialog:
    """Return a dialog with all keys, from the table."""
    closes = " or ".join(label(key) for key in keys.of("close")[:2])
    stops = " and ".join(label(key) for key in keys.of("stop")[:2])
    head = f"Keys ({closes} closes; {stops} also stop the arm)"

    def words(width: int) -> str:
        lines = (head, "", *keys.help(place, pairs))
        return "\n".join(row for line in lines for row in folded(line, width))

    return TextDialog(words)


def first_dialog(keys: Keyboard, status: Status) -> TextDialog:
    """Return a dialog with three facts to know before the first motion."""
    lines = ("Before you move anything", "", *first_facts(keys, status), "",
             f"{keys.label('close')}: understood")  # fmt: skip
    return TextDialog(lambda _: "\n".join(lines), short=True)


class PostureScreen(ModalScreen[bool]):
    """A posture, drawn and in words, with a yes and a no. Enter is neither."""

    BINDINGS: ClassVar[list[BindingType]] = bindings("question")

    def __init__(
        self,
        words: str,
        model: ArmModel,
        posture: Moment,
        keys: Keyboard,
        asked: str,
        confirmation: Confirmation,
        *,
        braille: bool,
    ) -> None:
        """`confirmation` lets a yes count once no other key has followed it."""
        super().__init__()
        self._words = words
        self._posture = posture
        self._asked = f"{asked}   {keys.label('yes')} yes   {keys.label('no')} no"
        self._confirmation = confirmation
        self._views = [
            SpaceView(model, braille=braille, camera=camera)
            for camera in posture_cameras(posture.joints)
        ]

    def compose(self) -> ComposeResult:
        """Lay the dialog out."""
        with Vertical(classes="dialog"):
            yield PlainText(id="posture-text")
            yield Horizontal(*self._views)
            yield PlainText(id="posture-question")

    def on_mount(self) -> None:
        """Draw the posture and put the question."""
        text_of(self, "posture-text").show(self._words)
        text_of(self, "posture-question").show(self._asked)
        for view in self._views:
            view.show(self._posture)

    def action_answer(self, answer: bool) -> None:
        """Close the dialog with this answer."""
        if answer:
            self._confirmation.press("says yes", partial(self.dismiss, result=True), needed=1)
        else:
            self.dismiss(result=False)


def first_facts(keys: Keyboard, status: Status) -> tuple[str, str, str]:
    """Return the three facts to know before the first motion."""
    stop, reference = keys.label("stop").upper(), keys.label("reference")
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
    rows: Iterable[DeskKey], run: Callable[[str], Awaitable[object]]
) -> Iterator[SystemCommand]:
    """Yield the entries of the palette: rows, which `run` takes by their ids.

    Keys that jog are not among them: a motion that a key holds cannot be chosen from a list.
    """
    for row in rows:
        if (row.description or row.also) and row.id not in NOT_LISTED:
            first, _, rest = row.tooltip.partition(". ")
            also = f" (also: {row.also})" if row.also else ""
            what = f"{first.removesuffix('.')}{also}"
            for name, keys, _ in row.bound:
                title = f"{row.description or row.id} ({label(keys[0])}): {what}"
                yield SystemCommand(title, rest, partial(run, name))
