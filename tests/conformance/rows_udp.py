"""The same over UDP: a datagram that is lost, comes twice or late is told of by nobody."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from .behaviour import Behaviour
from .bench import Bench
from .faults import FAULTS
from .laws import survives_in_motion
from .rows_connecting import connect_moves_nothing
from .rows_jogging import a_held_jog_expires_by_itself
from .rows_moving import a_joint_motion_arrives
from .rows_reconnecting import a_wire_that_is_back_moves_nothing
from .rows_stopping import a_joint_motion_stops_within_its_bound

DATAGRAMS = tuple(fault for fault in FAULTS if fault.name.startswith("a message "))
"""What a network does to a datagram, as faults of the simulator."""


def _row(name: str, run: Callable[[Bench], None]) -> Behaviour:
    return Behaviour(f"over UDP, {name}", "UDP", run, transports=("udp",))


ROWS = (
    _row("connecting, idling and leaving move nothing", connect_moves_nothing),
    _row("a joint motion arrives", a_joint_motion_arrives),
    _row("a joint motion stops within its bound", a_joint_motion_stops_within_its_bound),
    _row("a held jog expires by itself", a_held_jog_expires_by_itself),
    _row("a port that was closed and is back moves nothing", a_wire_that_is_back_moves_nothing),
    *(_row(each.name, partial(survives_in_motion, fault=each)) for each in DATAGRAMS),
)
