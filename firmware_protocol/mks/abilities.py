"""What each firmware of an MKS SERVO42D/57D on CAN can do: one table, and what a request needs.

Versions are those of the README's version notes (makerbase-motor/MKS-SERVO42D-57D), where not
marked otherwise. A drive tells its version from some firmware on; what does not answer
`ReadVersion` is older, or not there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from typing import TypeAlias

from firmware_protocol.errors import BadField, whole
from firmware_protocol.mks.actions import (
    ArmSynchronous,
    EmergencyStop,
    GoSynchronous,
    GoToZero,
    Restart,
    SetZero,
)
from firmware_protocol.mks.bus_settings import SetGroup, SetReplies
from firmware_protocol.mks.guard_settings import (
    SetArrival,
    SetPositionProtection,
    SilenceWatchdog,
)
from firmware_protocol.mks.motor_settings import SetCurrent, SetHoldingCurrent
from firmware_protocol.mks.moves import MoveAbsolutePulses, RunFor
from firmware_protocol.mks.reads import (
    ReadInputs,
    ReadRawEncoder,
    ReadSetting,
    ReadVersion,
    ReportByItself,
)
from firmware_protocol.mks.wire import Request

Version: TypeAlias = tuple[int, int, int]


class Ability(Enum):
    """Something that not every firmware can do."""

    ZERO = auto()
    GROUPS = auto()
    SILENT_BROADCAST = auto()
    """What is sent to all, or to a group, is not answered; before, all would answer at once."""
    INPUTS = auto()
    ABSOLUTE_PULSES = auto()
    EMERGENCY_STOP = auto()
    HOLDING_CURRENT = auto()
    CHOICE_OF_COMPLETION = auto()
    """8C has two bytes, and replies without those at the end of a motion."""
    RETARGET = auto()
    """An F5 replaces the one that is under way."""
    RESTART = auto()
    READ_SETTINGS = auto()
    RAW_ENCODER = auto()
    POSITION_PROTECTION = auto()
    UNKEPT_CURRENT = auto()
    TIMED_RUN = auto()
    HOMING_BY_COMMAND_READ = auto()
    SYNCHRONOUS_START = auto()
    ARRIVAL_THRESHOLD = auto()
    VERSION = auto()
    REPORTS_BY_ITSELF = auto()
    SILENCE_WATCHDOG = auto()
    GO_TO_ZERO = auto()


@dataclass(frozen=True, slots=True)
class Since:
    """From which version on; `verified` where the version notes name it."""

    version: Version
    verified: bool = True


SINCE: dict[Ability, Since] = {
    Ability.ZERO: Since((1, 0, 1)),
    Ability.GROUPS: Since((1, 0, 1)),
    Ability.SILENT_BROADCAST: Since((1, 0, 2)),
    Ability.INPUTS: Since((1, 0, 3)),
    Ability.ABSOLUTE_PULSES: Since((1, 0, 4)),
    Ability.EMERGENCY_STOP: Since((1, 0, 4)),
    Ability.HOLDING_CURRENT: Since((1, 0, 4)),
    Ability.CHOICE_OF_COMPLETION: Since((1, 0, 4)),
    Ability.RETARGET: Since((1, 0, 5)),
    Ability.RESTART: Since((1, 0, 5)),
    Ability.READ_SETTINGS: Since((1, 0, 6)),
    Ability.RAW_ENCODER: Since((1, 0, 6)),
    Ability.POSITION_PROTECTION: Since((1, 0, 6)),
    Ability.UNKEPT_CURRENT: Since((1, 0, 7)),
    Ability.TIMED_RUN: Since((1, 0, 7)),
    Ability.HOMING_BY_COMMAND_READ: Since((1, 0, 7)),
    Ability.SYNCHRONOUS_START: Since((1, 0, 8)),
    Ability.ARRIVAL_THRESHOLD: Since((1, 0, 8)),
    # in the manual 1.0.9, not in that of 1.0.6, and in no version note
    Ability.VERSION: Since((1, 0, 8), verified=False),
    Ability.REPORTS_BY_ITSELF: Since((1, 0, 9)),
    Ability.SILENCE_WATCHDOG: Since((1, 0, 9)),
    Ability.GO_TO_ZERO: Since((1, 0, 9)),
}

LATEST: Version = (1, 0, 9)
"""The newest firmware that this table knows of."""

_NEEDS: tuple[tuple[Callable[[Request], bool], Ability], ...] = (
    (lambda request: isinstance(request, SetZero), Ability.ZERO),
    (lambda request: isinstance(request, SetGroup), Ability.GROUPS),
    (lambda request: isinstance(request, ReadInputs), Ability.INPUTS),
    (lambda request: isinstance(request, MoveAbsolutePulses), Ability.ABSOLUTE_PULSES),
    (lambda request: isinstance(request, EmergencyStop), Ability.EMERGENCY_STOP),
    (lambda request: isinstance(request, SetHoldingCurrent), Ability.HOLDING_CURRENT),
    (lambda request: isinstance(request, SetReplies), Ability.CHOICE_OF_COMPLETION),
    (lambda request: isinstance(request, Restart), Ability.RESTART),
    (lambda request: isinstance(request, ReadSetting), Ability.READ_SETTINGS),
    (lambda request: isinstance(request, ReadRawEncoder), Ability.RAW_ENCODER),
    (lambda request: isinstance(request, SetPositionProtection), Ability.POSITION_PROTECTION),
    (lambda request: isinstance(request, SetCurrent) and not request.keep, Ability.UNKEPT_CURRENT),
    (lambda request: isinstance(request, RunFor), Ability.TIMED_RUN),
    (
        lambda request: isinstance(request, ArmSynchronous | GoSynchronous),
        Ability.SYNCHRONOUS_START,
    ),
    (lambda request: isinstance(request, SetArrival), Ability.ARRIVAL_THRESHOLD),
    (lambda request: isinstance(request, ReadVersion), Ability.VERSION),
    (lambda request: isinstance(request, ReportByItself), Ability.REPORTS_BY_ITSELF),
    (lambda request: isinstance(request, SilenceWatchdog), Ability.SILENCE_WATCHDOG),
    (lambda request: isinstance(request, GoToZero), Ability.GO_TO_ZERO),
)


def abilities_of(version: Version) -> frozenset[Ability]:
    """Return what a firmware can do; one newer than `LATEST` what `LATEST` can."""
    if not isinstance(version, tuple) or len(version) != 3:
        raise BadField("version", version, "three whole numbers")
    for part in version:
        whole("version", part, 0, 255)
    return frozenset(ability for ability, since in SINCE.items() if version >= since.version)


def needed_for(request: Request) -> Ability | None:
    """Return what a drive must be able to do to understand a request; None for what all can."""
    return next((ability for fits, ability in _NEEDS if fits(request)), None)
