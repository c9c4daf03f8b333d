"""Driving CiA 402 drives on a CANopen bus.

Read in this order, after `dialects.bus`:

    controller   requests of an arm: which collaborator carries out each
    wire         frames out, events in, and what is known of each drive
    exchange     turns by SYNC, looks, ways between states, objects by SDO
    contact      finding the drives, setting them up, switching them on and off, clearing faults
    leading      what all motions share: beginning, returning, arriving, stopping
    motion       cyclic targets, bursts by profile, homing

The rest is for people: `settings` for the arm file, `survey` for a bus, `words` and `objects` for
what passes on it.

Here is the row of the registry: what such an arm can do, and how it is used where no arm file says
otherwise.
"""

from __future__ import annotations

from armdrive.abilities import Torque, Traffic
from armdrive.dialects.bus import row
from armdrive.dialects.dialect import DeviceTools, Dialect, Driver, Language


def _driver() -> Driver:
    from armdrive.dialects.cia402.controller import DRIVER

    return DRIVER


def _tools() -> DeviceTools:
    from armdrive.dialects.cia402.survey import TOOLS

    return TOOLS


ENTRY = Dialect(
    name="cia402",
    title="CiA 402 drives",
    preset="minimover5-cia402",
    baud=row.BITS_S,
    raise_dtr=False,
    quick_stop=row.QUICK_STOP,
    torque=Torque(
        disable="sags: every drive switches its motor off",
        estop="is held: the drives brake on their quick-stop ramps and hold",
        power_loss="sags, and most drives count from zero afterwards",
        closed_port="is held: the drives miss the heartbeat, brake if they move, and hold",
    ),
    abilities=row.abilities(Traffic(line_chars=80, answer_chars=74), register_bits=32, beats=True),
    driver=_driver,
    tools=_tools,
    language=Language(
        "canopen",
        "CANopen",
        _tools,
        "An idle bus is silent where no drive was told to say heartbeats (object 1017)",
    ),
)
