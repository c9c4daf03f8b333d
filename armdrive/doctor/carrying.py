"""Gives the probing a wire and a clock."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Protocol

from armdrive.doctor.probes import QUICK_BAUD
from armdrive.doctor.probing import Examination, Script, Turn, examine
from armdrive.transports.link import Link
from armdrive.transports.url import open_link, scheme

QUIET_S = 0.1
"""A device that was recognised may have something to add for this long."""

Opening = Callable[[int], Link]


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

    DTR is raised and left up where the system can leave it, so that neither a change of the baud
    rate nor the next program restarts a board. Windows cannot: there it is never raised.
    """

    def opened(at_baud: int) -> Link:
        posix = os.name == "posix"
        return open_link(port, at_baud, raise_dtr=posix, keep_dtr_on_close=posix)

    # a raw network connection has no baud rate: one round is enough
    one_baud = baud or (QUICK_BAUD if scheme(port) in ("socket", "udp") else None)
    return carry_out(examine(one_baud, datagrams=scheme(port) == "udp"), opened, RealClock())


def carry_out(script: Script, opened: Opening, clock: Clock) -> Examination:
    """Carry out a script on the link that `opened(baud)` gives, one link at a time."""
    link: Link | None = None
    baud, answer = 0, None
    try:
        while True:
            turn = next(script) if answer is None else script.send(answer)
            if link is None or turn.baud != baud:
                if link is not None:
                    link.close()
                link, baud = opened(turn.baud), turn.baud
            answer = _take_turn(turn, link, clock)
    except StopIteration as end:
        found: Examination = end.value
        return found
    finally:
        if link is not None:
            link.close()


def _take_turn(turn: Turn, link: Link, clock: Clock) -> bytes:
    now_s = clock.now_s()
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
