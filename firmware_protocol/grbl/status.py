"""GRBL's status report, `<Idle|MPos:0.000,0.000,0.000|FS:0,0>`: to a line and back.

Source: gnea/grbl doc/markdown/interface.md. Fields that are not known are kept as they came.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError, whole
from firmware_protocol.grbl.answers import coordinates, within, write_coordinates
from firmware_protocol.grbl.words import number, write_number

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


@dataclass(frozen=True, slots=True)
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
        if not isinstance(self.state, str) or not _STATE.fullmatch(self.state) or ":" in self.state:
            raise BadField("state", self.state, "a state, or a name in letters")
        object.__setattr__(self, "state", _STATES.get(self.state, self.state))
        if (self.machine_position is None) == (self.work_position is None):
            raise BadField("machine_position", self.machine_position, "given, or else the work's")
        for name in ("machine_position", "work_position", "work_offset"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, coordinates(name, getattr(self, name)))
        for name, most in (("sub_state", 999), ("line_number", COUNT_MAX)):
            if getattr(self, name) is not None:
                whole(name, getattr(self, name), 0, most)
        self._check_pairs()
        for name in ("pins", "accessories"):
            if getattr(self, name) is not None:
                within(name, getattr(self, name), "|<>")
        object.__setattr__(self, "others", tuple(within("others", o, "|<>") for o in self.others))
        if any(other.partition(":")[0] in _READERS or not other for other in self.others):
            raise BadField("others", self.others, "fields that have no place of their own")

    def _check_pairs(self) -> None:
        if (self.free_blocks is None) != (self.free_bytes is None):
            raise BadField("free_bytes", self.free_bytes, "given where free_blocks is")
        for name in ("free_blocks", "free_bytes"):
            if getattr(self, name) is not None:
                whole(name, getattr(self, name), 0, COUNT_MAX)
        rates = [self.feed, self.speed, self.actual_speed]
        for name, rate, before in zip(
            ("feed", "speed", "actual_speed"), rates, [0.0, *rates], strict=False
        ):
            if rate is not None and before is None:
                raise BadField(name, rate, "given where what stands before it is")
            if rate is not None:
                number(name, rate)
        if self.overrides is not None:
            found = tuple(whole("overrides", part, 0, COUNT_MAX) for part in self.overrides)
            if len(found) != 3:
                raise BadField("overrides", self.overrides, "three numbers")
            object.__setattr__(self, "overrides", found)

    @property
    def line(self) -> str:
        """The line without its end."""
        sub = "" if self.sub_state is None else f":{self.sub_state}"
        fields = [f"{name}:{text}" for name, text in self._fields() if text is not None]
        return f"<{'|'.join([f'{self.state}{sub}', *fields, *self.others])}>"

    def _fields(self) -> list[tuple[str, str | None]]:
        rates = [
            write_number(r) for r in (self.feed, self.speed, self.actual_speed) if r is not None
        ]
        free = None if self.free_blocks is None else f"{self.free_blocks},{self.free_bytes}"
        return [
            ("MPos", _written(self.machine_position)),
            ("WPos", _written(self.work_position)),
            ("Bf", free),
            ("Ln", None if self.line_number is None else str(self.line_number)),
            ("F" if len(rates) == 1 else "FS", ",".join(rates) or None),
            ("Pn", self.pins),
            ("WCO", _written(self.work_offset)),
            ("Ov", None if self.overrides is None else ",".join(map(str, self.overrides))),
            ("A", self.accessories),
        ]


def _written(values: tuple[float, ...] | None) -> str | None:
    return None if values is None else write_coordinates(values)


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


def _free(text: str) -> dict[str, object]:
    return dict(zip(("free_blocks", "free_bytes"), wholes(text, 2), strict=True))


def _speeds(text: str) -> dict[str, object]:
    found = decimals(text)
    if not 2 <= len(found) <= 3:
        raise RemoteProtocolError(f"'{text[:48]}' is not a feed and a speed")
    return dict(zip(("feed", "speed", "actual_speed"), found, strict=False))


def _feed(text: str) -> dict[str, object]:
    found = decimals(text)
    if len(found) != 1:
        raise RemoteProtocolError(f"'{text[:48]}' is not one feed")
    return {"feed": found[0]}


_READERS: dict[str, Callable[[str], dict[str, object]]] = {
    "MPos": lambda text: {"machine_position": decimals(text)},
    "WPos": lambda text: {"work_position": decimals(text)},
    "Bf": _free,
    "Ln": lambda text: {"line_number": wholes(text, 1)[0]},
    "F": _feed,
    "FS": _speeds,
    "Pn": lambda text: {"pins": text},
    "WCO": lambda text: {"work_offset": decimals(text)},
    "Ov": lambda text: {"overrides": wholes(text, 3)},
    "A": lambda text: {"accessories": text},
}


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
        reader = _READERS.get(name) if colon else None
        read = {} if reader is None else reader(text)
        if read.keys() & found.keys():
            raise RemoteProtocolError(f"a status report has {name} twice")
        found |= read
        others += [] if reader else [part]
    try:
        return StatusReport(state[1], others=tuple(others), **found)  # type: ignore[arg-type]
    except LocalProtocolError as error:  # what does not fit was not our choice
        raise RemoteProtocolError(f"status report: {error}") from None
