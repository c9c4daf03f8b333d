"""Recognise the device at a port: the probes of each dialect, their risks, and the answers.

No dialect is named here: each states its own `Recognition`, and a `Recogniser` orders the probes of
several dialects. Nothing here opens a port.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import TypeVar

from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.lines import LineSplitter

# The messages of a dialect.
M = TypeVar("M")

# Only this many of the last bytes are examined.
MOST_BYTES = 16384

MOST_SHOWN = 48  # bytes in an excerpt


def excerpt(data: bytes, most: int = MOST_SHOWN) -> str:
    """Return the first bytes as printable text, with terminal control codes escaped."""
    text = data[:most].decode("latin-1").encode("unicode_escape").decode("ascii")
    return f"'{text}'{' ...' if len(data) > most else ''}"


@dataclass(frozen=True, slots=True)
class Identity:
    """A device's firmware. `dialect` is empty if armdrive does not support it.

    `greeted` means that the bytes are the board's greeting. `remedy` says what would help with
    unsupported firmware.
    """

    dialect: str
    firmware: str
    greeted: bool = False
    remedy: str = field(default="", compare=False)


class Risk(IntEnum):
    """What a probe may do to a device of another kind. Riskier probes are sent later."""

    NONE = 0
    """Nothing: no device stores anything of it, at any baud rate."""
    NOISE = 1
    """Its bytes mean nothing elsewhere, but may garble a line that is half sent."""
    LINE_END = 2
    """It ends a line that another program left half sent."""
    SETTINGS = 3
    """It changes a setting of another device, such as its speed, but moves nothing."""
    MOTION = 4
    """It would move another arm, unless the probe named in `after` was sent before."""


@dataclass(frozen=True, slots=True)
class Probe:
    """Bytes that ask for an answer, sent up to `times` times; `wait_s` is the timeout of each.

    `after` names a probe that makes this one safe, and is always sent before it. `dialect` is the
    one expected to answer, and `baud` its usual baud rate: both come from its row of the registry.
    """

    name: str
    data: bytes
    wait_s: float
    times: int = 1
    risk: Risk = Risk.NONE
    after: str = ""
    dialect: str = ""
    baud: int = 0

    def __post_init__(self) -> None:
        if self.risk is Risk.MOTION and not self.after:
            raise ValueError(
                f"the probe {self.name!r} could move another arm: name the probe that prevents it"
            )


class Certainty(IntEnum):
    """How certain a sign is: if two dialects recognise the same bytes, the surer one wins."""

    CHECKED = 0
    """Frames with check bytes."""
    WORDED = 1
    """Answers in words that no other firmware uses."""
    BARE = 2
    """Answers that another firmware could give too, such as bare numbers."""


@dataclass(frozen=True, slots=True, eq=False)
class Recognition:
    """How one dialect is recognised.

    `sign` identifies the firmware from received bytes, and never raises. The first of `probes` is
    the dialect's own, which is enough for a device that is switched on and at rest.
    `obeys_letters` means that a single letter can move the arm, so it is probed before bytes of
    another baud rate can reach it. `greets_on_open` means that a board greets each program that
    opens its port, so that a greeting is no sign of a restart. `datagrams` means that it can be
    probed over UDP. `installable` names firmware of this dialect that could replace unsupported
    firmware on a board.
    """

    sign: Callable[[bytes], Identity | None]
    certainty: Certainty
    probes: tuple[Probe, ...]
    obeys_letters: bool = False
    greets_on_open: bool = False
    datagrams: bool = False
    installable: str = ""

    def of(self, dialect: str, baud: int) -> Recognition:
        """Return the same with probes for a dialect at its usual baud rate."""
        probes = tuple(replace(each, dialect=dialect, baud=baud) for each in self.probes)
        return replace(self, probes=probes)


def in_safe_order(probes: Iterable[Probe]) -> tuple[Probe, ...]:
    """Return the probes unchanged. Raises `ValueError` if one comes before its `after`."""
    earlier: list[str] = []
    given = tuple(probes)
    for probe in given:
        if probe.after and probe.after not in earlier:
            raise ValueError(f"{probe.name!r} must not be sent before {probe.after!r}")
        earlier.append(probe.name)
    return given


@dataclass(frozen=True, slots=True, eq=False)
class Recogniser:
    """Recognises the devices of several dialects, by the dialects' names."""

    known: Mapping[str, Recognition]

    @property
    def probes(self) -> tuple[Probe, ...]:
        """Every probe, in the order for one baud rate: by risk."""
        every = [probe for each in self.known.values() for probe in each.probes]
        return in_safe_order(sorted(every, key=lambda probe: probe.risk))

    def sequence(
        self, given_baud: int | None = None, *, datagrams: bool = False
    ) -> tuple[Probe, ...]:
        """Return the probes in sending order, all at the given baud rate.

        Without one, arms that obey single letters come first. Before them, at their rate, come the
        probes without risk: a board with native USB receives them at any rate.
        """
        if datagrams:
            return tuple(each for each in self.probes if self.known[each.dialect].datagrams)
        if given_baud is not None:
            return tuple(replace(each, baud=given_baud) for each in self.probes)
        harmless = [each for each in self.probes if each.risk is Risk.NONE]
        early = [each for each in self.probes if self.known[each.dialect].obeys_letters]
        rates = dict.fromkeys(each.baud for each in early)
        lead = [replace(each, baud=baud) for baud in rates for each in harmless]
        rest = [each for each in self.probes if each not in early]
        return in_safe_order([*lead, *early, *rest])

    def own_probe(self, dialect: str) -> Probe | None:
        """Return a dialect's own probe, at its usual baud rate."""
        known = self.known.get(dialect)
        return None if known is None else known.probes[0]

    def greets_on_open(self, dialect: str) -> bool:
        """Return whether a board greets when its port is opened, also if it did not restart."""
        known = self.known.get(dialect)
        return known is not None and known.greets_on_open

    def recognise(self, received: bytes) -> Identity | None:
        """Identify the firmware that sent some bytes; None if it is unknown. Never raises."""
        received = received[-MOST_BYTES:]
        for each in sorted(self.known.values(), key=lambda each: each.certainty):
            if found := each.sign(received):
                return found
        return self._unsupported(received)

    def _unsupported(self, received: bytes) -> Identity | None:
        firmware = " or ".join(each.installable for each in self.known.values() if each.installable)
        for pattern, name, remedy in _UNSUPPORTED:
            if re.search(pattern, received, re.MULTILINE):
                return Identity("", name, remedy=remedy.format(firmware=firmware))
        return None


