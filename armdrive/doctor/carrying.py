"""Gives the probing a wire and a clock."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Protocol

from armdrive.doctor.probes import QUICK_BAUD
from armdrive.doctor.probing import Examination, Script, Turn, examine
from armdrive.errors import PortUnavailable
from armdrive.transports.link import Link
from armdrive.transports.serial_port import SerialLink
from armdrive.transports.udp import UdpLink
from armdrive.transports.url import host_and_port, scheme

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
