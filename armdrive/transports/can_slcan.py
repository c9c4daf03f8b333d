"""A serial CAN adapter (slcan): python-can's bus, extended to read the adapter's own replies.

python-can's slcan ignores these replies, so that a frame that could not be sent looks sent
(hardbyte/python-can issue 2060). It also waits two seconds for every adapter, and lets two programs
share one. Its names and options are kept.
"""

from __future__ import annotations

import contextlib
import os
import select
import sys
import time
from collections import deque
from typing import Any

import can
import serial
from can.exceptions import error_check
from can.interfaces.slcan import slcanBus

from armdrive.errors import NoConnection
from armdrive.errors.printable import reason_of
from armdrive.transports.address import CanAddress
from armdrive.transports.can_link import frame_of as frame_of_message
from armdrive.transports.can_link import message_of
from firmware_protocol.frames import BELL, Frame, SlcanLines, frame_of, line_of

if sys.platform != "win32":
    import fcntl

GREETING_S = 0.4  # ask the adapter again if it has not answered by then
GREETINGS = 6  # attempts: an Arduino-based adapter restarts for two seconds after its port opens
MOST_LINES = 100  # lines kept from the greeting, for the error message
WRITE_PATIENCE_S = 0.5  # an adapter that takes no byte for this long is stuck
POLL_S = 0.02  # where the system has no `select` for the port
# The first bytes of an adapter's lines; an empty line means OK.
_LINE_STARTS = frozenset({b"", BELL, *(bytes([each]) for each in b"VvNzZtTrR")})
_YES = frozenset({b"", b"z", b"Z"})
# Our own commands: a device that sends them back only echoes, and is no adapter.
_ECHOES = frozenset({b"C", b"O", b"V"})


