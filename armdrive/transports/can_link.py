"""A CAN bus as a `Link`: the engine reads and writes packed frames, which python-can transports.

One thread receives, another one sends, and a watch declares the bus lost: bus-off means a lost bus
at once; error-passive, refused frames and failing reads do if they last. A received frame clears
all three. No driver or kernel ever repeats a frame periodically: the frames that keep an arm moving
come from the engine alone, and end with it.
"""

from __future__ import annotations

import contextlib
import errno
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from armdrive.transports.can_health import (
    BusHealth,
    BusState,
    left_bus,
    not_heard,
    of_error_frame,
)
from armdrive.transports.link import Bell, Link, closed_link, lost_link
from armdrive.transports.ports import gone_words, number_of
from firmware_protocol.frames import DATA_MAX, Frame, Unpacker, pack

if TYPE_CHECKING:
    import can

# A problem that lasts this long without a received frame ends the link.
#
# Longer than the interval at which even an arm at rest answers.
WATCH_PATIENCE_S = 0.85


@runtime_checkable
class ReportsRefusals(Protocol):
    """A bus whose adapter reports frames that it could not send (slcan)."""

    refused: int
    """The number of frames that the adapter reported as not sent."""
    refusing: bool
    """Whether the adapter reported the latest frame as not sent."""


def frame_of(message: can.Message) -> Frame | None:
    """Return the frame of a message; None for CAN FD, which no supported arm uses."""
    if message.is_fd or len(message.data) > DATA_MAX:
        return None
    data = b"" if message.is_remote_frame else bytes(message.data)
    return Frame(message.arbitration_id, data, message.is_extended_id, message.is_remote_frame)


def message_of(frame: Frame) -> can.Message:
    """Return a frame as python-can's message."""
    import can

    return can.Message(
        arbitration_id=frame.can_id,
        data=frame.data,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
    )


class Watch:
    """Decides when a bus is lost. Called from the reader, the writer and the engine's thread."""

    def __init__(self, clock: Callable[[], float], ring: Callable[[], None]) -> None:
        """Call `ring` to wake the thread that sleeps on the link."""
        self.ended = threading.Event()
        self._clock = clock
        self._ring = ring
        self._lock = threading.Lock()
        self._health = BusHealth()
        self._lost = ""
        self._since: dict[str, tuple[float, str]] = {}

    @property
    def health(self) -> BusHealth:
        """The state of the bus and its counters."""
        return self._health

    @property
    def lost(self) -> str:
        """The reason why the bus is lost; empty while it is not."""
        return self._lost

    def count(self, **more: int) -> None:
        """Add to counters."""
        with self._lock:
            sums = {name: getattr(self._health, name) + each for name, each in more.items()}
            self._health = replace(self._health, **sums)

    def heard(self, frames: int) -> None:
        """Count received frames; they prove that the bus works, and clear lasting problems."""
        self.count(received=frames)
        self._since.clear()

    def state(self, state: BusState, why: str) -> None:
        """Note the state of the adapter's controller."""
        with self._lock:
            trouble = why or self._health.last_trouble
            self._health = replace(self._health, state=state, last_trouble=trouble)
        if state is BusState.OFF:  # no frame leaves or arrives until the adapter is opened again
            self.lose(left_bus(why))
        elif state is BusState.PASSIVE:
            self.lasting("passive", not_heard(why))
        else:
            self.settled("passive")

    def lasting(self, kind: str, why: str) -> None:
        """Note a problem that ends the link if it lasts."""
        since_s, _ = self._since.get(kind, (self._clock(), ""))
        self._since[kind] = since_s, why
        with self._lock:
            self._health = replace(self._health, last_trouble=why)

    def settled(self, kind: str) -> None:
        """Note that a problem is over."""
        self._since.pop(kind, None)

    def look(self) -> None:
        """Declare the bus lost if a problem has lasted too long."""
        for since_s, why in list(self._since.values()):
            if self._clock() - since_s >= WATCH_PATIENCE_S:
                self.lose(why)

    def lose(self, why: str) -> None:
        """End the link; only the first reason is reported."""
        with self._lock:
            self._lost = self._lost or why
        self.ended.set()
        self._ring()


REFUSES = "the adapter refuses frames: no node acknowledges them, or the adapter has restarted"
RECV_S = 0.05  # timeout of one read, and so the interval at which lasting problems are checked
STATE_S = 0.2  # interval at which the driver is asked for the state
PAUSE_S = 0.01  # pause after an error, so that a driver that fails at once does not hog a core
MOST_UNREAD_FRAMES = 4096  # about a second of a full bus at 500 kbit/s


