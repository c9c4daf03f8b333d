"""Goes through the table of probes until somebody is recognised: a script, at any baud rate."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Protocol, TypeAlias

from armdrive.connect.port import recogniser
from armdrive.dialects.exchange import Received, ScriptIO, ScriptLoop
from armdrive.dialects.recognition import Identity, Probe
from armdrive.errors import PortUnavailable
from armdrive.setup import dialog_runner
from armdrive.setup.dialog_runner import Clock, carry_out
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
QUIET_S = 0.1
"""A device that was recognised may have something to add for this long."""


class ProbeWire(ScriptIO[bytes]):
    """Says bytes at a baud rate, and listens. `tune` changes the rate."""

    def __init__(self, tune: Callable[[int], None]) -> None:
        super().__init__(lambda _data: None)
        self._tune = tune

    def turn(
        self, probe: Probe, enough: Callable[[bytes], bool]
    ) -> Generator[float, bytes | None, bytes]:
        """Say a probe, then listen for its time, or until it is enough and a while longer."""
        self._tune(probe.baud)
        self.say(probe.data)
        told = yield from self.collect(probe.wait_s, lambda heard: enough(b"".join(heard)), QUIET_S)
        return b"".join(told)


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


Script: TypeAlias = Generator[float, bytes | None, Examination]


def examination(wire: ProbeWire, given_baud: int | None, datagrams: bool) -> Script:
    """Find out what a port leads to; with `given_baud` at that baud rate alone."""
    probes = recogniser().sequence(given_baud, datagrams=datagrams)
    first_baud = given_baud or QUICK_BAUD  # whoever has something to say at the start says it so
    found = yield from _listen(wire, Examination(), first_baud, 0.0 if datagrams else LISTEN_S)
    for probe in probes:
        if found.identity is not None:
            break
        if probe.baud != found.baud:
            found = yield from _listen(wire, found, probe.baud, SETTLE_S)
        found = yield from _probe(wire, found, probe)
    if given_baud is None:
        found = yield from _at_usual_rate(wire, found)
    return (yield from _details(wire, found, given_baud))


def _probe(wire: ProbeWire, found: Examination, probe: Probe) -> Script:
    for _ in range(probe.times):
        if found.identity is None:
            found = yield from _turn(wire, found, probe)
    return found


def _listen(wire: ProbeWire, found: Examination, baud: int, wait_s: float) -> Script:
    found = yield from _turn(wire, replace(found, baud=baud), Probe("", "", baud, b"", wait_s))
    return found


def _turn(wire: ProbeWire, found: Examination, probe: Probe) -> Script:
    """Say a probe, and weigh all that was heard at this baud rate so far."""
    before = b"".join(each.answer for each in found.heard if each.baud == probe.baud)

    def known(data: bytes) -> bool:
        return recogniser().recognise(before + _without_echo(probe.data, data)) is not None

    data = yield from wire.turn(probe, known)
    heard = Heard(probe.name, probe.baud, probe.data, data)
    identity = _better(found.identity, recogniser().recognise(before + heard.answer))
    return replace(found, identity=identity, heard=(*found.heard, heard))


def _better(known: Identity | None, told: Identity | None) -> Identity | None:
    """Return what is known now; that it restarted stays true."""
    if known is None or told is None:
        return told or known
    return replace(told, restarted=told.restarted or known.restarted)


def _at_usual_rate(wire: ProbeWire, found: Examination) -> Script:
    """Ask once more at the usual rate where another was heard: native USB hears at any."""
    identity = found.identity
    probe = recogniser().own_probe(identity.dialect) if identity is not None else None
    if identity is None or probe is None or probe.baud == found.baud:
        return found
    heard_at = found.baud
    found = yield from _turn(wire, found, probe)
    answered = recogniser().recognise(found.heard[-1].answer) is not None
    return replace(found, baud=probe.baud if answered else heard_at)


def _details(wire: ProbeWire, found: Examination, given_baud: int | None) -> Script:
    """Ask a board that has just said its first words which version it is."""
    identity = found.identity
    probe = recogniser().details(identity.dialect) if identity is not None else None
    if identity is None or probe is None or not identity.restarted:
        return found
    probe = replace(probe, baud=given_baud or found.baud or probe.baud)
    found = yield from _turn(wire, found, probe)
    return found


# Gives the probing a wire and a clock.


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
    found = examine(link, dialog_runner.RealClock(), one_baud, datagrams=kind == "udp")
    return replace(found, baud=None) if network else found


def _opened(port: str, baud: int) -> TunableLink:
    if scheme(port) == "udp":
        return TunableUdpLink(*host_and_port(port))
    return TunableSerialLink(port, baud, raise_dtr=True, keep_dtr_on_close=True)


def examine(
    link: TunableLink, clock: Clock, given_baud: int | None, *, datagrams: bool = False
) -> Examination:
    """Find out what a link leads to, and close it."""
    wire = ProbeWire(link.tune)
    loop = ScriptLoop(Received(lambda data: (data,) if data else ()), wire)
    try:
        found: Examination = carry_out(
            loop, partial(examination, wire, given_baud, datagrams), link, clock
        )
    finally:
        link.close()
    return found
