"""A real serial port, by pyserial: exclusive, with the handshake lines as the arm wants them.

pyserial's URLs (`socket://host:port`, `rfc2217://`, `spy://`) work wherever a port's name does.
"""

from __future__ import annotations

import os

import serial

from armdrive.errors import LinkLost, PortUnavailable
from armdrive.transports.bell import Bell

WRITE_PATIENCE_S = 1.0
"""A port that takes no byte for this long is lost: a line is sent only when all is quiet."""


POLL_S = 0.005
"""A port that cannot be slept on (Windows, network ports) is looked at this often."""


class SerialLink:
    """A `Link` over pyserial."""

    def __init__(self, port: str, baud: int, *, raise_dtr: bool = False) -> None:
        """Open the port; raises `PortUnavailable` with what to do about it. Sends nothing."""
        self._name = port
        self._baud = baud
        try:
            made = serial.serial_for_url(
                port, baudrate=baud, timeout=0, write_timeout=WRITE_PATIENCE_S, do_not_open=True
            )
            made.dtr = made.rts = raise_dtr
            if "://" not in port:
                made.exclusive = True if os.name == "posix" else None
            made.open()
        except (serial.SerialException, OSError, ValueError) as error:
            raise PortUnavailable(_advice(port, error)) from None
        self._port = made
        self._bell = Bell()

    @property
    def description(self) -> str:
        """Name the port and its speed."""
        return f"{self._name} at {self._baud} baud"

    def write(self, data: bytes, now_s: float) -> None:  # noqa: ARG002 - real time is the port's own
        """Send bytes."""
        try:
            self._port.write(data)
        except (serial.SerialException, OSError) as error:
            raise self._lost(error) from None

    def read(self, now_s: float) -> bytes:  # noqa: ARG002
        """Return what has arrived."""
        try:
            # a port that is gone says so in in_waiting on one system and in read on another
            waiting = self._port.in_waiting
            return bytes(self._port.read(waiting or 1))
        except (serial.SerialException, OSError, TypeError) as error:
            raise self._lost(error) from None

    def next_s(self) -> float:
        """Return infinity: nobody knows when a real arm answers."""
        return float("inf")

    def wait(self, timeout_s: float) -> None:
        """Sleep until bytes arrive, `wake` is called, or the time is over."""
        fileno = self._fileno()
        if fileno is None:
            self._bell.wait(min(timeout_s, POLL_S))
        else:
            self._bell.wait(timeout_s, fileno)

    def wake(self) -> None:
        """End a `wait` early."""
        self._bell.ring()

    def close(self) -> None:
        """Give the port back."""
        self._port.close()
        self._bell.close()

    def _fileno(self) -> int | None:
        try:
            return int(self._port.fileno()) if os.name == "posix" else None
        except (AttributeError, OSError, ValueError, TypeError, serial.SerialException):
            return None

    def _lost(self, error: object) -> LinkLost:
        return LinkLost(
            f"the connection on {self._name} was lost ({error}). The arm stands once its last "
            "burst has ended; plug the cable in and connect again"
        )


def _advice(port: str, error: Exception) -> str:
    text = str(error)
    if isinstance(error, PermissionError) or "Permission denied" in text or "Errno 13" in text:
        return (
            f"no permission to open {port}: add yourself to the group that owns it (on Debian and "
            "Ubuntu `sudo adduser $USER dialout`), then log in again"
        )
    if "exclusively lock" in text or "Errno 11" in text or "Access is denied" in text:
        return f"{port} is in use by another program: end that program first"
    if "No such file" in text or "Errno 2]" in text or "FileNotFoundError" in text:
        return f"there is no port {port}: check the cable, and the name with `ls /dev/tty*`"
    return f"{port} cannot be opened: {text}"
