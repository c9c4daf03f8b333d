"""The engine: one exchange on the wire at a time, one task at a time, no clock of its own.

`advance(now_s)` does all that is due by now and returns when it wants to be called next. Faults of
the wire are thrown into the task (tasks.py) where it waits, so that it can say what they mean for
the arm. Whoever calls `advance` is the only one that touches the wire.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import fields, replace
from typing import Any, Protocol, TypeVar

from armdrive.dialects.controller import Controller
from armdrive.errors import ArmError, LinkLost, NoAnswer, Refused, WrongState
from armdrive.tasks import (
    Alert,
    Event,
    Exchange,
    Progress,
    ProtocolWarning,
    Reply,
    Request,
    SleepUntil,
    Task,
    TaskBody,
    Timeout,
)
from armdrive.trace.calls import NO_TRACER, Tracer
from armdrive.transports.link import Link

# How long a call may take that moves nothing: one rule for connecting, resets, looks and the rest.
# The engine keeps it, whatever comes over the wire, so that no controller has to.

CALL_LIMIT_S = 20.0
"""Connecting, a reset, a look and whatever else moves nothing ends within this.

Twice the slowest first contact: a GRBL board may take 4 s to start, and is then reset three times,
2 s each. So one attempt may be lost to noise.
"""

DEVICE_WAITS = ("answer_margin_s", "answer_s", "boot_s", "mute_s")
"""The settings of a dialect that say how long its device is waited for."""


def call_limit_s(device: object) -> float:
    """Return the limit for an arm, by the section of its file that is named after its dialect.

    Who has a slow device waited for three times as long as usual gets three times the limit: a
    deadline that no device of theirs could keep would leave the arm without any use.
    """
    longer = 1.0
    for each in fields(device) if hasattr(device, "__dataclass_fields__") else ():  # type: ignore[arg-type]
        if each.name in DEVICE_WAITS and isinstance(each.default, float) and each.default > 0.0:
            longer = max(longer, getattr(device, each.name) / each.default)
    return CALL_LIMIT_S * longer


# What came in over a wire while an answer was waited for, in words for an error.

MOST_BYTES = 512
"""So much is remembered: more than any excerpt shows."""
MOST_SHOWN = 48
"""Bytes of an excerpt."""
MOST_IDS = 6
"""Ids of frames that are named."""
NOT_THE_ANSWER = "but not the answer"
"""Stands before what was received, in an error's words."""
ANOTHER = "and that port, baud rate and dialect are right"


class ReceivedFrame(Protocol):
    """A frame, of which the id is told."""

    @property
    def can_id(self) -> int:
        """The id that it was sent with."""


class FrameReader(Protocol):
    """Reads frames out of what comes in, whatever the chunks."""

    def feed(self, data: bytes) -> Iterable[ReceivedFrame]:
        """Take bytes; return the frames that they complete."""


class Received:
    """What has come since a call began: bytes, or the frames that `frames` reads out of them."""

    def __init__(self, frames: Callable[[], FrameReader] | None = None) -> None:
        self._frames = frames
        self.clear()

    def clear(self) -> None:
        """Forget what came: another call begins."""
        self.count = 0
        self._first = bytearray()
        self._reader = None if self._frames is None else self._frames()
        self._ids: dict[int, None] = {}

    def add(self, data: bytes) -> None:
        """Take note of what came."""
        if self._reader is not None:
            for frame in self._reader.feed(data):
                self.count += 1
                if len(self._ids) <= MOST_IDS:
                    self._ids[frame.can_id] = None
            return
        self.count += len(data)
        self._first += data[: MOST_BYTES - len(self._first)]

    def look_at(self, silent: str) -> str:
        """Return what a person does about it: `silent`, and more where bytes came."""
        return silent if self._frames or not self.count else f"{silent}, {ANOTHER}"

    def __str__(self) -> str:
        if not self.count:
            return "nothing was received"
        if self._frames:
            named = [f"{each:X}" for each in list(self._ids)[:MOST_IDS]]
            more = ", ..." if len(self._ids) > MOST_IDS else ""
            return f"{_many(self.count, 'frame')}, {NOT_THE_ANSWER}: ids {', '.join(named)}{more}"
        return f"{_many(self.count, 'byte')}, {NOT_THE_ANSWER}: {excerpt(bytes(self._first))}"


def _many(count: int, noun: str) -> str:
    return f"1 {noun} was received" if count == 1 else f"{count} {noun}s were received"


