"""The two threads of a CAN link, one that reads and one that writes, and the judge of its bus.

The policy: bus-off is a loss at once. Error-passive, refused frames and a reader that gets only
errors are a loss if they last. A received frame clears all three.
"""

from __future__ import annotations

import contextlib
import errno
import math
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
    of_status,
)
from armdrive.transports.open_errors import gone_words, number_of
from firmware_protocol.frames import DATA_MAX, Frame

if TYPE_CHECKING:
    import can


WATCH_PATIENCE_S = 0.85
"""What lasts this long without a frame being heard is a loss; a standing arm answers oftener."""


@runtime_checkable
class Tells(Protocol):
    """A bus whose adapter says of itself what python-can does not ask it (slcan)."""

    refused: int
    """How many frames the adapter has said it did not send."""
    refusing: bool
    """Whether that is what it said of the last one."""

    def ask(self) -> None:
        """Ask for its status. Called by the writer."""

    def take_status(self) -> int | None:
        """Take the answer, once there is one. Called by the reader."""


def frame_of(message: can.Message) -> Frame | None:
    """Return the frame of a message; None of CAN FD, which no arm here speaks."""
    if message.is_fd or len(message.data) > DATA_MAX:
        return None
    data = b"" if message.is_remote_frame else bytes(message.data)
    return Frame(message.arbitration_id, data, message.is_extended_id, message.is_remote_frame)


def message_of(frame: Frame) -> can.Message:
    """Return a frame as python-can has it."""
    import can

    return can.Message(
        arbitration_id=frame.can_id,
        data=frame.data,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
    )


class Watch:
    """The one judge of a bus. Called from the reader, the writer and the engine's thread."""

    def __init__(self, clock: Callable[[], float], ring: Callable[[], None]) -> None:
        """`ring` wakes whoever sleeps on the link."""
        self.ended = threading.Event()
        self._clock = clock
        self._ring = ring
        self._lock = threading.Lock()
        self._health = BusHealth()
        self._lost = ""
        self._since: dict[str, tuple[float, str]] = {}

    @property
    def health(self) -> BusHealth:
        """What is known of the bus."""
        return self._health

    @property
    def lost(self) -> str:
        """Why the bus is lost; empty while it is not."""
        return self._lost

    def count(self, **more: int) -> None:
        """Add to counters."""
        with self._lock:
            sums = {name: getattr(self._health, name) + each for name, each in more.items()}
            self._health = replace(self._health, **sums)

    def heard(self, frames: int) -> None:
        """Hear that frames came: somebody else is on the bus, and understood."""
        self.count(heard=frames)
        self._since.clear()

    def state(self, state: BusState, why: str) -> None:
        """Hear what state the adapter's controller is in."""
        with self._lock:
            trouble = why or self._health.last_trouble
            self._health = replace(self._health, state=state, last_trouble=trouble)
        if state is BusState.OFF:
            self.lose(left_bus(why))
        elif state is BusState.PASSIVE:
            self.lasting("passive", not_heard(why))
        else:
            self.settled("passive")

    def lasting(self, kind: str, why: str) -> None:
        """Hear of something that is a loss when it lasts."""
        since_s, _ = self._since.get(kind, (self._clock(), ""))
        self._since[kind] = since_s, why
        with self._lock:
            self._health = replace(self._health, last_trouble=why)

    def settled(self, kind: str) -> None:
        """Hear that it is over."""
        self._since.pop(kind, None)

    def look(self) -> None:
        """Judge what was heard of and is not over yet."""
        for since_s, why in list(self._since.values()):
            if self._clock() - since_s >= WATCH_PATIENCE_S:
                self.lose(why)

    def lose(self, why: str) -> None:
        """End the link; the first reason is the one that is told."""
        with self._lock:
            self._lost = self._lost or why
        self.ended.set()
        self._ring()


RECV_S = 0.05
"""So long one look at the bus takes at most; what lasts is judged as often."""
STATE_S = 0.2
"""The state is asked of the driver this often."""
PAUSE_S = 0.01
"""After an error, so that a driver that fails at once does not keep a core busy."""
MOST_UNREAD_FRAMES = 4096


