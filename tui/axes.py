"""Rows of axes: the keys that move each, its value, and its place between two limits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from textual import events

from kinematics.text import shown_name, tenths
from tui.keys.table import JogPair
from tui.widgets import UNKNOWN, PlainText, Span

NAME_WIDTH = 11
VALUE_WIDTH = 9
LIMIT_WIDTH = 4
# What the two limits take at the ends of a bar, with the gaps.
ENDS_WIDTH = 2 * LIMIT_WIDTH + 3

SHORTEST_BAR, LONGEST_BAR = 6, 40

# A value within this share of its range from a limit is marked as near.
NEAR_SHARE = 0.05

# Less than any printed digit: a value this close to a limit is at it.
AT_SHARE = 0.002

DEGREE = "\N{DEGREE SIGN}"
CAP_STYLE = "reverse"
# The style of a value and of its mark on the bar, by the sign after the value.
MARK_STYLES = {"": "bold $text-primary", "!": "bold $text-warning", "!!": "bold $text-error"}


@dataclass(frozen=True, slots=True)
class AxisRow:
    """One axis as it is shown. A value or limits of None are not known.

    `pair` are the keys that move it in the present mode; None where none do. `warns` is whether it
    is worth a warning that a limit is near.
    """

    name: str
    value: float | None
    unit: str
    limits: tuple[float, float] | None = None
    pair: JogPair | None = None
    warns: bool = True

    @property
    def margin(self) -> float | None:
        """How far the value is from the nearer limit; negative beyond it."""
        if self.value is None or self.limits is None:
            return None
        low, high = self.limits
        return min(self.value - low, high - self.value)

    @property
    def margin_share(self) -> float | None:
        """The same as a share of the range."""
        if self.margin is None or self.limits is None:
            return None
        low, high = self.limits
        return self.margin / (high - low)

    @property
    def sign(self) -> str:
        """How close the value is to a limit: `!` near it, `!!` at it or beyond."""
        margin = self.margin_share
        if margin is None or not self.warns:
            return ""
        return "!!" if margin < AT_SHARE else "!" if margin < NEAR_SHARE else ""

    @property
    def value_text(self) -> str:
        """The value with its unit."""
        return UNKNOWN if self.value is None else f"{tenths(self.value)}{self.unit}"


def bar_parts(value: float | None, low: float, high: float, width: int) -> tuple[str, str, str]:
    """Return a bar in three parts, which shows where a value lies between two limits.

    The parts are what is before the mark, the mark, and after it. The mark is `<` or `>` for a
    value outside.
    """
    if value is None:
        return "\N{BOX DRAWINGS HEAVY HORIZONTAL}" * width, "", ""
    share = (value - low) / (high - low)
    place = min(max(round(share * (width - 1)), 0), width - 1)
    outside = "<" if share < -AT_SHARE else ">" if share > 1 + AT_SHARE else ""
    line = "\N{BOX DRAWINGS HEAVY HORIZONTAL}"
    return line * place, outside or "\N{BLACK CIRCLE}", line * (width - 1 - place)


class HeldButton(Protocol):
    """The jog key whose cap the mouse holds."""

    held_button: str
    """The key; empty if nothing is held."""

    def moved(self) -> None:
        """Note that the mouse has moved while it holds a cap."""

    def lift(self) -> None:
        """Let go of the cap."""


class AxisTable(PlainText):
    """A titled panel of axes. Its key caps are buttons: pressing one holds it.

    The table is never focused: no key can press a cap.
    """

    can_focus = False

    def __init__(
        self,
        button: HeldButton,
        push: Callable[[str], None],
        *,
        cap: Callable[[str], str],
        id: str,  # noqa: A002
        name_width: int = NAME_WIDTH,
    ) -> None:
        """`push` holds the cap of a jog key; `cap` returns what is printed on it."""
        super().__init__(id=id, classes="panel")
        self._button = button
        self._push = push
        self._cap = cap
        self._name_width = name_width
        self._rows: tuple[AxisRow, ...] = ()
        self._note = ""
        self._filled: object = None

    @property
    def held(self) -> str:
        """The jog key whose cap in this table is held; empty if none is."""
        key = self._button.held_button
        pairs = (row.pair for row in self._rows if row.pair is not None)
        return key if any(key in (pair.plus, pair.minus) for pair in pairs) else ""

    def show_axes(self, rows: Sequence[AxisRow], note: str = "") -> None:
        """Show these axes."""
        self._rows, self._note = tuple(rows), note
        if (self._rows, self._note, self.held) != self._filled:
            self._fill()

    def set_titles(self, title: str, more: str) -> None:
        """Name the panel, and say more in its lower border, or after the name if it has none."""
        if self.screen.has_class("-short"):
            title, more = f"{title}  {more}".rstrip(), ""
        if (self.border_title, self.border_subtitle) != (title, more):
            self.border_title, self.border_subtitle = title, more

    def on_resize(self) -> None:
        """Fit the bars to another width."""
        self._fill()

    def _fill(self) -> None:
        width = self.content_size.width
        if width <= 0:
            return
        self._filled = (self._rows, self._note, self.held)
        caps, spans = self._caps_width(), list[Span]()
        for row in self._rows:
            spans += [*self._row(row, width, caps), ("\n", "")]
        self.show(*spans[:-1], *([f"\n{self._note}"] if self._note else []))

    def _row(self, row: AxisRow, width: int, caps: int) -> Iterator[Span]:
        yield from self._caps(row.pair, caps)
        yield f"  {shown_name(row.name)[: self._name_width]:<{self._name_width}}", ""
        yield f"{row.value_text:>{VALUE_WIDTH}}", MARK_STYLES[row.sign] if row.sign else "bold"
        yield f"{row.sign:<2}", MARK_STYLES[row.sign]
        room = width - (caps + 2 + self._name_width + VALUE_WIDTH + 2 + ENDS_WIDTH)
        if row.limits is None or room < SHORTEST_BAR:
            return
        low, high = row.limits
        before, mark, after = bar_parts(row.value, low, high, min(room, LONGEST_BAR))
        yield f" {low:>{LIMIT_WIDTH}.0f} ", "dim"
        yield before, "dim"
        yield mark, MARK_STYLES[row.sign]
        yield after, "dim"
        yield f" {high:.0f}", "dim"

    def _caps(self, pair: JogPair | None, width: int) -> Iterator[Span]:
        if pair is None:
            yield " " * width, ""
            return
        for key in (pair.plus, pair.minus):
            left, right = ("<", ">") if key == self.held else (" ", " ")
            text = f"{left}{self._cap(key):^{width // 2 - 2}}{right}"
            yield text, CAP_STYLE if left == " " else f"bold {CAP_STYLE} $warning"

    def _caps_width(self) -> int:
        """Return the width of both caps of a pair; nothing in a table that no key moves."""
        pairs = [row.pair for row in self._rows if row.pair is not None]
        longest = max((len(self._cap(key)) for p in pairs for key in (p.plus, p.minus)), default=1)
        return 2 * (longest + 2)

    # -- the mouse ------------------------------------------------------------------------------

    def at(self, x: int, y: int) -> str:
        """Return the jog key at a place in the content; empty outside the key caps."""
        width = self._caps_width()
        if not (0 <= y < len(self._rows) and 0 <= x < width):
            return ""
        pair = self._rows[y].pair
        if pair is None:
            return ""
        return pair.plus if x < width // 2 else pair.minus

    def _under(self, event: events.MouseEvent) -> str:
        inner = self.content_region
        return self.at(math.floor(event.screen_x) - inner.x, math.floor(event.screen_y) - inner.y)

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """Press a cap, with the first button of the mouse alone."""
        event.stop()
        self._let_go()
        found = self._under(event)
        if event.button == 1 and found:
            self.capture_mouse()
            self._push(found)
            self._fill()

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """Go on while the mouse stays on its cap; leaving it lets go."""
        if not self.held:
            return
        if self._under(event) == self.held:
            self._button.moved()
        else:
            self._let_go()

    def on_mouse_up(self, event: events.MouseUp) -> None:
        """Let go."""
        event.stop()
        self._let_go()

    def on_leave(self) -> None:
        """Let go when the mouse is somewhere else."""
        self._let_go()

    def on_hide(self) -> None:
        """Let go of a cap that is not shown any more."""
        self._let_go()

    def _let_go(self) -> None:
        self.release_mouse()
        if self.held:
            self._button.lift()
            self._fill()
