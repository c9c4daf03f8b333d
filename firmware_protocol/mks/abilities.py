"""What each firmware of an MKS SERVO42D/57D on CAN can do: one table.

Requests say themselves which ability they need.

Versions are those of the README's version notes (makerbase-motor/MKS-SERVO42D-57D), where not
marked otherwise. A drive tells its version from some firmware on; what does not answer
`ReadVersion` is older, or not there.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from typing import TypeAlias

from firmware_protocol.errors import BadField, whole

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


def abilities_of(version: Version) -> frozenset[Ability]:
    """Return what a firmware can do; one newer than `LATEST` what `LATEST` can."""
    if not isinstance(version, tuple) or len(version) != 3:
        raise BadField("version", version, "three whole numbers")
    for part in version:
        whole("version", part, 0, 255)
    return frozenset(ability for ability, since in SINCE.items() if version >= since.version)
