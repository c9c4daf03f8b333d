"""The screens of the desk, in one table: function keys, palette and help are made from it.

A screen is a row here and a `DeskScreen` in a file of its own (base.py says what that needs).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tui.screens.base import DeskScreen


@dataclass(frozen=True, slots=True)
class Entry:
    """One screen: its key, what it is called, and what it is for in a few words.

    `home` is module and class, imported when the screen is first shown: the desk starts sooner.
    """

    id: str
    key: str
    title: str
    summary: str
    home: tuple[str, str]

    @property
    def make(self) -> Callable[[], DeskScreen]:
        """Return what makes the screen."""
        module, name = self.home

        def made() -> DeskScreen:
            screen: DeskScreen = getattr(import_module(module), name)()
            return screen

        return made


SCREENS = (
    Entry("jog", "f2", "jog", "Move the arm by hand, joint by joint or the tip along a line.",
          ("tui.screens.jog", "JogScreen")),
    Entry("move", "f3", "move", "Type a goal, see what the motion would be, then move.",
          ("tui.screens.move", "MoveScreen")),
    Entry("points", "f4", "points", "Name places, go back to them, step through sequences.",
          ("tui.screens.points", "PointsScreen")),
    Entry("setup", "f5", "set-up", "Find an arm, describe it in a file, and check its motors.",
          ("tui.screens.setup", "SetupScreen")),
    Entry("theory", "f6", "theory", "Matrices, Jacobian, singularities of the arm as it stands.",
          ("tui.screens.theory", "TheoryScreen")),
    Entry("log", "f7", "log", "What passes between the arm and this program, in words.",
          ("tui.screens.log", "LogScreen")),
)  # fmt: skip
"""The first one is shown first."""


def summary_of(screen: str) -> str:
    """Say which screen this is and what it is for; nothing of one that stands in no table."""
    found = (f"{entry.title}: {entry.summary}" for entry in SCREENS if entry.id == screen)
    return next(found, "")


def titled(screen: str) -> str:
    """Return what a screen is called; its id where it stands in no table (dialogs)."""
    return next((entry.title for entry in SCREENS if entry.id == screen), screen)
