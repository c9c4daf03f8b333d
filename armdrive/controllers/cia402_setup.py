"""How CiA 402 drives are set up when contact is made with them: the objects that are written."""

from __future__ import annotations

import math

from armdrive.controllers.cia402_bus import setups
from armdrive.controllers.cia402_settings import Cia402Settings
from firmware_protocol.canopen import (
    CONSUMER_HEARTBEAT,
    FAULT_REACTION_OPTION,
    FOLLOWING_ERROR_TIMEOUT_MS,
    FOLLOWING_ERROR_WINDOW,
    HEARTBEAT_REACTION,
    NOT_VALID,
    PRODUCER_HEARTBEAT_MS,
    QUICK_STOP_DECELERATION,
    QUICK_STOP_OPTION,
    DataType,
    HeartbeatWatch,
    Place,
    QuickStopOption,
    Service,
    Write,
    cob_id,
)

QUICK_STOP = 3
"""Of object 6007: a drive that misses the heartbeat makes a quick stop."""
BRAKE = 2
"""Of object 605E: a drive in fault brakes before it lets its motor go."""
PERIOD, PERIOD_UNIT = Place(0x60C2, 1), Place(0x60C2, 2)
MILLISECONDS = -3
BUSY_AT_MOST = 0.7
"""How much of a bus's time the cyclic frames may take."""
FRAME_BITS, SYNC_BITS = 123, 56
"""Of a PDO of seven bytes and of a SYNC, with stuffing and the space behind."""
_OTHERS = (
    (0x1401, Service.RPDO2),
    (0x1402, Service.RPDO3),
    (0x1403, Service.RPDO4),
    (0x1801, Service.TPDO2),
    (0x1802, Service.TPDO3),
    (0x1803, Service.TPDO4),
)


def period_ms(settings: Cia402Settings, drives: int, bit_rate: int) -> int:
    """Return the period of SYNC: the arm file's, or a longer one that the bus can carry."""
    bits = 2 * drives * FRAME_BITS + SYNC_BITS
    return max(settings.period_ms, math.ceil(1000.0 * bits / bit_rate / BUSY_AT_MOST))


def needed(node: int, quick_slope: float, cycle_ms: int | None) -> tuple[Write, ...]:
    """Return what no drive can do without. `quick_slope` is in increments a second squared.

    `cycle_ms` is None where no cyclic mode is used.
    """
    received, transmitted = setups(node)
    cyclic = (
        Write(PERIOD, DataType.U8, cycle_ms or 0),
        Write(PERIOD_UNIT, DataType.I8, MILLISECONDS),
    )
    return (
        *received.writes,
        *transmitted.writes,
        Write(HEARTBEAT_REACTION, DataType.I16, QUICK_STOP),
        Write(QUICK_STOP_OPTION, DataType.I16, QuickStopOption.QUICK_RAMP_AND_STAY),
        Write(QUICK_STOP_DECELERATION, DataType.U32, max(round(quick_slope), 1)),
        *(cyclic if cycle_ms else ()),
    )


def wished(settings: Cia402Settings, node: int) -> tuple[Write, ...]:
    """Return what a drive is better with: some do not have all of it."""
    silenced = (
        Write(Place(index, 1), DataType.U32, cob_id(service, node) | NOT_VALID)
        for index, service in _OTHERS
    )
    return (
        Write(FAULT_REACTION_OPTION, DataType.I16, BRAKE),
        Write(FOLLOWING_ERROR_WINDOW, DataType.U32, settings.following_window),
        Write(FOLLOWING_ERROR_TIMEOUT_MS, DataType.U16, settings.following_ms),
        Write(PRODUCER_HEARTBEAT_MS, DataType.U16, settings.drive_beat_ms),
        *silenced,
    )


def watch(settings: Cia402Settings, *, on: bool) -> Write:
    """Return what has a drive mind this program's heartbeat, or nobody's."""
    wanted = HeartbeatWatch(settings.master_id, settings.heartbeat_ms * on)
    return Write(CONSUMER_HEARTBEAT, DataType.U32, wanted.value if on else 0)