class CanReader:
    """Receives frames in its own thread, into a queue that drops the oldest when it is full.

    python-can's Notifier is not suitable, because it ends at the first error (hardbyte/python-can
    issues 907, 1667 and 1828). This thread survives every error of the bus and its driver.
    """

    def __init__(
        self,
        bus: can.BusABC,
        ids: frozenset[int],
        watch: Watch,
        *,
        ring: Callable[[], None],
        also: Callable[[], None],
    ) -> None:
        """Start receiving the `ids`, or all; call `ring` for a frame and `also` after each read."""
        self._bus = bus
        self._ids = ids
        self._watch = watch
        self._ring = ring
        self._also = also
        self._frames: deque[Frame] = deque()
        self._refused = 0
        self._state_s = 0.0
        self._thread = threading.Thread(target=self._run, name="armdrive-can-in", daemon=True)
        self._thread.start()

    def take(self) -> list[Frame]:
        """Return the received frames, in order, and remove them from the queue."""
        taken: list[Frame] = []
        with contextlib.suppress(IndexError):
            while len(taken) < MOST_UNREAD_FRAMES:
                taken.append(self._frames.popleft())
        return taken

    def join(self, patience_s: float) -> None:
        """Wait for the thread to end."""
        if self._thread is not threading.current_thread():
            self._thread.join(patience_s)

    def _run(self) -> None:
        while not self._watch.ended.is_set():
            try:
                message = self._bus.recv(RECV_S)
            except Exception as error:  # each backend raises its own types
                self._failed(error)
            else:
                self._watch.settled("reading")
                if message is not None:
                    self._hear(message)
            self._ask()
            self._also()
            self._watch.look()

    def _hear(self, message: can.Message) -> None:
        if message.is_error_frame:
            self._watch.count(error_frames=1)
            if report := of_error_frame(message.arbitration_id, bytes(message.data)):
                self._watch.state(*report)
            return
        frame = frame_of(message)
        if frame is None or not message.is_rx:
            return
        self._watch.heard(1)
        if not self._ids or frame.can_id in self._ids:
            if len(self._frames) >= MOST_UNREAD_FRAMES:
                self._frames.popleft()
                self._watch.count(overrun=1)
            self._frames.append(frame)
            self._ring()

    def _failed(self, error: Exception) -> None:
        self._watch.count(read_errors=1)
        if gone := gone_words(error):
            self._watch.lose(gone)
        self._watch.lasting("reading", f"it cannot be read ({error.__cause__ or error})")
        self._watch.ended.wait(PAUSE_S)

    def _ask(self) -> None:
        """Check the state of the controller, if its driver or adapter knows it."""
        if isinstance(self._bus, ReportsRefusals):
            more, self._refused = self._bus.refused - self._refused, self._bus.refused
            if more:
                self._watch.count(refused=more)
                self._watch.state(BusState.PASSIVE, REFUSES)
            elif not self._bus.refusing:
                self._watch.state(BusState.ACTIVE, "")
            return
        now_s = time.monotonic()
        if now_s - self._state_s < STATE_S:
            return
        self._state_s = now_s
        with contextlib.suppress(Exception):  # some of the drivers that do not know it raise
            if self._bus.state.name == "ERROR":
                self._watch.state(BusState.OFF, "its driver reports so")


SEND_S = 0.25  # timeout of one attempt to send; some drivers ignore it, so `look` checks the time
PATIENCE_S = 0.8  # a frame that has not left by then means a lost bus
FRESH_S = 0.15  # drop frames that waited longer: the drives may have stopped by themselves
MOST_AWAKE_S = 0.4  # a longer gap between two checks is a suspension, and counts only this much
AGAIN_S = 0.005  # pause before the next attempt, when the adapter has no room
MOST_FRAMES = 256  # a longer queue means that the bus has stopped
_FULL = frozenset({errno.ENOBUFS, errno.EAGAIN, errno.ETIMEDOUT})


