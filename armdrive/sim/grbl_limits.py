"""Hard limits of a simulated GRBL board: a switch that changes while the board is not homing.

The firmware's interrupt comes with either edge of any of the switches, so that backing off a
switch is an alarm as well. Source: gnea/grbl grbl/limits.c.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from armdrive.sim.grbl_settings import HARD_LIMITS
from firmware_protocol.grbl import State

if TYPE_CHECKING:
    from armdrive.sim.grbl_board import Board

TICK_S = 0.005
"""How often the switches are looked at while something moves."""
HARD_LIMIT = 1


class HardLimits:
    """Looks at the switches; `due_s` is when to call `look` next."""

    def __init__(self) -> None:
        self.due_s = math.inf
        self._pressed = 0

    def plan(self, board: Board) -> None:
        """Find out when to look next."""
        limited = _in_force(board) and board.state is not State.HOME
        if not (limited and board.drive.moving) or board.critical:
            self.due_s = math.inf
        elif math.isinf(self.due_s):
            self.due_s = board.now_s + TICK_S

    def look(self, board: Board) -> None:
        """Raise the alarm where a switch has changed."""
        before = self._pressed
        self.forget(board)
        deaf = board.state in (State.ALARM, State.HOME) or board.boot.active
        if self._pressed != before and _in_force(board) and not deaf:
            board.alarm(HARD_LIMIT)

    def forget(self, board: Board) -> None:
        """Take the switches as they are."""
        self.due_s = math.inf
        self._pressed = board.switches.mask()


def _in_force(board: Board) -> bool:
    """Tell whether a switch that changes is an alarm: not every build acts on $21=1."""
    return board.firmware.hard_limits and board.settings.on(HARD_LIMITS)
