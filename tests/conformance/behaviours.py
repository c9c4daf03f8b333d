"""The table of behaviours: all families, in the order in which the page shows them."""

from __future__ import annotations

from . import rows_connecting, rows_faults, rows_moving, rows_stopping
from .behaviour import Behaviour

BEHAVIOURS: tuple[Behaviour, ...] = (
    *rows_connecting.ROWS,
    *rows_moving.ROWS,
    *rows_stopping.ROWS,
    *rows_faults.ROWS,
)
