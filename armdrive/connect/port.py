"""Finds and opens the port of a real arm, and explains a failed connection."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from types import MappingProxyType

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.dialects.recognition import Recogniser, comes_back, says_something_readable
from armdrive.errors import DeviceFault, LinkLost, PortUnavailable
from armdrive.registry import DIALECTS
from armdrive.runtime.engine import NOT_THE_ANSWER, excerpt
from armdrive.trace.entries import EntryKind, TraceEntry
from armdrive.transports import opening, ports
from armdrive.transports.address import PREFIX, CanAddress, is_can, scheme
from armdrive.transports.link import Link


class PortOpening:
    """Opens the port of one arm, found by its adapter's USB serial number, otherwise by name.

    An adapter with a serial number is later found by that number. When it is plugged in again, it
    may have a different name, and another adapter may have its old name.
    """

    def __init__(self, config: ArmConfig) -> None:
        self._wire = config.connection
        self._port = config.connection.port
        self._serial_number = config.connection.usb_serial
        own: tuple[int, ...] = getattr(config.device, "ids", ())
        self._ids: tuple[int, ...] = getattr(config.device, "frame_ids", own)
        if not (self._port or self._serial_number):
            raise PortUnavailable(
                f'the arm file of {config.name} names no port: write port (such as "/dev/ttyUSB0") '
                "or usb_serial under [connection]"
            )
        if is_can(self._port) and DIALECTS[self._wire.dialect].bus is None:
            raise PortUnavailable(
                f"{self._port} is a CAN bus, but a controller that speaks {self._wire.dialect} is "
                "not on a bus: correct the port or the dialect"
            )

    def find(self) -> str:
        """Return the port's present name. Raises `NoSuchPort` if no port has the serial number."""
        if self._serial_number:
            self._port = ports.device_of(self._serial_number, self._port)
        return self._port

    def open(self) -> Link:
        """Open the port under its present name; sends nothing. Raises `PortUnavailable`."""
        port = self.find()
        link = opening.open_link(
            self._filtered(port),
            self._wire.baud,
            raise_dtr=self._wire.raise_dtr,
            keep_dtr_on_close=self._wire.keep_dtr_on_close,
        )
        if not self._serial_number and not scheme(port):
            self._serial_number = ports.serial_number_of(port)
        return link

    def _filtered(self, port: str) -> str:
        """Add the drives' ids to the address of a CAN bus, so that no other frames are read."""
        if not (self._ids and is_can(port)):
            return port
        address = CanAddress.parse(port)
        return port if address.ids else str(replace(address, ids=frozenset(self._ids)))


# Explaining a failed connection: which device answered instead of the expected one.

MOST_BYTES = 4096  # received bytes that are examined
MOST_WRITES = 64  # writes that are compared with them, to find an echo


@cache
def recogniser() -> Recogniser:
    """Return the recogniser of all devices that are not on a bus."""
    found = {name: row.tools().recognition for name, row in DIALECTS.items()}
    return Recogniser(MappingProxyType({name: each for name, each in found.items() if each}))


@contextlib.contextmanager
def explaining(recorded: Callable[[], Iterable[TraceEntry]], wire: Connection) -> Iterator[None]:
    """Add what was received, and how to find out more, to the error of a failed connection.

    `recorded` returns the entries of the connection's recorder. On a bus that is lost at once, no
    node acknowledges frames: `armdrive doctor` finds out which nodes are there.
    """
    try:
        yield
    except DeviceFault as fault:
        entries = tuple(recorded())
        sent, received = (
            [each.what for each in entries if each.kind is kind and isinstance(each.what, bytes)]
            for kind in (EntryKind.SENT, EntryKind.RECEIVED)
        )
        heard = b"".join(received)[:MOST_BYTES]
        raise explained(fault, heard, wire, sent[:MOST_WRITES]) from None
    except LinkLost as lost:
        if not is_can(wire.port):
            raise
        raise LinkLost(f"{str(lost).rstrip('.')}. {_doctor(wire.port)}") from None


def explained(
    fault: DeviceFault, received: bytes, wire: Connection, sent: Sequence[bytes] = ()
) -> DeviceFault:
    """Return the fault with what was received, and how to find out more."""
    instead = "" if is_can(wire.port) else _instead(received, wire.dialect, sent, str(fault))
    sentences = [str(fault).rstrip(".") + ".", instead, _doctor(wire.port)]
    return type(fault)(" ".join(each for each in sentences if each))


def bare(fault: BaseException, wire: Connection) -> str:
    """Return the error text of a failed connection without the reference to the doctor."""
    return str(fault).removesuffix(_doctor(wire.port)).rstrip(" .")


def _instead(received: bytes, dialect: str, sent: Sequence[bytes], fault: str) -> str:
    if comes_back(sent, received):
        return (
            "Everything that is sent comes straight back: transmit and receive are connected, or "
            "the adapter or the board echoes. Switch the echo off, and check the wiring."
        )
    identity = recogniser().recognise(received)
    if identity is not None and identity.dialect != dialect:
        choice = f"set the dialect to {identity.dialect}" if identity.dialect else identity.remedy
        chosen = f"; {choice}" if choice else ""
        return f"The device does not speak {dialect}: it is {identity.firmware}{chosen}."
    if not received or identity is not None:
        return ""
    came = "" if NOT_THE_ANSWER in fault else f": {excerpt(received)}"
    if says_something_readable(received):
        return f"The bytes received are not in the {dialect} dialect{came}."
    return f"The bytes received are unreadable{came}; is the baud rate right?"


def _doctor(port: str) -> str:
    if is_can(port):
        bus = port.removeprefix(PREFIX)
        return (
            f"`armdrive doctor --can '{bus}'` finds out which drives are there, and moves nothing."
        )
    where, which = (port, "") if port else ("PORT", ", for the port that `armdrive ports` shows,")
    return f"`armdrive doctor {where}`{which} finds out what is there, and moves nothing."
