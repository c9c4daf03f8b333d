"""Driving CiA 402 drives on a CANopen bus.

Read in this order, after `dialects.bus`:

    controller   what the engine uses: the script of each request, frames, the bounds of stops
    drives       one drive: what it has reported, and what can be wrong with it
    exchange     what scripts work with: the drives, their cycles by SYNC, the heartbeat
    transfers    reading and writing objects of several drives by SDO, for motions and surveys
    states       holding, stopping, switching off, resetting faults
    contact      finding the drives, setting them up, switching their current, clearing faults
    motion       the one rule for all motions; cyclic targets, bursts by profile position
    homing       the drives' own search for their switches
    measuring    the units of a drive's speeds and ramps, by slow turns

The rest serves people: `settings` and `compare` for the arm file, `survey` asks the nodes of a bus
what they are, and `words` and `objects` describe frames and objects in words. No motion needs them.
"""

from __future__ import annotations

from armdrive.abilities import Torque, Traffic
from armdrive.dialects import on_demand
from armdrive.dialects.bus import bus_dialect

ENTRY = bus_dialect(
    "cia402",
    "CiA 402 drives",
    ("canopen", "CANopen"),
    driver=on_demand("armdrive.dialects.cia402.controller:DRIVER"),
    tools=on_demand("armdrive.dialects.cia402.survey:TOOLS"),
    torque=Torque(
        disable="sags: every drive switches its motor off",
        estop="is held: the drives brake on their quick-stop ramps and hold",
        power_loss="sags, and most drives count from zero afterwards",
        closed_port="is held: the drives miss the heartbeat, brake if they move, and hold",
    ),
    traffic=Traffic(line_chars=80, answer_chars=74),
    register_bits=32,
    silence="An idle bus is silent unless its drives produce heartbeats (object 1017)",
    beats=True,
)
