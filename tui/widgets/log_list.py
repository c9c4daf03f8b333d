"""Rows of the log, painted when they change; what an error is, its mark says, and its style too."""

from __future__ import annotations

from collections.abc import Sequence

from textual.content import Content
from textual.widgets import Static

from armdrive.text.printable import printable

Row = tuple[str, str]
"""A text and its style."""


class LogList(Static):
    """As many rows as fit, each cut to the width before it comes here."""

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__("", id=id, markup=False)
        self._rows: tuple[Row, ...] = ()

    @property
    def shown(self) -> str:
        """The rows as text."""
        return "\n".join(text for text, _ in self._rows)

    def show(self, rows: Sequence[Row]) -> None:
        """Show these rows from now on."""
        if tuple(rows) != self._rows:
            self._rows = tuple(rows)
            # cut once more: an escape is longer than what it stands for
            fitting = ((printable(text)[: len(text)], style) for text, style in rows)
            lines = (Content.styled(text, style) for text, style in fitting)
            self.update(Content("\n").join(lines))
