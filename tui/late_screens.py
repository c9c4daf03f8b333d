"""The screens that are loaded when one of them is first shown.

What they need takes as long to load as the desk itself: setting up probes ports, theory has the
textbook, programs have a parser.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from tui.desk import DeskScreen
from tui.program import ProgramScreen
from tui.setup import SetupScreen
from tui.theory import TheoryScreen

LATE_SCREENS: Mapping[str, Callable[[], DeskScreen]] = MappingProxyType(
    {each.place: each for each in (SetupScreen, TheoryScreen, ProgramScreen)}
)
"""These screens by their ids."""
