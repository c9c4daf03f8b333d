"""A list with one chosen row: the framework's, moved by the keys of the table."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from textual.content import Content
from textual.widgets import OptionList

from armdrive.errors.printable import printable


class ChoiceList(OptionList, can_focus=False):
    """A titled list. It is never focused, so no key acts on it by itself; a click chooses a row."""

    def __init__(self, chosen: Callable[[int], object], *, id: str) -> None:  # noqa: A002
        """`chosen` is called with the row that was clicked."""
        super().__init__(id=id, classes="panel", compact=True, markup=False)
        self._clicked = chosen
        self._rows: tuple[str, ...] = ()

    @property
    def shown(self) -> str:
        """The rows as they stand, the chosen one with a mark."""
        return "\n".join(
            f"{'>' if at == self.highlighted else ' '} {row}" for at, row in enumerate(self._rows)
        )

    def show_rows(self, rows: Sequence[str], chosen: int | None) -> None:
        """Show these rows, one of them chosen; repaint only what has changed."""
        texts = tuple(printable(row) for row in rows)
        if texts != self._rows:
            self._rows = texts
            self.set_options(Content(f"  {text}") for text in texts)
            self.highlighted = None
        if self.highlighted != chosen:
            for at, mark in ((self.highlighted, " "), (chosen, ">")):
                if at is not None:
                    self.replace_option_prompt_at_index(at, Content(f"{mark} {texts[at]}"))
            self.highlighted = chosen

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Choose the row that was clicked."""
        event.stop()
        self._clicked(event.option_index)
