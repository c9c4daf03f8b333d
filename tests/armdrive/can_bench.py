"""For tests of CAN: functions that read links, an echoing drive, a bus that fails on request."""

import threading
from collections import deque

import can
from waiting import LONG_S, looks

from armdrive.errors import LinkLost
from armdrive.transports.can_link import CanLink
from firmware_protocol.frames import Frame, Unpacker


def frames_of(link, count: int = 1) -> list[Frame]:
    """Read frames as the engine does: take those that are there, and wait on the link."""
    unpacker, found = Unpacker(), []
    for _ in looks("the frames never came"):
        found += unpacker.feed(link.read(0.0))
        if len(found) >= count:
            break
        link.wait(LONG_S)
    return found


def until_lost(link) -> str:
    """Wait until the link breaks, and return the error's words."""
    for _ in looks("the link never broke"):
        try:
            link.read(0.0)
        except LinkLost as lost:
            return str(lost)
        link.wait(0.05)
    raise AssertionError


class EchoDrive:
    """A device that replies to each frame with the same data and the next id, after a time."""

    def __init__(self, after_s: float = 0.0) -> None:
        self.heard: list[tuple[float, Frame]] = []
        self.mute = False
        self._after_s = after_s
        self._due: deque[tuple[float, Frame]] = deque()

    def receive(self, message: tuple[Frame, ...], now_s: float) -> None:
        for frame in message:
            self.heard.append((now_s, frame))
            if not self.mute:
                self._due.append((now_s + self._after_s, Frame(frame.can_id + 1, frame.data)))

    def transmit(self, now_s: float) -> tuple[Frame, ...]:
        said = []
        while self._due and self._due[0][0] <= now_s:
            said.append(self._due.popleft()[1])
        return tuple(said)

    def next_s(self) -> float:
        return self._due[0][0] if self._due else float("inf")


class FailingBus(can.BusABC):
    """A bus that yields the frames and errors that a test gives it, and records sent frames."""

    def __init__(self) -> None:
        self.channel_info = "failing"
        self.coming: deque[can.Message | Exception] = deque()
        self.always: Exception | None = None
        self.sending: deque[Exception] = deque()
        self.full = False
        self.stuck = threading.Event()
        self.stuck.set()
        self.sent: list[can.Message] = []
        self.broken = can.BusState.ACTIVE
        super().__init__("failing")

    def _recv_internal(self, timeout):
        if self.always is not None:
            raise self.always
        if self.coming:
            came = self.coming.popleft()
            if isinstance(came, Exception):
                raise came
            return came, False
        threading.Event().wait(min(timeout, 0.005))
        return None, False

    def send(self, msg, timeout=None):
        self.stuck.wait()
        if self.full:
            raise can.CanOperationError("Transmit buffer full")
        if self.sending:
            raise self.sending.popleft()
        self.sent.append(msg)

    @property
    def state(self):
        return self.broken


def failing_link(**settings) -> tuple[FailingBus, CanLink]:
    bus = FailingBus()
    return bus, CanLink(bus, "can:failing", **settings)


def message(can_id: int, data: bytes = b"", **more) -> can.Message:
    return can.Message(arbitration_id=can_id, data=data, is_extended_id=False, **more)
