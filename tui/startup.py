"""Runs the desk of an arm, and reports how it was left."""

from __future__ import annotations

import sys
from pathlib import Path

from armdrive import Arm
from armdrive.render.canvas import draws_braille
from tui.desk import Desk
from tui.keys.keyboard import DEFAULT_KEYS, Keyboard
from tui.settings import memory_file
from tui.terminal import forget_a_closed_terminal

# The interpreter lets a thread that computes go on for 5 ms before another one that has been woken
# may run. A stop passes through three threads, while the one that paints is hardly ever at rest.
# `benchmarks/desk.py keys` shows what a stop gains by it, `painting` that it costs nothing.
TURN_S = 0.0005


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
    desk = Desk(
        arm,
        braille=draws_braille(ascii_only=ascii_only),
        handle_signals=True,
        keys=keys,
        memory=memory_file(),
        first=first,
        program=program,
    )
    desk.message = desk.message or hint
    before_s = sys.getswitchinterval()
    sys.setswitchinterval(TURN_S)
    try:
        desk.run_or_raise()
    finally:
        sys.setswitchinterval(before_s)
        arm.request_stop()
        forget_a_closed_terminal()
    return desk.return_code or 0
