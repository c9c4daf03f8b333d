"""The widgets that the screens share: texts, lists, and what surrounds the body of each screen."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from itertools import accumulate

from rich.cells import cell_len
from textual import events
from textual.app import ComposeResult
from textual.containers import Container
from textual.content import Content
from textual.dom import DOMNode
from textual.widget import Widget
from textual.widgets import OptionList, Static

from armdrive.errors.printable import printable, printable_lines
from tui.keys.keyboard import Keyboard, short_label
from tui.keys.table import SCREENS, DeskKey

# A text and its style.
Span = tuple[str, str]

# Stands for a value that is not known.
UNKNOWN = "?"

# Between two groups of the line of keys.
KEY_GAP = "  "


class PlainText(Static):
    """Text that is shown as it is, and repainted only when it has changed.

    The framework's own widget would read square brackets as markup, paint every update, and send
    an escape sequence in the text to the terminal: text may come from a file or a device.
    """

    def __init__(self, *, id: str, classes: str = "") -> None:  # noqa: A002
        super().__init__("", id=id, classes=classes, markup=False)
        self._spans: tuple[Span, ...] = ()

    @property
    def shown(self) -> str:
        """The text as it stands."""
        return "".join(text for text, _ in self._spans)

    def show(self, *parts: str | Span) -> None:
        """Show these texts from now on, one after the other."""
        spans = tuple(_printable_span(part) for part in parts)
        if spans == self._spans:
            return
        before = self._rows_without_breaks()
        self._spans = spans
        same_height = before is not None and before == self._rows_without_breaks()
        # laying out the screen takes longer than painting it, and each poll of a moving arm changes
        # several texts, mostly only their numbers
        self.update(Content.assemble(*spans), layout=not same_height)

    def _rows_without_breaks(self) -> int | None:
        """Return how many rows the text takes; None if it is empty or a line has to be broken."""
        lines = self.shown.split("\n")
        fits = all(cell_len(line) <= self.content_size.width for line in lines)
        return len(lines) if self.shown and fits else None

    def show_lines(self, lines: Iterable[Span]) -> None:
        """Show lines, each in its own style."""
        ended = [(f"{text}\n", style) for text, style in lines]
        self.show(*ended[:-1], *((text[:-1], style) for text, style in ended[-1:]))


def _printable_span(part: str | Span) -> Span:
    text, style = (part, "") if isinstance(part, str) else part
    return printable_lines(text), style


def is_printable(character: str) -> bool:
    """Return whether a character can be typed. Space never gets here: it stops the arm."""
    return character.isprintable()


class TypedText:
    """A line of text that the user types on a screen or in a dialog, its `typing`.

    No widget has the focus, so that a stop key never types a letter and keys that arrive together
    keep their order. Only keys that work everywhere come before the line; other rows of the table
    have their keys where the line does not take the character.
    """

    def __init__(
        self,
        text: str = "",
        *,
        takes: Callable[[str], bool] = is_printable,
        longest: int | None = None,
        offered: bool = False,
        changed: Callable[[str], None] | None = None,
    ) -> None:
        """`takes` decides which characters are accepted; `changed` is called with each new text.

        With `longest`, further characters are dropped; a port or a path may have any length.
        """
        self.text = text
        self.offered = offered
        """Whether the text is only a proposal, which the first key replaces completely."""
        self._takes = takes
        self._longest = longest
        self._changed = changed

    def takes(self, character: str | None) -> bool:
        """Return whether the character of a key is accepted here."""
        return bool(character) and self._takes(str(character))

    def type(self, character: str) -> None:
        """Append a character; a full line is unchanged."""
        typed = ("" if self.offered else self.text) + character
        self.set(typed[: self._longest])

    def erase(self) -> None:
        """Delete the last character."""
        self.set("" if self.offered else self.text[:-1])

    def clear(self) -> None:
        """Delete all characters."""
        self.set("")

    def set(self, text: str) -> None:
        """Replace the text, which is shown literally."""
        self.text, self.offered = text, False
        if self._changed is not None:
            self._changed(text)


def text_of(parent: DOMNode, name: str) -> PlainText:
    """Return one of the texts of a screen or a panel."""
    return parent.query_one(f"#{name}", PlainText)


def show_panel(parent: DOMNode, name: str, text: str) -> None:
    """Show a text in its panel; hide the panel while there is none."""
    panel = text_of(parent, name)
    panel.show(text)
    panel.display = bool(text)


class ChoiceList(OptionList, can_focus=False):
    """A titled list. It is never focused, so no key acts on it by itself.

    A click on a row does what the keys do that go to it from the chosen row.
    """

    def __init__(
        self,
        action: str,
        *,
        id: str,  # noqa: A002
        classes: str = "panel",
    ) -> None:
        """`action` is that of the keys: it takes by how many rows to go on."""
        super().__init__(id=id, classes=classes, compact=True, markup=False)
        self._action = action
        self._chosen = 0
        self._rows: tuple[str, ...] = ()

    @property
    def shown(self) -> str:
        """The rows as they stand, the chosen one with a mark."""
        return "\n".join(
            f"{'>' if at == self.highlighted else ' '} {row}" for at, row in enumerate(self._rows)
        )

    def show_rows(self, rows: Sequence[str], chosen: int | None) -> None:
        """Show these rows, one of them chosen; repaint only what has changed."""
        self._chosen = chosen or 0
        texts = tuple(printable(row) for row in rows)
        if texts != self._rows:
            self._rows = texts
            self.set_options(Content(f"  {text}") for text in texts)
            self.highlighted = None  # so that the mark is drawn again below
        if self.highlighted != chosen:
            for at, mark in ((self.highlighted, " "), (chosen, ">")):
                if at is not None:
                    self.replace_option_prompt_at_index(at, Content(f"{mark} {texts[at]}"))
            self.highlighted = chosen

    async def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Choose the row that was clicked."""
        event.stop()
        by = event.option_index - self._chosen
        await self.app.run_action(f"{self._action}({by})", self.screen)


