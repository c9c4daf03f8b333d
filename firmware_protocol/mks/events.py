"""What a host hears from MKS drives, one event at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.frames import Frame
from firmware_protocol.mks.actions import Motion
from firmware_protocol.mks.identity import SettingRead
from firmware_protocol.mks.readings import Reading
from firmware_protocol.mks.reads import Read, ReadSetting
from firmware_protocol.mks.wire import Answer, Request


@dataclass(frozen=True, slots=True)
class Answered:
    """A read and its answer."""

    node: int
    request: Read | ReadSetting
    answer: Reading | SettingRead


@dataclass(frozen=True, slots=True)
class Started:
    """A motion, a homing or a calibration has begun."""

    node: int
    request: Motion


@dataclass(frozen=True, slots=True)
class Done:
    """A setting or an action was taken, or a motion has ended where it should."""

    node: int
    request: Request


@dataclass(frozen=True, slots=True)
class Failed:
    """Refused, or ended short of its end."""

    node: int
    request: Request


@dataclass(frozen=True, slots=True)
class LimitStop:
    """A limit switch has ended a motion."""

    node: int
    request: Motion


@dataclass(frozen=True, slots=True)
class StoredForStart:
    """A motion waits for the synchronous start."""

    node: int
    request: Motion


@dataclass(frozen=True, slots=True)
class Superseded:
    """A motion was given up by the drive for a newer one, which goes on."""

    node: int
    request: Motion


@dataclass(frozen=True, slots=True)
class Reported:
    """A reading that the drive tells by itself, as it was asked to."""

    node: int
    reading: Reading


@dataclass(frozen=True, slots=True)
class Stray:
    """A readable answer that nobody awaits: a late one, or that of a second drive of this id."""

    node: int
    answer: Answer


@dataclass(frozen=True, slots=True)
class Garbled:
    """A frame with a drive's id that is no answer of this dialect, and why."""

    frame: Frame
    reason: str


@dataclass(frozen=True, slots=True)
class Foreign:
    """A frame of somebody else on the bus."""

    frame: Frame


@dataclass(frozen=True, slots=True)
class Overrun:
    """So many events were not fetched in time, the oldest; they are lost."""

    count: int


Event: TypeAlias = (
    Answered
    | Started
    | Done
    | Failed
    | LimitStop
    | StoredForStart
    | Superseded
    | Reported
    | Stray
    | Garbled
    | Foreign
    | Overrun
)
