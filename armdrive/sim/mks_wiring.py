"""How the drives of a simulated arm are set up, out of the arm's configuration.

What the arm file's own section says is read without its class: the driver's figures are its own,
so that a difference has to be found.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from armdrive.errors import BadRequest
from firmware_protocol.errors import BadField
from firmware_protocol.mks import (
    Bitrate,
    Mode,
    SetBitrate,
    SetCurrent,
    SetHoming,
    SetId,
    SetMicrosteps,
    SetMode,
    SetStallProtection,
    Setting,
)

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig

HOMING_RPM = 60
USUAL_MA, USUAL_MICROSTEPS = 1600, 16


def drive_settings(
    config: ArmConfig,
    count: int,
    bitrate: Bitrate,
    *,
    factory: bool,
    limits: bool,
    stall_protection: bool,
) -> list[list[Setting]]:
    """Return what somebody has set on each drive who knows this arm; of new ones, the speed."""
    device: Any = config.device
    ids = tuple(getattr(device, "ids", ()) or range(1, count + 1))[:count]
    if len(ids) < count:
        raise BadRequest(f"ids of {len(ids)} drives cannot turn the {count} motors of this arm")
    if factory:
        return [[SetBitrate(bitrate)] for _ in ids]
    current_ma = getattr(device, "current_ma", 0) or USUAL_MA
    microsteps = getattr(device, "microsteps", 0) or USUAL_MICROSTEPS
    try:
        return [
            [
                SetBitrate(bitrate),
                SetId(node),
                SetMode(Mode.BUS_FOC),
                SetCurrent(current_ma),
                SetMicrosteps(microsteps),
                SetStallProtection(stall_protection),
                SetHoming(
                    active_high=False,
                    counter_clockwise=True,
                    speed_rpm=HOMING_RPM,
                    limits=limits,
                    method=0,
                ),
            ]
            for node in ids
        ]
    except BadField as error:
        raise BadRequest(str(error)) from None