class CanWriter:
    """Sends frames from its own thread, so that a stuck adapter blocks no other thread.

    Frames leave in order. A frame that cannot leave in time ends the link, and the frames after it
    are dropped. So are frames that waited while this program was suspended: no frame is sent late.
    """

    def __init__(self, bus: can.BusABC, watch: Watch, clock: Callable[[], float]) -> None:
        self._bus = bus
        self._watch = watch
        self._clock = clock
        self._frames: deque[tuple[Frame, float]] = deque()  # each with the time of `put`
        self._work = threading.Condition()
        self._sending = False
        self._looked_s = clock()
        self._stuck_s = 0.0
        """How long the current frame has been in sending, not counting suspensions."""
        self._thread = threading.Thread(target=self._run, name="armdrive-can-out", daemon=True)
        self._thread.start()

    def put(self, frames: Iterable[Frame]) -> None:
        """Queue frames for sending; on a lost bus they are dropped."""
        now_s = self._clock()
        with self._work:
            self._frames.extend((frame, now_s) for frame in frames)
            if len(self._frames) > MOST_FRAMES:
                self._watch.lose(not_heard(f"{len(self._frames)} frames wait to be sent"))
            self._work.notify_all()

    def look(self) -> None:
        """Check the frame that is being sent, because its driver may hang."""
        with self._work:
            now_s = self._clock()
            if self._sending:
                # a long gap is a suspension of this program, which says nothing about the adapter
                self._stuck_s += min(now_s - self._looked_s, MOST_AWAKE_S)
            self._looked_s = now_s
            stuck = self._stuck_s > PATIENCE_S
        if stuck:
            self._watch.lose(not_heard(f"the adapter took no frame for {PATIENCE_S} s"))

    def drain(self, patience_s: float) -> None:
        """Wait until all frames have left, or the timeout."""

        def is_done() -> bool:
            return self._watch.ended.is_set() or not (self._frames or self._sending)

        with self._work:
            self._work.wait_for(is_done, patience_s)

    def join(self, patience_s: float) -> None:
        """Drop the waiting frames, and wait for the thread to end."""
        with self._work:
            self._frames.clear()
            self._work.notify_all()
        self._thread.join(patience_s)

    def _run(self) -> None:
        while True:
            with self._work:
                self._work.wait_for(lambda: self._frames or self._watch.ended.is_set())
                if self._watch.ended.is_set():
                    self._frames.clear()
                    return
                frame, written_s = self._frames.popleft()
                self._sending = True
            self._send(frame, written_s)
            with self._work:
                self._sending, self._stuck_s = False, 0.0
                self._work.notify_all()

    def _send(self, frame: Frame, written_s: float) -> None:
        """Send a frame, unless it waited too long in the queue or during a suspension."""
        message = message_of(frame)
        oldest_s = FRESH_S
        while not self._watch.ended.is_set() and self._clock() - written_s <= oldest_s:
            try:
                self._bus.send(message, timeout=SEND_S)
            except Exception as error:  # each backend raises its own types
                if not _is_full(error):
                    self._watch.lose(gone_words(error) or f"it cannot be written to ({error})")
                    return
                # `look` ends the link before that, unless this program was suspended meanwhile
                oldest_s = PATIENCE_S + FRESH_S
                self._watch.ended.wait(AGAIN_S)
            else:
                self._watch.count(sent=1)
                return
        self._watch.count(forgotten=1)


def _is_full(error: Exception) -> bool:
    """Return whether a frame could not be sent for lack of room, so that a retry may succeed."""
    full = isinstance(error, TimeoutError) or number_of(error) in _FULL
    return full or any(word in str(error).lower() for word in ("buffer full", "queue"))


# The link: it joins the two threads.

DRAIN_S = 0.3  # `close` waits this long for written frames to leave; one may be a stop
CLOSING_S = 0.5  # a driver or thread that has not ended by then is abandoned


class CanLink(Link):
    """A `Link` over a python-can bus, with one thread that receives and one that sends.

    The link owns the bus: no other code may send, receive or shut it down.
    """

    def __init__(self, bus: can.BusABC, name: str, ids: Iterable[int] = ()) -> None:
        """Take over a bus. Receive only frames with these `ids`, or all frames without any."""
        self._bus = bus
        self._name = name
        self._bell = Bell()
        self._watch = Watch(time.monotonic, self._bell.ring)
        self._unpacker = Unpacker()
        self._closed = False
        self._writer = CanWriter(bus, self._watch, time.monotonic)
        self._reader = CanReader(
            bus, frozenset(ids), self._watch, ring=self._bell.ring, also=self._writer.look
        )

    @property
    def description(self) -> str:
        """Name the adapter, and the bit rate if it is known."""
        return self._name

    @property
    def health(self) -> BusHealth:
        """The state of the bus and its counters so far."""
        return self._watch.health

    def write(self, data: bytes, now_s: float) -> None:  # noqa: ARG002 - real time is the bus's own
        """Queue packed frames for sending, without waiting. Raises `LinkLost` on a lost bus."""
        self._check()
        self._writer.put(self._unpacker.feed(data))

    def read(self, now_s: float) -> bytes:  # noqa: ARG002
        """Return the received frames, packed. Raises `LinkLost` on a lost bus with none left."""
        frames = self._reader.take()
        if not frames:
            self._check()
        return b"".join(map(pack, frames))

    def wait(self, timeout_s: float) -> None:
        """Sleep until a frame arrives, the bus is lost, `wake` is called, or the timeout."""
        self._bell.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` early."""
        self._bell.ring()

    def close(self) -> None:
        """Take the adapter off the bus, after giving written frames `DRAIN_S` to leave."""
        if self._closed:
            return
        self._closed = True
        self._writer.drain(DRAIN_S)
        self._watch.ended.set()
        self._writer.join(CLOSING_S)
        self._reader.join(CLOSING_S)
        if sys.is_finalizing():
            return  # a thread that is started now never runs, and would be waited for without end
        closing = threading.Thread(target=self._shut_down, name="armdrive-can-end", daemon=True)
        closing.start()
        closing.join(CLOSING_S)
        self._bell.close()

    def _shut_down(self) -> None:
        with contextlib.suppress(Exception):  # drivers fail in many ways if the adapter is gone
            self._bus.shutdown()

    def _check(self) -> None:
        if self._closed:
            raise closed_link(f"the connection on {self._name}")
        if self._watch.lost:
            raise lost_link(f"the CAN bus on {self._name}", self._watch.lost, "wait for its end")
