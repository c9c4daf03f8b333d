"""How the wire of a real arm is found and opened, the first time and after it was lost."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from types import MappingProxyType

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.dialects.recognition import Recogniser, comes_back, says_something_readable
from armdrive.errors import DeviceFault, LinkLost, PortUnavailable
from armdrive.registry import DIALECTS
from armdrive.runtime.engine import NOT_THE_ANSWER, excerpt
from armdrive.transports import opening, ports
from armdrive.transports.address import PREFIX, is_can, scheme
from armdrive.transports.can_address import CanAddress
from armdrive.transports.link import Link


class PortOpening:
    """The way to one arm: by the USB serial number of its adapter, else by the port's name.

    An adapter that tells a number is remembered by it from the first opening on, since plugged in
    again it may have another name, and its name may be another adapter's.
    """

    def __init__(self, config: ArmConfig) -> None:
        self._wire = config.connection
        self._port = config.connection.port
        self._serial_number = config.connection.usb_serial
        own: tuple[int, ...] = getattr(config.device, "ids", ())
        self._ids: tuple[int, ...] = getattr(config.device, "frame_ids", own)
        if not (self._port or self._serial_number):
            raise PortUnavailable(
                f'the arm file of {config.name} names no port: write port = "/dev/ttyUSB0", say, '
                "or usb_serial, under [connection]"
            )

    def find(self) -> str:
        """Return the port's present name. Raises `NoSuchPort` where no port has the number."""
        if self._serial_number:
            self._port = ports.device_of(self._serial_number, self._port)
        return self._port

    def open(self) -> Link:
        """Open the wire, wherever it is now. Raises `PortUnavailable`; sends nothing."""
        port = self.find()
        link = opening.open_link(
            self._heard(port),
            self._wire.baud,
            raise_dtr=self._wire.raise_dtr,
            keep_dtr_on_close=self._wire.keep_dtr_on_close,
        )
        if not self._serial_number and not scheme(port):
            self._serial_number = ports.serial_number_of(port)
        return link

    def _heard(self, port: str) -> str:
        """Return a port; of a CAN bus, with the ids of what the drives say: no more is heard."""
        if not (self._ids and is_can(port)):
            return port
        address = CanAddress.parse(port)
        return port if address.ids else str(replace(address, ids=frozenset(self._ids)))


# A connection that failed: what was heard instead of the dialect that was asked for.

MOST_BYTES = 4096
"""So much is remembered of what came in."""
MOST_WRITES = 64
"""So much of what was sent."""


@cache
def recogniser() -> Recogniser:
    """Return what recognises the devices of every dialect that is not spoken on a bus."""
    found = {name: row.tools().recognition for name, row in DIALECTS.items()}
    return Recogniser(MappingProxyType({name: each for name, each in found.items() if each}))


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
    if comes_back(sent, heard):
        return (
            "What is sent comes straight back: transmit and receive are joined somewhere, or the "
            "adapter or the board echoes. Switch the echo off, and check the wiring."
        )
    identity = recogniser().recognise(heard)
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
