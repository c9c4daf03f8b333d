"""The table of probes: what is said to a port of which nobody knows what it leads to.

Each is said only while nothing has been recognised. None of them moves any arm of the table of
dialects, and none leaves anything half received in it; docs/finding-the-arm.md says why, byte by
byte, and tests say it to the simulated arms.

At one baud rate the order is that of the table: what leaves no trace anywhere comes first. Where
both are tried, the Armdroid is looked for before anybody hears bytes of another rate than its own:
it is the one dialect in which a single letter moves an arm. Before it `?` is said, for boards with
native USB, which hear at any rate. Slow bytes are harmless at the quick
rate, since one slow bit fills a whole quick byte: nothing is heard but 0x00, and bytes from 0x80
up whose ones are all on top.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from armdrive.dialects.teachmover.controller import FIRST_LINE
from firmware_protocol.armdroid import Version
from firmware_protocol.armdroid import wire as armdroid_wire
from firmware_protocol.grbl import Realtime
from firmware_protocol.robko01 import Host, Ping
from firmware_protocol.teachmover import Read
from firmware_protocol.teachmover import wire as teachmover_wire
from firmware_protocol.teachmover.messages import ATTENTION

CR = b"\r"
QUICK_BAUD, SLOW_BAUD = 115200, 9600

LISTEN_S = 2.5
"""How long is only listened at first: a board that restarts says so within this time, and its
boot loader, which would take probes for its own commands, has ended."""
SETTLE_S = 0.3
"""How long is only listened after the baud rate was changed."""


@dataclass(frozen=True, slots=True)
class Probe:
    """Bytes that ask for an answer, said up to `times` times; `wait_s` is for each answer.

    `dialect` names who is expected to answer, and `baud` its baud rate.
    """

    name: str
    dialect: str
    baud: int
    data: bytes
    wait_s: float
    times: int = 1


PROBES = (
    Probe("?", "grbl", QUICK_BAUD, bytes((Realtime.STATUS,)), 0.5, times=2),
    # six times six bytes: a frame that another program left half sent swallows 29 at most
    Probe("ping", "robko01", QUICK_BAUD, Host().send(Ping()), 0.15, times=6),
    # the CR ends what a board of another dialect takes for a line
    Probe("v", "armdroid", SLOW_BAUD, armdroid_wire.encode_command(Version()) + CR, 0.5),
    # an Armdroid that was too busy to answer has nothing to repeat after this
    Probe("a line that moves no arm", "teachmover", SLOW_BAUD, FIRST_LINE, 0.5),
    Probe("@READ", "teachmover", SLOW_BAUD, teachmover_wire.encode_command(Read(), ATTENTION), 1.0),
)

_IN_DATAGRAMS = "robko01"
"""Other dialects know no datagrams."""


def sequence(given_baud: int | None = None, *, datagrams: bool = False) -> tuple[Probe, ...]:
    """Return the probes in the order in which they are said, all of them at a given baud rate."""
    if datagrams:
        return tuple(each for each in PROBES if each.dialect == _IN_DATAGRAMS)
    if given_baud is not None:
        return tuple(replace(each, baud=given_baud) for each in PROBES)
    status, ping, version, *rest = PROBES
    return (replace(status, baud=version.baud), version, status, ping, *rest)


def own_probe(dialect: str) -> Probe | None:
    """Return what the devices of a dialect are asked first, at the rate that is usual for them."""
    return next((each for each in PROBES if each.dialect == dialect), None)


DETAILS = {
    "armdroid": Probe("v", "armdroid", SLOW_BAUD, armdroid_wire.encode_command(Version()), 0.5),
    "grbl": Probe("$I", "grbl", QUICK_BAUD, b"$I\n", 0.5),
}
"""What is asked of a board that has just restarted and said who it is.

Before that nothing can be left half received in it. To a GRBL board that did not restart, no line
end is ever sent: it could complete a line that another program left half sent.
"""
