"""Goes through the table of probes until somebody is recognised. No wire, no clock.

`examine` is a generator: it yields what is to be said and for how long to listen, and is sent what
was heard.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from dataclasses import dataclass, field, replace
from typing import Protocol

from armdrive.connect.port import recogniser
from armdrive.dialects.recognition import Identity, Probe
from armdrive.errors import PortUnavailable
from armdrive.transports.address import host_and_port, scheme
from armdrive.transports.link import Link
from armdrive.transports.serial_port import SerialLink
from armdrive.transports.udp import UdpLink

LISTEN_S = 2.5
"""How long is only listened at first: a board that restarts says so within this time, and its
boot loader, which would take probes for its own commands, has ended."""
SETTLE_S = 0.3
"""How long is only listened after the baud rate was changed."""
QUICK_BAUD = 115_200
"""The rate at which boards say their first words. Slow bytes are harmless at it, since one slow
bit fills a whole quick byte: nothing is heard but 0x00, and bytes from 0x80 up whose ones are all
on top."""


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
    probes = recogniser().sequence(given_baud, datagrams=datagrams)
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
        return recogniser().recognise(before + _without_echo(probe.data, data)) is not None

    data = yield Turn(probe.baud, probe.data, probe.wait_s, known)
    heard = Heard(probe.name, probe.baud, probe.data, data)
    identity = _better(found.identity, recogniser().recognise(before + heard.answer))
    return replace(found, identity=identity, heard=(*found.heard, heard))


def _better(known: Identity | None, told: Identity | None) -> Identity | None:
    """Return what is known now; that it restarted stays true."""
    if known is None or told is None:
        return told or known
    return replace(told, restarted=told.restarted or known.restarted)


def _at_usual_rate(found: Examination) -> Script:
    """Ask once more at the usual rate where another was heard: native USB hears at any."""
    identity = found.identity
    probe = recogniser().own_probe(identity.dialect) if identity is not None else None
    if identity is None or probe is None or probe.baud == found.baud:
        return found
    heard_at = found.baud
    found = yield from _turn(found, probe)
    answered = recogniser().recognise(found.heard[-1].answer) is not None
    return replace(found, baud=probe.baud if answered else heard_at)


def _details(found: Examination, given_baud: int | None) -> Script:
    """Ask a board that has just said its first words which version it is."""
    identity = found.identity
    probe = recogniser().details(identity.dialect) if identity is not None else None
    if identity is None or probe is None or not identity.restarted:
        return found
    probe = replace(probe, baud=given_baud or found.baud or probe.baud)
    found = yield from _turn(found, probe)
    return found


# Gives the probing a wire and a clock.

QUIET_S = 0.1
"""A device that was recognised may have something to add for this long."""


class TunableLink(Link, Protocol):
    """A wire whose baud rate can be changed while it is open."""

    def tune(self, baud: int) -> None:
        """Change the baud rate."""


class TunableSerialLink(SerialLink):
    """A serial port that is opened once for all baud rates: each opening may restart a board."""

    def tune(self, baud: int) -> None:
        """Change the baud rate; a raw network connection has none."""
        if baud == self._baud or self._scheme == "socket":
            return
        try:
            self._port.baudrate = baud
        except (OSError, ValueError) as error:
            raise PortUnavailable(
                f"{self._name} cannot be set to {baud} baud ({error}): name another rate"
            ) from None
        self._baud = baud


class TunableUdpLink(UdpLink):
    """Datagrams, which have no baud rate."""

    def tune(self, baud: int) -> None:
        """Nothing is to be changed."""


class Clock(Protocol):
    """Time that passes while somebody listens."""

    def now_s(self) -> float:
        """Return the time."""

    def sleep(self, link: Link, until_s: float) -> None:
        """Let time pass until something may have arrived, or until a moment."""


class RealClock:
    """The computer's own."""

    def now_s(self) -> float:
        """Return the monotonic time."""
        return time.monotonic()

    def sleep(self, link: Link, until_s: float) -> None:
        """Sleep on the link."""
        link.wait(max(until_s - self.now_s(), 0.0))


def examine_port(port: str, baud: int | None) -> Examination:
    """Open a port and find out what it leads to; moves nothing. Raises `LinkError`.

    DTR is raised, since boards with native USB are mute without, and left up where the system can
    leave it, so that the next opening restarts no board. Windows cannot leave it.
    """
    kind = scheme(port)
    network = kind in ("socket", "udp")
    # a raw network connection has no baud rate: one round is enough
    one_baud = baud or (QUICK_BAUD if network else None)
    link = _opened(port, one_baud or QUICK_BAUD)
    found = carry_out(examine(one_baud, datagrams=kind == "udp"), link, RealClock())
    return replace(found, baud=None) if network else found


def _opened(port: str, baud: int) -> TunableLink:
    if scheme(port) == "udp":
        return TunableUdpLink(*host_and_port(port))
    return TunableSerialLink(port, baud, raise_dtr=True, keep_dtr_on_close=True)


def carry_out(script: Script, link: TunableLink, clock: Clock) -> Examination:
    """Carry out a script on a link, and close it."""
    try:
        turn = next(script)
        while True:
            turn = script.send(_take_turn(turn, link, clock))
    except StopIteration as end:
        found: Examination = end.value
        return found
    finally:
        link.close()


def _take_turn(turn: Turn, link: TunableLink, clock: Clock) -> bytes:
    now_s = clock.now_s()
    link.tune(turn.baud)
    if turn.data:
        link.write(turn.data, now_s)
    heard = bytearray(link.read(now_s))
    until_s, known = now_s + turn.wait_s, False
    while now_s < until_s:
        clock.sleep(link, until_s)
        now_s = clock.now_s()
        heard += link.read(now_s)
        if not known and turn.enough(bytes(heard)):
            known, until_s = True, now_s + QUIET_S
    return bytes(heard)
