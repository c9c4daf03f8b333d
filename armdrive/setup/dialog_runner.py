"""Carries out work on a link, and talks about it: what is done on the wire, what a person is asked.

Drives are moved by nothing but their controller, and stopped by it too.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Protocol, TypeVar

from armdrive.dialects.bus.tools import CarryOut, Executor, OnWire
from armdrive.dialects.exchange import ScriptLoop
from armdrive.dialog.conversation import Announce, AskPerson, Keep, NotePosture, Talk
from armdrive.errors import LinkError
from armdrive.runtime.clock import SignalsBetweenSteps
from armdrive.tasks import Alert, Progress, ProtocolWarning, RequestRejected
from armdrive.transports.link import Link

T = TypeVar("T")

STOP_S = 3.0
"""What is at work is given so long to end once a stop was asked for."""
SILENCE_S = 1.2
"""Whoever falls silent on purpose is silent for so long: longer than what it began goes on."""


class Clock(Protocol):
    """Time that passes while somebody listens."""

    def now_s(self) -> float:
        """Return the time."""

    def sleep(self, link: Link, until_s: float) -> None:
        """Let time pass until something may have arrived, or until a moment."""


class RealClock:
    """The computer's own."""

    def now_s(self) -> float:
        """Return the monotonic time."""
        return time.monotonic()

    def sleep(self, link: Link, until_s: float) -> None:
        """Sleep on the link."""
        link.wait(max(until_s - self.now_s(), 0.0))


class DialogClock:
    """Time on a simulated bus: it passes when somebody waits."""

    def __init__(self) -> None:
        self._now_s = 0.0

    def now_s(self) -> float:
        """Return the time."""
        return self._now_s

    def sleep(self, link: Link, until_s: float) -> None:
        """Jump to when something may have come, or to a moment."""
        self._now_s = min(max(link.next_s(), self._now_s), until_s)


def carry_out(
    executor: Executor,
    request: Any,
    link: Link,
    clock: Clock,
    silent_after_s: float = math.inf,
) -> Any:
    """Have a request carried out over a link; return its reply.

    Whatever ends it early stops what it has set in motion. With `silent_after_s` nothing is said or
    heard from then on for `SILENCE_S`; then it is stopped. Raises `LinkLost`.
    """
    began_s = clock.now_s()
    executor.begin(request, began_s)
    try:
        reply = _led(executor, link, clock, began_s + silent_after_s)
        if executor.busy:
            until_s = clock.now_s() + SILENCE_S
            while clock.now_s() < until_s:
                clock.sleep(link, until_s)
                link.read(clock.now_s())
            reply = _stopped(executor, link, clock, hard=False)
    except LinkError:
        raise
    except BaseException:
        with contextlib.suppress(LinkError):
            _stopped(executor, link, clock, hard=True)
        raise
    return reply


def _stopped(executor: Executor, link: Link, clock: Clock, *, hard: bool) -> Any:
    if isinstance(executor, ScriptLoop):
        executor.forget()
        link.write(executor.advance(clock.now_s()), clock.now_s())
        return None
    executor.stop(hard=hard)
    reply = _led(executor, link, clock, clock.now_s() + STOP_S)
    if executor.busy:
        executor.forget()
    return reply


def _led(executor: Executor, link: Link, clock: Clock, until_s: float) -> Any:
    """Let an executor work until it has answered, or until a time; return its answer.

    An alert meanwhile is the answer: nothing else that was told is to be trusted then.
    """
    reply, alert = None, None
    while True:
        now_s = clock.now_s()
        with SignalsBetweenSteps():  # a script that Ctrl-C tears apart could stop nothing
            executor.receive(link.read(now_s), now_s)
            if said := executor.advance(now_s):
                link.write(said, now_s)
        while (event := executor.next_event()) is not None:
            if isinstance(event, Alert):
                alert = RequestRejected(event.text)
            elif not isinstance(event, Progress | ProtocolWarning):
                reply = event
        if not executor.busy or now_s >= until_s:
            return alert or reply
        clock.sleep(link, max(min(executor.next_s(), until_s), now_s))


class DialogPerson(Protocol):
    """Who is told, is asked, and looks at the arm."""

    def tell(self, text: str) -> None:
        """Hear a line."""

    def answer(self, asked: AskPerson) -> Any:
        """Answer a question, by its reader's value."""

    def watch(self, motor: int) -> None:
        """Look how the arm stands, before a motor turns."""


class DialogRunner:
    """One link, the scripts of the protocol spoken on it, one clock, one person."""

    def __init__(
        self,
        link: Link,
        scripts: ScriptLoop[Any],
        clock: Clock,
        person: DialogPerson,
        keep: Callable[[Mapping[str, Any]], None],
    ) -> None:
        self._link = link
        self._scripts = scripts
        self._clock = clock
        self._person = person
        self._keep = keep

    def run(self, talk: Talk[T]) -> T:
        """Carry out a talk to its end."""
        result: Any = None
        try:
            while True:
                result = self._do(talk.send(result))
        except StopIteration as end:
            found: T = end.value
            return found

    def _do(self, act: object) -> Any:
        match act:
            case Announce(text):
                self._person.tell(text)
            case AskPerson():
                return self._person.answer(act)
            case NotePosture(motor):
                self._person.watch(motor)
            case Keep(notes):
                self._keep(notes)
            case OnWire(script):
                return self._carry_out(self._scripts, partial(script, self._scripts.io))
            case CarryOut(executor, request, silent_after_s):
                return self._carry_out(executor, request, silent_after_s)
        return None

    def _carry_out(self, executor: Executor, request: Any, silent_after_s: float = math.inf) -> Any:
        now_s = self._clock.now_s()
        executor.receive(self._link.read(now_s), now_s)  # what came before answers nothing of this
        return carry_out(executor, request, self._link, self._clock, silent_after_s)
