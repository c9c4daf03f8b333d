"""What an arm on drives of a CAN bus can do, whatever they speak: for the rows of the registry."""

from __future__ import annotations

from armdrive.abilities import Abilities, Abort, Switching, Traffic

BITS_S = 500_000
"""The bus's speed where no arm file says otherwise."""
QUICK_STOP = "The switch of the motors' supply is the quicker stop: the arm sags then."


def abilities(traffic: Traffic, register_bits: int, *, beats: bool = False) -> Abilities:
    """Return what the drives of an arm can do as delivered; its controller knows more of them."""
    return Abilities(
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
        traffic=traffic,
        register_bits=register_bits,
        ramp_s=0.15,
        jerk_s=0.05,
        beats=beats,
    )
