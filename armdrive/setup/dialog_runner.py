"""Carries out requests and scripts on a link, on the computer's time or a simulated one.

There are two executors: a controller, which moves a drive and takes requests such as `MoveBy`, and
a `ScriptLoop`, which reads and sets values and takes a generator. Neither has a clock or a wire.
`carry_out` gives one of them its request, and passes bytes and time on until it has a reply:

    executor.begin(request)  then again and again  receive(bytes), advance() -> bytes, next_event()

Only a drive's controller moves it, and the same controller stops it. A `DriveDialog` has a person,
scripts and `carry_out` together, for commissioning.
"""

from __future__ import annotations

import contextlib
import math
import time
from typing import Any, Protocol

from armdrive.dialects.bus.tools import DriveDialog, Executor
from armdrive.dialects.exchange import ScriptLoop
from armdrive.dialog import DialogPerson
from armdrive.errors import LinkError
from armdrive.runtime.clock import SignalsBetweenSteps
from armdrive.tasks import Alert, Progress, ProtocolWarning, RequestRejected
from armdrive.transports.link import Link

# A stopped request has this long to end.
STOP_S = 3.0


class Clock(Protocol):
    """The time that passes while a link is read."""

    def now_s(self) -> float:
        """Return the time."""

    def sleep(self, link: Link, until_s: float) -> None:
        """Let time pass until something may have arrived, or until a moment."""


class RealClock:
    """The computer's monotonic clock."""

    def now_s(self) -> float:
        """Return the monotonic time."""
        return time.monotonic()

    def sleep(self, link: Link, until_s: float) -> None:
        """Sleep on the link."""
        link.wait(max(until_s - self.now_s(), 0.0))


class DialogClock:
    """The time of a simulated bus, which passes only while the dialog waits."""

    def __init__(self) -> None:
        self._now_s = 0.0

    def now_s(self) -> float:
        """Return the time."""
        return self._now_s

    def sleep(self, link: Link, until_s: float) -> None:
        """Jump to the moment when something may have come, or to `until_s`."""
        self._now_s = min(max(link.next_s(), self._now_s), until_s)


def carry_out(executor: Executor, request: Any, link: Link, clock: Clock) -> Any:
    """Carry out a request over a link; return its reply. Raises `LinkLost`.

    An exception stops the motion that the request has begun.
    """
    executor.begin(request, clock.now_s())
    try:
        return _led(executor, link, clock, math.inf)
    except LinkError:
        raise
    except BaseException:
        with contextlib.suppress(LinkError):
            _stop(executor, link, clock)
        raise


def _stop(executor: Executor, link: Link, clock: Clock) -> None:
    if isinstance(executor, ScriptLoop):
        executor.abandon()  # it may send something while it closes
        link.write(executor.advance(clock.now_s()), clock.now_s())
        return
    executor.stop(hard=True)
    _led(executor, link, clock, clock.now_s() + STOP_S)
    if executor.busy:
        executor.abandon()


def _led(executor: Executor, link: Link, clock: Clock, until_s: float) -> Any:
    """Let an executor work until it has a reply, or until a time; return the reply.

    An alert takes the reply's place, since no reply can be trusted after it.
    """
    reply, alert = None, None
    # Ctrl-C inside a step would leave a motion running. Simulated drives can do no harm, and
    # changing the signal handlers would take longer than the step itself.
    step = contextlib.nullcontext if isinstance(clock, DialogClock) else SignalsBetweenSteps
    while True:
        now_s = clock.now_s()
        with step():
            executor.receive(link.read(now_s), now_s)
            if data := executor.advance(now_s):
                link.write(data, now_s)
        while (event := executor.next_event()) is not None:
            if isinstance(event, Alert):
                alert = RequestRejected(event.text)
            elif not isinstance(event, Progress | ProtocolWarning):
                reply = event
        if not executor.busy or now_s >= until_s:
            return alert or reply
        clock.sleep(link, max(min(executor.next_s(), until_s), now_s))


def drive_dialog(
    link: Link, scripts: ScriptLoop[Any], clock: Clock, person: DialogPerson
) -> DriveDialog:
    """Return a dialog during which scripts and controllers use a link."""

    def carry_out_next(executor: Executor, request: Any) -> Any:
        now_s = clock.now_s()
        executor.receive(link.read(now_s), now_s)  # older bytes answer no new request
        return carry_out(executor, request, link, clock)

    return DriveDialog(person, scripts, carry_out_next)
