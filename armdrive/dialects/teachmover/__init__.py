"""The registry entry of the TeachMover: its abilities and the defaults of an arm file.

Which file decides what:

    controller   an arm's requests, and the bounds of its stops
    settings     what differs from arm to arm
    pendant      the program in the arm's memory: rows, file, meaning
    words        messages in words, and recognition
"""

from __future__ import annotations

from armdrive.abilities import Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects import Dialect, on_demand

ENTRY = Dialect(
    name="teachmover",
    title="TeachMover",
    preset="teachmover",
    baud=9600,
    quick_stop="The pendant's STOP key stops faster; it ends a burst at once.",
    torque=Torque(
        disable="sags: `@RESET` switches the current off until the next motion",
        estop="is held: the burst under way is finished, and the current stays on",
        power_loss="sags, and the registers are zero afterwards",
        closed_port="is held: nothing is sent, and DTR and RTS stay down",
    ),
    abilities=Abilities(
        motors=6,
        coordinated=True,
        abort=Abort.NONE,
        current=Switching.DROPS,
        grip_switch=True,
        jog_burst_s=0.15,
        planned_burst_s=0.15,
        traffic=Traffic(line_chars=36, answer_chars=2),
        register_bits=16,
        program_rows=64,
        inputs=7,
        outputs=8,
    ),
    driver=on_demand("armdrive.dialects.teachmover.controller:DRIVER"),
    tools=on_demand("armdrive.dialects.teachmover.words:TOOLS"),
)
