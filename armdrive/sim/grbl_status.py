"""The status report of a simulated GRBL board, and how often it comes.

Source: gnea/grbl grbl/report.c and config.h: WCO comes with every 30th report while something
moves and every 10th while nothing does, Ov with every 20th and 10th, both at once after a change.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from armdrive.sim.grbl_settings import INCHES, REPORT
from firmware_protocol.grbl import State, StatusReport

if TYPE_CHECKING:
    from armdrive.sim.grbl_board import Board

GAP_S = 0.005
"""Reports come no closer than this: what is asked in between is answered once."""
BITS_A_BYTE = 10
_BUSY = (State.HOME, State.RUN, State.HOLD, State.JOG, State.DOOR)
_WCO_BUSY, _OV_BUSY, _IDLE = 30, 20, 10
_MPOS, _BUFFERS = 1, 2
_MINUTE_S = 60.0
MM_PER_INCH = 25.4


class Reporter:
    """Answers `?`. A report takes its time on the wire, and the next one waits for it."""

    def __init__(self, baud: int | None) -> None:
        self.asked = False
        self._byte_s = BITS_A_BYTE / baud if baud else 0.0
        self._free_s = -math.inf
        self.restart()

    def restart(self) -> None:
        """Begin as after a reset: the first report has the work offset."""
        self.asked = False
        self._until_wco = self._until_ov = 0

    def offset_changed(self) -> None:
        """Have the next report tell the work offset."""
        self._until_wco = 0

    def overrides_changed(self) -> None:
        """Have the next report tell the overrides."""
        self._until_ov = 0

    def due_s(self, board: Board) -> float:
        """Tell when a report is to be sent; infinity while none is, or none can be."""
        if not self.asked:
            return math.inf
        firmware = board.firmware
        silent = board.boot.active or (board.critical and firmware.mute_in_critical)
        if silent or (firmware.silent_in_homing and board.state is State.HOME):
            return math.inf
        return max(self._free_s, board.now_s)

    def report(self, board: Board) -> StatusReport:
        """Return the report of this moment."""
        self.asked = False
        per_unit = 1.0 / MM_PER_INCH if board.settings.on(INCHES) else 1.0
        position = tuple(at * per_unit for at in board.drive.units_of(board.drive.counts))
        offset = tuple(at * per_unit for at in board.parser.offset)
        mask = int(board.settings[REPORT])
        work = tuple(a - b for a, b in zip(position, offset, strict=True))
        told = bool(mask & _BUFFERS)
        wco, overrides = self._now_and_then(board.state in _BUSY)
        report = StatusReport(
            board.state,
            _sub_state(board),
            position if mask & _MPOS else None,
            None if mask & _MPOS else work,
            board.firmware.blocks - board.drive.queued(board.now_s) if told else None,
            board.ring.free if told else None,
            feed=float(round(board.drive.speed(board.now_s) * _MINUTE_S * per_unit)),
            speed=board.outputs.speed,
            pins=_pins(board),
            work_offset=offset if wco else None,
            overrides=tuple(board.overrides) if overrides else None,
            accessories=(board.outputs.letters or None) if overrides else None,
        )
        length = len(report.line) + 2
        self._free_s = board.now_s + max(GAP_S, length * self._byte_s)
        return report

    def _now_and_then(self, busy: bool) -> tuple[bool, bool]:
        """Count on, and tell whether the offset and the overrides are due; never both."""
        if self._until_wco == 0:
            self._until_wco = (_WCO_BUSY if busy else _IDLE) - 1
            self._until_ov = max(self._until_ov, 1)
            wco = True
        else:
            self._until_wco -= 1
            wco = False
        if self._until_ov == 0:
            self._until_ov = (_OV_BUSY if busy else _IDLE) - 1
            return wco, True
        self._until_ov -= 1
        return wco, False


def _sub_state(board: Board) -> int | None:
    if board.state is State.HOLD:
        return 0 if board.stands else 1
    if board.state is State.DOOR:
        return 0 if board.stands else 2
    return None


def _pins(board: Board) -> str | None:
    letters = "".join(
        letter for axis, letter in enumerate(board.axes) if board.switches.pressed(axis)
    )
    return (board.inputs + letters) or None