class Slcan(slcanBus):
    """python-can's slcan bus with the adapter's replies.

    `refused` counts the frames that the adapter could not send (it replies with a bell), and
    `refusing` is whether its latest reply was such a refusal.
    """

    def __init__(
        self, channel: str, *, sleep_after_open: float | None = None, **settings: Any
    ) -> None:
        """Open the port and the bus, and wait until the adapter answers.

        With `sleep_after_open`, only wait that long, without asking the adapter anything.
        """
        self.refused = 0
        self.refusing = False
        self._heard: deque[Frame] = deque()
        self._received_lines: list[bytes] = []
        self._lines = SlcanLines()
        self._lock_file = _Lock(channel)
        try:
            super().__init__(channel, sleep_after_open=sleep_after_open or 0.0, **settings)
            if sleep_after_open is None:
                self._greet(channel, settings.get("bitrate"))
        except BaseException:
            self.shutdown()
            raise

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame, or raise a `can.CanError` within the timeout."""
        frame = frame_of_message(msg)
        if frame is None:
            raise can.CanOperationError("an slcan adapter sends no frames of CAN FD")
        self._put(line_of(frame), WRITE_PATIENCE_S if timeout is None else timeout)

    def shutdown(self) -> None:
        """Take the adapter off the bus, and release the port in any case."""
        with contextlib.suppress(can.CanError, AttributeError):  # the latter if it was never open
            if not self._is_shutdown:
                super().shutdown()
        with contextlib.suppress(AttributeError, OSError):
            self.serialPortOrig.close()
        self._lock_file.close()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        end_s = time.monotonic() + (3600.0 if timeout is None else timeout)
        while not self._heard:
            left_s = end_s - time.monotonic()
            data = self._fill(max(left_s, 0.0))
            for line in self._lines.feed(data):
                self._take(line)
            if not self._heard and left_s <= 0.0:
                return None, False
        return message_of(self._heard.popleft()), False

    def _take(self, line: bytes) -> None:
        frame = frame_of(line)
        if frame is not None:
            self._heard.append(frame)
        elif line.endswith(BELL):
            self.refused += 1
            self.refusing = True
        elif line in _YES:
            self.refusing = False
        if len(self._received_lines) < MOST_LINES:
            self._received_lines.append(line)

    def _fill(self, pause_s: float) -> bytes:
        """Return the bytes that have arrived, or wait for some during the pause."""
        with error_check("the serial port of the adapter cannot be read"):
            try:
                files = [self.serialPortOrig.fileno()]
            except (AttributeError, OSError):  # Windows, or a URL
                files = []
            if files and os.name == "posix":
                if not select.select(files, [], [], pause_s)[0]:
                    return b""
                return bytes(self.serialPortOrig.read(self.serialPortOrig.in_waiting or 1))
            self.serialPortOrig.timeout = min(pause_s, POLL_S)
            return bytes(self.serialPortOrig.read(max(self.serialPortOrig.in_waiting, 1)))

    def _write(self, string: str) -> None:
        """Send a line. Replaces python-can's method, which waits for a stuck adapter forever."""
        self._put(string.encode() + self.LINE_TERMINATOR, WRITE_PATIENCE_S)

    def _put(self, data: bytes, patience_s: float) -> None:
        port = self.serialPortOrig
        try:
            if port.write_timeout != patience_s:
                port.write_timeout = patience_s
            port.write(data)
        except serial.SerialTimeoutException as error:
            raise can.CanTimeoutError("the adapter takes nothing more") from error
        except (serial.SerialException, OSError) as error:
            raise can.CanOperationError(
                f"the adapter cannot be written to ({reason_of(error)})"
            ) from error

    def _greet(self, channel: str, bitrate: int | None) -> None:
        """Wait for the adapter's version, or another reply that only an slcan adapter sends."""
        for turn in range(GREETINGS):
            self._write("V")
            if self._answered(GREETING_S):
                if turn:  # the adapter was still restarting when it was sent the bit rate
                    self._set_up_again(bitrate)
                # discard leftovers of an earlier session
                self.refused, self.refusing = 0, False
                self._heard.clear()
                return
        raise NoConnection(_no_adapter(channel, self._received_lines))

    def _set_up_again(self, bitrate: int | None) -> None:
        if bitrate is None:
            self.close()
            self.open()
        else:
            self.set_bitrate(bitrate)
        self._received_lines.clear()
        self._write("V")
        self._answered(GREETING_S)

    def _answered(self, patience_s: float) -> bool:
        """Return whether the adapter answered: by its version, or by another slcan reply.

        Stop reading at the version, because everything before it is left over.
        """
        end_s = time.monotonic() + patience_s
        while (left_s := end_s - time.monotonic()) > 0.0:
            for line in self._lines.feed(self._fill(left_s)):
                self._take(line)
            if any(_is_version(line) for line in self._received_lines):
                return True
        echoes = any(line in _ECHOES for line in self._received_lines)
        return not echoes and any(_is_own(line) for line in self._received_lines)


class _Lock:
    """An exclusive lock on a port, where the system has such locks; python-can takes none."""

    def __init__(self, channel: str) -> None:
        self._file: int | None = None
        device = CanAddress("slcan", channel).device
        if sys.platform == "win32" or "://" in device:
            return
        self._file = os.open(device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self.close()
            raise

    def close(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            os.close(file)


def _is_version(line: bytes) -> bool:
    """Return whether a line is an adapter's version: `V1013`, or a CANable's text."""
    return (line[:1] in (b"V", b"v") and len(line) > 1) or b"can" in line.lower()


def _is_own(line: bytes) -> bool:
    """Return whether a line may come from an slcan adapter."""
    return line[:1] in _LINE_STARTS or _is_version(line)


def _no_adapter(channel: str, lines: list[bytes]) -> str:
    text = b" ".join(lines)[:40]
    what = f"sends {text!r}, which no slcan adapter does" if text else "sends nothing"
    return (
        f"{channel} {what}: it is not a CAN adapter, or has another firmware. With candleLight "
        "firmware an adapter is not a serial port: use can:socketcan:can0 on Linux, or "
        "can:gs_usb:0. If your slcan adapter never answers, add &sleep_after_open=2"
    )
