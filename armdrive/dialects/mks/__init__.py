"""What an arm on MKS drives can do, and how it is used where no arm file says otherwise."""

from __future__ import annotations

from armdrive.abilities import Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects.dialect import DeviceTools, Dialect, Language, Part

_TOOLS: Part[DeviceTools] = Part("armdrive.dialects.mks.commissioning", "TOOLS")

ENTRY = Dialect(
    name="mks",
    title="MKS servo drives",
    preset="minimover5-mks",
    baud=500_000,
    raise_dtr=False,
    quick_stop="The switch of the motors' supply is the quicker stop: the arm sags then.",
    torque=Torque(
        disable="sags: every drive switches its motor off",
        estop="is held: the drives stop dead and hold; above 1000 rpm they ramp down",
        power_loss="sags, and the drives count from zero afterwards",
        closed_port="is held: the drives stand and hold, whoever is silent",
    ),
    abilities=Abilities(
        motors=6,
        coordinated=True,
        abort=Abort.RAMP,
        queued_segments=3,
        speed_mode_with_watchdog=False,
        reports_while_moving=True,
        own_homing=True,
        resets_on_open=False,
        check_bytes=True,
        current=Switching.BOTH,
        grip_switch=False,
        pendant=False,
        jog_burst_s=0.15,
        planned_burst_s=0.3,
        traffic=Traffic(line_chars=78, answer_chars=60),
        register_bits=48,
        ramp_s=0.15,
        jerk_s=0.05,
    ),
    driver=Part("armdrive.dialects.mks.controller", "DRIVER"),
    tools=_TOOLS,
    language=Language(
        "mks",
        "MKS drives",
        _TOOLS,
        "An idle bus of drives is silent: they speak when they are asked",
    ),
)
