"""Finds out who answers on an open wire: a device on a serial port, or the drives of a CAN bus.

`examine_port` opens a serial port and runs the script `examination` on it: listen, then go through
the probes of all dialects in an order that moves nothing, and judge after each what has come so
far. `ask_bus` asks the ids of a CAN bus in every protocol, the harmless ones first.

Nothing that is sent here moves an arm of any dialect (docs/how-to/finding-the-arm.md).
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from types import MappingProxyType
from typing import Protocol, TypeAlias

from armdrive.connect.port import recogniser
from armdrive.dialects.bus.tools import Answers, BusTools, SeenNodes
from armdrive.dialects.exchange import Received, ScriptIO, ScriptLoop
from armdrive.dialects.recognition import Identity, Probe
from armdrive.registry import DIALECTS
from armdrive.setup import dialog_runner
from armdrive.setup.dialog_runner import Clock, carry_out
from armdrive.transports.address import host_and_port, scheme
from armdrive.transports.link import Link
from armdrive.transports.serial_port import SerialLink
from armdrive.transports.udp import UdpLink
from firmware_protocol.frames import Frame

# A serial port: a script goes through the table of probes until a device is recognised.

# The prober listens this long before its first probe. A board that restarts greets within this
# time, and its boot loader, which would take probes for its own commands, has ended.
LISTEN_S = 2.5
# The prober listens this long after it changes the baud rate.
SETTLE_S = 0.3
# The rate at which boards greet. Slower bytes are harmless at this rate, since one slow bit fills a
# whole fast byte: a device receives nothing but 0x00, and bytes from 0x80 up whose ones are all on
# top.
QUICK_BAUD = 115_200
# The prober waits this long for more from a device that it has recognised.
QUIET_S = 0.1


class ProbeIO(ScriptIO[bytes]):
    """Sends bytes at a baud rate, and collects the reply. `tune` changes the rate."""

    def __init__(self, tune: Callable[[int], None]) -> None:
        super().__init__(lambda _data: None)
        self.tune = tune


@dataclass(frozen=True, slots=True)
class ProbeReply:
    """The bytes received after a probe, or, with an empty name, while only listening."""

    probe: str
    baud: int
    sent: bytes
    data: bytes

    @property
    def answer(self) -> bytes:
        """The reply without an echo of the probe."""
        return _without_echo(self.sent, self.data)


def _without_echo(sent: bytes, received: bytes) -> bytes:
    """Return a reply without a copy of the probe, which would be taken for an answer."""
    return received.removeprefix(sent) if len(sent) > 1 else received


@dataclass(frozen=True, slots=True)
class Examination:
    """The device at a port, its baud rate, and every reply on the way to them.

    `baud` is None if the connection has no baud rate.
    """

    identity: Identity | None = None
    baud: int | None = None
    replies: tuple[ProbeReply, ...] = field(default=(), repr=False)

    @property
    def everything(self) -> bytes:
        """All received bytes."""
        return b"".join(each.data for each in self.replies)

    @property
    def echoes(self) -> bool:
        """Whether the line returned a probe, which no dialect does."""
        sent = [each for each in self.replies if len(each.sent) > 1]
        return any(each.data.startswith(each.sent) for each in sent)

    @property
    def restarted(self) -> bool:
        """Whether the device greeted because it restarted when its port was opened."""
        if self.identity is None or recogniser().greets_on_open(self.identity.dialect):
            return False
        return self.identity.greeted


Script: TypeAlias = Generator[float, bytes | None, Examination]


def examination(io: ProbeIO, given_baud: int | None, datagrams: bool) -> Script:
    """Identify the device at a port; with `given_baud` at that baud rate alone."""
    found = Examination()
    # nothing restarts because a socket for datagrams was opened, so there is nothing to wait for
    wait_s = 0.0 if datagrams else LISTEN_S
    found = yield from _turn(io, found, Probe("", b"", wait_s, baud=given_baud or QUICK_BAUD))
    for probe in recogniser().sequence(given_baud, datagrams=datagrams):
        if found.identity is None and probe.baud != found.baud:
            found = yield from _turn(io, found, Probe("", b"", SETTLE_S, baud=probe.baud))
        for _ in range(probe.times):
            if found.identity is None:
                found = yield from _turn(io, found, probe)
    if given_baud is None and found.identity is not None:
        # native USB works at any rate: ask again at the dialect's own
        own, worked_at = recogniser().own_probe(found.identity.dialect), found.baud
        if own is not None and own.baud != worked_at:
            found = yield from _turn(io, found, own)
            if recogniser().recognise(found.replies[-1].answer) is None:
                found = replace(found, baud=worked_at)
    return found


def _turn(io: ProbeIO, found: Examination, probe: Probe) -> Script:
    """Send a probe; judge all replies at this baud rate so far."""
    before = b"".join(each.answer for each in found.replies if each.baud == probe.baud)

    def identified(parts: Sequence[bytes]) -> Identity | None:
        return recogniser().recognise(before + _without_echo(probe.data, b"".join(parts)))

    io.tune(probe.baud)
    io.write(probe.data)
    parts = yield from io.collect(probe.wait_s, lambda got: identified(got) is not None, QUIET_S)
    reply = ProbeReply(probe.name, probe.baud, probe.data, b"".join(parts))
    identity = identified(parts) or found.identity
    return Examination(identity, probe.baud, (*found.replies, reply))


# The wire of a serial probe.


class TunableLink(Link, Protocol):
    """A link whose baud rate can be changed while it is open."""

    def tune(self, baud: int) -> None:
        """Change the baud rate."""


def examine_port(port: str, baud: int | None) -> Examination:
    """Open a port and identify its device. Raises `LinkError`.

    DTR is raised, since boards with native USB stay mute without it. It stays up after closing, so
    that the next opening does not restart the board; Windows cannot do that.
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
        return UdpLink(*host_and_port(port))
    return SerialLink(port, baud, raise_dtr=True, keep_dtr_on_close=True)


