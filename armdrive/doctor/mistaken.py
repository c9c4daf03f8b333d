"""A connection that failed: what was heard instead of the dialect that was asked for."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from armdrive.errors import DeviceFault, LinkLost
from armdrive.received import NOT_THE_ANSWER, excerpt
from armdrive.transports.can_address import PREFIX, is_can

if TYPE_CHECKING:
    from armdrive.armsections import Connection
    from armdrive.transports.link import Link

MOST_BYTES = 4096
"""So much is remembered of what came in."""
MOST_WRITES = 64
"""So much of what was sent."""


class Ears:
    """A link that remembers the first bytes that came in over it."""

    def __init__(self, link: Link) -> None:
        self.link = link
        self.heard = bytearray()
        self.sent: list[bytes] = []
        self.remembers = True

    @property
    def description(self) -> str:
        """Name the wire for people."""
        return self.link.description

    def write(self, data: bytes, now_s: float) -> None:
        """Send bytes, and remember the first ones."""
        if self.remembers and len(self.sent) < MOST_WRITES:
            self.sent.append(data)
        self.link.write(data, now_s)

    def read(self, now_s: float) -> bytes:
        """Return what has arrived, and remember it."""
        data = self.link.read(now_s)
        if self.remembers:
            self.heard += data
            self.remembers = len(self.heard) < MOST_BYTES
        return data

    def next_s(self) -> float:
        """Tell when the wire next has something."""
        return self.link.next_s()

    def wait(self, timeout_s: float) -> None:
        """Sleep on the wire."""
        self.link.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` early."""
        self.link.wake()

    def close(self) -> None:
        """Give the wire back."""
        self.link.close()


@contextlib.contextmanager
def overheard(link: Link, wire: Connection) -> Iterator[Ears]:
    """Give a link to connect over; a `DeviceFault` on the way out tells what was heard instead.

    A bus that was lost at once is one on which nobody acknowledges: who is there can be found out.
    """
    ears = Ears(link)
    try:
        yield ears
    except DeviceFault as fault:
        raise explained(fault, bytes(ears.heard), wire, ears.sent) from None
    except LinkLost as lost:
        if not is_can(wire.port):
            raise
        raise LinkLost(f"{str(lost).rstrip('.')}. {_doctor(wire.port)}") from None
    finally:
        ears.remembers = False
        ears.heard.clear()
        ears.sent.clear()


def explained(
    fault: DeviceFault, heard: bytes, wire: Connection, sent: Sequence[bytes] = ()
) -> DeviceFault:
    """Return the fault of a failed connection with what was heard, and who finds out more."""
    instead = "" if is_can(wire.port) else _instead(heard, wire.dialect, sent, str(fault))
    told = [str(fault).rstrip(".") + ".", instead, _doctor(wire.port)]
    return type(fault)(" ".join(part for part in told if part))


def bare(fault: BaseException, wire: Connection) -> str:
    """Return the sentence of a failed connection without its pointer to the doctor."""
    return str(fault).removesuffix(_doctor(wire.port)).rstrip(" .")


def _instead(heard: bytes, dialect: str, sent: Sequence[bytes], told: str) -> str:
    from armdrive.doctor.signs import comes_back, recognise, says_something_readable

    if comes_back(sent, heard):
        return (
            "What is sent comes straight back: transmit and receive are joined somewhere, or the "
            "adapter or the board echoes. Switch the echo off, and check the wiring."
        )
    identity = recognise(heard)
    if identity is not None and identity.dialect != dialect:
        choice = f"say dialect {identity.dialect}" if identity.dialect else identity.remedy
        chosen = f": {choice}" if choice else ""
        return f"What answered is no {dialect}, but {identity.firmware}{chosen}."
    if not heard or identity is not None:
        return ""
    came = "" if NOT_THE_ANSWER in told else f": {excerpt(heard)}"
    if says_something_readable(heard):
        return f"What came is no {dialect}'s{came}."
    return f"What came cannot be read{came}; is the baud rate right?"


def _doctor(port: str) -> str:
    if is_can(port):
        bus = port.removeprefix(PREFIX)
        return f"`armdrive doctor --can '{bus}'` finds out who is there, and moves nothing."
    where, which = (port, "") if port else ("PORT", ", for the port that `armdrive ports` shows,")
    return f"`armdrive doctor {where}`{which} finds out who is there, and moves nothing."
