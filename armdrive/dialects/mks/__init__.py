"""Driving MKS SERVO42D/57D drives on a CAN bus.

Read in this order, after `dialects.bus`:

    controller   an arm's requests: which script carries out each; the announced bounds
    drive        one drive: its orders, the replies that it owes, and what its readings show
    exchange     what scripts work with: the drives, frames to them and their replies
    contact      finding the drives, their firmware, why they do not move; switching their current,
                 clearing stalls
    motion       a motion, from the first order until all drives stand: targets along a path,
                 updated while the drives move, or bursts; what ends it
    stops        stopping, and relieving drives that push against an obstacle
    homing       the drives' own search for their switches

The rest serves people: `settings` and `compare` for the arm file, `survey` and `commissioning` for
a bus and its drives, `words` for the traffic on it.
"""

from __future__ import annotations

from armdrive.abilities import Torque, Traffic
from armdrive.dialects import on_demand
from armdrive.dialects.bus import bus_dialect

ENTRY = bus_dialect(
    "mks",
    "MKS servo drives",
    ("mks", "MKS drives"),
    driver=on_demand("armdrive.dialects.mks.controller:DRIVER"),
    tools=on_demand("armdrive.dialects.mks.commissioning:TOOLS"),
    torque=Torque(
        disable="sags: every drive switches its motor off",
        estop="is held: the drives stop dead and hold; above 1000 rpm they ramp down",
        power_loss="sags, and the drives count from zero afterwards",
        closed_port="is held: the drives stand and hold, even on a silent bus",
    ),
    traffic=Traffic(line_chars=78, answer_chars=60),
    register_bits=48,
    silence="An idle bus of these drives is silent: they only answer questions",
)
