"""What lines wait for on a simulated GRBL board, as parts of their scripts."""

from __future__ import annotations

import math
from collections.abc import Generator

from armdrive.sim.grbl_board import Board
from armdrive.sim.path_rack import SEGMENT_S
from firmware_protocol.grbl import State

Waits = Generator[float, None, None]


def until_still(board: Board) -> Waits:
    """Wait until everything queued has been driven."""
    while board.drive.rack.waiting or board.state is State.RUN:
        board.autostart()
        yield math.inf


def until_room(board: Board) -> Waits:
    """Wait until the planner takes one more line: one leaves it with its last segment."""
    while board.full:
        board.autostart()
        yield board.now_s + SEGMENT_S


def write_eeprom(board: Board) -> Waits:
    """Write, with the interrupts off on some boards: what arrives meanwhile is lost."""
    if board.firmware.deaf_in_eeprom:
        board.deaf_until_s = board.now_s + board.firmware.eeprom_s
    yield board.now_s + board.firmware.eeprom_s
