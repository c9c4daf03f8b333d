"""The engine: runs one task at a time and one exchange on the wire at a time, without a clock.

`advance(now_s)` does all that is due and returns the time of the next call. Link faults are raised
inside the waiting task (tasks.py), which knows what they mean for the arm. Only the thread that
calls `advance` touches the wire.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Any, TypeVar

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
from armdrive.trace.recorder import FlightRecorder
from armdrive.transports.link import Link, closed_link

# The time limit of a call that moves nothing: connecting, resetting, reading the position. The
# engine enforces it, whatever arrives on the wire, so that no controller has to.
#
# Twice the slowest first contact: a GRBL board may take 4 s to start and is then reset up to three
# times, 2 s each. The second half allows for one attempt that is lost to noise.
CALL_LIMIT_S = 20.0

# The settings of a dialect that are timeouts of its device.
DEVICE_TIMEOUTS = ("answer_margin_s", "answer_s", "boot_s", "report_timeout_s")


def call_limit_s(device: Any) -> float:
    """Return the call limit for an arm, given its dialect's settings.

    The limit grows with the longest of the device's timeouts, relative to its default. Otherwise an
    arm file that allows a slow device three times as long could never connect.
    """
    usual = type(device)()
    own = [name for name in DEVICE_TIMEOUTS if hasattr(usual, name)]
    longer: list[float] = [getattr(device, name) / getattr(usual, name) for name in own]
    return CALL_LIMIT_S * max([1.0, *longer])


# The engine itself.

T = TypeVar("T")

MOST_TURNS = 10_000  # a task that takes more steps without waiting is broken, and is ended
LAST_STEPS = 16  # steps that a task may take to clean up after its time limit

FORKED = (
    "the arm belongs to the process that connected to it, and this process was forked from that "
    "one: drive the arm there, or connect again here after it was closed there"
)


def closed_for_good() -> WrongState:
    """Return the error of a call on a connection that this program has closed."""
    return WrongState("this connection was closed for good: create a new one")


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
        tracer: FlightRecorder,
        call_limit_s: float,
    ) -> None:
        """Take a link, a controller and four callbacks.

        `idle(now)` returns the time of its next call and, if there is routine work, a task;
        `stopping` is called while a stop is requested, `lost` when the link is lost, `noticed` with
        each unsolicited message of the device. `call_limit_s` limits routine work.
        """
        self.link = link
        self.controller = controller
        self.tracer = tracer
        self.now_s = 0.0
        self.due_s = -math.inf
        """When the engine has work even if the wire brings nothing; -inf while that is unknown."""
        self.asleep_s: Callable[[], float] = _never
        self.round_s: Callable[[], float] = _never
        self._suspend_count = 0
        self.stop_asked = False
        self.stop_hard = False
        self.stop_why = ""
        self.last_answer = ""
        self.requests_sent = 0
        self.received_s = -math.inf
        self._idle = idle
        self._stopping = stopping
        self._lost = lost
        self._noticed = noticed
        self._task: Task[Any] | None = None
        self._next: Task[Any] | None = None
        self._wait: Exchange | SleepUntil | None = None
        self._asked = False
        self._wake_s = math.inf  # when routine work is due, as far as is known
        self.process: int | None = None
        """The process whose thread calls the engine; None if the callers that wait do."""
        self._broken: ArmError | None = None
        self._proved = True
        self.call_limit_s = call_limit_s
        self.reconnect: Callable[[float], float] | None = None
        """Called while the link is lost. May `take` a new link; returns when to call again."""

    @property
    def last_sent(self) -> str:
        """The text of the latest message sent."""
        return self.controller.last_said

    @property
    def busy(self) -> bool:
        """Whether a task is running or waiting to run."""
        return self._task is not None or self._next is not None

    @property
    def under_way(self) -> Task[Any] | None:
        """The running task; None if none is running, or only routine work."""
        task = self._task
        return None if task is None or task.routine else task

    @property
    def suspend_count(self) -> int:
        """Number of times this program was suspended, including a suspension in progress.

        Hold the lock of `advance` while comparing two values.
        """
        return self._suspend_count + (self.asleep_s() > 0.0)

    @property
    def at_rest(self) -> bool:
        """Whether no task is running and no stop is pending."""
        return self.broken is not None or not (self.busy or self.stop_asked)

    @property
    def broken(self) -> ArmError | None:
        """Why nothing can be sent: the link was lost or closed; a forked process never had one."""
        return LinkLost(FORKED) if self.forked else self._broken

    @property
    def forked(self) -> bool:
        """Whether this process has only a copy of the engine, whose thread stayed in its parent."""
        return self.process is not None and self.process != os.getpid()

    def start(
        self, body: TaskBody[T], *, alone: bool = False, within_s: float = math.inf
    ) -> Task[T]:
        """Submit a task, which begins in `advance` as soon as the running task has ended.

        The task ends with `NoAnswer` after `within_s`, not counting the time in which it waits for
        another call's motion. Raises `WrongState` if another task already waits, or, with `alone`,
        if anything but routine work is running: no arm may start to move after its caller has
        stopped expecting it. A pending stop also applies to this task.
        """
        task = Task(body, within_s=within_s)
        if (lost := self.broken) is not None:
            task.fail(lost)
            return task
        busy = self._task is not None and not self._task.routine and alone
        if self._next is not None or busy:
            body.close()
            raise WrongState("something else is still at work: wait for its end, or stop the arm")
        self._next = task
        return task

    @contextmanager
    def limited(self) -> Iterator[None]:
        """Apply the call limit to this part of the running task.

        For position readings within a motion, which has no time limit of its own.
        """
        task = self._task
        if task is None or not math.isinf(task.within_s):
            yield
            return
        task.since_s, task.within_s = self.now_s, self.call_limit_s
        try:
            yield
        finally:
            task.within_s = math.inf

    def suspended(self, time_s: float) -> None:
        """Handle a suspension of this program that lasted `time_s`: stop any motion.

        After a suspension the operator no longer expects the arm to move.
        """
        self._suspend_count += 1
        for task in (self._task, self._next):  # the device could not answer in that time
            if task is not None:
                task.since_s += time_s
        if self._next is not None or (self._task is not None and not self._task.routine):
            self.stop_asked = True
            self.stop_why = f": this program was suspended for {time_s:.1f} s"

    def close(self) -> None:
        """Close the connection: the running task fails with `LinkLost`, later ones `WrongState`."""
        if self._broken is None:
            with suppress(LinkLost):
                if frames := self.controller.shutdown_frames():
                    self.tracer.sent(frames)
                    self.link.write(frames, self.now_s)
        self._end(closed_link("the connection"))
        self._broken = closed_for_good()

    def take(self, link: Link, controller: Controller) -> None:
        """Replace a lost link. All earlier requests, and a pending stop, are dropped."""
        self.link, self.controller = link, controller
        self._broken, self._proved = None, False
        self._end_stop()

    def prove(self) -> None:
        """Confirm that the arm answers on the new link."""
        self._proved = True

    def advance(self, now_s: float) -> float:
        """Do all that is due; return the time of the next call, on the same clock."""
        self.now_s = now_s
        self.due_s = -math.inf
        if self._broken is not None:
            next_s = math.inf if self.reconnect is None else self.reconnect(now_s)
            if self._broken is not None:
                return next_s
        self.tracer.tick(now_s, self.stop_asked, self.stop_hard)
        # A stop goes first, ahead of what has arrived and of every message that is due.
        if self.stop_asked:
            self._stopping()
            self.controller.stop(hard=self.stop_hard)
        try:
            # All that has arrived is read before a task or the controller calls an answer missing:
            # after a delay of this program, an answer may have waited longer than its timeout.
            self._listen()
            self._run()
        except LinkLost as lost:
            self._break(lost)
            return math.inf if self.reconnect is None else self.reconnect(now_s)
        except Exception as error:  # a bug of ours
            self.tracer.failed(error)
            raise
        return self._next_s()

    def _listen(self) -> None:
        data = self.link.read(self.now_s)
        if data:
            self.received_s = self.now_s
            self.tracer.received(data)
            self.controller.receive(data, self.now_s)
        self._talk()

    def _talk(self) -> None:
        """Write the controller's messages, and process its events.

        A message computed before a suspension of this program is not sent after it; the motion is
        stopped instead. To the controller, such a message was lost on the wire.
        """
        woken = self._woken()
        data = self.controller.advance(self.now_s)
        if data and (woken or not self._woken()) and not self._stale():
            self.tracer.sent(data)
            self.link.write(data, self.now_s)
        while (event := self.controller.next_event()) is not None:
            self._process(event)

    def _stale(self) -> bool:
        """Return whether it is too late to send an order; it is never too late for a stop."""
        return not self.stop_asked and self.round_s() > self.controller.abilities.order_s

    def _woken(self) -> bool:
        """Return whether this round was suspended and its motion is therefore being stopped."""
        asleep_s = self.asleep_s()
        if asleep_s <= 0.0:
            return False
        self.suspended(asleep_s)
        if self.stop_asked:
            self.controller.stop(hard=self.stop_hard)
        return self.stop_asked

    def _process(self, event: Event) -> None:
        self.tracer.reported(event)
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

    def _no_answer(self, timeout: Timeout) -> NoAnswer:
        """Return the error for a timeout; for a call with a limit, with the whole time it took."""
        task = self._task
        if task is not None and math.isfinite(task.within_s):
            timeout = replace(timeout, waited_s=self.now_s - task.since_s)
        return NoAnswer(
            f"{timeout} on {self.link.description}. {timeout.look_at}, then call `reset()`"
        )

    def _count_time(self) -> None:
        """Start the time limits of tasks; a waiting task's starts after another call's motion."""
        if (task := self._task) is not None and math.isnan(task.since_s):
            task.since_s = self.now_s
        waiting = self._task is not None and not self._task.routine
        if self._next is not None and math.isnan(self._next.since_s) and not waiting:
            self._next.since_s = self.now_s

    def _end_late(self) -> None:
        """End the running task if its time limit has passed, for every dialect and link.

        Controllers have timeouts of their own, but a device that sends endlessly, or answers every
        message in part, can keep those from expiring.
        """
        task = self._task
        if task is None or self.now_s < task.until_s:
            return
        error = self._no_answer(Timeout(self.controller.last_said, 0.0, self.controller.look_at))
        if self._asked:  # its answer would otherwise pass for the answer to the next request
            self._asked = False
            self.controller.abandon()
        for _ in range(LAST_STEPS):  # the task may clean up, and may even get more time
            self._resume(error)
            if self._task is not task or self.now_s < task.until_s:
                return
        task.give_up(error)
        self._finish(task)

    def _run(self) -> None:
        """Run tasks until the current one waits for something that is not there yet."""
        turns = 0
        self._count_time()
        self._end_late()
        while not self._asked:
            if self._task is None and not self._begin():
                return
            turns += 1
            if turns > MOST_TURNS:
                self._resume(ArmError("a task looped without waiting, and was ended"))
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
            self._wake_s, body = self._idle(self.now_s)
            if body is None:
                self._end_stop()  # nothing is left to stop
                return False
            # limited like a call, so that a device that sends endlessly cannot occupy the engine
            task = Task(body, routine=True, within_s=self.call_limit_s)
        self._task, self._wait = task, SleepUntil(-math.inf)
        self._count_time()
        return True

    def _send(self, request: Request) -> None:
        try:
            self.controller.begin(request, self.now_s)
        except (ValueError, Refused) as error:  # the dialect cannot express the request
            self._resume(error if isinstance(error, Refused) else Refused(f"not sent: {error}"))
            return
        self.tracer.requested(request)
        self._asked = True
        self.requests_sent += 1
        if self.stop_asked:  # the controller has just begun, and does not know of the stop yet
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
        if self._next is None:  # a stop also applies to the task that waits
            self._end_stop()
        task.done = True

    def _end_stop(self) -> None:
        self.stop_asked, self.stop_hard, self.stop_why = False, False, ""

    def _break(self, lost: LinkLost) -> None:
        self._end(lost)
        self._lost(lost)
        if self._proved:  # otherwise an attempt to reconnect has failed, which is no new loss
            self.tracer.lost(lost)

    def _end(self, lost: LinkLost) -> None:
        """End every task with the loss of the link."""
        self._broken = lost
        self._asked = False
        self._end_stop()  # without a link there is nothing left to stop
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
        """Return when the engine has work even if the wire brings nothing."""
        due_s = self.controller.next_s()
        if self._task is not None:
            due_s = min(due_s, self._task.until_s)
        if self._asked:
            return due_s
        if isinstance(self._wait, SleepUntil):
            return min(self._wait.time_s, due_s)
        return min(self._wake_s, due_s)
