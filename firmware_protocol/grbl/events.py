"""What a host learns from a board."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.grbl.answers import Banner, Error, Ok
from firmware_protocol.grbl.commands import Command
from firmware_protocol.grbl.reports import Info, WordedError
from firmware_protocol.grbl.status import StatusReport


@dataclass(frozen=True, slots=True)
class Acknowledged:
    """The board took a line: for a motion that it is planned, not that it is over."""

    command: Command


@dataclass(frozen=True, slots=True)
class Refused:
    """The board refused a line, which did nothing. `code` is None where it answered in words."""

    command: Command
    code: int | None
    meaning: str
    remedy: str


@dataclass(frozen=True, slots=True)
class AlarmRaised:
    """The board has locked itself. `position_kept` is false where steps may have been lost."""

    code: int | None
    meaning: str
    remedy: str
    position_kept: bool


@dataclass(frozen=True, slots=True)
class Restarted:
    """The board has started anew: its position is suspect, and `lost` lines have no answer.

    Of the lost lines some may have been executed.
    """

    banner: Banner
    lost: tuple[Command, ...] = ()


@dataclass(frozen=True, slots=True)
class StatusReported:
    """A status report, with both positions where they are known.

    The one that the report lacks is computed with the last work offset that was reported since
    the board's start; it is None where none was.
    """

    report: StatusReport
    machine_position: tuple[float, ...] | None
    work_position: tuple[float, ...] | None


@dataclass(frozen=True, slots=True)
class Unexpected:
    """An answer to a line where no line was unanswered."""

    answer: Ok | Error | WordedError


@dataclass(frozen=True, slots=True)
class Unreadable:
    """Bytes that cannot be read, and why."""

    data: bytes
    reason: str


Event: TypeAlias = (
    Acknowledged
    | Refused
    | AlarmRaised
    | Restarted
    | StatusReported
    | Unexpected
    | Unreadable
    | Info
)
