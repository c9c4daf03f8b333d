"""The line to a simulated device: its pace, its faults, and the link over it in one process.

Without a baud rate the line acts like a network: bytes pushed together arrive together, at once.
Times are in seconds on the caller's clock.
"""

from __future__ import annotations

import heapq
import itertools
import math
import random
import re
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeAlias, TypeVar

from armdrive.abilities import BITS_A_BYTE
from armdrive.errors import NoSuchPort
from armdrive.transports.link import Bell, Link, closed_link, lost_link
from firmware_protocol.frames import Frame

# Tolerance for floating-point rounding, as a share of one byte's time.
_ROUNDING = 1e-3


@dataclass(slots=True, eq=False)
class _Piece:
    data: bytes
    start_s: float
    byte_s: float
    end_s: float

    def arrived(self, now_s: float) -> int:
        """Return how many bytes have arrived completely."""
        if now_s >= self.end_s:
            return len(self.data)
        # Part of a piece counts, because a cable may be pulled in the middle of a line.
        count = math.floor((now_s - self.start_s) / self.byte_s + _ROUNDING) if self.byte_s else 0
        return min(max(count, 0), len(self.data))


class PacedWire:
    """A line at `baud` bits a second, or one that carries bytes at once."""

    def __init__(self, baud: int | None) -> None:
        self._byte_s = BITS_A_BYTE / baud if baud else 0.0
        self._pieces: deque[_Piece] = deque()
        self._free_s = -math.inf

    def push(self, data: bytes, now_s: float) -> None:
        """Put bytes on the line after those already under way."""
        if not data:
            return
        start_s = max(now_s, self._free_s)
        self._free_s = start_s + len(data) * self._byte_s
        self._pieces.append(_Piece(bytes(data), start_s, self._byte_s, self._free_s))

    def pull(self, now_s: float) -> bytes:
        """Take the bytes that have arrived completely by now."""
        return b"".join(self.pull_each(now_s))

    def pull_each(self, now_s: float) -> list[bytes]:
        """Take the arrived bytes in the pieces in which they were pushed."""
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
        """How many bytes are under way or have not been taken yet."""
        return sum(len(piece.data) for piece in self._pieces)

    def next_s(self) -> float:
        """Return when all bytes of the oldest `push` will have arrived; infinity when idle.

        One time for each push instead of one for each byte, because readers wait for whole lines.
        """
        return self._pieces[0].end_s if self._pieces else math.inf

    def clear(self) -> None:
        """Drop the bytes under way."""
        self._pieces.clear()
        self._free_s = -math.inf


# --- Faults: bytes lost, changed, repeated or late, in each direction by itself ------------------
# A message is what is put on the wire in one call: bytes, or on a bus a frame. There, faults act on
# frames as they do on the bytes of other wires. Random faults come from a seeded generator, so that
# a run can be repeated.

# A message: bytes, or frames.
M = TypeVar("M", bytes, tuple[Frame, ...])


class Amount:
    """Which bytes of the messages a fault affects, as indices of the next message.

    Each byte with the probability `share`; or the byte number `nth` from now, counted from 1; or
    without both of them the whole next message. The last two are then `spent`.
    """

    def __init__(self, draw: random.Random, *, share: float | None = None, nth: int = 0) -> None:
        self._draw, self._share, self._nth = draw, share, nth
        self.spent = False

    def strike(self, length: int) -> Sequence[int]:
        """Return the indices of the affected bytes of a message."""
        if self._share is not None:
            return [index for index in range(length) if self._draw.random() < self._share]
        if not self._nth:
            self.spent = True
            return range(length)
        last = self._nth
        self._nth = max(last - length, 0)
        self.spent = last <= length
        return (last - 1,) if self.spent else ()


# Turns a message with affected bytes into what passes of it.
Effect: TypeAlias = Callable[[Any, Sequence[int]], Any]


@dataclass(slots=True, eq=False)
class Rule:
    """One fault in one direction, until its amount is used up.

    A message that it affects is `late_s` late. Later ones wait for it, unless they may overtake it.
    """

    amount: Amount
    effect: Effect | None = None
    late_s: float = 0.0
    overtaken: bool = False


