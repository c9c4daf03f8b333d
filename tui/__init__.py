"""The desk: a terminal screen that jogs an arm."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tui.arm_port import DeskArm

__all__ = ["run_desk"]


def run_desk(arm: DeskArm, *, ascii_only: bool = False) -> int:
    """Show the desk until somebody leaves it, and return the exit code.

    However it ends, the arm has been told to stop; closing the arm remains the caller's duty,
    except after SIGTERM and SIGHUP, when it is closed at once.
    """
    import os
    import sys

    from armdrive.draw.terminal import can_braille
    from tui.desk import Desk
    from tui.framework import forget_a_closed_terminal

    braille = not ascii_only and can_braille(sys.stdout.encoding, os.environ)
    desk = Desk(arm, braille=braille, handle_signals=True)
    try:
        desk.run()
    finally:
        arm.request_stop()
        forget_a_closed_terminal()
    return desk.return_code or 0