def examine(
    link: TunableLink, clock: Clock, given_baud: int | None, *, datagrams: bool = False
) -> Examination:
    """Identify the device on a link, and close the link."""
    io = ProbeIO(link.tune)
    loop = ScriptLoop(Received(lambda data: (data,) if data else ()), io)
    try:
        found: Examination = carry_out(
            loop, partial(examination, io, given_baud, datagrams), link, clock
        )
    finally:
        link.close()
    return found


# A CAN bus: the protocols are tried in an order, and with ids, that harm no drive of another one.
#
# A protocol goes first if its questions do nothing to drives of any other: reading CANopen's
# objects by SDO does nothing to MKS drives, whatever their ids. A question to an MKS drive is a
# frame whose id is the drive's, and from 128 on those ids are CANopen's: SYNC, process data, orders
# to drives. So once a node of a protocol is seen, other protocols are limited to the ids that it
# leaves free.


@cache
def protocols() -> Mapping[str, BusTools]:
    """Return every protocol by its name, in the order in which an unknown bus is asked."""
    buses = (row.bus for row in DIALECTS.values())
    known = sorted((bus for bus in buses if bus is not None), key=lambda bus: not bus.harmless)
    return MappingProxyType({bus.name: bus for bus in known})


def is_command(frame: Frame, master: int | None = None) -> bool:
    """Return whether a frame must be another program's request to a drive, in any protocol.

    The heartbeat of the node `master` counts as one.
    """
    rows = protocols().values()
    if any(row.reads_answer(frame) for row in rows):
        return False
    return any(row.reads_command(frame, master) for row in rows)


def nodes_seen(frames: Sequence[Frame]) -> SeenNodes:
    """Return the nodes that sent these frames, with the state that each reported."""
    return {
        node: state for row in protocols().values() for node, state in row.heard(frames).items()
    }


def ask_bus(
    link: Link,
    clock: Clock,
    ids: Sequence[int],
    seen: SeenNodes = MappingProxyType({}),
    dialect: str = "",
) -> tuple[Answers, ...]:
    """Return the answers of each protocol's drives. Raises `LinkLost`.

    With `dialect` its protocol is asked first, and another one only if no drive answers.
    """
    rows = sorted(protocols().values(), key=lambda row: row.dialect != dialect)
    answers: list[Answers] = []
    for row in rows:
        if dialect and any(each.there for each in answers):
            break
        chosen = [each for each in harmless_ids(ids, answers, seen) if each <= row.most]
        if chosen or seen:
            scripts = row.scripts(chosen)
            ask = partial(row.ask, scripts.io, chosen, seen)
            answers.append(carry_out(scripts, ask, link, clock))
    return tuple(answers)


def harmless_ids(ids: Sequence[int], answers: Sequence[Answers], seen: SeenNodes) -> list[int]:
    """Return the ids without those that mean something to a node seen on the bus."""
    there = {each.protocol for each in answers if each.there}
    free = [
        row.leaves_free
        for row in protocols().values()
        if row.leaves_free is not None and (seen or row.name in there)
    ]
    return [each for each in ids if all(each <= most for most in free)]
