"""A board's answers and messages: ok, errors, alarms, banners, settings, reports.

`decode_answer` chooses a reader by the start of a line; a damaged line raises
`RemoteProtocolError`. Those that a simulated board sends can also be written (`line`). `ok` and
`error` answer a line of the host; everything else may come at any time.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from enum import StrEnum
from typing import ClassVar, TypeAlias

from firmware_protocol.errors import BadField, RemoteProtocolError, chosen_by_sender
from firmware_protocol.fields import each, message, optional, whole_from
from firmware_protocol.grbl.commands import SETTING_MAX
from firmware_protocol.grbl.dialect import (
    AXIS_LETTERS,
    Template,
    Variant,
    coordinates,
    number,
    printable,
    within,
    written,
)

CODE_MAX = 255
CODE = whole_from(1, CODE_MAX)


@message()
class Ok:
    """The line was accepted."""

    line: ClassVar[str] = "ok"


@message(code=CODE)
class Error:
    """The line was refused and had no effect."""

    code: int

    line = Template("error:{code}")


@message(code=CODE)
class Alarm:
    """The machine is locked."""

    code: int

    line = Template("ALARM:{code}")


@message(version=within(" []'<>"), firmware=within("[]'"))
class Banner:
    """The first line after a start or a reset.

    `firmware` is FluidNC's own version; the others have none here.
    """

    version: str = "1.1h"
    variant: Variant = Variant.GRBL
    firmware: str = ""

    def __post_init__(self) -> None:
        if not self.version:
            raise BadField("version", self.version, "not empty")
        if (self.variant is Variant.FLUIDNC) != bool(self.firmware):
            raise BadField("firmware", self.firmware, "given by FluidNC and by no other")

    @property
    def line(self) -> str:
        """The line without its end."""
        if self.variant is Variant.FLUIDNC:
            return f"Grbl {self.version} [FluidNC {self.firmware} '$' for help]"
        hint = "'$' or '$HELP'" if self.variant is Variant.GRBLHAL else "'$'"
        return f"{self.variant} {self.version} [{hint} for help]"


def _key(field: str, value: object) -> object:
    number_or_name = within("= ") if isinstance(value, str) else whole_from(0, SETTING_MAX)
    return number_or_name(field, value)


@message(key=_key, value=printable)
class Setting:
    """A setting's value, as text. Keys that are not numbers, such as FluidNC's paths, stay text.

    Startup lines come as the keys N0 and N1.
    """

    key: int | str
    value: str

    line = Template("${key}={value}")


@message(text=printable)
class Feedback:
    """A message for people: `[MSG:...]`."""

    text: str

    line = Template("[MSG:{text}]")


@message(text=printable)
class Remark:
    """A whole line that has no effect: other lines in brackets, and echoes of start-up lines.

    Examples are help (`[HLP:...]`), modes (`[GC:...]`), coordinates (`[G54:...]`), and `>G54:ok`.
    """

    text: str

    line = Template("{text}")


# What a host learns from the answers to `$I`. A simulated board sends these lines as `Remark`.


@message()
class Version:
    """The firmware's version."""

    version: str


@message()
class AxesInfo:
    """The letters of the axis motors; two motors may share one."""

    letters: str


# The status report, `<Idle|MPos:0.000,0.000,0.000|FS:0,0>`: to a line and back.
#
# Source: gnea/grbl doc/markdown/interface.md. Unknown fields are kept as they came.

COUNT_MAX = 99_999_999
_STATE = re.compile(r"([A-Za-z]+)(?::([0-9]{1,3}))?")
_DECIMAL = re.compile(r"-?[0-9]{1,9}(?:\.[0-9]{0,6})?")


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
_PART = within("|<>")


@message(
    state=_state,
    sub_state=optional(whole_from(0, 999)),
    machine_position=optional(coordinates),
    free_blocks=optional(_COUNT),
    free_bytes=optional(_COUNT),
    feed=optional(number),
    speed=optional(number),
    pins=optional(_PART),
    others=each(_PART),
)
class StatusReport:
    """One report as it stands on the wire. Raises `BadField`.

    Positions are in the machine's unit, in the order of its axes; a board that reports the work's
    instead ($10) gives none. `free_blocks` and `free_bytes` come together, and so do `feed` and
    `speed`. `others` are the remaining fields, such as overrides and accessories now and then.
    """

    state: State | str
    sub_state: int | None = None
    machine_position: tuple[float, ...] | None = None
    free_blocks: int | None = None
    free_bytes: int | None = None
    feed: float | None = None
    speed: float | None = None
    pins: str | None = None
    others: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if any(other.partition(":")[0] in _FIELDS or not other for other in self.others):
            raise BadField("others", self.others, "fields that have no place of their own")

    @property
    def line(self) -> str:
        """The line without its end."""
        sub = "" if self.sub_state is None else f":{self.sub_state}"
        parts = [f"{self.state}{sub}"]
        for name, (attributes, _) in _FIELDS.items():
            values = [getattr(self, attribute) for attribute in attributes]
            if None not in values:
                parts.append(f"{name}:{','.join(map(written, values))}")
        return f"<{'|'.join([*parts, *self.others])}>"


def _numbers(text: str) -> tuple[float, ...]:
    """Read numbers between commas; raises `RemoteProtocolError`."""
    parts = text.split(",")
    if not all(_DECIMAL.fullmatch(part) for part in parts):
        raise RemoteProtocolError(f"'{text[:48]}' are no numbers")
    return tuple(float(part) if "." in part else int(part) for part in parts)


