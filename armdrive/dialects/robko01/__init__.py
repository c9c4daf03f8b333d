"""The Robko 01's abilities and its defaults for connection and behaviour."""

from __future__ import annotations

from armdrive.abilities import Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects.dialect import DeviceTools, Dialect, Driver


def _driver() -> Driver:
    from armdrive.dialects.robko01.controller import DRIVER

    return DRIVER


def _tools() -> DeviceTools:
    from armdrive.dialects.robko01.words import TOOLS

    return TOOLS


ENTRY = Dialect(
    name="robko01",
    title="Robko 01",
    preset="robko01",
    baud=115_200,
    raise_dtr=False,
    quick_stop="The switch of its power supply is the quicker stop: the arm sags then.",
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
        queued_segments=0,
        speed_mode_with_watchdog=False,
        reports_while_moving=True,
        own_homing=False,
        resets_on_open=False,
        check_bytes=True,
        current=Switching.BOTH,
        grip_switch=False,
        pendant=False,
        jog_burst_s=0.25,
        planned_burst_s=0.5,
        traffic=Traffic(line_chars=32, answer_chars=12),
        register_bits=16,
        inputs=8,
    ),
    driver=_driver,
    tools=_tools,
)
