"""The table of behaviours: all families, in the order in which the page shows them."""

from __future__ import annotations

from . import (
    rows_conducting,
    rows_connecting,
    rows_faults,
    rows_gripping,
    rows_homing,
    rows_jogging,
    rows_moving,
    rows_neighbours,
    rows_reconnecting,
    rows_stopping,
    rows_udp,
)
from .behaviour import Behaviour

BEHAVIOURS: tuple[Behaviour, ...] = (
    *rows_connecting.ROWS,
    *rows_reconnecting.ROWS,
    *rows_homing.ROWS,
    *rows_moving.ROWS,
    *rows_gripping.ROWS,
    *rows_jogging.ROWS,
    *rows_stopping.ROWS,
    *rows_conducting.ROWS,
    *rows_neighbours.ROWS,
    *rows_faults.ROWS,
    *rows_udp.ROWS,
)
