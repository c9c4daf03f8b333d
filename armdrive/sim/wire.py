"""The line to a simulated device: bytes paced by a baud rate, and what may go wrong with them.

Without a baud rate the line is that of a network: what is pushed at once arrives at once, as one.
Times are in seconds on the caller's clock.
"""

from __future__ import annotations

import heapq
import itertools
import math
import random
import re
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

BITS_A_BYTE = 10
"""A start bit, eight data bits and a stop bit."""
_ROUNDING = 1e-3
"""The share of a byte's time that may be missing through floating-point rounding."""


@dataclass(slots=True, eq=False)
class _Piece:
    data: bytes
    start_s: float
    byte_s: float

    @property
    def end_s(self) -> float:
        return self.start_s + len(self.data) * self.byte_s

    def arrived(self, now_s: float) -> int:
        """Count the bytes whose last bit has arrived."""
        if not self.byte_s:
            return len(self.data) if now_s >= self.start_s else 0
        count = math.floor((now_s - self.start_s) / self.byte_s + _ROUNDING)
        return min(max(count, 0), len(self.data))


class PacedWire:
    """A line at `baud` bits a second; `extra_s` is a pause after each byte pushed from now on."""

    def __init__(self, baud: int | None, extra_s: float = 0.0) -> None:
        self.bit_s = 1.0 / baud if baud else 0.0
        self.extra_s = extra_s
        self._pieces: deque[_Piece] = deque()
        self._free_s = -math.inf

    def push(self, data: bytes, now_s: float) -> None:
        """Put bytes on the line, behind those that are still under way."""
        if not data:
            return
        start_s = max(now_s, self._free_s)
        piece = _Piece(bytes(data), start_s, BITS_A_BYTE * self.bit_s + self.extra_s)
        self._pieces.append(piece)
        self._free_s = piece.end_s

    def pull(self, now_s: float) -> bytes:
        """Take the bytes that have arrived whole by now."""
        return b"".join(self.pull_each(now_s))

    def pull_each(self, now_s: float) -> list[bytes]:
        """Take them apart as they were pushed."""
        taken: list[bytes] = []
        while self._pieces:
            piece = self._pieces[0]
            count = piece.arrived(now_s)
            if count:
                taken.append(piece.data[:count])
            if count < len(piece.data):
                piece.data = piece.data[count:]
                piece.start_s += count * piece.byte_s
                break
            self._pieces.popleft()
        return taken

    @property
    def waiting(self) -> int:
        """How many bytes are still under way, or were not taken yet."""
        return sum(len(piece.data) for piece in self._pieces)

    def next_s(self) -> float:
        """Tell when the bytes of the oldest `push` will all have arrived; infinity when idle.

        One moment for each push, not one for each byte: a whole line is what a reader waits for.
        """
        return self._pieces[0].end_s if self._pieces else math.inf

    def clear(self) -> None:
        """Lose what is under way."""
        self._pieces.clear()
        self._free_s = -math.inf


# --- Faults: bytes lost, changed, repeated or late, in each direction by itself ------------------
#
# A message is what is put on the wire at once. Random faults come from a seeded generator, so that
# a run can be repeated.


class Amount(ABC):
    """How much of what passes is struck, and which bytes of it."""

    spent = False

    @abstractmethod
    def strike(self, length: int) -> tuple[int, ...]:
        """Return the indices of the bytes of the next message that are struck."""

    def strikes(self, length: int) -> bool:
        """Tell whether the next message is struck, for what befalls messages only as a whole."""
        return bool(self.strike(length))


class Share(Amount):
    """Each byte (or message) with a probability."""

    def __init__(self, share: float, draw: random.Random) -> None:
        self._share = share
        self._draw = draw

    def strike(self, length: int) -> tuple[int, ...]:
        """Draw for each byte."""
        return tuple(index for index in range(length) if self._draw.random() < self._share)

    def strikes(self, length: int) -> bool:  # noqa: ARG002 - one draw, however long it is
        """Draw once."""
        return self._draw.random() < self._share


class Nth(Amount):
    """One byte alone: the n-th from now, counted from 1."""

    def __init__(self, number: int) -> None:
        self._left = number

    def strike(self, length: int) -> tuple[int, ...]:
        """Count on."""
        self._left -= length
        if self.spent or self._left > 0:
            return ()
        self.spent = True
        return (self._left + length - 1,)


class Next(Amount):
    """The whole of the next message."""

    def strike(self, length: int) -> tuple[int, ...]:
        """Strike all of it, once."""
        if self.spent:
            return ()
        self.spent = True
        return tuple(range(length))


Effect = Callable[[bytes, Amount], tuple[bytes, float]]
"""Turns a message into what passes, and how many seconds late."""


