"""Who is at a port: what each dialect is asked, what that risks, and how its answers are known.

Nothing here knows a dialect: each states its own `Recognition`, and a `Recogniser` puts those of
several dialects into one order. Nothing here opens a port either.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum

from firmware_protocol.lines import LineSplitter

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


class Risk(IntEnum):
    """What a probe may do to a device that it is not meant for. Riskier probes are said later."""

    NONE = 0
    """Nothing: no device keeps anything of it, at any baud rate."""
    NOISE = 1
    """Its bytes mean nothing elsewhere, but they may spoil what another program left half sent."""
    LINE_END = 2
    """It ends a line that another program left half sent."""
    SETTINGS = 3
    """It changes what another device has kept, its speed say, and moves nothing."""
    MOTION = 4
    """It would move another arm, unless the probe that it names in `after` was said before."""


@dataclass(frozen=True, slots=True)
class Probe:
    """Bytes that ask for an answer, said up to `times` times; `wait_s` is for each answer.

    `dialect` names who is expected to answer, and `baud` its baud rate. `after` is the name of a
    probe that takes away the danger of this one: this one is never said before that.
    """

    name: str
    dialect: str
    baud: int
    data: bytes
    wait_s: float
    times: int = 1
    risk: Risk = Risk.NONE
    after: str = ""

    def __post_init__(self) -> None:
        if self.risk is Risk.MOTION and not self.after:
            raise ValueError(
                f"the probe {self.name!r} could move another arm: name the probe that prevents it"
            )


class Certainty(IntEnum):
    """How sure a sign is: where two dialects know the same bytes, the surer one is believed."""

    CHECKED = 0
    """Frames with check bytes."""
    WORDED = 1
    """Answers in words that no other firmware uses."""
    BARE = 2
    """Answers that another firmware could give too, numbers alone say."""


@dataclass(frozen=True, slots=True, eq=False)
class Recognition:
    """How one dialect is recognised.

    `sign` tells from what was heard whose firmware it is, and never raises. The first of `probes`
    is the dialect's own: it alone is enough for a device that is switched on and at rest.
    `details` is asked of a board that has just said its first words: before that, something may be
    left half received in it. `obeys_letters` says that a single letter can move the arm: it is
    looked for before bytes of another baud rate can reach it. `datagrams` says that it can be
    asked over UDP. `installable` names firmware of this dialect that could be put on a board whose
    own firmware armdrive does not speak with.
    """

    sign: Callable[[bytes], Identity | None]
    certainty: Certainty
    probes: tuple[Probe, ...]
    details: Probe | None = None
    obeys_letters: bool = False
    datagrams: bool = False
    installable: str = ""


def in_safe_order(probes: Iterable[Probe]) -> tuple[Probe, ...]:
    """Return probes as they are given. Raises `ValueError` where one comes before its `after`."""
    said: list[str] = []
    given = tuple(probes)
    for probe in given:
        if probe.after and probe.after not in said:
            raise ValueError(f"{probe.name!r} must not be said before {probe.after!r}")
        said.append(probe.name)
    return given


@dataclass(frozen=True, slots=True, eq=False)
class Recogniser:
    """Knows the devices of several dialects, by the dialects' names."""

    known: Mapping[str, Recognition]

    @property
    def probes(self) -> tuple[Probe, ...]:
        """Every probe, in the order in which they are said at one baud rate: by their risk."""
        every = [probe for each in self.known.values() for probe in each.probes]
        return in_safe_order(sorted(every, key=lambda probe: probe.risk))

    def sequence(
        self, given_baud: int | None = None, *, datagrams: bool = False
    ) -> tuple[Probe, ...]:
        """Return the probes in the order in which they are said, all of them at a given baud rate.

        Without one, the arms that obey single letters are looked for first. Before them, at their
        rate, comes what risks nothing: a board with native USB hears it at any rate.
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
        """Return what the devices of a dialect are asked first, at their usual baud rate."""
        known = self.known.get(dialect)
        return None if known is None else known.probes[0]

    def details(self, dialect: str) -> Probe | None:
        """Return what a board of a dialect is asked that has just said its first words."""
        known = self.known.get(dialect)
        return None if known is None else known.details

    def recognise(self, heard: bytes) -> Identity | None:
        """Return whose firmware says such things; None where that is not known. Never raises."""
        heard = heard[-MOST_BYTES:]
        for each in sorted(self.known.values(), key=lambda each: each.certainty):
            if found := each.sign(heard):
                return found
        return self._stranger(heard)

    def _stranger(self, heard: bytes) -> Identity | None:
        firmware = " or ".join(each.installable for each in self.known.values() if each.installable)
        for pattern, name, remedy in _STRANGERS:
            if re.search(pattern, heard, re.MULTILINE):
                return Identity("", name, remedy=remedy.format(firmware=firmware))
        return None


_OTHER_PORT = "choose another port (`armdrive ports`)"
_OTHER_FIRMWARE = f"put {{firmware}} on the board, if it drives the arm; else {_OTHER_PORT}"
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


# What can be told of bytes that no dialect knows.


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


def lines_of(heard: bytes, ends: bytes) -> Iterator[bytes]:
    """Return the lines in some bytes, the last one also where its end has not come."""
    lines = LineSplitter(ends, max_lines=4096)
    lines.feed(heard)
    while (line := lines.next_line()) is not None:
        if isinstance(line, bytes):
            yield line
    if lines.partial:
        yield lines.partial
