"""The device's end of a wire that other programs open: a pseudo-terminal, TCP, UDP, a CAN adapter.

A server never blocks. Bytes that no client reads are dropped, as on a real line without a listener.
Every one has the same calls: `open` offers the wire, also again after `close`, possibly at another
address; `close` withdraws it, as if the cable were pulled, and may be called twice.
"""

from __future__ import annotations

import contextlib
import ipaddress
import os
import socket
import sys
from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, TypeAlias

from armdrive.errors import PortUnavailable
from armdrive.errors.printable import reason_of
from armdrive.sim.bus.line import AdapterFaults
from armdrive.transports.ports import is_left_link
from firmware_protocol.frames import (
    BELL,
    CR,
    ON_BUS,
    Frame,
    SlcanLines,
    Unpacker,
    frame_of,
    line_of,
    pack,
)

if sys.platform != "win32":
    import pty
    import tty

CHUNK = 4096
_PTY_FOLDERS = ("/dev/pts/", "/dev/ttys")


class PtyServer:
    """A pseudo-terminal in raw mode; `path` becomes a link to the side that others open.

    The server keeps that side open itself, so that clients can come and go. The link replaces only
    the link of an ended simulation, and `close` removes it.
    """

    paced = True

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._ends: tuple[int, int] | None = None
        self._target = ""
        self.open()

    @property
    def address(self) -> str:
        """The link's path, or the pseudo-terminal's own if there is no link."""
        return str(self._path or self._target)

    def open(self, address: str | None = None) -> None:
        """Make the pseudo-terminal and its link. Raises `PortUnavailable`."""
        if self._ends is not None:
            return
        if address is not None:
            self._path = Path(address)
        if sys.platform == "win32":
            raise PortUnavailable("this system has no pseudo-terminals: use --tcp 127.0.0.1:PORT")
        master, slave = pty.openpty()
        self._ends, self._target = (master, slave), os.ttyname(slave)
        os.set_blocking(master, False)
        try:
            tty.setraw(slave)
            if self._path is not None:
                self._link(self._path)
        except BaseException:
            self._close_ends()
            raise

    def filenos(self) -> tuple[int, ...]:
        """The file descriptors to select on for reading."""
        return () if self._ends is None else self._ends[:1]

    def read(self) -> bytes:
        """Return what clients have written."""
        if self._ends is not None:
            with contextlib.suppress(BlockingIOError):
                return os.read(self._ends[0], CHUNK)
        return b""

    def write(self, data: bytes) -> None:
        """Write to the reader; bytes that do not fit the system's buffer are lost."""
        if self._ends is not None:
            with contextlib.suppress(BlockingIOError):
                os.write(self._ends[0], data)

    def close(self) -> None:
        """Hang up, and remove the link if it is still this pseudo-terminal's."""
        if self._ends is None:
            return
        if self._path is not None and self._path.is_symlink():
            with contextlib.suppress(OSError):
                if str(self._path.readlink()) == self._target:
                    self._path.unlink()
        self._close_ends()

    def _close_ends(self) -> None:
        for end in self._ends or ():
            os.close(end)
        self._ends = None

    def _link(self, path: Path) -> None:
        try:
            if path.is_symlink() and self._left_behind(path):
                path.unlink()
            path.symlink_to(self._target)
        except FileExistsError:
            raise PortUnavailable(
                f"{path} exists and is no left-over of an ended simulation: "
                "remove it, or choose another path"
            ) from None
        except OSError as error:
            raise PortUnavailable(f"{path} cannot be made: {error.strerror}") from None

    def _left_behind(self, path: Path) -> bool:
        """Return whether a link leads to a pseudo-terminal that is gone, or that is a newer one."""
        target = str(path.readlink())
        is_pty = target.startswith(_PTY_FOLDERS)
        return is_pty and (target == self._target or not path.exists() or is_left_link(path))


# --- Network ports -------------------------------------------------------------------------------

LOOPBACK = "127.0.0.1"


def split_address(address: str) -> tuple[str, int]:
    """Split `HOST:PORT`, `:PORT` or `PORT`. Raises `PortUnavailable`."""
    host, _, port = address.rpartition(":")
    if not (port.isascii() and port.isdecimal()):
        raise PortUnavailable(f"{address!r} is no address: write HOST:PORT, for example :7410")
    return host or LOOPBACK, int(port)


class NetworkServer(ABC):
    """A port of this computer; 0 picks a free one. Visible only locally unless a host is named.

    Anybody who reaches the port can move the simulated arm.
    """

    scheme: ClassVar[str]
    """What an address begins with."""

    def __init__(self, host: str = LOOPBACK, port: int = 0) -> None:
        self._host = host
        self._port = port
        self._ear: socket.socket | None = None
        self.open()

    @property
    def address(self) -> str:
        """The address for the other program to open."""
        return f"{self.scheme}{self._host}:{self._port}"

    @property
    def port(self) -> int:
        """The port number, chosen by the system if 0 was requested."""
        return self._port

    def open(self, address: str | None = None) -> None:
        """Listen, at another address if one is given. Raises `PortUnavailable`."""
        if self._ear is not None:
            return
        if address is not None:
            self._host, self._port = split_address(address)
        try:
            ear = self._bound(self._host, self._port)
        except (OSError, OverflowError) as error:
            raise PortUnavailable(
                f"cannot listen on {self.address} ({reason_of(error)}): choose another port"
            ) from None
        ear.setblocking(False)
        self._ear, self._port = ear, ear.getsockname()[1]

    def close(self) -> None:
        """Stop listening."""
        ear, self._ear = self._ear, None
        if ear is not None:
            ear.close()

    @abstractmethod
    def _bound(self, host: str, port: int) -> socket.socket:
        """Return a listening socket. Raises `OSError` or `OverflowError`."""


