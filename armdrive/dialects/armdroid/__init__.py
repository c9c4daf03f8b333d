"""The Armdroid's abilities and its defaults for connection and behaviour.

Which file decides what:

    controller   an arm's requests, and the bounds of its stops
    exchange     commands that move nothing, and their answers
    settings     what differs from arm to arm
    words        messages in words, and recognition
"""

from __future__ import annotations

from armdrive.abilities import Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects import Dialect, on_demand

ENTRY = Dialect(
    name="armdroid",
    title="Armdroid 1",
    preset="armdroid1",
    baud=9600,
    raise_dtr=True,
    quick_stop="Only the motors' power switch stops faster; the arm then sags.",
    torque=Torque(
        disable="sags: `0t` switches the current off; firmware before 2.0 cannot, and holds",
        estop="is held: the burst under way is finished, and the current stays on",
        power_loss="sags; a reset of the board alone is up to the interface",
        closed_port="is held, unless the board is reset by the next opening of its port",
    ),
    abilities=Abilities(
        motors=6,
        coordinated=False,
        abort=Abort.NONE,
        resets_on_open=True,
        current=Switching.BOTH,
        jog_burst_s=0.15,
        planned_burst_s=0.15,
        traffic=Traffic(line_chars=22, answer_chars=60, device_s=0.2),
        register_bits=16,
    ),
    driver=on_demand("armdrive.dialects.armdroid.controller:DRIVER"),
    tools=on_demand("armdrive.dialects.armdroid.words:TOOLS"),
)
