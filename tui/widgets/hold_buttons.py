"""Buttons for the mouse that move an arm while they are held: a column of minus and plus."""

from __future__ import annotations

from collections.abc import Callable

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.strip import Strip
from textual.widget import Widget

CELLS = ("[-]", "[+]")
WIDTH = sum(map(len, CELLS)) + 1
HELD = "<->", "<+>"
"""How a button looks that is held: not by its colour alone."""


class HoldButtons(Widget):
    """One row for each pair of jog keys. Pressing holds; letting go, or leaving, lets go.

    `push(row, plus)` is called when a button is pressed, `moved()` when the mouse is heard of while
    it holds, `lift()` when it is let go of. The column is never focused: no key can press it.
    """

    DEFAULT_CSS = f"""
    HoldButtons {{ width: {WIDTH}; }}
    """
    can_focus = False

    def __init__(
        self,
        push: Callable[[int, bool], None],
        moved: Callable[[], None],
        lift: Callable[[], None],
        *,
        id: str,  # noqa: A002
    ) -> None:
        super().__init__(id=id)
        self._push, self._moved, self._lift = push, moved, lift
        self._rows = 0
        self._held: tuple[int, bool] | None = None

    @property
    def held(self) -> tuple[int, bool] | None:
        """The row and side that is held down."""
        return self._held

    def show(self, rows: int, *, held: bool) -> None:
        """Show so many rows; `held` says whether whatever is pressed still moves something."""
        if not held and self._held is not None:
            self._held = None
            self.refresh()
        if rows != self._rows:
            self._rows = rows
            self.styles.height = rows
            self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return one row of buttons."""
        style = self.rich_style
        segments = [Segment(" ", style)]
        for side in (False, True):
            down = self._held == (y, side)
            look = style + Style(reverse=True) if down else style
            segments.append(Segment((HELD if down else CELLS)[side], look))
        return Strip(segments, WIDTH) if y < self._rows else Strip.blank(WIDTH, style)

    def at(self, x: int, y: int) -> tuple[int, bool] | None:
        """Return the row and side of a place, None beside the buttons."""
        if not (0 <= y < self._rows and 1 <= x < WIDTH):
            return None
        return y, x > len(CELLS[0])

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """Press a button, with the first button of the mouse alone."""
        event.stop()
        self._let_go()
        found = self.at(event.x, event.y)
        if event.button != 1 or found is None:
            return
        self._held = found
        self.capture_mouse()
        self.refresh()
        self._push(*found)

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """Go on while the mouse stays on its button; leaving it lets go."""
        if self._held is None:
            return
        if self.at(event.x, event.y) == self._held:
            self._moved()
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
        """Let go of a button that is not shown any more."""
        self._let_go()

    def _let_go(self) -> None:
        self.release_mouse()
        if self._held is not None:
            self._held = None
            self.refresh()
            self._lift()
