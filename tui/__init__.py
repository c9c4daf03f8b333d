"""The desk: terminal screens from which a person drives an arm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kinematics import ArmModel
    from tui.arm_port import DeskArm
    from tui.keyboard import Keyboard
    from tui.pad_reader import Pad

__all__ = ["DeskEnd", "run_desk", "run_watch"]


@dataclass(frozen=True, slots=True)
class DeskEnd:
    """How a desk was left: its exit code, and the arm file that the next one is wanted for."""

    code: int = 0
    opens: Path | None = None


def run_desk(
    arm: DeskArm,
    *,
    ascii_only: bool = False,
    keys: Keyboard | None = None,
    first: str = "",
    hint: str = "",
    reopens: bool = False,
    gamepad: str | None = None,
) -> DeskEnd:
    """Show the desk until somebody leaves it, and return how that was.

    `keys` is the keyboard; without one it is the user's own file of keys, where there is one.
    `first` is the id of the screen to begin at, instead of the one that was left; `hint` is said
    at the beginning. With `reopens` the caller opens another desk where an arm file that was
    written here is to be used at once. `gamepad` are letters of the name of the gamepad that jogs
    as well, none of them for the only one; raises `BadRequest` where none can be read.
    However it ends, the arm has been told to stop; closing the arm remains the caller's duty,
    except after SIGTERM and SIGHUP, when it is closed at once.
    """
    import os
    import sys

    from armdrive.render.canvas import can_braille
    from tui.desk import Desk
    from tui.framework import forget_a_closed_terminal
    from tui.memory import memory_file
    from tui.remap import load_keys
    from tui.turns import short_turns

    if keys is None:
        keys = load_keys(None)
    braille = not ascii_only and can_braille(sys.stdout.encoding, os.environ)
    memory = memory_file()
    find_pad = None if gamepad is None else _finds_pad(gamepad)
    desk = Desk(
        arm,
        braille=braille,
        handle_signals=True,
        keys=keys,
        memory=memory,
        first=first,
        find_pad=find_pad,
    )
    desk.reopens = reopens
    desk.message = hint or desk.message
    try:
        with short_turns():
            desk.run_or_raise()
    finally:
        arm.request_stop()
        forget_a_closed_terminal()
    return DeskEnd(desk.return_code or 0, desk.opens)


def _finds_pad(wanted: str) -> Callable[[], Pad | None]:
    from functools import partial

    from tui.pad_evdev import check_gamepads, open_gamepad

    return partial(open_gamepad, wanted, check_gamepads())


def run_watch(
    name: str, model: ArmModel, *, ascii_only: bool = False, keys: Keyboard | None = None
) -> int:
    """Show an arm that another program drives, until somebody leaves; return the exit code.

    Nothing here moves the arm, and leaving does not stop it.
    """
    import os
    import sys

    from armdrive.render.canvas import can_braille
    from tui.held_arm import HeldArm
    from tui.memory import memory_file, recall
    from tui.remap import load_keys
    from tui.watching import Watching

    if keys is None:
        keys = load_keys(None)
    braille = not ascii_only and can_braille(sys.stdout.encoding, os.environ)
    look = recall(memory_file()).look
    app = Watching(name, model, HeldArm(name), braille=braille, keys=keys, look=look)
    app.run_or_raise()
    return app.return_code or 0
