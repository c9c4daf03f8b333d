"""Builds a desk for an arm, runs it, and reports how it was left."""

from __future__ import annotations

import contextlib
import pkgutil
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType

from armdrive import Arm
from armdrive.render.canvas import draws_braille
from tui.desk import Desk, DeskScreen
from tui.jog.screen import JogScreen
from tui.keys.keyboard import DEFAULT_KEYS, Keyboard
from tui.log import LogScreen
from tui.move import MoveScreen
from tui.settings import memory_file
from tui.terminal import forget_a_closed_terminal


def _on_demand(place: str) -> Callable[[], DeskScreen]:
    """Return a function that imports the screen at a place, `package.module:Name`, and makes one.

    What such a screen needs takes as long to load as the desk itself: setting up probes ports,
    programs and points have a parser.
    """

    def made() -> DeskScreen:
        screen: DeskScreen = pkgutil.resolve_name(place)()
        return screen

    return made


# What makes each screen of the desk, by its id in `tui.keys.table.SCREENS`.
SCREEN_FACTORIES: Mapping[str, Callable[[], DeskScreen]] = MappingProxyType(
    {
        "jog": JogScreen,
        "move": MoveScreen,
        "points": _on_demand("tui.points:PointsScreen"),
        "log": LogScreen,
        "setup": _on_demand("tui.setup:SetupScreen"),
        "program": _on_demand("tui.program:ProgramScreen"),
    }
)


def run_desk(
    arm: Arm,
    *,
    ascii_only: bool = False,
    keys: Keyboard = DEFAULT_KEYS,
    first: str = "",
    hint: str = "",
    program: Path | None = None,
) -> int:
    """Show the desk until the user leaves it, and return the exit code.

    `keys` is the keyboard. `first` is the id of the screen to begin at, instead of the first one;
    `hint` is the first message, `program` the file that the program screen begins with.
    However it ends, a stop has been requested; closing the arm remains the caller's duty,
    except after SIGTERM and SIGHUP, when it is closed at once.
    """
    braille = draws_braille(ascii_only=ascii_only)
    desk = Desk(
        arm,
        screens=SCREEN_FACTORIES,
        braille=braille,
        handle_signals=True,
        keys=keys,
        memory=memory_file(),
        first=first,
        program=program,
    )
    desk.message = desk.message or hint
    try:
        with short_turns():
            desk.run_or_raise()
    finally:
        arm.request_stop()
        forget_a_closed_terminal()
    return desk.return_code or 0


# How soon a thread of the desk has its turn: the one that speaks to the arm waits for no picture.
# The interpreter lets a thread that computes go on for 5 ms before another one that has been woken
# may run. A stop passes through three threads, while the one that paints is hardly ever at rest.

# `benchmarks/desk.py keys` shows what a stop gains by it, `painting` that it costs nothing.
TURN_S = 0.0005


@contextlib.contextmanager
def short_turns() -> Iterator[None]:
    """Make threads take turns quickly while this lasts, unless they do so already."""
    before_s = sys.getswitchinterval()
    sys.setswitchinterval(min(before_s, TURN_S))
    try:
        yield
    finally:
        sys.setswitchinterval(before_s)
