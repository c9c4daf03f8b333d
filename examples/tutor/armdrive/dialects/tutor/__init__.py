"""What a Tutor board can do, and how it is used where no arm file says otherwise."""

from __future__ import annotations

from armdrive.abilities import Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects.dialect import DeviceTools, Dialect, Driver


def _driver() -> Driver:
    from armdrive.dialects.tutor.controller import DRIVER

    return DRIVER


def _tools() -> DeviceTools:
    from armdrive.dialects.tutor.words import TOOLS

    return TOOLS


ENTRY = Dialect(
    name="tutor",
    title="Tutor board",
    preset="minimover5",
    baud=115_200,
    raise_dtr=False,
    quick_stop="The switch of the motors' supply is the quicker stop: the arm sags then.",
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
        queued_segments=0,
        speed_mode_with_watchdog=False,
        reports_while_moving=False,
        own_homing=False,
        resets_on_open=False,
        check_bytes=False,
        current=Switching.NONE,
        grip_switch=False,
        pendant=False,
        jog_burst_s=0.15,
        planned_burst_s=0.15,
        traffic=Traffic(line_chars=30, answer_chars=3),
        register_bits=32,
    ),
    driver=_driver,
    tools=_tools,
)