T = TypeVar("T")


class TimeQueue(Generic[T]):
    """Items ordered by their time in seconds; items with the same time keep their order."""

    def __init__(self) -> None:
        self._entries: list[tuple[float, int, T]] = []
        self._number = itertools.count()
        self.next_s = math.inf
        """When the next item is due; infinity if there is none."""

    def put(self, time_s: float, thing: T) -> None:
        """Schedule an item."""
        heapq.heappush(self._entries, (time_s, next(self._number), thing))
        self.next_s = self._entries[0][0]

    def pop(self) -> T:
        """Remove and return the next item."""
        thing = heapq.heappop(self._entries)[2]
        self.next_s = self._entries[0][0] if self._entries else math.inf
        return thing

    def due(self, now_s: float) -> Iterator[T]:
        """Remove and yield every item that is due by now."""
        while self.next_s <= now_s:
            yield self.pop()

    def clear(self) -> None:
        """Drop all items."""
        self._entries.clear()
        self.next_s = math.inf


class WireDirection:
    """One direction of the wire, with its faults."""

    def __init__(self) -> None:
        self.rules: list[Rule] = []
        self.until_s = -math.inf
        """When the last delayed message passes for which later ones wait."""

    def passed(self, message: M, now_s: float) -> tuple[M, float]:
        """Return the part of a message that passes, and when."""
        time_s, waits = now_s, True
        for rule in self.rules:
            if struck := rule.amount.strike(len(message)):
                message = message if rule.effect is None else rule.effect(message, struck)
                time_s += rule.late_s
                waits = waits and not rule.overtaken
        self.rules = [rule for rule in self.rules if not rule.amount.spent]
        if waits:
            time_s = max(time_s, self.until_s)
            self.until_s = time_s if time_s > now_s else self.until_s
        return message, time_s


class WireFaults:
    """Both directions, from the host and from the device, and the delayed messages of both."""

    def __init__(self) -> None:
        self.host = WireDirection()
        self.device = WireDirection()
        self.late: TimeQueue[tuple[WireDirection, Any]] = TimeQueue()

    def lose_late(self) -> None:
        """Drop the delayed messages of both directions."""
        self.late.clear()
        self.host.until_s = self.device.until_s = -math.inf


def lost(message: M, struck: Sequence[int]) -> M:
    """Drop the affected bytes or frames."""
    return _each(message, struck, 0)


def repeated(message: M, struck: Sequence[int]) -> M:
    """Send each affected byte or frame twice, and a wholly affected message twice in a row."""
    return message * 2 if len(struck) == len(message) else _each(message, struck, 2)


def _each(message: M, struck: Sequence[int], times: int) -> M:
    """Return a message in which each affected byte or frame stands `times` times."""
    passed = message[:0]
    for index in range(len(message)):
        passed += message[index : index + 1] * (times if index in struck else 1)
    return passed


def changed(draw: random.Random) -> Effect:
    """Return the effect that flips a bit in each affected byte, or one bit of a whole message.

    A frame with a wrong bit is lost, because its CRC is wrong.
    """

    def effect(message: M, struck: Sequence[int]) -> M:
        if not isinstance(message, bytes):
            return lost(message, struck)
        garbled = bytearray(message)
        for index in struck if len(struck) < len(message) else (draw.choice(struck),):
            garbled[index] ^= 1 << draw.randrange(8)
        return bytes(garbled)

    return effect


# --- The line with both directions ---------------------------------------------------------------

# Each line is a piece of its own: a device would otherwise get all of them when the last one ends.
_LINES = re.compile(rb"[^\r\n]*[\r\n]|[^\r\n]+")


class WireDevice(Protocol):
    """The device side of a dialect, as the wire sees it."""

    def receive(self, message: Any, now_s: float) -> None:
        """Receive bytes, or on a bus frames, that have arrived at the device by now."""

    def transmit(self, now_s: float) -> Any:
        """Advance the arm to now and return what it has sent since the last call."""

    def next_s(self) -> float:
        """Return when the device next acts on its own; infinity while it only waits."""