class KeyLine(PlainText):
    """Words in one line, each of which does what a key does when it is clicked."""

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__(id=id)
        self._ends: tuple[tuple[int, str], ...] = ()

    def show_words(self, words: Iterable[tuple[str, Sequence[Span]]]) -> None:
        """Show words, each with the id of the binding that a click on it acts as."""
        words = tuple(words)
        self._ends = tuple(
            zip(
                accumulate(sum(len(text) for text, _ in word) for _, word in words),
                (name for name, _ in words),
                strict=True,
            )
        )
        self.show(*(span for _, word in words for span in word))

    def show_keys(self, rows: Sequence[DeskKey], width: int) -> None:
        """Show these keys, without the less important ones where there is too little room."""
        offered = list(rows)
        while sum(map(_width, offered)) - len(KEY_GAP) > width and len(offered) > 1:
            # the commands can be missed first, then the last of a screen's own
            spare = [row for row in offered[1:] if row.id not in ("help", "quit")]
            offered.remove(spare[-1] if spare else offered[-1])
        self.show_words(word for row in offered for word in _words(row))

    async def on_click(self, event: events.Click) -> None:
        """Do what the word under the mouse does."""
        found = next((name for end, name in self._ends if event.x < end), None)
        if found is not None:
            await self.app.run_action(f"app.do_row('{found}')")


def _width(row: DeskKey) -> int:
    return len(f"{short_label(row)} {row.description}{KEY_GAP}")


def _words(row: DeskKey) -> Iterator[tuple[str, Sequence[Span]]]:
    """Yield a row's keys, the one that does the opposite first, and its name behind the last."""
    *back, key = short_label(row).split(" ")
    for each in back:
        yield f"{row.id}-back", [(f"{each} ", "bold $text-primary")]
    yield row.id, [(key, "bold $text-primary"), (f" {row.description}{KEY_GAP}", "")]


class ScreenTabs(KeyLine):
    """The screens of the desk with their keys; the current one is lit."""

    def __init__(self, place: str, keys: Keyboard) -> None:
        super().__init__(id="tabs")
        self.place = place
        """The id of the screen that is lit."""
        self._keys = keys

    def on_resize(self) -> None:
        """Show all tabs; where they have too little room, the others keep only their keys."""
        titles = {entry.id: f" {entry.title.capitalize()}" for entry in SCREENS}
        rows = {place: f"screen-{place}" for place in titles}
        room = self.content_size.width
        if sum(len(self._keys.label(rows[place]) + titles[place]) + 2 for place in titles) > room:
            titles = {place: titles[place] if place == self.place else "" for place in titles}
        # on a terminal without colours the lit tab is in reverse
        lit = "bold reverse" if self.app.no_color else "bold $text on $primary"
        self.show_words(
            (row, [(f" {self._keys.label(row).upper()}{titles[place]} ", style)])
            for place, row in rows.items()
            for style in [lit if place == self.place else ""]
        )


def framed(head: Iterable[Widget], body: Iterable[Widget]) -> ComposeResult:
    """Lay a screen out: what stands above its middle, the middle, a message, the line of keys."""
    yield from head
    with Container(id="body"):
        yield from body
    yield PlainText(id="messages")
    yield KeyLine(id="footer")


def fill_frame(screen: DOMNode, message: str, rows: Sequence[DeskKey]) -> None:
    """Show the message and the line of keys of a screen."""
    text_of(screen, "messages").show(message)
    footer = screen.query_one("#footer", KeyLine)
    footer.show_keys(rows, footer.content_size.width)


def panels(**titles: str) -> Iterator[PlainText]:
    """Yield a titled panel of text for each id."""
    for name, title in titles.items():
        panel = PlainText(id=name, classes="panel")
        panel.border_title = title
        yield panel


# How the line that runs is shown, those before it, and those with a mistake.
CURRENT_STYLE, DONE_STYLE, WRONG_STYLE = "bold reverse $primary", "dim", "bold $text-error"


class ProgramLines(PlainText):
    """A panel of program lines, as many as it has room for, hidden while there are none."""

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__(id=id, classes="panel")

    def show_program(
        self,
        lines: Sequence[str] = (),
        current: int | None = None,
        wrong: Collection[int] = (),
        top: int = 0,
    ) -> None:
        """Show lines about the `current` one, which runs, or else from `top` on.

        `wrong` are lines with mistakes. Lines count from 1, as people count them.
        """
        self.display = bool(lines)
        height = self.content_size.height
        before = top if current is None else current - 1 - height // 2
        begin = max(min(before, len(lines) - height), 0)
        numbered = enumerate(lines[begin : begin + height], begin + 1)
        self.show_lines(_program_line(*each, current, wrong) for each in numbered)


def _program_line(number: int, line: str, current: int | None, wrong: Collection[int]) -> Span:
    done = current is not None and number < current
    mark, style = " ", DONE_STYLE if done else ""
    if number in wrong:
        mark, style = "!", WRONG_STYLE
    if number == current:
        mark, style = ">", style if number in wrong else CURRENT_STYLE
    return f"{mark}{number:>4}  {line}", style
