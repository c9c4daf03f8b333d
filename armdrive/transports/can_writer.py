"""The one thread that speaks on a CAN bus, so that an adapter that is stuck holds up nobody else.

Frames leave one after the other. One that cannot leave in time ends the link, and those behind it
are forgotten, as are those that waited while this program was suspended: nothing is said late.
"""

from __future__ import annotations

import errno
import math
import threading
from collections import deque
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from armdrive.transports.can_health import BusState, not_heard
from armdrive.transports.can_refusals import gone_words, number_of
from armdrive.transports.can_watch import Tells

if TYPE_CHECKING:
    import can

    from armdrive.transports.can_watch import Watch
    from firmware_protocol.frames import Frame

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


class Writer:
    """Sends frames from its own thread."""

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
        message = _message(frame)
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


def _message(frame: Frame) -> can.Message:
    import can

    return can.Message(
        arbitration_id=frame.can_id,
        data=frame.data,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
    )
