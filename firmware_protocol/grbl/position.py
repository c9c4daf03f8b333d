"""Machine position and work position out of reports that give one of them.

WPos = MPos - WCO, and the offset (WCO) is reported now and then: at once when it has changed.
"""

from __future__ import annotations

from collections.abc import Callable
from operator import add, sub
from typing import TypeAlias

from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.grbl.status import StatusReport

Coordinates: TypeAlias = tuple[float, ...]
_DECIMALS = 6
"""Sums of reported numbers are rounded to these; reports have three or four."""


class Positions:
    """Remembers the work offset of one run of the board."""

    def __init__(self) -> None:
        self._offset: Coordinates | None = None

    def of(self, report: StatusReport, axes: int) -> tuple[Coordinates | None, Coordinates | None]:
        """Return machine position and work position, None where it cannot be known.

        Raises `RemoteProtocolError` where the report has another number of axes: a damaged line,
        or a board that was built otherwise than its owner believes.
        """
        for values in (report.machine_position, report.work_position, report.work_offset):
            if values is not None and len(values) != axes:
                raise RemoteProtocolError(
                    f"{len(values)} coordinates, but the board has {axes} axes"
                )
        if report.work_offset is not None:
            self._offset = report.work_offset
        machine, work = report.machine_position, report.work_position
        if machine is None:
            return self._shifted(work, add), work
        return machine, self._shifted(machine, sub)

    def _shifted(
        self, values: Coordinates | None, how: Callable[[float, float], float]
    ) -> Coordinates | None:
        if values is None or self._offset is None or len(self._offset) != len(values):
            return None
        return tuple(round(how(a, b), _DECIMALS) for a, b in zip(values, self._offset, strict=True))
