"""The fields of a goal as a table: what was typed, its unit, and where the arm is now."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from textual import events
from textual.content import Content
from textual.coordinate import Coordinate
from textual.widgets import DataTable

from tui.keys.table import words
from tui.move.form import GoalForm

COLUMNS = (("", 12), ("goal", 12), ("", 3), ("now", 9))
"""The titles of the columns, and their widths in characters."""

Cells = tuple[str, str, str, str]


class GoalFields(DataTable[Content], can_focus=False):
    """The fields; the one that is typed into is lit. It is never focused; a click chooses a field.

    The keys of the table of keys type and move, so that a stop is never taken as text.
    """

    def __init__(self, chosen: Callable[[int], object], *, id: str) -> None:  # noqa: A002
        """`chosen` is called with the number of the field that was clicked."""
        super().__init__(id=id, cursor_type="row", cell_padding=0, show_cursor=True)
        self._clicked = chosen
        self._rows: tuple[Cells, ...] = ()

    @property
    def shown(self) -> str:
        """The rows as they stand."""
        return "\n".join(" ".join(row) for row in self._rows)

    def on_mount(self) -> None:
        """Make the columns."""
        for title, width in COLUMNS:
            self.add_column(f"{title:>{width}}", width=width)

    def show_form(self, form: GoalForm, present: Mapping[str, float]) -> None:
        """Show the fields of a form, with where the arm is; repaint only what has changed."""
        rows = tuple(_cells(form, name, present) for name in form.names)
        if len(rows) != len(self._rows):
            self.clear()
            self.add_rows(map(Content, row) for row in rows)
        else:
            for at, (row, before) in enumerate(zip(rows, self._rows, strict=True)):
                for column, text in enumerate(row):
                    if text != before[column]:
                        self.update_cell_at(Coordinate(at, column), Content(text))
        self._rows = rows
        if self.cursor_row != form.at:
            self.move_cursor(row=form.at)

    def on_click(self, event: events.Click) -> None:
        """Choose the field that was clicked."""
        row = event.style.meta.get("row", -1)
        if 0 <= row < len(self._rows):
            self._clicked(row)


def _cells(form: GoalForm, name: str, present: Mapping[str, float]) -> Cells:
    chosen = name == form.name
    now = f"{present[name]:.1f}" if name in present else "?"
    text = form.entry(name).shown + "_" * chosen
    return (f"{'>' if chosen else ' '} {words(name)}", f"{text:>12}", f" {form.unit(name)}",
            f"{now:>9}")  # fmt: skip
