"""FluidNC's own way to name settings: `$/stepping/idle_ms`, and `=255` behind it to change it.

What is changed lasts until the power is gone on a real board: its file is another matter.
"""

from __future__ import annotations

import math
import re
from collections.abc import Generator

from armdrive.sim.grbl_board import Board
from armdrive.sim.grbl_settings import ACCELERATION, IDLE_MS, RATE, STEPS, TRAVEL
from firmware_protocol.grbl import Setting, State

Steps = Generator[float, None, int]
UNKNOWN, NO_NUMBER, NOT_IDLE = 3, 2, 8
FIRST_TOLD = 10
"""Of the numbered settings `$$` lists those from here on."""
_LINE = re.compile(r"\$/([a-z0-9_/]+)(?:=(.*))?", re.IGNORECASE)
_AXIS = re.compile(r"axes/([a-z])/(\w+)")
_OF_AXIS = {
    "steps_per_mm": STEPS,
    "max_rate_mm_per_min": RATE,
    "acceleration_mm_per_sec2": ACCELERATION,
    "max_travel_mm": TRAVEL,
}


def named_path(line: str) -> tuple[str, str | None] | None:
    """Return the path that a line names, and the value that it sets; None for any other line."""
    found = _LINE.fullmatch(line)
    return None if found is None else (found[1].lower(), found[2])


def run_path(board: Board, path: str, value: str | None) -> Steps:
    """Tell a setting, or change it."""
    yield from ()
    number = _number(board, path)
    if number is None:
        return UNKNOWN
    if value is None:
        text = dict(board.settings.written())[number]
        board.say(Setting(f"/{path}", text))
        return 0
    if board.state not in (State.IDLE, State.ALARM):
        return NOT_IDLE
    try:
        given = float(value)
    except ValueError:
        return NO_NUMBER
    if not math.isfinite(given):
        return NO_NUMBER
    code = board.settings.store(number, given)
    board.drive.rack.limits = board.settings.limits()
    return code


def _number(board: Board, path: str) -> int | None:
    if path == "stepping/idle_ms":
        return IDLE_MS
    found = _AXIS.fullmatch(path)
    if found is None or found[1].upper() not in board.axes or found[2] not in _OF_AXIS:
        return None
    return _OF_AXIS[found[2]] + board.axes.index(found[1].upper())