class DeviceLine:
    """A line to a device: carries bytes both ways at a baud rate, or at once without one.

    Time may advance in steps of any size. Events in between happen at their own time, so replies
    are exactly as late as if the line had been polled continuously. Text lines sent together on a
    paced line each arrive at their own time.
    """

    def __init__(self, device: WireDevice, baud: int | None) -> None:
        self.device = device
        self.faults = WireFaults()
        self._baud = baud
        self._in = PacedWire(baud)
        self._out = PacedWire(baud)
        self._plugged = True
        self._advanced_s = -math.inf

    @property
    def pace(self) -> str:
        """The speed of the line, as text for people."""
        return f"at {self._baud} baud" if self._baud else ""

    @property
    def trouble(self) -> str:
        """Return nothing: only a pulled cable disconnects the host."""
        return ""

    @property
    def backlog(self) -> int:
        """How many bytes are still on their way to the device."""
        return self._in.waiting

    def send(self, data: bytes, now_s: float) -> None:
        """Send bytes to the device."""
        self.advance(now_s)
        if self._plugged:
            self._pass(self.faults.host, data, now_s)

    def receive(self, now_s: float) -> bytes:
        """Return the bytes that have come back by now."""
        self.advance(now_s)
        return self._out.pull(now_s)

    def advance(self, now_s: float) -> None:
        """Process everything that is due by now."""
        while (due_s := self._due_s()) < now_s:
            self.exchange(due_s)
        # A host often reads and writes at one moment: once is enough, unless more is due.
        if now_s > self._advanced_s or due_s <= now_s:
            self.exchange(now_s)

    def exchange(self, now_s: float) -> None:
        """Do what is due now. Nothing may have been due earlier."""
        self._advanced_s = now_s
        # Late messages go first: what is sent now was written after them.
        for lane, message in self.faults.late.due(now_s):
            self._carry(lane, message, now_s)
        self._deliver(now_s)
        if sent := self.device.transmit(now_s):
            self._answer(sent, now_s)

    def next_s(self) -> float:
        """Return when something next happens on either side; infinity if nothing is pending."""
        return min(self._due_s(), self._out.next_s())

    def readable_s(self) -> float:
        """Return when the bytes under way to the host have arrived; infinity if there are none."""
        return self._out.next_s()

    def unplug(self) -> None:
        """Pull the cable. Bytes under way are lost in both directions; the device keeps running."""
        self._plugged = False
        self._in.clear()
        self._out.clear()
        self.faults.lose_late()

    def replug(self, now_s: float) -> None:
        """Plug the cable back in. What the device sent in the meantime is lost."""
        self.advance(now_s)
        self.plug()

    def plug(self) -> None:
        """Plug the cable back in at the device's current time."""
        self._plugged = True

    def reopen(self) -> None:
        """Do nothing: a serial line does not notice when its host reopens the port."""

    def say(self, data: bytes, now_s: float) -> None:
        """Send bytes to the host that the device itself never sent."""
        if self._plugged:
            self._out.push(data, now_s)

    def _due_s(self) -> float:
        """Return when something happens other than an arrival at the host."""
        return min(self._in.next_s(), self.device.next_s(), self.faults.late.next_s)

    def _pass(self, lane: WireDirection, message: M, now_s: float) -> None:
        """Carry a message as far as the faults of its direction let it, now or later."""
        message, time_s = lane.passed(message, now_s)
        if time_s > now_s:
            self.faults.late.put(time_s, (lane, message))
        else:
            self._carry(lane, message, now_s)

    def _carry(self, lane: WireDirection, message: Any, now_s: float) -> None:
        """Put a message on the line; each line of a text is due at its own time."""
        if lane is self.faults.device:
            self._out.push(message, now_s)
            return
        for line in _LINES.findall(message) if self._baud else (message,):
            self._in.push(line, now_s)

    def _deliver(self, now_s: float) -> None:
        """Give the device what has arrived by now."""
        for arrived in self._in.pull_each(now_s):
            self.device.receive(arrived, now_s)

    def _answer(self, sent: Any, now_s: float) -> None:
        """Carry what the device has sent."""
        if self._plugged:
            self._pass(self.faults.device, sent, now_s)


