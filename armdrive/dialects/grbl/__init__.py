"""The registry entry of the GRBL boards: their abilities and the defaults of an arm file.

Read in this order:

    controller   an arm's requests: which collaborator carries out each
    board        what is known of a board: its state, its position, alarms, restarts
    exchange     a line and its answer, a query and its report, a reset; their timeouts
    contact      getting a board to read lines
    motion       how far ahead lines are sent, when a motion is over, homing
    stops        stopping, and the outputs that a reset switches off
    planner      a model of the board: how long its lines take, and how it stops
    settings     the `[grbl]` section and the board's own settings
    variants     how the firmwares of the family differ, as a table
    words        messages in words, and recognition
"""

from __future__ import annotations

from armdrive.abilities import Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects import Dialect, on_demand

ENTRY = Dialect(
    name="grbl",
    title="GRBL board",
    preset="minimover5",
    baud=115_200,
    torque=Torque(
        disable="sags: `$SLP` puts the board and its motors to sleep",
        estop="sags for 0.5 s in motion (`ALARM:3`), then is held; grblHAL and FluidNC hold it",
        power_loss="sags, and the position is zero afterwards",
        closed_port="is held where `$1` is 255; opening the port resets most boards",
    ),
    abilities=Abilities(
        motors=6,
        coordinated=True,
        abort=Abort.RAMP,
        queued_segments=15,
        reports_while_moving=True,
        own_homing=True,
        resets_on_open=True,
        current=Switching.DROPS,
        jog_burst_s=0.15,
        planned_burst_s=0.4,
        traffic=Traffic(line_chars=34, answer_chars=4),
        register_bits=32,
        ramp_s=0.15,
        jerk_s=0.05,
        inputs=11,
        outputs=8,
    ),
    driver=on_demand("armdrive.dialects.grbl.controller:DRIVER"),
    tools=on_demand("armdrive.dialects.grbl.words:TOOLS"),
)