@dataclass(slots=True, eq=False)
class Rule:
    """One fault on one lane, until its amount is spent."""

    effect: Effect
    amount: Amount


T = TypeVar("T")


class TimeQueue(Generic[T]):
    """Things by their time in seconds; of two at the same time the one put first comes first."""

    def __init__(self) -> None:
        self._entries: list[tuple[float, int, T]] = []
        self._number = itertools.count()
        self.next_s = math.inf
        """When the next one is due; infinity while there is none."""

    def put(self, time_s: float, thing: T) -> None:
        """Have something come at a time."""
        heapq.heappush(self._entries, (time_s, next(self._number), thing))
        self.next_s = self._entries[0][0]

    def pop(self) -> T:
        """Take the next one out."""
        thing = heapq.heappop(self._entries)[2]
        self.next_s = self._entries[0][0] if self._entries else math.inf
        return thing

    def due(self, now_s: float) -> Iterator[T]:
        """Take out one after the other that is due by now."""
        while self.next_s <= now_s:
            yield self.pop()

    def clear(self) -> None:
        """Have nothing come any more."""
        self._entries.clear()
        self.next_s = math.inf


class WireDirection:
    """One direction of the wire, with its faults; what is late stays in its order."""

    def __init__(self) -> None:
        self.rules: list[Rule] = []
        self._late: TimeQueue[bytes] = TimeQueue()
        self._last_s = -math.inf

    @property
    def next_s(self) -> float:
        """When the next late message is due; infinity while there is none."""
        return self._late.next_s

    @property
    def clear(self) -> bool:
        """Whether all passes at once as it is."""
        return not self.rules and self._late.next_s == math.inf

    def passed(self, data: bytes, now_s: float) -> list[bytes]:
        """Return what of a message passes at once; the rest is lost, or comes by `due`."""
        late_s = 0.0
        for rule in self.rules:
            data, more_s = rule.effect(data, rule.amount)
            late_s += more_s
        self.rules = [rule for rule in self.rules if not rule.amount.spent]
        if not late_s and math.isinf(self.next_s):
            return [data] if data else []
        self._last_s = max(now_s + late_s, self._last_s)
        self._late.put(self._last_s, data)
        return []

    def due(self, now_s: float) -> list[bytes]:
        """Take the late messages whose time has come."""
        return list(self._late.due(now_s)) if self._late.next_s <= now_s else []

    def lose_late(self) -> None:
        """Lose what is late."""
        self._late.clear()


class WireFaults:
    """The two lanes: what the host says, and what the device says."""

    def __init__(self) -> None:
        self.host = WireDirection()
        self.device = WireDirection()

    @property
    def next_s(self) -> float:
        """When a late message is due on either lane."""
        host_s, device_s = self.host.next_s, self.device.next_s
        return min(device_s, host_s)

    def lose_late(self) -> None:
        """Lose what is late in both directions."""
        self.host.lose_late()
        self.device.lose_late()


def lost(message: bytes, amount: Amount) -> tuple[bytes, float]:
    """Lose the bytes that are struck."""
    struck = amount.strike(len(message))
    return bytes(byte for index, byte in enumerate(message) if index not in struck), 0.0


def repeated(message: bytes, amount: Amount) -> tuple[bytes, float]:
    """Say the bytes that are struck twice; a whole message, one time after the other."""
    struck = amount.strike(len(message))
    if len(struck) == len(message):
        return message * 2, 0.0
    pieces = (bytes([byte]) * (1 + (index in struck)) for index, byte in enumerate(message))
    return b"".join(pieces), 0.0


def changed(draw: random.Random) -> Effect:
    """Flip a bit in each byte that is struck; in one byte of a message that is struck whole."""

    def effect(message: bytes, amount: Amount) -> tuple[bytes, float]:
        struck = amount.strike(len(message))
        if isinstance(amount, Next) and struck:
            struck = (draw.choice(struck),)
        garbled = bytearray(message)
        for index in struck:
            garbled[index] ^= 1 << draw.randrange(8)
        return bytes(garbled), 0.0

    return effect


def late(delay_s: float) -> Effect:
    """Delay messages; those behind a late one wait for it."""

    def effect(message: bytes, amount: Amount) -> tuple[bytes, float]:
        return message, delay_s if amount.strikes(len(message)) else 0.0

    return effect


# --- The line with both directions ---------------------------------------------------------------

_LINES = re.compile(rb"[^\r\n]*[\r\n]|[^\r\n]+")


class WireDevice(Protocol):
    """The device side of a dialect, as its wire knows it."""

    @property
    def byte_gap_s(self) -> float:
        """How long the device pauses after each byte that it sends, beyond the baud rate's time."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that have arrived at the device by now."""

    def transmit(self, now_s: float) -> bytes:
        """Advance the arm to now and return the bytes that it has to say since the last call."""

    def next_s(self) -> float:
        """Tell when the device next does something by itself; infinity while it only waits."""


