"""Decoding of a board's lines, by a table of their beginnings."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.grbl.answers import (
    Alarm,
    AxesInfo,
    Banner,
    Bracketed,
    BuildInfo,
    Error,
    Feedback,
    Ok,
    Parameter,
    ParserState,
    Setting,
    StartupEcho,
    Version,
    is_parameter,
)
from firmware_protocol.grbl.dialect import Variant
from firmware_protocol.grbl.status import StatusReport, decimals, read_status

Info: TypeAlias = (
    Setting
    | Feedback
    | Version
    | BuildInfo
    | AxesInfo
    | ParserState
    | Parameter
    | StartupEcho
    | Bracketed
)
"""What is pushed, or follows a query, and changes nothing in the host's machine."""


@dataclass(frozen=True, slots=True)
class WordedError:
    """A refusal in words instead of a number, from older or verbose firmware."""

    text: str


@dataclass(frozen=True, slots=True)
class WordedAlarm:
    """An alarm in words instead of a number."""

    text: str


Answer: TypeAlias = Ok | Error | Alarm | Banner | StatusReport | Info
"""What a device sends."""

END = b"\r\n"
PADDING = b" \t\0"
"""Bytes that are ignored at either end of a line."""

_CODE = re.compile(r" ?([0-9]{1,3})")
_BANNER = re.compile(
    r"(grblhal|grbl) ([!-Z\\^-~]+) \[(?:FluidNC ([^\[\]']*) )?'\$'.* for help\]", re.IGNORECASE
)
_SETTING = re.compile(r"([^= ]+)=(.*)")
_COMMENT = re.compile(r" +\(.*\)$")
_STARTUP = re.compile(r">(.*):(?:ok|error: ?([0-9]{1,3}))")


def encode_answer(answer: Answer) -> bytes:
    """Return the bytes of a line, CR LF at its end; a banner has an empty line before it."""
    before = END if isinstance(answer, Banner) else b""
    return before + answer.line.encode("ascii") + END


def decode_answer(line: bytes) -> Answer | WordedError | WordedAlarm:
    """Decode a line without its end. Raises `RemoteProtocolError`."""
    body = line.strip(PADDING)
    if not all(0x20 <= byte <= 0x7E for byte in body):
        raise RemoteProtocolError("the line has bytes that are no printable ASCII")
    text = body.decode("ascii")
    for start, reader in _READERS.items():
        if text.startswith(start):
            try:
                return reader(text)
            except LocalProtocolError as error:  # the board chose the value
                raise RemoteProtocolError(str(error)) from None
    raise RemoteProtocolError("the line is nothing that this firmware family sends")


def _ok(text: str) -> Ok:
    if text != "ok":
        raise RemoteProtocolError("an ok has something behind it")
    return Ok()


def _error(text: str) -> Error | WordedError:
    rest = text.partition(":")[2]
    code = _CODE.fullmatch(rest)
    return Error(int(code[1])) if code else WordedError(_words(rest))


def _alarm(text: str) -> Alarm | WordedAlarm:
    rest = text.partition(":")[2]
    code = _CODE.fullmatch(rest)
    return Alarm(int(code[1])) if code else WordedAlarm(_words(rest))


def _words(rest: str) -> str:
    """Admit words alone: damaged digits are no words."""
    if not re.search("[A-Za-z]{2}", rest):
        raise RemoteProtocolError(f"'{rest[:16]}' is no code")
    return rest.strip()


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


def _startup(text: str) -> StartupEcho:
    found = _STARTUP.fullmatch(text)
    if found is None:
        raise RemoteProtocolError("a startup line does not say how it went")
    return StartupEcho(found[1], int(found[2]) if found[2] else None)


def _bracketed(text: str) -> Info:
    if not text.endswith("]"):
        raise RemoteProtocolError("a bracket is not closed")
    name, colon, rest = text[1:-1].partition(":")
    if colon and is_parameter(name):
        return _parameter(name, rest)
    reader = _BRACKETS.get(name) if colon else None
    return Bracketed(text[1:-1]) if reader is None else reader(rest)


def _parameter(name: str, rest: str) -> Parameter:
    numbers, colon, success = rest.partition(":")
    if colon and success not in ("0", "1"):
        raise RemoteProtocolError("a probing is either 0 or 1")
    return Parameter(name, decimals(numbers), success == "1" if colon else None)


def _version(rest: str) -> Version:
    version, _, note = rest.partition(":")
    return Version(version, note)


def _build_info(rest: str) -> BuildInfo:
    letters, *parts = rest.split(",")
    numbers = [int(part) for part in parts[:2] if part.isdigit() and len(part) <= 5]
    if len(numbers) != len(parts[:2]):
        raise RemoteProtocolError("the blocks or the ring of the build are no numbers")
    padded = (*numbers, None, None)
    return BuildInfo(letters, padded[0], padded[1], tuple(parts[2:]))


def _axes_info(rest: str) -> AxesInfo:
    count, _, letters = rest.replace(" ", "").partition(":")
    if not re.fullmatch("[0-9]{1,2}", count):
        raise RemoteProtocolError("the number of axes is no number")
    return AxesInfo(int(count), letters)


_BRACKETS: dict[str, Callable[[str], Info]] = {
    "MSG": Feedback,
    "GC": lambda rest: ParserState(tuple(rest.split())),
    "VER": _version,
    "OPT": _build_info,
    "AXS": _axes_info,
}

_READERS: dict[str, Callable[[str], Answer | WordedError | WordedAlarm]] = {
    "ok": _ok,
    "error:": _error,
    "<": read_status,
    "ALARM:": _alarm,
    "$": _setting,
    "[": _bracketed,
    ">": _startup,
    "Grbl": _banner,
    "grbl": _banner,
}
