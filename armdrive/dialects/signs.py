"""The table of signs: what was heard, and whose firmware says such things. Nothing here raises."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from firmware_protocol import armdroid, grbl, robko01
from firmware_protocol.armdroid.wire import decode_answer as armdroid_answer
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.grbl.reports import decode_answer as grbl_answer
from firmware_protocol.lines import LineSplitter
from firmware_protocol.teachmover import Registers, Status
from firmware_protocol.teachmover.wire import decode_reply

MOST_BYTES = 16384
"""More than this is not looked at."""


@dataclass(frozen=True, slots=True)
class Identity:
    """Whose firmware it is. `dialect` is empty where armdrive does not speak with it.

    `restarted` says that these are the first words of a board that has just started. `remedy` says
    what would help, where armdrive does not speak with it.
    """

    dialect: str
    firmware: str
    restarted: bool = False
    remedy: str = field(default="", compare=False)


def recognise(heard: bytes) -> Identity | None:
    """Return who says such things; None where nobody is known who does."""
    found = None
    for sign in SIGNS:
        if found := sign(heard[-MOST_BYTES:]):
            break
    return found


def says_something_readable(heard: bytes) -> bool:
    """Tell whether bytes look like text: at a wrong baud rate they do not."""
    printable = sum(0x20 <= byte <= 0x7E or byte in b"\r\n\t" for byte in heard)
    return printable >= 0.9 * len(heard)


FIRST_WRITES = 8
"""So many of the first writes are looked for in what came back."""


def comes_back(sent: Sequence[bytes], heard: bytes) -> bool:
    """Tell whether what was sent was heard again, in its order; answers may stand in between.

    A line end may come back as another one, as terminals send it.
    """
    pieces = [piece.rstrip(b"\r\n") for piece in sent]
    words = [piece for piece in pieces if len(piece) > 1][:FIRST_WRITES]
    words = words or [b"".join(pieces)[:FIRST_WRITES]]  # single bytes alone: one after the other
    at = 0
    for word in words:
        at = heard.find(word, at)
        if len(word) < 2 or at < 0:
            return False
        at += len(word)
    return True


def _lines(heard: bytes, ends: bytes) -> Iterator[bytes]:
    """Return the lines, the last one also where its end has not come."""
    lines = LineSplitter(ends, max_lines=4096)
    lines.feed(heard)
    while (line := lines.next_line()) is not None:
        if isinstance(line, bytes):
            yield line
    if lines.partial:
        yield lines.partial


def _armdroid(heard: bytes) -> Identity | None:
    firmware, restarted, seen = "", False, False
    for line in _lines(heard, b"\r\n"):
        try:
            answer = armdroid_answer(line)
        except RemoteProtocolError:
            continue
        seen = True
        if isinstance(answer, armdroid.VersionReported):
            spoken = f", protocol {answer.protocol}" if answer.protocol else ""
            firmware = f"Armdroid serial driver {answer.firmware}{spoken}"
        restarted |= isinstance(answer, armdroid.Welcome)
    found = Identity("armdroid", firmware or "Armdroid serial driver", restarted)
    return found if seen else None


_OLD = re.compile(r"grbl 0\.", re.IGNORECASE)
_GRBL_FIRMWARE = "GRBL 1.1, grbl-Mega-5X, grblHAL or FluidNC"
_BEGUN_BANNER = re.compile(rb"(?:^|[\r\n])(grbl(?:hal)? [0-9][!-~]*)", re.IGNORECASE)
"""Enough of a banner, where its end was lost or something stands before it."""
_REFUSAL = re.compile(rb"(?:^|[\r\n])error:[0-9]{1,3}\r?\n")


def _grbl(heard: bytes) -> Identity | None:
    firmware, restarted, seen = "", False, _REFUSAL.search(heard) is not None
    for line in _lines(heard, b"\r\n"):
        try:
            answer = grbl_answer(line)
        except RemoteProtocolError:
            continue
        seen |= isinstance(answer, grbl.StatusReport | grbl.Alarm)
        if isinstance(answer, grbl.Banner):
            firmware = f"{answer.variant} {answer.version}"
            if answer.firmware:
                firmware = f"FluidNC {answer.firmware}"
            restarted = True
        elif isinstance(answer, grbl.Version) and answer.version:
            firmware = f"{firmware or 'GRBL'} ({answer.version})"
    begun = _BEGUN_BANNER.search(heard)
    if not firmware and begun:
        firmware, restarted = begun[1].decode("ascii"), True
    if _OLD.match(firmware):
        return Identity(
            "",
            f"{firmware}, whose reports have an older form",
            restarted,
            f"put {_GRBL_FIRMWARE} on the board",
        )
    found = Identity("grbl", firmware or "GRBL, version not told", restarted)
    return found if seen or firmware else None


def _robko01(heard: bytes) -> Identity | None:
    host = robko01.Host()
    host.receive_data(heard)
    host.silence()
    while (event := host.next_event()) is not None:
        if isinstance(event, robko01.Stray):
            return Identity("robko01", "Robko 01 SUPER protocol")
    return None


def _teachmover(heard: bytes) -> Identity | None:
    """Take seven numbers for a TeachMover's registers behind a status line alone."""
    before: object = None
    for line in _lines(heard, b"\r"):
        try:
            reply = decode_reply(line)
        except RemoteProtocolError:
            before = None
            continue
        if isinstance(reply, Registers):
            if before is Status.DONE:
                return Identity("teachmover", "TeachMover")
            return Identity(
                "",
                "Robko 01 retrofit, in its text mode",
                remedy="switch the retrofit to its SUPER protocol, which is the dialect robko01",
            )
        before = reply
    return None


_OTHER_PORT = "choose another port (`armdrive ports`)"
_OTHER_FIRMWARE = f"put {_GRBL_FIRMWARE} on the board, if it drives the arm; else {_OTHER_PORT}"

_STRANGERS = (
    (
        rb"echo:\s*Marlin|Marlin [0-9b]|FIRMWARE_NAME:\s*Marlin",
        "Marlin, the firmware of a 3D printer",
        _OTHER_FIRMWARE,
    ),
    (rb"Smoothie", "Smoothieware", _OTHER_FIRMWARE),
    (rb"Repetier", "Repetier, the firmware of a 3D printer", _OTHER_FIRMWARE),
    (rb"TinyG|g2core", "TinyG", _OTHER_FIRMWARE),
    (rb"MicroPython|^>>> $", "MicroPython without a program", _OTHER_PORT),
    (rb"\blogin: ", "a computer that asks for a login", _OTHER_PORT),
    (
        rb"rst:0x[0-9a-f]+ \(|ets [A-Z][a-z]{2} ",
        "an ESP32 whose firmware has said nothing yet",
        "wait until it has started; if it says no more, its firmware is missing or broken",
    ),
)
"""What is often found on such a port, and is no arm."""


def _stranger(heard: bytes) -> Identity | None:
    for pattern, name, remedy in _STRANGERS:
        if re.search(pattern, heard, re.MULTILINE):
            return Identity("", name, remedy=remedy)
    return None


SIGNS: tuple[Callable[[bytes], Identity | None], ...] = (
    _robko01,
    _armdroid,
    _grbl,
    _teachmover,
    _stranger,
)
"""In this order; frames with check bytes are the surest."""
