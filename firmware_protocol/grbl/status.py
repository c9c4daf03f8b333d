"""GRBL's status report, `<Idle|MPos:0.000,0.000,0.000|FS:0,0>`: to a line and back.

Source: gnea/grbl doc/markdown/interface.md. Fields that are not known are kept as they came.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError
from firmware_protocol.fields import checks, each, optional, row_of, whole_from
from firmware_protocol.grbl.words import coordinates, number, within, written

COUNT_MAX = 99_999_999
_STATE = re.compile(r"([A-Za-z]+)(?::([0-9]{1,3}))?")
_DECIMAL = re.compile(r"-?[0-9]{1,9}(?:\.[0-9]{0,6})?")
_WHOLE = re.compile(r"[0-9]{1,8}")


class State(StrEnum):
    """What the machine is doing. A state that is not listed stays text in a report."""

    IDLE = "Idle"
    RUN = "Run"
    HOLD = "Hold"
    """Sub-state 0: it stands; 1: it is still braking."""
    JOG = "Jog"
    ALARM = "Alarm"
    DOOR = "Door"
    CHECK = "Check"
    HOME = "Home"
    SLEEP = "Sleep"
    TOOL = "Tool"
    """grblHAL only: it waits for a tool change."""


_STATES = {str(state): state for state in State}


def _state(field: str, value: object) -> State | str:
    if not isinstance(value, str) or not _STATE.fullmatch(value) or ":" in value:
        raise BadField(field, value, "a state, or a name in letters")
    return _STATES.get(value, value)


_COUNT = whole_from(0, COUNT_MAX)
_PLACE = optional(coordinates)
_PART = within("|<>")


@dataclass(frozen=True, slots=True)
@checks(
    state=_state,
    sub_state=optional(whole_from(0, 999)),
    machine_position=_PLACE,
    work_position=_PLACE,
    free_blocks=optional(_COUNT),
    free_bytes=optional(_COUNT),
    line_number=optional(_COUNT),
    feed=optional(number),
    speed=optional(number),
    actual_speed=optional(number),
    pins=optional(_PART),
    work_offset=_PLACE,
    overrides=optional(row_of(_COUNT, 3, "three numbers")),
    accessories=optional(_PART),
    others=each(_PART),
)
class StatusReport:
    """One report as it stands on the wire: machine position or work position, never both.

    Positions are in the machine's unit, in the order of its axes. `work_offset`, `overrides`
    (feed, rapid, spindle in per cent) and `accessories` appear now and then. Raises `BadField`.
    """

    state: State | str
    sub_state: int | None = None
    machine_position: tuple[float, ...] | None = None
    work_position: tuple[float, ...] | None = None
    free_blocks: int | None = None
    free_bytes: int | None = None
    line_number: int | None = None
    feed: float | None = None
    speed: float | None = None
    actual_speed: float | None = None
    pins: str | None = None
    work_offset: tuple[float, ...] | None = None
    overrides: tuple[int, ...] | None = None
    accessories: str | None = None
    others: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if (self.machine_position is None) == (self.work_position is None):
            raise BadField("machine_position", self.machine_position, "given, or else the work's")
        if (self.free_blocks is None) != (self.free_bytes is None):
            raise BadField("free_bytes", self.free_bytes, "given where free_blocks is")
        rates = (self.feed, self.speed, self.actual_speed)
        for name, before, rate in zip(("speed", "actual_speed"), rates, rates[1:], strict=False):
            if rate is not None and before is None:
                raise BadField(name, rate, "given where what stands before it is")
        if any(other.partition(":")[0] in _FIELDS or not other for other in self.others):
            raise BadField("others", self.others, "fields that have no place of their own")

    @property
    def line(self) -> str:
        """The line without its end."""
        sub = "" if self.sub_state is None else f":{self.sub_state}"
        texts = ((name, field.text(self)) for name, field in _FIELDS.items())
        fields = [f"{name}:{text}" for name, text in texts if text is not None]
        return f"<{'|'.join([f'{self.state}{sub}', *fields, *self.others])}>"


def decimals(text: str) -> tuple[float, ...]:
    """Read decimal numbers between commas; raises `RemoteProtocolError`."""
    parts = text.split(",")
    if not all(_DECIMAL.fullmatch(part) for part in parts):
        raise RemoteProtocolError(f"'{text[:48]}' are no decimal numbers")
    return tuple(float(part) for part in parts)


def wholes(text: str, count: int) -> tuple[int, ...]:
    """Read so many whole numbers between commas; raises `RemoteProtocolError`."""
    parts = text.split(",")
    if len(parts) != count or not all(_WHOLE.fullmatch(part) for part in parts):
        raise RemoteProtocolError(f"'{text[:48]}' is not {count} whole numbers")
    return tuple(int(part) for part in parts)


@dataclass(frozen=True, slots=True)
class ReportField:
    """A field of a report: the attributes that it fills, and how their values are read.

    It is written where so many of the attributes are known as `counts` says.
    """

    attributes: tuple[str, ...]
    read: Callable[[str], tuple[object, ...]]
    counts: range = range(1, 2)
    called: str = ""
    write: Callable[[Any], str] = written

    def text(self, report: StatusReport) -> str | None:
        """Return what is written of a report; None where it is left out."""
        if getattr(report, self.attributes[0]) is None:  # as most of them are, in most reports
            return None
        values = [getattr(report, name) for name in self.attributes]
        known = [value for value in values if value is not None]
        return ",".join(map(self.write, known)) if len(known) in self.counts else None

    def values(self, text: str) -> dict[str, object]:
        """Return what a text says of the attributes; raises `RemoteProtocolError`."""
        found = self.read(text)
        if len(found) not in self.counts:
            raise RemoteProtocolError(f"'{text[:48]}' is not {self.called}")
        return dict(zip(self.attributes, found, strict=False))


_RATES = ("feed", "speed", "actual_speed")
_FIELDS: dict[str, ReportField] = {
    "MPos": ReportField(("machine_position",), lambda text: (decimals(text),)),
    "WPos": ReportField(("work_position",), lambda text: (decimals(text),)),
    "Bf": ReportField(("free_blocks", "free_bytes"), lambda text: wholes(text, 2), range(2, 3)),
    "Ln": ReportField(("line_number",), lambda text: wholes(text, 1)),
    "F": ReportField(_RATES, decimals, range(1, 2), "one feed"),
    "FS": ReportField(_RATES, decimals, range(2, 4), "a feed and a speed"),
    "Pn": ReportField(("pins",), lambda text: (text,)),
    "WCO": ReportField(("work_offset",), lambda text: (decimals(text),)),
    "Ov": ReportField(
        ("overrides",),
        lambda text: (wholes(text, 3),),
        write=lambda values: ",".join(map(str, values)),
    ),
    "A": ReportField(("accessories",), lambda text: (text,)),
}
"""The fields by their names, in the order in which they are written."""


def read_status(line: str) -> StatusReport:
    """Read a report with its chevrons; raises `RemoteProtocolError`."""
    if not line.startswith("<") or not line.endswith(">"):
        raise RemoteProtocolError("a status report does not end where it should")
    head, *parts = line[1:-1].split("|")
    state = _STATE.fullmatch(head)
    if state is None:
        raise RemoteProtocolError(f"'{head[:16]}' is no state")
    found: dict[str, object] = {"sub_state": int(state[2]) if state[2] else None}
    others: list[str] = []
    for part in parts:
        name, colon, text = part.partition(":")
        field = _FIELDS.get(name) if colon else None
        read = {} if field is None else field.values(text)
        if read.keys() & found.keys():
            raise RemoteProtocolError(f"a status report has {name} twice")
        found |= read
        others += [] if field else [part]
    try:
        return StatusReport(state[1], others=tuple(others), **found)  # type: ignore[arg-type]
    except LocalProtocolError as error:  # what does not fit was not our choice
        raise RemoteProtocolError(f"status report: {error}") from None