def excerpt(heard: bytes, most: int = MOST_SHOWN) -> str:
    """Return bytes for people, with nothing that a terminal obeys; the end of them cut off."""
    text = heard[:most].decode("latin-1").encode("unicode_escape").decode("ascii")
    return f"'{text}'{' ...' if len(heard) > most else ''}"


# The engine itself.

T = TypeVar("T")

MOST_TURNS = 10_000
"""A task that takes more steps without waiting for anything is broken, and is ended."""

LAST_WORDS = 16
"""A task whose time is over may wait so often for something else: nothing is given to it."""


def _never() -> float:
    return 0.0


class Engine:
    """Carries bytes between one link and one controller, and runs tasks over them."""

    def __init__(
        self,
        link: Link,
        controller: Controller,
        *,
        idle: Callable[[float], tuple[float, TaskBody[Any] | None]],
        stopping: Callable[[], None],
        lost: Callable[[LinkLost], None],
        noticed: Callable[[Alert | Progress], None],
        tracer: Tracer = NO_TRACER,
        received: Received | None = None,
        call_limit_s: float = CALL_LIMIT_S,
    ) -> None:
        """Take a link and a controller, and four calls.

        `idle(now)` gives work for quiet times and when to ask again; `stopping` hears that a
        stop was asked for, `lost` that the wire broke, `noticed` what the device says unasked.
        `call_limit_s` is how long a routine look may take; `received` keeps what came meanwhile.
        """
        self.link = link
        self.controller = controller
        self.tracer = tracer
        self.now_s = 0.0
        self.due_s = -math.inf
        """When it has something to do, whatever the wire brings; before now: that is unknown."""
        self.asleep_s: Callable[[], float] = _never
        self.round_s: Callable[[], float] = _never
        self._absences = 0
        self.stop_asked = False
        self.stop_hard = False
        self.stop_why = ""
        self.last_answer = ""
        self.requests_sent = 0
        self.bytes_sent = 0
        self.bytes_heard = 0
        self.heard_s = -math.inf
        self._idle = idle
        self._stopping = stopping
        self._lost = lost
        self._noticed = noticed
        self._task: Task[Any] | None = None
        self._next: Task[Any] | None = None
        self._wait: Exchange | SleepUntil | None = None
        self._asked = False
        self._broken: LinkLost | None = None
        self._proved = True
        self.received = received or Received()
        self.call_limit_s = call_limit_s
        self.reconnect: Callable[[float], float] | None = None
        """What is called while the wire is broken, and may `take` another; says when next."""

    @property
    def last_sent(self) -> str:
        """The text of what was sent last."""
        return self.controller.last_said

    @property
    def busy(self) -> bool:
        """Tell whether a task is at work."""
        return self._task is not None or self._next is not None

    @property
    def absences(self) -> int:
        """How often this program stood still, this very moment's suspension included.

        Whoever compares two of these holds the lock that `advance` is called with.
        """
        return self._absences + (self.asleep_s() > 0.0)

    @property
    def at_rest(self) -> bool:
        """Tell whether nothing is at work and no stop is left that nobody has seen."""
        return self._broken is not None or not (self.busy or self.stop_asked)

    @property
    def broken(self) -> LinkLost | None:
        """The loss of the wire, once it has happened."""
        return self._broken

    def start(
        self, body: TaskBody[T], *, alone: bool = False, within_s: float = math.inf
    ) -> Task[T]:
        """Hand over a task; it begins at an `advance`, when what is at work has ended.

        It ends with `NoAnswer` where it takes longer than `within_s`. The time counts from now
        on, but not while the motion of another call is at work.
        Raises `WrongState` while another one waits, or with `alone` while anything but routine
        is at work: nothing may begin to move when its caller no longer expects it to. A stop
        that nobody has seen yet holds for this task as well.
        """
        busy = self._task is not None and not self._task.routine and alone
        if self._next is not None or busy:
            body.close()
            raise WrongState("something else is still at work: wait for its end, or stop the arm")
        task = Task(body, within_s=within_s)
        if self._broken is not None:
            task.fail(self._broken)
        else:
            self._next = task
        return task

    @contextmanager
    def limited(self) -> Iterator[None]:
        """Have what the task at work does herein end within `call_limit_s`, as if it were a call.

        For the looks that are part of a motion, whose own time nobody knows beforehand.
        """
        task = self._task
        if task is None or not math.isinf(task.within_s):
            yield
            return
        task.since_s, task.within_s = self.now_s, self.call_limit_s
        self.received.clear()
        try:
            yield
        finally:
            task.within_s = math.inf

    def absent(self, time_s: float) -> None:
        """Hear that this program stood still for so long: nobody knows what happened meanwhile.

        A motion that goes on after that is one that nobody expects, so it is stopped.
        """
        self._absences += 1
        for task in (self._task, self._next):  # the device could not answer in that time
            if task is not None:
                task.since_s += time_s
        if self._next is not None or (self._task is not None and not self._task.routine):
            self.stop_asked = True
            self.stop_why = f": this program had stood still for {time_s:.1f} s"

    def close(self) -> None:
        """Give up the wire for good: whatever is at work or comes later fails with `LinkLost`."""
        if self._broken is None:
            with suppress(LinkLost):
                if said := self.controller.farewell():
                    self.tracer.sent(said)
                    self.link.write(said, self.now_s)
            self._end(LinkLost("the connection was closed: connect again"))

    def take(self, link: Link, controller: Controller) -> None:
        """Go on over another wire in place of the broken one. Nothing is left of what was asked."""
        self.link, self.controller = link, controller
        self._broken, self._proved = None, False
        self.stop_asked, self.stop_hard, self.stop_why = False, False, ""

    def prove(self) -> None:
        """Hear that the arm is behind the wire that was taken."""
        self._proved = True

    def advance(self, now_s: float) -> float:
        """Do what is due by now; return when to call again, on the same clock."""
        self.now_s = now_s
        self.due_s = -math.inf
        if self._broken is not None:
            next_s = math.inf if self.reconnect is None else self.reconnect(now_s)
            if self._broken is not None:
                return next_s
        self.tracer.tick(now_s, self.stop_asked, self.stop_hard)
        if self.stop_asked:
            self._stopping()
            self.controller.stop(hard=self.stop_hard)
        try:
            self._listen()
            self._run()
        except LinkLost as lost:
            self._break(lost)
            return math.inf if self.reconnect is None else self.reconnect(now_s)
        except Exception as error:  # a flaw of ours
            self.tracer.failed(error)
            raise
        return self._next_s()

    def _listen(self) -> None:
        data = self.link.read(self.now_s)
        if data:
            self.heard_s = self.now_s
            self.bytes_heard += len(data)
            self.received.add(data)
            self.tracer.heard(data)
            self.controller.receive(data, self.now_s)
        self._talk()

    def _talk(self) -> None:
        """Write what the controller has to say by now, and take in what it has heard.

        What was thought out before this program was suspended is not said after it: it is stopped.
        To the controller, what is left unsaid then is a message that was lost on the wire.
        """
        woken = self._woken()
        said = self.controller.advance(self.now_s)
        if said and (woken or not self._woken()) and not self._stale():
            self.tracer.sent(said)
            self.link.write(said, self.now_s)
            self.bytes_sent += len(said)
        while (event := self.controller.next_event()) is not None:
            self._hear(event)

    def _stale(self) -> bool:
        """Tell whether an order comes too late to be said; a stop never does."""
        return not self.stop_asked and self.round_s() > self.controller.abilities.order_s

    def _woken(self) -> bool:
        """Tell whether this round was suspended; what was at work hears of a stop then."""
        asleep_s = self.asleep_s()
        if asleep_s <= 0.0:
            return False
        self.absent(asleep_s)
        if self.stop_asked:
            self.controller.stop(hard=self.stop_hard)
        return self.stop_asked

    def _hear(self, event: Event) -> None:
        self.tracer.told(event)
        if isinstance(event, ProtocolWarning):
            self.last_answer = event.text
        elif isinstance(event, Alert | Progress):
            self.last_answer = event.text if isinstance(event, Alert) else str(event.registers)
            self._noticed(event)
        elif not self._asked:
            self.last_answer = f"unexpected: {event}"
        else:
            self._asked = False
            if isinstance(event, Timeout):
                self._resume(self._no_answer(event))
            else:
                self.last_answer = str(event)
                self._resume(event)

    def _no_answer(self, silence: Timeout) -> NoAnswer:
        """Return the error of a silence: of a call with a deadline, with all the time it took."""
        task = self._task
        if task is None or math.isinf(task.within_s):
            return NoAnswer(
                f"{silence} on {self.link.description}. {silence.look_at}, then call `reset()`"
            )
        silence = replace(silence, waited_s=self.now_s - task.since_s)
        return NoAnswer(
            f"{silence} on {self.link.description}: {self.received}. "
            f"{self.received.look_at(silence.look_at)}, then call `reset()`"
        )

    def _count_time(self) -> None:
        """Have the time of tasks count, unless a motion that somebody asked for is at work."""
        if (task := self._task) is not None and math.isnan(task.since_s):
            task.since_s = self.now_s
        waiting = self._task is not None and not self._task.routine
        if self._next is not None and math.isnan(self._next.since_s) and not waiting:
            self._next.since_s = self.now_s

    def _end_late(self) -> None:
        """End the task at work where its time is over: one rule for every dialect and wire.

        A device that never stops talking, or that answers a part of everything, keeps a
        controller's own deadlines from passing.
        """
        task = self._task
        if task is None or self.now_s < task.until_s:
            return
        silence = Timeout(self.controller.last_said, 0.0, self.controller.look_at)
        error = self._no_answer(silence)
        if self._asked:
            self._asked = False
            self.controller.forget()
        for _ in range(LAST_WORDS):
            self._resume(error)
            if self._task is not task or self.now_s < task.until_s:
                return
        task.give_up(error)
        self._finish(task)

    def _run(self) -> None:
        """Let tasks take steps until the present one waits for something that is not there yet."""
        turns = 0
        self._count_time()
        self._end_late()
        while not self._asked:
            if self._task is None and not self._begin():
                return
            turns += 1
            if turns > MOST_TURNS:
                self._resume(ArmError("a task went round without waiting, and was ended"))
                return
            if isinstance(self._wait, SleepUntil):
                if self._wait.time_s > self.now_s and not self.stop_asked:
                    return
                self._resume(self.now_s)
            elif isinstance(self._wait, Exchange):
                self._send(self._wait.request)

    def _begin(self) -> bool:
        task, self._next = self._next, None
        if task is None:
            _, body = self._idle(self.now_s)
            if body is None:
                self.stop_asked = self.stop_hard = False  # nothing is left to stop
                return False
            task = Task(body, routine=True, within_s=self.call_limit_s)
        self._task, self._wait = task, SleepUntil(-math.inf)
        self.received.clear()
        self._count_time()
        return True

    def _send(self, request: Request) -> None:
        try:
            self.controller.begin(request, self.now_s)
        except (ValueError, Refused) as error:  # what the dialect cannot express
            self._resume(error if isinstance(error, Refused) else Refused(f"not sent: {error}"))
            return
        self.tracer.asked(request)
        self._asked = True
        self.requests_sent += 1
        if self.stop_asked:
            self.controller.stop(hard=self.stop_hard)
        self._talk()

    def _resume(self, outcome: Reply | float | ArmError) -> None:
        task = self._task
        if task is None:
            return
        self._wait = None
        try:
            self._wait = task.step(outcome)
        finally:  # also of Ctrl-C in simulated time: the task is dead
            if task.over:
                self._finish(task)

    def _finish(self, task: Task[Any]) -> None:
        self.tracer.ended(task.error)
        self._task, self._wait = None, None
        if self._next is None:
            self.stop_asked, self.stop_hard, self.stop_why = False, False, ""
        task.done = True

    def _break(self, lost: LinkLost) -> None:
        self._end(lost)
        self._lost(lost)
        if self._proved:  # else it is a wire that was only tried
            self.tracer.lost(lost)

    def _end(self, lost: LinkLost) -> None:
        """Let everything at work hear of the loss where it waits, and end it."""
        self._broken = lost
        self._asked = False
        self.stop_asked = False  # what could still be stopped has ended with the wire
        if (task := self._task) is not None:
            task.abandon(lost)
            self._finish(task)
        if self._next is not None:
            self._next.fail(lost)
            self._next = None

    def _next_s(self) -> float:
        self.due_s = self._due_s()
        return min(self.due_s, self.link.next_s())

    def _due_s(self) -> float:
        """Return when there is something to do, whatever the wire brings."""
        due_s = self.controller.next_s()
        if self._task is not None:
            due_s = min(due_s, self._task.until_s)
        if self._asked:
            return due_s
        if isinstance(self._wait, SleepUntil):
            return min(self._wait.time_s, due_s)
        wake_s, _ = self._idle(self.now_s)
        return min(wake_s, due_s)
