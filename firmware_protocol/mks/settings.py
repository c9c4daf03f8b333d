"""What is set up in an MKS drive, and kept by it without current.

A setting is read back (`ReadSetting`) in the form in which it is set. The mode that checks no
check bytes (0F) is left out: it is meant for typing by hand.
"""

from __future__ import annotations

from typing import TypeAlias

from firmware_protocol.mks.bus_settings import SetBitrate, SetGroup, SetId, SetReplies
from firmware_protocol.mks.guard_settings import (
    SetArrival,
    SetHoming,
    SetPositionProtection,
    SetStallProtection,
    SilenceWatchdog,
)
from firmware_protocol.mks.motor_settings import (
    SetCurrent,
    SetDirection,
    SetHoldingCurrent,
    SetMicrosteps,
    SetMode,
)

Setting: TypeAlias = (
    SetMode
    | SetCurrent
    | SetHoldingCurrent
    | SetMicrosteps
    | SetDirection
    | SetStallProtection
    | SetPositionProtection
    | SetHoming
    | SetArrival
    | SilenceWatchdog
    | SetBitrate
    | SetId
    | SetGroup
    | SetReplies
)
SETTINGS: tuple[type[Setting], ...] = (
    SetMode,
    SetCurrent,
    SetHoldingCurrent,
    SetMicrosteps,
    SetDirection,
    SetStallProtection,
    SetPositionProtection,
    SetHoming,
    SetArrival,
    SilenceWatchdog,
    SetBitrate,
    SetId,
    SetGroup,
    SetReplies,
)
SETTING_CODES = frozenset(setting.code for setting in SETTINGS)
