"""One row of the table of keys."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class DeskKey:
    """One thing to do, and the keys that do it, named as the framework names them.

    `place` is the screen (or kind of dialog) on which they do it; without one it is all screens.
    `everywhere` keys work in every dialog too, before anything else. Those without a description
    stand in no footer.
    """

    id: str
    keys: tuple[str, ...]
    action: str
    description: str
    tooltip: str
    place: str = ""
    everywhere: bool = False