class PacedDevice:
    """A `Line` to a device: carries bytes both ways at a baud rate, or at once where there is none.

    Time may be advanced in steps of any size: what happens in between happens at its own moment,
    so that an answer is as late as if the line had been looked at all the time. Of lines that
    are put on a paced line at once, each arrives at its own moment.
    """

    def __init__(self, device: WireDevice, baud: int | None) -> None:
        self.device = device
        self.faults = WireFaults()
        self._baud = baud
        self._in = PacedWire(baud)
        self._out = PacedWire(baud)
        self._plugged = True

    @property
    def pace(self) -> str:
        """How fast bytes travel, for people."""
        return f"at {self._baud} baud" if self._baud else ""

    @property
    def trouble(self) -> str:
        """Return nothing: only a pulled cable cuts the host off."""
        return ""

    @property
    def backlog(self) -> int:
        """How many bytes are still on their way to the device."""
        return self._in.waiting

    def send(self, data: bytes, now_s: float) -> None:
        """Put bytes on the line to the device."""
        self.advance(now_s)
        if self._plugged:
            for piece in self.faults.host.passed(data, now_s):
                self._push(piece, now_s)

    def receive(self, now_s: float) -> bytes:
        """Take what has come back by now."""
        self.advance(now_s)
        return self._out.pull(now_s)

    def advance(self, now_s: float) -> None:
        """Let everything happen that is due by now."""
        while (due_s := self._due_s()) < now_s:
            self._exchange(due_s)
        self._exchange(now_s)

    def next_s(self) -> float:
        """Tell when something next happens on either side; infinity while all is quiet."""
        return min(self._due_s(), self._out.next_s())

    def readable_s(self) -> float:
        """Return when what is on its way to the host has arrived; infinity while nothing is."""
        return self._out.next_s()

    def unplug(self) -> None:
        """Pull the cable: what is under way is lost in both directions; the device lives on."""
        self._plugged = False
        self._in.clear()
        self._out.clear()
        self.faults.lose_late()

    def replug(self, now_s: float) -> None:
        """Put the cable back; what the device sent meanwhile is lost."""
        self.advance(now_s)
        self.plug()

    def plug(self) -> None:
        """Put the cable back at the device's present moment."""
        self._plugged = True

    def reopen(self) -> None:
        """Do nothing: a serial line does not notice when its host opens the port again."""

    def say(self, data: bytes, now_s: float) -> None:
        """Put bytes on the line to the host that the device itself never sent."""
        if self._plugged:
            self._out.push(data, now_s)

    def _push(self, data: bytes, now_s: float) -> None:
        for line in _LINES.findall(data) if self._baud else (data,):
            self._in.push(line, now_s)

    def _due_s(self) -> float:
        """Tell when something next happens that is more than an arrival at the host."""
        return min(self._in.next_s(), self.device.next_s(), self.faults.next_s)

    def _exchange(self, now_s: float) -> None:
        for late in self.faults.host.due(now_s):
            self._push(late, now_s)
        for arrived in self._in.pull_each(now_s):
            self.device.receive(arrived, now_s)
        sent = self.device.transmit(now_s)
        pieces = self.faults.device.due(now_s)
        if sent and self._plugged:
            pieces += self.faults.device.passed(sent, now_s)
        for piece in pieces:
            self._out.extra_s = self.device.byte_gap_s
            self._out.push(piece, now_s)


# --- Faults of whole CAN frames: one is lost, or overtaken by the next one -----------------------
#
# A single wrong bit is no fault here: a frame's CRC finds it, and its controller sends it again.


def frame_lost(frame: bytes, amount: Amount) -> tuple[bytes, float]:
    """Lose whole frames: an adapter's or a drive's buffer was full."""
    return (b"" if amount.strikes(len(frame)) else frame), 0.0


def overtaken(amount: Amount) -> Rule:
    """Return the rule that has frames come after the next one; without a next one they are lost."""
    holding = _Holding(amount)
    return Rule(holding.passed, holding)


class _Holding(Amount):
    """Holds a frame back; it is spent when its amount is, and nothing is held any more."""

    def __init__(self, amount: Amount) -> None:
        self._amount = amount
        self._held = b""

    def strike(self, length: int) -> tuple[int, ...]:
        """Ask the amount."""
        return self._amount.strike(length)

    def passed(self, frame: bytes, _: Amount) -> tuple[bytes, float]:
        """Hold a frame that is struck, and let it go behind the next one."""
        if self._held:
            frame, self._held = frame + self._held, b""
            self.spent = self._amount.spent
        elif self._amount.strikes(len(frame)):
            frame, self._held = b"", frame
        return frame, 0.0
