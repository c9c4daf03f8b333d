"""How the desk is laid out, and the framework's bindings made from the table of keys."""

from __future__ import annotations

from collections.abc import Iterable

from textual.binding import Binding, BindingType

from tui.key_row import DeskKey
from tui.keys import TABLE

CSS = """
#title, #footer { height: 1; text-style: reverse; }
#title.-real { background: $error; color: $text; text-style: bold; }
#banner { height: auto; display: none; background: $error; color: $text; text-style: bold; }
#banner.-shown { display: block; }
#body { height: 1fr; }
#remarks { height: auto; min-height: 1; max-height: 4; }
ArmView { height: 1fr; }
ModalScreen { align: center middle; }
SearchIcon { display: none; }
.dialog { width: 90%; max-width: 100; height: 90%; border: solid $primary; padding: 0 1; }
.short { height: auto; }
.dialog PlainText { height: auto; }
"""


def bindings(*places: str) -> list[BindingType]:
    """Make the framework's bindings of the rows that count at these places; "" is the desk itself.

    A file of keys changes them later, by their ids.
    """
    return bindings_of(row for row in TABLE if row.place in places)


def bindings_of(rows: Iterable[DeskKey]) -> list[BindingType]:
    """Make the framework's bindings of these rows."""
    return [
        Binding(
            ",".join(row.keys),
            row.action,
            row.description,
            tooltip=row.tooltip,
            priority=row.everywhere,
            show=bool(row.description),
            id=row.id,
        )
        for row in rows
    ]