_OTHER_PORT = "choose another port (`armdrive ports`)"
_OTHER_FIRMWARE = f"put {{firmware}} on the board, if it drives the arm; else {_OTHER_PORT}"
# Other devices that are often connected to such a port.
_UNSUPPORTED = (
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
        "an ESP32 whose firmware has sent nothing yet",
        "wait until it has started; if nothing else comes, its firmware is missing or broken",
    ),
)


# Bytes that no dialect recognises.


def says_something_readable(received: bytes) -> bool:
    """Return whether bytes look like text, as they do only at the right baud rate."""
    printable = sum(0x20 <= byte <= 0x7E or byte in b"\r\n\t" for byte in received)
    return printable >= 0.9 * len(received)


# How many of the first writes are searched for in the received bytes.
FIRST_WRITES = 8


def comes_back(sent: Sequence[bytes], received: bytes) -> bool:
    """Return whether sent bytes came back in order, possibly with answers in between.

    Line ends may come back changed, as terminals send them.
    """
    pieces = [piece.rstrip(b"\r\n") for piece in sent]
    words = [piece for piece in pieces if len(piece) > 1][:FIRST_WRITES]
    if not words:  # single bytes alone: one after the other
        words, received = [b"".join(pieces)[:FIRST_WRITES]], received.translate(None, b"\r\n")
    at = 0
    for word in words:
        at = received.find(word, at)
        if len(word) < 2 or at < 0:
            return False
        at += len(word)
    return True


def decoded(received: bytes, ends: bytes, decode: Callable[[bytes], M]) -> Iterator[M | None]:
    """Decode every line in some bytes, also an unfinished last one; yield None if that fails."""
    lines = LineSplitter(ends)
    lines.feed(received)
    found = [line for line in iter(lines.next_line, None) if isinstance(line, bytes)]
    for line in (*found, lines.partial) if lines.partial else found:
        try:
            yield decode(line)
        except RemoteProtocolError:
            yield None
