"""What an arm on CiA 402 drives can do, and how it is used where no arm file says otherwise."""

from __future__ import annotations

from armdrive.abilities import Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects.dialect import DeviceTools, Dialect, Language, Part

_TOOLS: Part[DeviceTools] = Part("armdrive.dialects.cia402.survey", "TOOLS")

ENTRY = Dialect(
    name="cia402",
    title="CiA 402 drives",
    preset="minimover5-cia402",
    baud=500_000,
    raise_dtr=False,
    quick_stop="The switch of the motors' supply is the quicker stop: the arm sags then.",
    torque=Torque(
        disable="sags: every drive switches its motor off",
        estop="is held: the drives brake on their quick-stop ramps and hold",
        power_loss="sags, and most drives count from zero afterwards",
        closed_port="is held: the drives miss the heartbeat, brake if they move, and hold",
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
        traffic=Traffic(line_chars=80, answer_chars=74),
        register_bits=32,
        ramp_s=0.15,
        jerk_s=0.05,
        beats=True,
    ),
    driver=Part("armdrive.dialects.cia402.controller", "DRIVER"),
    tools=_TOOLS,
    language=Language(
        "canopen",
        "CANopen",
        _TOOLS,
        "An idle bus is silent where no drive was told to say heartbeats (object 1017)",
    ),
)
