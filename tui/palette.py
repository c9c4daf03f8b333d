"""The command palette: what can be done at this place and everywhere, from the tables."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from textual.app import SystemCommand
from textual.command import CommandPalette
from textual.widgets import Input

from tui.key_row import DeskKey
from tui.keyboard import label
from tui.themes import LOOKS

if TYPE_CHECKING:
    from tui.desk import Desk

NOT_LISTED = ("palette",)


class StillPalette(CommandPalette):
    """The framework's, with a cursor that does not blink.

    A blinking one is painted for as long as nobody types, and is there in one picture only of two.
    """

    def on_mount(self) -> None:
        """Hold the cursor still."""
        self.query_one(Input).cursor_blink = False


def commands(desk: Desk) -> Iterator[SystemCommand]:
    """Yield everything that is not a motion held by a key, and the looks."""
    for row in desk.keys.at(desk.place.place):
        if row.description and row.id not in NOT_LISTED:
            title, more = _said(row)
            yield SystemCommand(title, more, partial(_run, desk, row))
    for look in LOOKS:
        yield SystemCommand(f"look: {look.name}", look.summary, partial(desk.look, look.name))


def _said(row: DeskKey) -> tuple[str, str]:
    """Return what is searched and what is only read: names and first sentence, and the rest."""
    first, _, rest = row.tooltip.partition(". ")
    return f"{row.description} ({label(row.keys[0])}): {first.removesuffix('.')}", rest


async def _run(desk: Desk, row: DeskKey) -> None:
    await desk.run_action(row.action, desk.place if row.place else desk)