class TcpServer(NetworkServer):
    """A TCP port for one client at a time; a second one is rejected."""

    scheme = "socket://"
    paced = True
    _client: socket.socket | None = None

    def filenos(self) -> tuple[int, ...]:
        """The file descriptors to select on for reading."""
        return tuple(end.fileno() for end in (self._ear, self._client) if end is not None)

    def read(self) -> bytes:
        """Return all that the client has sent, and accept the next client once it has left."""
        first = self._hear()
        self._admit()
        return first + self._hear()

    def write(self, data: bytes) -> None:
        """Send to the client, if there is one."""
        if self._client is not None:
            try:
                self._client.send(data)
            except BlockingIOError:
                pass
            except OSError:
                self._hang_up()

    def close(self) -> None:
        """Disconnect the client and stop listening."""
        self._hang_up()
        super().close()

    def _bound(self, host: str, port: int) -> socket.socket:
        return socket.create_server((host, port), backlog=1)

    def _hear(self) -> bytes:
        received = b""
        while self._client is not None and len(received) < CHUNK:
            try:
                data = self._client.recv(CHUNK)
            except BlockingIOError:
                break
            except OSError:
                data = b""
            received += data
            if not data:
                self._hang_up()
        return received

    def _admit(self) -> None:
        if self._ear is None:
            return
        try:
            client, _ = self._ear.accept()
        except OSError:
            return
        if self._client is not None:
            client.close()
            return
        client.setblocking(False)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._client = client

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None


HIGHEST_PORT = 65535


class UdpServer(NetworkServer):
    """A UDP port: passes each datagram on by itself, and replies to the last sender."""

    scheme = "udp://"
    paced = False
    _peer: tuple[Any, ...] | None = None

    def filenos(self) -> tuple[int, ...]:
        """The file descriptors to select on for reading."""
        return () if self._ear is None else (self._ear.fileno(),)

    def read(self) -> bytes:
        """Return one datagram, or nothing; there may be more."""
        if self._ear is not None:
            with contextlib.suppress(OSError):  # nothing there, or an earlier reply was rejected
                data, self._peer = self._ear.recvfrom(HIGHEST_PORT)
                return data
        return b""

    def write(self, data: bytes) -> None:
        """Send a datagram to the last sender."""
        if self._ear is not None and self._peer is not None and data:
            with contextlib.suppress(OSError):
                self._ear.sendto(data, self._peer)

    def close(self) -> None:
        """Stop listening, and forget the last sender."""
        super().close()
        self._peer = None

    def _bound(self, host: str, port: int) -> socket.socket:
        ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            ear.bind((host, port))
        except BaseException:
            ear.close()
            raise
        return ear


def beyond_this_computer(address: str) -> str:
    """Return a warning if others can reach an address; empty if only this computer can.

    Raises `PortUnavailable` for an invalid address.
    """
    host, _ = split_address(address)
    if host.lower() == "localhost" or _is_loopback(host):
        return ""
    return (
        f"WARNING: anyone who reaches {host} over the network can move this simulated arm and hear "
        f"the messages to it; {LOOPBACK} keeps it to this computer"
    )


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:  # a host name: it may lead anywhere
        return False


# --- A serial CAN adapter ------------------------------------------------------------------------
# It behaves like a Lawicel adapter: it answers a command with CR or the bell character, an accepted
# frame with `z` or `Z`, and `F`, `V` and `N` with text. Timestamps are off.

_KBIT_S = (10, 20, 50, 100, 125, 250, 500, 750, 1000)
# Bit rates set by `S` and a digit.
BITRATES: Mapping[bytes, int] = MappingProxyType(
    {b"%d" % number: 1000 * kbit_s for number, kbit_s in enumerate(_KBIT_S)}
)
VERSION = b"V1013"
SERIAL_NUMBER = b"NA123"
_PASSIVE, _BUS_ERRORS = 0x20, 0x80