# --- The link to a device in this process ---------------------------------------------------------
# It runs on the time that the engine passes in, simulated or real. The line sets the baud rate.

# `run` returns after this many events, so that its caller notices a clock that stands still.
MOST_EVENTS = 100


class MemoryLink(Link):
    """A `Link` to a simulated device in this process.

    Any thread may call `wake`, `unplug` and `replug`; everything else belongs to one thread.
    """

    def __init__(self, line: DeviceLine, name: str) -> None:
        """Use a line; `name` is the readable name of the device at its far end."""
        self._line = line
        self._name = name
        self._bell = Bell()
        self._plugged = True
        self._connected = True
        self._closed = False
        self._woken = False

    @property
    def line(self) -> DeviceLine:
        """The line that carries the bytes; its faults are those of the link."""
        return self._line

    @property
    def description(self) -> str:
        """Name the wire for people."""
        return f"{self._name} {self._line.pace}".rstrip()

    def write(self, data: bytes, now_s: float) -> None:
        """Send bytes. Raises `LinkLost` while unplugged."""
        self._check(now_s)
        self._line.send(data, now_s)

    def read(self, now_s: float) -> bytes:
        """Return what has arrived by now. Raises `LinkLost` while unplugged."""
        self._check(now_s)
        return self._line.receive(now_s)

    def next_s(self) -> float:
        """Return when bytes next arrive at either end, or the device next acts."""
        return self._line.next_s()

    def run(self, until_s: float) -> float:
        """Run the device until `until_s`, or until the host has something to do; return that time.

        The host has to act on received bytes, a `wake`, and a lost link. On simulated time it can
        skip all device events before that.
        """
        for _ in range(MOST_EVENTS):
            next_s = self.next_s()
            if next_s >= until_s:
                return until_s
            cut_off = not (self._plugged and self._connected) or self._closed
            if cut_off or self._line.readable_s() <= next_s:
                break
            self._line.exchange(next_s)
            if self._woken or self._line.trouble:
                self._woken = False
                break
        return next_s

    def wait(self, timeout_s: float) -> None:
        """Sleep until `wake` is called, or the timeout (real time only)."""
        self._bell.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` or a `run` early, from any thread."""
        self._woken = True
        self._bell.ring()

    def unplug(self) -> None:
        """Pull the cable: calls raise `LinkLost` from now on, and bytes in transit are lost."""
        self._plugged = False
        self.wake()

    def replug(self, name: str | None = None) -> None:
        """Plug the cable in again, optionally under another name.

        Everything that the device sent meanwhile is lost.
        """
        self._name = self._name if name is None else name
        self._plugged = True
        self.wake()

    def reopen(self, now_s: float | None = None) -> MemoryLink:
        """Open the link again after `close`. Raises `NoSuchPort` while unplugged.

        The device has run on until `now_s`, when its cable may have been plugged in again.
        """
        if not self._plugged and now_s is not None:
            self._cut_off(now_s)
        if not self._plugged:
            raise NoSuchPort(f"the cable to the {self._name} is unplugged: plug it in")
        if self._closed:
            self._closed, self._bell = False, Bell()
        self._line.reopen()
        return self

    def close(self) -> None:
        """Release the link; the device keeps its state."""
        self._closed = True
        self._bell.close()

    def _cut_off(self, now_s: float) -> None:
        """Let the device run on without its host."""
        self._line.unplug()
        self._connected = False
        self._line.advance(now_s)

    def _check(self, now_s: float) -> None:
        """Pass a pulled or replugged cable on to the line, on the thread that owns the line."""
        if self._closed:
            raise closed_link(f"the connection to the {self._name}")
        if not self._plugged:
            self._cut_off(now_s)
            raise lost_link(
                f"the connection to the {self._name}", "the cable is unplugged", "plug it in"
            )
        if not self._connected:
            self._line.replug(now_s)
            self._connected = True
        if trouble := self._line.trouble:
            self._line.advance(now_s)  # the device keeps running
            raise lost_link(f"the connection to the {self._name}", trouble, "wait for its end")
