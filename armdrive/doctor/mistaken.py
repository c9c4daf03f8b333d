"""A connection that failed: what was heard instead of the dialect that was asked for."""

from __future__ import annotations

from armdrive.doctor.signs import MOST_BYTES, recognise, says_something_readable, shown
from armdrive.errors import DeviceFault
from armdrive.transports.link import Link


class Ears:
    """A link that remembers what came in over it, until it is told to listen no more."""

    def __init__(self, link: Link) -> None:
        self.link = link
        self.heard = bytearray()

    @property
    def description(self) -> str:
        """Name the wire for people."""
        return self.link.description

    def write(self, data: bytes, now_s: float) -> None:
        """Send bytes."""
        self.link.write(data, now_s)

    def read(self, now_s: float) -> bytes:
        """Return what has arrived, and remember it."""
        data = self.link.read(now_s)
        self.heard += data[: max(MOST_BYTES - len(self.heard), 0)]
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


def explained(fault: DeviceFault, heard: bytes, *, dialect: str, port: str) -> DeviceFault:
    """Return the fault of a failed connection with what was heard, and who finds out more."""
    told = " ".join(part for part in (_instead(heard, dialect), _doctor(port)) if part)
    return type(fault)(f"{fault}. {told}" if told else str(fault))


def _instead(heard: bytes, dialect: str) -> str:
    identity = recognise(heard)
    if identity is not None and identity.dialect != dialect:
        chosen = f": say dialect {identity.dialect}" if identity.dialect else ""
        return f"What answered is no {dialect}, but {identity.firmware}{chosen}."
    if not heard or identity is not None:
        return ""
    if says_something_readable(heard):
        return f"What came is no {dialect}'s: {shown(bytes(heard))}."
    return f"What came cannot be read: {shown(bytes(heard))}; is the baud rate right?"


def _doctor(port: str) -> str:
    return f"`armdrive doctor {port}` finds out who is there, and moves nothing." if port else ""
