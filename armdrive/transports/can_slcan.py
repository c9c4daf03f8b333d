"""A serial CAN adapter (slcan) that is listened to: python-can's own, with its answers heard.

python-can's slcan reads past what the adapter says of itself, so that a frame which could not be
sent looks sent (hardbyte/python-can issue 2060), waits two seconds for every adapter, and lets two
programs share one. Its names and options are kept.
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
from armdrive.transports.can_threads import frame_of as frame_of_message
from armdrive.transports.can_threads import message_of
from firmware_protocol.frames import Frame
from firmware_protocol.slcan import BELL, SlcanLines, frame_of, line_of

if sys.platform != "win32":
    import fcntl

GREETING_S = 0.4
"""An adapter that does not answer by then is asked again."""
GREETINGS = 6
"""So often, since one on an Arduino sleeps for two seconds after its port was opened."""
MOST_WORDS = 100
WRITE_PATIENCE_S = 0.5
POLL_S = 0.02
CHUNK = 4096
_OWN_WORDS = frozenset({b"", BELL, *(bytes([each]) for each in b"VvNzZtTrRF")})
"""What an adapter's lines begin with; an empty one is its yes."""
_YES = frozenset({b"", b"z", b"Z"})
_ECHOES = frozenset({b"C", b"O", b"V"})
"""What only a device says that repeats what it hears."""


class Slcan(slcanBus):
    """python-can's slcan bus; `refused` counts the adapter's bells, `refusing` is its last word."""

    def __init__(
        self, channel: str, *, sleep_after_open: float | None = None, **settings: Any
    ) -> None:
        """Open the port and the bus, and wait until the adapter answers.

        With a `sleep_after_open` it is waited for so long, and nothing is asked.
        """
        self.refused = 0
        self.refusing = False
        self._status: int | None = None
        self._heard: deque[Frame] = deque()
        self._words: list[bytes] = []
        self._lines = SlcanLines()
        self._lock_file = _Lock(channel)
        try:
            super().__init__(channel, sleep_after_open=sleep_after_open or 0.0, **settings)
            if sleep_after_open is None:
                self._greet(channel, settings.get("bitrate"))
        except BaseException:
            self.shutdown()
            raise

    def ask(self) -> None:
        """Ask for the status of the adapter; it comes while frames are received, if at all."""
        self._write("F")

    def take_status(self) -> int | None:
        """Take the answer, once it is there."""
        status, self._status = self._status, None
        return status

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame, or raise a `can.CanError` within the timeout."""
        frame = frame_of_message(msg)
        if frame is None:
            raise can.CanOperationError("an slcan adapter sends no frames of CAN FD")
        self._put(line_of(frame), WRITE_PATIENCE_S if timeout is None else timeout)

    def shutdown(self) -> None:
        """Take the adapter off the bus, and give the port back whatever happens."""
        with contextlib.suppress(can.CanError, AttributeError):  # the latter: it never was open
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
        elif line[:1] == b"F" and len(line) == 3:
            with contextlib.suppress(ValueError):
                self._status = int(line[1:], 16)
        if len(self._words) < MOST_WORDS:
            self._words.append(line)

    def _fill(self, pause_s: float) -> bytes:
        """Return what has come; sleep for it, but no longer than the pause."""
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
        """Say a line: python-can's own would wait for a stuck adapter for ever."""
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
            raise can.CanOperationError(f"the adapter cannot be written to ({error})") from error

    def _greet(self, channel: str, bitrate: int | None) -> None:
        """Wait until the adapter has told its version, or anything else that only it would say."""
        for turn in range(GREETINGS):
            self._write("V")
            if self._answered(GREETING_S):
                if turn:  # it was asleep when it was told the bit rate
                    self._set_up_again(bitrate)
                # whatever was said before was said to somebody else
                self.refused, self.refusing, self._status = 0, False, None
                self._heard.clear()
                return
        raise NoConnection(_nobody(channel, self._words))

    def _set_up_again(self, bitrate: int | None) -> None:
        if bitrate is None:
            self.close()
            self.open()
        else:
            self.set_bitrate(bitrate)
        self._words.clear()
        self._write("V")
        self._answered(GREETING_S)

    def _answered(self, patience_s: float) -> bool:
        """Listen for the version, which ends all that was said before; other words are signs."""
        end_s = time.monotonic() + patience_s
        while (left_s := end_s - time.monotonic()) > 0.0:
            for line in self._lines.feed(self._fill(left_s)):
                self._take(line)
            if any(_is_version(line) for line in self._words):
                return True
        echoes = any(line in _ECHOES for line in self._words)
        return not echoes and any(_is_own(line) for line in self._words)


class _Lock:
    """The right to a port for one program, where there are such locks: python-can takes none."""

    def __init__(self, channel: str) -> None:
        self._file: int | None = None
        device = channel.rpartition("@")[0] or channel
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
    """Tell whether a line is an adapter's version: `V1013`, or the words of a CANable."""
    return (line[:1] in (b"V", b"v") and len(line) > 1) or b"can" in line.lower()


def _is_own(line: bytes) -> bool:
    """Tell whether a line is one that an slcan adapter says."""
    return line[:1] in _OWN_WORDS or _is_version(line)


def _nobody(channel: str, words: list[bytes]) -> str:
    heard = b" ".join(words)[:40]
    what = f"says {heard!r}, which no slcan adapter does" if heard else "says nothing"
    return (
        f"{channel} {what}: it is no CAN adapter, or one with another firmware. candleLight "
        "firmware is no serial port at all: use can:socketcan:can0 on Linux, or can:gs_usb:0; an "
        "adapter that never answers is opened with &sleep_after_open=2"
    )