class CanReader:
    """Hears a bus from its own thread into a queue that drops the oldest frames when it is full.

    python-can's Notifier would not do: it ends at the first error (hardbyte/python-can issues
    907, 1667 and 1828). This thread survives whatever the bus and its driver complain of.
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
        """Begin to listen to the `ids`, or to all; `ring` for a frame, `also` at every look."""
        self._bus = bus
        self._tells = bus if isinstance(bus, Tells) else None
        self._ids = ids
        self._watch = watch
        self._ring = ring
        self._also = also
        self._frames: deque[Frame] = deque()
        self._state_s = 0.0
        self._thread = threading.Thread(target=self._run, name="armdrive-can-in", daemon=True)
        self._thread.start()

    def take(self) -> list[Frame]:
        """Take the frames that have come, in their order."""
        taken: list[Frame] = []
        with contextlib.suppress(IndexError):
            while len(taken) < MOST_UNREAD_FRAMES:
                taken.append(self._frames.popleft())
        return taken

    def join(self, patience_s: float) -> None:
        """Wait for the thread's end."""
        if self._thread is not threading.current_thread():
            self._thread.join(patience_s)

    def _run(self) -> None:
        while not self._watch.ended.is_set():
            try:
                message = self._bus.recv(RECV_S)
            except Exception as error:  # every backend has its own kinds
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
            state, why = of_error_frame(message.arbitration_id, bytes(message.data))
            if state is not None:
                self._watch.state(state, why)
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
        if self._watch.ended.is_set():
            return
        self._watch.count(read_errors=1)
        if gone := gone_words(error):
            self._watch.lose(gone)
        self._watch.lasting("reading", f"it cannot be read ({error.__cause__ or error})")
        self._watch.ended.wait(PAUSE_S)

    def _ask(self) -> None:
        """Look at the state of the controller, as far as its driver knows it."""
        now_s = time.monotonic()
        if now_s - self._state_s < STATE_S:
            return
        self._state_s = now_s
        if self._tells is not None:
            status = self._tells.take_status()
            if status is not None:
                self._watch.state(*of_status(status))
            return
        with contextlib.suppress(Exception):  # most drivers do not know, and some say so by raising
            if self._bus.state.name == "ERROR":
                self._watch.state(BusState.OFF, "its driver says so")


SEND_S = 0.25
"""What a driver may take for one frame; not every one keeps to it, so that it is watched."""
PATIENCE_S = 0.8
"""A frame that has not left by then never will."""
FRESH_S = 0.15
"""A frame that waited longer is not said any more: the drives may have stopped by themselves."""
MOST_AWAKE_S = 0.4
"""What takes longer from one look to the next was a suspension of this program, and counts so."""
AGAIN_S = 0.005
LOOK_S = 0.1
ASK_AGAIN_S = 1.0
"""An adapter that knows no status may refuse the question too: it is not asked in a circle."""
MOST_FRAMES = 256
"""More wait for a bus only where it has stopped."""
REFUSES = "the adapter refuses frames: nobody acknowledges them, or it has restarted"
_FULL = frozenset({errno.ENOBUFS, errno.EAGAIN, errno.ETIMEDOUT})


