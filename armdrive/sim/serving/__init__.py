"""A simulated arm as a separate process: the real-time loop between a server and a console.

Which file decides what:

    servers    the wire that other programs open: pseudo-terminal, TCP, UDP, CAN adapter
    console    the commands on standard input: one table

One thread does everything but read commands: it sleeps until a client has written, a command has
come or the device has something to do, and passes bytes between the server and the device's line.
The line decides when they arrive, as it does for a driver in the same process.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import FrameType

from armdrive.errors.printable import printable_lines
from armdrive.sim.bus.line import BusLine
from armdrive.sim.device import SimDevice
from armdrive.sim.faults import FaultRequest
from armdrive.sim.serving.console import Console
from armdrive.sim.serving.servers import (
    PtyServer,
    Server,
    SlcanServer,
    TcpServer,
    UdpServer,
    split_address,
)
from armdrive.sim.wire import DeviceLine
from armdrive.transports.address import BITRATE
from armdrive.transports.link import Bell

LONGEST_SLEEP_S = 0.25
LONGEST_LINE = 1024  # bytes of a command; the beginning of a longer one is lost
# As many bytes as a computer's own serial port buffers.
MOST_BACKLOG = 4096
_CHUNK = 4096


def make_server(
    *,
    pty: Path | None = None,
    tcp: str | None = None,
    udp: str | None = None,
    slcan: Path | None = None,
    listener: Path | None = None,
    bits_s: int = BITRATE,
) -> Server:
    """Offer a pty (linked at a path), or a TCP or UDP port (`HOST:PORT`, `:PORT` or `PORT`).

    With none of them, offer a pty without a link. With `slcan`, offer a pty with a CAN adapter
    behind it, on a bus of that bit rate; `listener` adds a second such adapter. Raises
    `PortUnavailable`.
    """
    if slcan is not None:
        return SlcanServer(*filter(None, (slcan, listener)), bits_s=bits_s)
    if tcp is not None:
        return TcpServer(*split_address(tcp))
    return PtyServer(pty) if udp is None else UdpServer(*split_address(udp))


def run_device(
    device: SimDevice,
    server: Server,
    commands: int | None,
    say: Callable[[str], object],
    *,
    faults: Iterable[FaultRequest] = (),
) -> None:
    """Run the device in real time until `quit`, SIGTERM or SIGINT, then close the server.

    The `faults` begin, or start counting their time, at the same moment. Raises `BadRequest` for a
    fault that this device cannot have.

    `commands` is a file descriptor with one-line commands, or None; its end does not end the
    device. `say` is called with each reply, of one line or several.
    """
    bell = Bell()
    try:
        loop = ServeLoop(device, server, say, bell)
        loop.begin(faults)
        with _ending_signals(loop.end):
            if commands is not None:
                threading.Thread(
                    target=_hear, args=(commands, loop.lines, bell), daemon=True
                ).start()
            loop.run()
    finally:
        server.close()
        bell.close()


class ServeLoop:
    """Passes bytes and commands to the device as they come."""

    def __init__(
        self,
        device: SimDevice,
        server: Server,
        say: Callable[[str], object],
        bell: Bell,
    ) -> None:
        self.lines: deque[str] = deque()
        self._line = _line_to(device, server)
        self._console = Console(device, server, self._line)
        self._server = server
        self._reply = say
        self._bell = bell

    def end(self) -> None:
        """End the loop; safe within a signal handler."""
        self._console.ended = True
        self._bell.ring()

    def begin(self, faults: Iterable[FaultRequest]) -> None:
        """Start the device's clock and its faults."""
        self._line.advance(time.monotonic())
        for fault in faults:
            self._console.faults.ask(fault)

    def run(self) -> None:
        """Serve until the loop is ended."""
        while not self._console.ended:
            self._sleep()
            self.turn()

    def turn(self) -> None:
        """Pass on what is there."""
        now_s = time.monotonic()
        data = self._server.read() if self._listening() else b""
        if data:
            self._line.send(data, now_s)
        self._server.write(self._line.receive(now_s))
        while self.lines and not self._console.ended:
            self._obey(self.lines.popleft())
        while self._console.faults.troubles:
            self._say(self._console.faults.troubles.pop(0))

    def _sleep(self) -> None:
        """Sleep until bytes or commands arrive, or the device has something to do."""
        pause_s = min(max(self._line.next_s() - time.monotonic(), 0.0), LONGEST_SLEEP_S)
        self._bell.wait(pause_s, *(self._server.filenos() if self._listening() else ()))

    def _listening(self) -> bool:
        """Return whether to read more bytes: a client that floods the line has to wait for it."""
        return self._line.backlog < MOST_BACKLOG

    def _obey(self, line: str) -> None:
        answer = self._console.answer(line)
        if answer:
            self._say(answer)

    def _say(self, line: str) -> None:
        with contextlib.suppress(OSError, ValueError):  # the reader of the replies is gone
            self._reply(printable_lines(line))


def _line_to(device: SimDevice, server: Server) -> DeviceLine:
    """Return the line that carries the bytes: a paced serial line, or the bus behind an adapter."""
    if isinstance(server, SlcanServer):
        adapter = server.adapters[0]
        return BusLine(device, adapter.bus_bitrate, adapter.faults)
    return DeviceLine(device, device.board.baud if server.paced else None)


def _hear(fileno: int, lines: deque[str], bell: Bell) -> None:
    """Read command lines on a thread, because not every system can select on such files.

    It uses the system's own read: a thread blocked in a Python file would hang at exit.
    """
    rest = b""
    with contextlib.suppress(OSError):
        while data := os.read(fileno, _CHUNK):
            *whole, rest = (rest + data).split(b"\n")
            rest = rest[-LONGEST_LINE:]
            lines.extend(line.decode("utf-8", "replace") for line in whole)
            bell.ring()
    if rest.strip():
        lines.append(rest.decode("utf-8", "replace"))
        bell.ring()


@contextlib.contextmanager
def _ending_signals(end: Callable[[], None]) -> Iterator[None]:
    """Make SIGTERM and SIGINT end the loop. Only the main thread can set signal handlers."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def handler(_number: int, _frame: FrameType | None) -> None:
        end()

    kept = {number: signal.signal(number, handler) for number in (signal.SIGTERM, signal.SIGINT)}
    try:
        yield
    finally:
        for number, before in kept.items():
            signal.signal(number, before)
