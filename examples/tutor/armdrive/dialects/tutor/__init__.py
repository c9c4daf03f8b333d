"""What a Tutor board can do, and how it is used where no arm file says otherwise."""

from __future__ import annotations

from armdrive.abilities import Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects import Dialect, on_demand

ENTRY = Dialect(
    name="tutor",
    title="Tutor board",
    preset="minimover5",
    baud=115_200,
    torque=Torque(
        disable="is held: nothing switches the current off",
        estop="is held: the burst under way is finished, and the current stays on",
        power_loss="sags, and the positions are zero afterwards",
        closed_port="is held: nothing is sent",
    ),
    abilities=Abilities(
        motors=6,
        coordinated=True,
        abort=Abort.NONE,
        current=Switching.NONE,
        jog_burst_s=0.15,
        planned_burst_s=0.15,
        traffic=Traffic(line_chars=30, answer_chars=3),
        register_bits=32,
    ),
    driver=on_demand("armdrive.dialects.tutor.controller:DRIVER"),
    tools=on_demand("armdrive.dialects.tutor.words:TOOLS"),
)
