"""Goes through the table of probes until somebody is recognised. No wire, no clock.

`examine` is a generator: it yields what is to be said and for how long to listen, and is sent what
was heard.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, field, replace

from armdrive.doctor.probes import (
    DETAILS,
    LISTEN_S,
    QUICK_BAUD,
    SETTLE_S,
    Probe,
    own_probe,
    sequence,
)
from armdrive.doctor.signs import Identity, recognise


@dataclass(frozen=True, slots=True)
class Turn:
    """Say `data` at `baud`, then listen for `wait_s`, or until `enough` says of what was heard."""

    baud: int
    data: bytes
    wait_s: float
    enough: Callable[[bytes], bool]


@dataclass(frozen=True, slots=True)
class Heard:
    """What was heard after a probe was said, or (with an empty name) while only listening."""

    probe: str
    baud: int
    said: bytes
    data: bytes

    @property
    def answer(self) -> bytes:
        """What was heard beside an echo of what was said."""
        return _without_echo(self.said, self.data)


def _without_echo(said: bytes, heard: bytes) -> bytes:
    """Return what was heard without a copy of what was said: it would be taken for an answer."""
    return heard.removeprefix(said) if len(said) > 1 else heard


@dataclass(frozen=True, slots=True)
class Examination:
    """What came of it: who it is and at which baud rate, and all that was heard on the way.

    `baud` is None where the connection has none.
    """

    identity: Identity | None = None
    baud: int | None = None
    heard: tuple[Heard, ...] = field(default=(), repr=False)

    @property
    def everything(self) -> bytes:
        """All that was heard."""
        return b"".join(each.data for each in self.heard)

    @property
    def echoes(self) -> bool:
        """Tell whether what was said came back, which no dialect does."""
        said = [each for each in self.heard if len(each.said) > 1]
        return any(each.data.startswith(each.said) for each in said)

    @property
    def restarted(self) -> bool:
        """Tell whether the device was heard to begin anew when its port was opened.

        First words at another baud rate than its own cannot be read, but were heard.
        """
        if self.identity is None:
            return False
        first = self.heard[:1] if self.baud is not None else ()
        elsewhere = any(each.data and each.baud != self.baud for each in first)
        return self.identity.restarted or elsewhere


Script = Generator[Turn, bytes, Examination]


def examine(given_baud: int | None = None, *, datagrams: bool = False) -> Script:
    """Find out what a port leads to; with `given_baud` at that baud rate alone."""
    probes = sequence(given_baud, datagrams=datagrams)
    first_baud = given_baud or QUICK_BAUD  # whoever has something to say at the start says it so
    found = yield from _listen(Examination(), first_baud, 0.0 if datagrams else LISTEN_S)
    for probe in probes:
        if found.identity is not None:
            break
        if probe.baud != found.baud:
            found = yield from _listen(found, probe.baud, SETTLE_S)
        found = yield from _probe(found, probe)
    if given_baud is None:
        found = yield from _at_usual_rate(found)
    return (yield from _details(found, given_baud))


def _probe(found: Examination, probe: Probe) -> Script:
    for _ in range(probe.times):
        if found.identity is None:
            found = yield from _turn(found, probe)
    return found


def _listen(found: Examination, baud: int, wait_s: float) -> Script:
    found = yield from _turn(replace(found, baud=baud), Probe("", "", baud, b"", wait_s))
    return found


def _turn(found: Examination, probe: Probe) -> Script:
    """Say a probe, and weigh all that was heard at this baud rate so far."""
    before = b"".join(each.answer for each in found.heard if each.baud == probe.baud)

    def known(data: bytes) -> bool:
        return recognise(before + _without_echo(probe.data, data)) is not None

    data = yield Turn(probe.baud, probe.data, probe.wait_s, known)
    heard = Heard(probe.name, probe.baud, probe.data, data)
    identity = _better(found.identity, recognise(before + heard.answer))
    return replace(found, identity=identity, heard=(*found.heard, heard))


def _better(known: Identity | None, told: Identity | None) -> Identity | None:
    """Return what is known now; that it restarted stays true."""
    if known is None or told is None:
        return told or known
    return replace(told, restarted=told.restarted or known.restarted)


def _at_usual_rate(found: Examination) -> Script:
    """Ask once more at the usual rate where another was heard: native USB hears at any."""
    identity = found.identity
    probe = own_probe(identity.dialect) if identity is not None else None
    if identity is None or probe is None or probe.baud == found.baud:
        return found
    heard_at = found.baud
    found = yield from _turn(found, probe)
    answered = recognise(found.heard[-1].answer) is not None
    return replace(found, baud=probe.baud if answered else heard_at)


def _details(found: Examination, given_baud: int | None) -> Script:
    """Ask a board that has just said its first words which version it is."""
    identity = found.identity
    probe = DETAILS.get(identity.dialect) if identity is not None else None
    if identity is None or probe is None or not identity.restarted:
        return found
    probe = replace(probe, baud=given_baud or found.baud or probe.baud)
    found = yield from _turn(found, probe)
    return found