class CanWriter:
    """Sends frames from its own thread, so that a stuck adapter holds up nobody else.

    Frames leave one after the other. A frame that cannot leave in time ends the link, and the
    frames after it are forgotten. So are frames that waited while this program was suspended:
    nothing is sent late.
    """

    def __init__(self, bus: can.BusABC, watch: Watch, clock: Callable[[], float]) -> None:
        self._bus = bus
        self._tells = bus if isinstance(bus, Tells) else None
        self._watch = watch
        self._clock = clock
        self._frames: deque[tuple[Frame, float]] = deque()  # each with when it was written
        self._work = threading.Condition()
        self._began_s: float | None = None
        self._looked_s = -math.inf
        self._stuck_s = 0.0
        """For how long a frame has been on its way while this program was awake to see it."""
        self._refused = 0
        self._asked_s = -math.inf
        self._thread = threading.Thread(target=self._run, name="armdrive-can-out", daemon=True)
        self._thread.start()

    def put(self, frames: Iterable[Frame]) -> None:
        """Have frames sent, or forgotten where the bus is lost."""
        now_s = self._clock()
        with self._work:
            self._frames.extend((frame, now_s) for frame in frames)
            if len(self._frames) > MOST_FRAMES:
                self._watch.lose(not_heard(f"{len(self._frames)} frames wait to be sent"))
            self._work.notify_all()

    def look(self) -> None:
        """Judge a frame that is being sent: its driver may never come back from it."""
        began_s, now_s = self._began_s, self._clock()
        since_s = math.inf if began_s is None else max(began_s, self._looked_s)
        if since_s == began_s:
            self._stuck_s = 0.0
        self._stuck_s += min(max(now_s - since_s, 0.0), MOST_AWAKE_S)
        self._looked_s = now_s
        if began_s is not None and self._stuck_s > PATIENCE_S:
            self._watch.lose(not_heard(f"the adapter took no frame for {PATIENCE_S} s"))

    @property
    def waiting(self) -> int:
        """How many frames have not left yet."""
        return len(self._frames) + (self._began_s is not None)

    def drain(self, patience_s: float) -> None:
        """Wait until all frames have left, or the time is over."""
        with self._work:
            self._work.wait_for(lambda: self._watch.ended.is_set() or not self.waiting, patience_s)

    def join(self, patience_s: float) -> None:
        """Wait for the thread's end."""
        with self._work:
            self._frames.clear()
            self._work.notify_all()
        self._thread.join(patience_s)

    def _run(self) -> None:
        while not self._watch.ended.is_set():
            with self._work:
                if not self._frames:
                    self._work.wait(LOOK_S)
                taken = self._frames.popleft() if self._frames else None
                self._began_s = None if taken is None else self._clock()
            if taken is not None:
                self._send(*taken)
                self._sent()
            self._mind_refusals()
        with self._work:
            self._frames.clear()

    def _sent(self) -> None:
        with self._work:
            self._began_s = None
            self._work.notify_all()

    def _send(self, frame: Frame, written_s: float) -> None:
        """Send a frame that is still worth saying: it may have waited, or lain in our hand."""
        message = message_of(frame)
        began_s = last_s = self._clock()
        if began_s - written_s > FRESH_S:
            self._watch.count(forgotten=1)
            return
        waited_s = 0.0
        while not self._watch.ended.is_set():
            try:
                self._bus.send(message, timeout=SEND_S)
            except Exception as error:  # every backend has its own kinds
                now_s = self._clock()
                waited_s += min(now_s - last_s, MOST_AWAKE_S)
                last_s = now_s
                self._failed(error, waited_s)
                if now_s - began_s > PATIENCE_S:  # this program was suspended meanwhile
                    self._watch.count(forgotten=1)
                    return
            else:
                self._watch.count(sent=1)
                return

    def _failed(self, error: Exception, waited_s: float) -> None:
        if not _is_full(error):
            self._watch.lose(gone_words(error) or f"it cannot be written to ({error})")
        elif waited_s > PATIENCE_S - SEND_S:
            self._watch.lose(not_heard(f"its transmit buffer stays full: {error}"))
        else:
            self._watch.ended.wait(AGAIN_S)

    def _mind_refusals(self) -> None:
        """Hear of frames that an slcan adapter says it did not send, and ask it why."""
        if self._tells is None:
            return
        more, self._refused = self._tells.refused - self._refused, self._tells.refused
        if more:
            self._watch.count(refused=more)
        if not self._tells.refusing:
            self._watch.settled("refused")
        elif more:
            self._watch.lasting("refused", not_heard(REFUSES))
        troubled = self._watch.health.state is not BusState.ACTIVE  # so it does know a status
        again_s = LOOK_S if troubled else ASK_AGAIN_S
        if (more or troubled) and self._clock() - self._asked_s > again_s:
            self._asked_s = self._clock()
            try:
                self._tells.ask()
            except Exception as error:
                self._watch.lose(f"it cannot be written to ({error})")


def _is_full(error: Exception) -> bool:
    """Tell whether a frame could not be sent now, and perhaps can be soon."""
    text = str(error).lower()
    return (
        isinstance(error, TimeoutError)
        or number_of(error) in _FULL
        or "buffer full" in text
        or "queue" in text
    )
