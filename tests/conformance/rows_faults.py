"""Behaviours under faults: a row for each fault and moment, made from the table of faults."""

from __future__ import annotations

from functools import partial

from armdrive.status import State, Trust

from .behaviour import Behaviour
from .bench import Bench
from .faults import FAULTS
from .going import joints_from
from .laws import survives_in_motion, survives_while_idle
from .rows_moving import arrived
from .seen import check

IN_SIMULATION = ("memory", "pty", "tcp")


def replugged_under_another_name(bench: Bench) -> None:
    arm = bench.ready()
    arm.move_j(**joints_from(arm))
    bench.fault("unplug")
    bench.sleep(1.5)
    check(arm.status.state is State.DISCONNECTED, f"the cable is out: {arm.status.state}")
    bench.replug_elsewhere()
    arm = bench.connect()
    check(arm.status.trust is not Trust.REFERENCED, "a position was trusted without asking")
    bench.refer(arm)
    arm.move_j(**joints_from(arm, -10.0, 5.0))
    arrived(bench, arm)


ROWS = (
    *(
        Behaviour(f"{fault.name}, in motion", "fault", partial(survives_in_motion, fault=fault),
                  needs=fault.needs, transports=IN_SIMULATION)
        for fault in FAULTS
    ),
    *(
        Behaviour(f"{fault.name}, standing", "fault", partial(survives_while_idle, fault=fault),
                  needs=fault.needs, transports=IN_SIMULATION)
        for fault in FAULTS
        if fault.idle
    ),
    Behaviour("plugged in again under another name", "fault", replugged_under_another_name,
              transports=("memory", "pty")),
)  # fmt: skip
