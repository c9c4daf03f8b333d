"""A serial port through pyserial: opened exclusively, with the handshake lines that the arm needs.

Of pyserial's URLs, `socket://host:port` and `rfc2217://host:port` work like the name of a port. Its
`SerialException` is an `OSError`, and is caught as one.
"""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from typing import TYPE_CHECKING

from armdrive.errors import LinkLost, PortUnavailable
from armdrive.errors.printable import reason_of
from armdrive.transports.address import TCP_SCHEMES, host_and_port, scheme
from armdrive.transports.link import Bell, Link, lost_link
from armdrive.transports.ports import no_connection, refusal, require_no_terminal

if sys.platform != "win32":
    import termios

if TYPE_CHECKING:
    import serial

# A port that accepts no byte for this long is lost; its buffer is empty when a line is sent.
WRITE_PATIENCE_S = 1.0

POLL_S = 0.005  # polling interval of ports without a file to wait on (Windows, rfc2217)
CHUNK = 4096  # most bytes in one read


class SerialLink(Link):
    """A `Link` over pyserial."""

    def __init__(
        self, port: str, baud: int, *, raise_dtr: bool = False, keep_dtr_on_close: bool = False
    ) -> None:
        """Open the port, without sending anything; raises `PortUnavailable`.

        With `raise_dtr`, DTR and RTS are up while the port is open. Without it, Windows never
        raises them; Linux and macOS raise them on opening, and we lower them at once. To reopen a
        port without resetting a board that restarts when DTR rises, give both `raise_dtr` and
        `keep_dtr_on_close` (see `clear_hupcl`).
        """
        self._name = port
        self._baud = baud
        self._scheme = scheme(port)
        if self._scheme in TCP_SCHEMES:
            host_and_port(port)
        elif self._scheme:
            raise PortUnavailable(
                f"{port} cannot be used: write a port's name, or an address that begins with "
                "socket://, rfc2217:// or udp://"
            )
        else:
            require_no_terminal(port)
        made = _made(port, baud, self._scheme)
        try:
            made.dtr = made.rts = raise_dtr
            _open(made, self._scheme)
        except (OSError, ValueError) as error:
            if self._scheme:
                raise no_connection(port, error) from None
            raise refusal(port, error) from None
        self._port = made
        self._bell = Bell()
        fileno = self._fileno()
        if keep_dtr_on_close and not self._scheme and fileno is not None:
            clear_hupcl(fileno)

    @property
    def description(self) -> str:
        """Name the port, and its speed if it has one."""
        return self._name if self._scheme == "socket" else f"{self._name} at {self._baud} baud"

    def write(self, data: bytes, now_s: float) -> None:  # noqa: ARG002 - real time is the port's own
        """Send bytes."""
        try:
            self._port.write(data)
        except OSError as error:
            raise self._lost(error) from None

    def read(self, now_s: float) -> bytes:  # noqa: ARG002
        """Return what has arrived."""
        data = bytearray()
        try:
            # if the port is gone, in_waiting raises on some systems and read on others
            waiting = self._port.in_waiting
            while piece := self._port.read(max(waiting, CHUNK)):
                data += piece
                # rfc2217 returns one byte at a time, whatever the requested size
                waiting = self._port.in_waiting
                if not waiting or len(data) >= CHUNK:
                    break
        except (OSError, TypeError) as error:
            if not data:
                raise self._lost(error) from None
        return bytes(data)

    def tune(self, baud: int) -> None:
        """Change the baud rate; a raw network connection has none. Raises `PortUnavailable`.

        Opening the port again might restart the board.
        """
        if baud == self._baud or self._scheme == "socket":
            return
        try:
            self._port.baudrate = baud
        except (OSError, ValueError) as error:
            raise PortUnavailable(
                f"{self._name} cannot be set to {baud} baud ({reason_of(error)}): name another rate"
            ) from None
        self._baud = baud

    def wait(self, timeout_s: float) -> None:
        """Sleep until bytes arrive, `wake` is called, or the timeout."""
        fileno = self._fileno()
        if fileno is None:
            self._bell.wait(min(timeout_s, POLL_S))
        else:
            self._bell.wait(timeout_s, fileno)

    def wake(self) -> None:
        """End a `wait` early."""
        self._bell.ring()

    def close(self) -> None:
        """Close the port."""
        # pyserial forgets to close a socket whose other end has gone
        left = getattr(self._port, "_socket", None)
        self._port.close()
        if left is not None:
            left.close()
        self._bell.close()

    def _fileno(self) -> int | None:
        """Return the file to wait on: a socket, or a device on a POSIX system; else None."""
        if self._scheme != "socket" and os.name != "posix":
            return None
        try:
            return int(self._port.fileno())
        except (AttributeError, OSError, ValueError, TypeError):
            return None

    def _lost(self, error: object) -> LinkLost:
        todo = "check the network" if self._scheme else "plug the cable in"
        return lost_link(f"the connection on {self._name}", reason_of(error), todo)


def clear_hupcl(fileno: int) -> None:
    """Clear HUPCL of an open port, so that DTR stays up when the port is closed.

    Boards with an Arduino's reset circuit restart when DTR rises. Linux and macOS raise DTR
    whenever a port is opened, and drop it at the last close if HUPCL is set. Without HUPCL it
    stays up between programs, so that the next open brings no edge. The first open after plugging
    in has already reset the board: no setting prevents that.

    Windows has no such setting, nor has a file that is no terminal. The setting stays with the
    device until it is unplugged or another program changes it.
    """
    if sys.platform != "win32":
        with contextlib.suppress(termios.error):
            settings = termios.tcgetattr(fileno)
            settings[2] &= ~termios.HUPCL
            termios.tcsetattr(fileno, termios.TCSANOW, settings)


def _made(port: str, baud: int, kind: str) -> serial.Serial:
    """Return the port, not yet open."""
    import serial  # an arm on simulated time needs no port library

    # pyserial's rfc2217 has no write timeout; its socket has a timeout of its own
    patience_s = None if kind == "rfc2217" else WRITE_PATIENCE_S
    made = serial.serial_for_url(
        port, baudrate=baud, timeout=0, write_timeout=patience_s, do_not_open=True
    )
    if not kind and os.name == "posix":
        made.exclusive = True
    return made


def _open(made: serial.Serial, kind: str) -> None:
    if kind != "rfc2217":
        made.open()
        return
    with warnings.catch_warnings():  # pyserial starts its thread in a deprecated way
        warnings.simplefilter("ignore", DeprecationWarning)
        made.open()
