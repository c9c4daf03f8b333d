"""A CAN interface of the kernel with simulated drives behind it, which can be taken down and up.

As on Linux: a socket hears once that its interface went down, and nothing more until it is up;
who sends meanwhile is told each time. The drives live on.
"""

from __future__ import annotations

import errno
import os
import threading
import time
from queue import Empty, SimpleQueue
from typing import Any

import can

from armdrive.connect.target import simulated_config
from armdrive.registry import simulate_device
from armdrive.sim.bus.line import BusLine
from armdrive.sim.device import SimDevice
from firmware_protocol.frames import Frame, Unpacker, pack

LONGEST_S = 0.05


class Interface:
    """`can0`: drives in real time, and every socket that is open on them."""

    def __init__(self) -> None:
        self.device: SimDevice = simulate_device(simulated_config("mks"))
        self.up = self.there = True
        self.sockets: list[Socket] = []
        self._line = BusLine(self.device)
        self._lock = threading.Lock()
        self._work = threading.Event()
        self._ended = False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def open(self, **_settings: Any) -> Socket:
        """Open a socket on it, in place of python-can's `Bus`."""
        if not self.there:
            raise failure("open", errno.ENODEV)
        self.sockets.append(Socket(self))
        return self.sockets[-1]

    def down(self, *, heard: bool = True) -> None:
        """`ip link set can0 down`; where it is not `heard`, only who sends is told."""
        with self._lock:
            self.up = False
            for each in self.sockets if heard else ():
                each.heard.put(errno.ENETDOWN)

    def remove(self) -> None:
        """Have the adapter unplugged: the interface is no more."""
        with self._lock:
            self.up = self.there = False
            for each in self.sockets:
                each.heard.put(errno.ENODEV)

    def bring_up(self) -> None:
        """`ip link set can0 up`, plugged in again where it was not."""
        self.up = self.there = True

    def send(self, frame: Frame) -> None:
        """Put a frame on the bus."""
        with self._lock:
            if not self.up:
                raise failure("transmit", errno.ENETDOWN)
            self._line.send(pack(frame), time.monotonic())
        self._work.set()

    def end(self) -> None:
        """End the drives' time."""
        self._ended = True
        self._work.set()
        self._thread.join()

    def _run(self) -> None:
        unpacker = Unpacker()
        while not self._ended:
            with self._lock:
                for frame in unpacker.feed(self._line.receive(time.monotonic())):
                    for each in self.sockets if self.up else ():
                        each.heard.put(frame)
                due_s = self._line.next_s()
            self._work.wait(min(max(due_s - time.monotonic(), 0.0), LONGEST_S))
            self._work.clear()


class Socket(can.BusABC):
    """What one program has open on it."""

    def __init__(self, interface: Interface) -> None:
        self.channel_info = "socketcan channel 'can0'"
        self.heard: SimpleQueue[Frame | int] = SimpleQueue()
        """Frames, and the numbers of the system's errors."""
        self._interface = interface
        super().__init__("can0")

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send, or say why not."""
        self._interface.send(Frame(msg.arbitration_id, bytes(msg.data)))

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        try:
            heard = self.heard.get(timeout=timeout or 0.0)
        except Empty:
            return None, False
        if isinstance(heard, int):
            raise failure("receive", heard)
        return can.Message(
            arbitration_id=heard.can_id, data=heard.data, is_extended_id=False
        ), False


def failure(what: str, number: int) -> can.CanOperationError:
    """Return the error that python-can makes of the system's."""
    return can.CanOperationError(f"Failed to {what}: {os.strerror(number)}", number)