# What a field holds, and how it is read, by its name; in the order in which they are written.
# grblHAL may add the actual speed to `FS`, which is not kept.
_FIELDS: dict[str, tuple[tuple[str, ...], Callable[[str], tuple[object, ...]]]] = {
    "MPos": (("machine_position",), lambda text: (tuple(map(float, _numbers(text))),)),
    "Bf": (("free_blocks", "free_bytes"), _numbers),
    "FS": (("feed", "speed"), lambda text: tuple(map(float, _numbers(text)))[:2]),
    "Pn": (("pins",), lambda text: (text,)),
}


def read_status(line: str) -> StatusReport:
    """Read a report with its chevrons; raises `RemoteProtocolError` or `BadField`."""
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
        if not colon or name not in _FIELDS:
            others.append(part)
            continue
        attributes, read = _FIELDS[name]
        values = read(text)
        if len(values) != len(attributes) or attributes[0] in found:
            raise RemoteProtocolError(f"a status report has '{part[:48]}'")
        found.update(zip(attributes, values, strict=True))
    if "machine_position" in found and any(other.startswith("WPos:") for other in others):
        # GRBL reports one position or the other; Smoothieware reports both
        raise RemoteProtocolError("a status report has both positions, as GRBL's have not")
    return StatusReport(state[1], others=tuple(others), **found)  # type: ignore[arg-type]


# Messages that follow a query or come by themselves, and answer no line.
Info: TypeAlias = Setting | Feedback | Version | AxesInfo | Remark


@message()
class WordedError:
    """A refusal in words instead of a number: FluidNC's, if it is told to be verbose."""

    text: str


# What a device sends.
Answer: TypeAlias = Ok | Error | Alarm | Banner | StatusReport | Setting | Feedback | Remark
# What a host reads.
HostMessage: TypeAlias = Answer | Version | AxesInfo | WordedError

END = b"\r\n"
# Bytes that are ignored at either end of a line.
PADDING = b" \t\0"

_CODE = re.compile(r" ?([0-9]{1,3})")
_BANNER = re.compile(
    r"(grblhal|grbl) ([!-Z\\^-~]+) \[(?:FluidNC ([^\[\]']*) )?'\$'.* for help\]", re.IGNORECASE
)
_SETTING = re.compile(r"([^= ]+)=(.*)")
_COMMENT = re.compile(r" +\(.*\)$")


def encode_answer(answer: Answer) -> bytes:
    """Return the bytes of a line, CR LF at its end; a banner has an empty line before it."""
    before = END if isinstance(answer, Banner) else b""
    return before + answer.line.encode("ascii") + END


def decode_answer(line: bytes) -> HostMessage:
    """Decode a line without its end. Raises `RemoteProtocolError`."""
    body = line.strip(PADDING)
    if not all(0x20 <= byte <= 0x7E for byte in body):
        raise RemoteProtocolError("the line has bytes that are no printable ASCII")
    text = body.decode("ascii")
    for start, reader in _READERS.items():
        if text.startswith(start):
            with chosen_by_sender():
                return reader(text)
    raise RemoteProtocolError("no firmware of this family sends such a line")


def _ok(text: str) -> Ok:
    if text != "ok":
        raise RemoteProtocolError("an ok is followed by more text")
    return Ok()


def _error(text: str) -> Error | WordedError:
    rest = text.partition(":")[2]
    code = _CODE.fullmatch(rest)
    if code:
        return Error(int(code[1]))
    if not re.search("[A-Za-z]{2}", rest):  # damaged digits are no words
        raise RemoteProtocolError(f"'{rest[:16]}' is no code")
    return WordedError(rest.strip())


def _alarm(text: str) -> Alarm:
    code = _CODE.fullmatch(text.partition(":")[2])
    if code is None:
        raise RemoteProtocolError(f"'{text[:16]}' is no alarm")
    return Alarm(int(code[1]))


def _banner(text: str) -> Banner:
    found = _BANNER.fullmatch(text)
    if found is None:
        raise RemoteProtocolError("a banner does not end as it should")
    if found[3]:
        return Banner(found[2], Variant.FLUIDNC, found[3])
    return Banner(found[2], Variant.GRBLHAL if found[1].lower() == "grblhal" else Variant.GRBL)


def _setting(text: str) -> Setting:
    found = _SETTING.fullmatch(text[1:])
    if found is None:
        raise RemoteProtocolError("a setting has no value")
    if not found[1].isdigit():
        return Setting(found[1], found[2].strip())
    return Setting(int(found[1]), _COMMENT.sub("", found[2]).strip())


def _bracketed(text: str) -> Info:
    if not text.endswith("]"):
        raise RemoteProtocolError("a bracket is not closed")
    name, colon, rest = text[1:-1].partition(":")
    reader = _BRACKETS.get(name) if colon else None
    return Remark(text) if reader is None else reader(rest)


def _version(rest: str) -> Version:
    return Version(rest.partition(":")[0])


def _axes_info(rest: str) -> AxesInfo:
    letters = rest.replace(" ", "").partition(":")[2]
    if not letters or not set(letters) <= set(AXIS_LETTERS):
        raise RemoteProtocolError(f"'{letters[:16]}' are no letters of axes")
    return AxesInfo(letters)


_BRACKETS: dict[str, Callable[[str], Info]] = {
    "MSG": Feedback,
    "VER": _version,
    "AXS": _axes_info,
}

_READERS: dict[str, Callable[[str], HostMessage]] = {
    "ok": _ok,
    "error:": _error,
    "<": read_status,
    "ALARM:": _alarm,
    "$": _setting,
    "[": _bracketed,
    ">": Remark,
    "Grbl": _banner,
    "grbl": _banner,
}