class Adapter:
    """The device's side of slcan."""

    def __init__(self, bus_bitrate: int = 500_000) -> None:
        self.bus_bitrate = bus_bitrate
        self.faults = AdapterFaults()
        self.refused = 0
        """How many of its host's frames it did not send."""
        self._bitrate = 0
        self._open = False
        self._listens = False
        self._lines = SlcanLines()
        self._said = bytearray()
        self._sent: list[Frame] = []

    @property
    def on_bus(self) -> bool:
        """Whether frames pass in at least one direction."""
        return self._open and self._bitrate == self.bus_bitrate and not self.faults.bus_off

    def receive(self, data: bytes) -> list[Frame]:
        """Receive bytes from the host; return the frames that go out on the bus."""
        for line in self._lines.feed(data):
            if not self.faults.dead:
                self._obey(line)
        sent, self._sent = self._sent, []
        return sent

    def show(self, *frames: Frame) -> None:
        """Receive frames from the bus."""
        if self.on_bus and not self.faults.dead:
            self._said += b"".join(map(line_of, frames))

    def say(self) -> bytes:
        """Take the bytes to send to the host."""
        sent = bytes(self._said)
        self._said.clear()
        return sent

    def restart(self) -> None:
        """Lose the power, and with it all settings made by the host."""
        self._open, self._bitrate, self._lines = False, 0, SlcanLines()
        self._said.clear()

    def _obey(self, line: bytes) -> None:
        order, rest = line[:1], line[1:]
        if order in (b"V", b"N"):
            self._said += (VERSION if order == b"V" else SERIAL_NUMBER) + CR
        elif order and order in ON_BUS:
            self._transmit(line)
        elif order == b"F" and self._open:
            self._reply(b"F%02X" % self._status() + CR)
        else:
            self._reply(CR if self._changed(order, rest) else BELL)

    def _changed(self, order: bytes, rest: bytes) -> bool:
        """Execute a command that changes the adapter or its channel; False if it is refused."""
        match order:
            case b"":
                return True
            case b"S" if rest in BITRATES and not self._open:
                self._bitrate = BITRATES[rest]
                return True
            case b"O" | b"L" if self._bitrate and not (self._open or rest):
                self._open, self._listens, self.refused = True, order == b"L", 0
                return True
            case b"C":
                was, self._open = self._open, False
                self.faults.bus_off = False
                return was and not rest
            case _:
                return order == b"Z" and rest == b"0"

    def _reply(self, words: bytes) -> None:
        if not self.faults.mute:
            self._said += words

    def _transmit(self, line: bytes) -> None:
        frame = frame_of(line)
        troubled = self.faults.alone or not self.on_bus or self._listens
        if frame is None or troubled:
            self.refused += 1
            self._reply(BELL)
            return
        self._sent.append(frame)
        self._reply((b"Z" if frame.extended else b"z") + CR)

    def _status(self) -> int:
        if self.faults.bus_off:
            return _PASSIVE | _BUS_ERRORS
        return _PASSIVE if self.refused and (self.faults.alone or not self.on_bus) else 0


class SlcanServer:
    """A `Server` whose bus other programs reach through serial CAN adapters, one for each path.

    Each program opens `can:slcan:PATH`, or its own form of such an address, and also receives what
    the others send. Faults affect the first adapter. On the simulator's side the server reads and
    writes packed frames, like every other server.

    `close` followed by `open` corresponds to pulling the adapters out and plugging them in: they
    lose their bit rates and their open channels.
    """

    paced = False

    def __init__(self, *paths: Path | None, bits_s: int = 500_000) -> None:
        """Make the pseudo-terminals, linked at paths. Raises `PortUnavailable`."""
        self._ports = tuple(PtyServer(path) for path in paths or (None,))
        self.adapters = tuple(Adapter(bits_s) for _ in self._ports)
        self._unpacker = Unpacker()

    @property
    def address(self) -> str:
        """The path of the first serial port for others to open."""
        return self._ports[0].address

    @property
    def can_addresses(self) -> tuple[str, ...]:
        """The address of each adapter in armdrive's notation."""
        rate = self.adapters[0].bus_bitrate
        return tuple(f"can:slcan:{port.address}?bitrate={rate}" for port in self._ports)

    def open(self, address: str | None = None) -> None:
        """Plug the adapters in, the first one possibly under another name.

        Raises `PortUnavailable`.
        """
        first, *others = self._ports
        first.open(address)
        for port in others:
            port.open()

    def filenos(self) -> tuple[int, ...]:
        """The file descriptors to select on for reading."""
        return tuple(fileno for port in self._ports for fileno in port.filenos())

    def read(self) -> bytes:
        """Return the frames sent by the other programs, packed; commands are answered."""
        sent: list[Frame] = []
        for port, adapter in zip(self._ports, self.adapters, strict=True):
            frames = adapter.receive(port.read())
            for other in self.adapters:
                if other is not adapter:
                    other.show(*frames)
            sent += frames
        self._answer()
        return b"".join(map(pack, sent))

    def write(self, data: bytes) -> None:
        """Pass frames of the bus to the adapters."""
        frames = self._unpacker.feed(data)
        for adapter in self.adapters:
            adapter.show(*frames)
        self._answer()

    def close(self) -> None:
        """Pull the adapters out of their ports."""
        for port, adapter in zip(self._ports, self.adapters, strict=True):
            port.close()
            adapter.restart()

    def _answer(self) -> None:
        for port, adapter in zip(self._ports, self.adapters, strict=True):
            if sent := adapter.say():
                port.write(sent)


Server: TypeAlias = PtyServer | TcpServer | UdpServer | SlcanServer
