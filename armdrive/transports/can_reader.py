"""The one thread that hears a CAN bus: it survives whatever bus and driver complain of.

python-can's Notifier ends at the first error (hardbyte/python-can issues 907, 1667, 1828).
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from armdrive.transports.can_health import BusState, of_error_frame, of_status
from armdrive.transports.can_refusals import gone_words
from armdrive.transports.can_watch import Tells
from firmware_protocol.frames import Frame

if TYPE_CHECKING:
    import can

    from armdrive.transports.can_watch import Watch

RECV_S = 0.05
"""So long one look at the bus takes at most; what lasts is judged as often."""
STATE_S = 0.2
"""The state is asked of the driver this often."""
PAUSE_S = 0.01
"""After an error, so that a driver that fails at once does not keep a core busy."""
MOST_FRAMES = 4096
_MOST_BYTES = 8


class Reader:
    """Hears a bus from its own thread into a queue that drops the oldest frames when it is full."""

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
            while len(taken) < MOST_FRAMES:
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
        frame = _frame(message)
        if frame is None or not message.is_rx:
            return
        self._watch.heard(1)
        if not self._ids or frame.can_id in self._ids:
            if len(self._frames) >= MOST_FRAMES:
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


def _frame(message: can.Message) -> Frame | None:
    """Return the frame of a message; None of CAN FD, which no arm here speaks."""
    if message.is_fd or len(message.data) > _MOST_BYTES:
        return None
    data = b"" if message.is_remote_frame else bytes(message.data)
    return Frame(
        message.arbitration_id,
        data,
        extended=message.is_extended_id,
        remote=message.is_remote_frame,
    )
