"""The Robko 01's abilities and its defaults for connection and behaviour.

Which file decides what:

    controller   an arm's requests, and the bounds of its stops
    exchange     a message and its answer, and what is done about a lost one
    motion       when the motors count as arrived or standing
    settings     what differs from arm to arm, and the speeds of its motors
    words        messages in words, and recognition
"""

from __future__ import annotations

from armdrive.abilities import Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects import Dialect, on_demand

ENTRY = Dialect(
    name="robko01",
    title="Robko 01",
    preset="robko01",
    baud=115_200,
    quick_stop="The power supply's switch stops faster; the arm then sags.",
    torque=Torque(
        disable="sags: the motors are switched off",
        estop="is held: the burst ramps down; whether an AVR board holds, feel once",
        power_loss="sags, and the registers are zero afterwards",
        closed_port="is held on a serial port; sags when the retrofit's TCP link ends",
    ),
    abilities=Abilities(
        motors=6,
        coordinated=False,
        abort=Abort.RAMP,
        reports_while_moving=True,
        current=Switching.BOTH,
        jog_burst_s=0.25,
        planned_burst_s=0.5,
        traffic=Traffic(line_chars=32, answer_chars=12),
        register_bits=16,
        inputs=8,
        outputs=8,
    ),
    driver=on_demand("armdrive.dialects.robko01.controller:DRIVER"),
    tools=on_demand("armdrive.dialects.robko01.words:TOOLS"),
)
