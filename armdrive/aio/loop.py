"""Run calls of arms for an event loop: simulated time on the loop itself, real time in threads.

`await arm.move_j(...)` comes here as `LoopContext.carry`, with the coroutine of the call
(armdrive/blocking.py), which awaits nothing but a `Wait`.

In simulated time, a `SimulatedCall` runs the coroutine to its first wait, and the `ClockDriver` of
the clock takes over: in each turn of the loop it advances the clock by a few steps and resumes the
calls whose waits are over. In real time, a `ThreadCall` runs the coroutine on a thread of its own,
and the loop waits for the thread's end.

A cancelled task stops its arm first, and gets its `CancelledError` once the arm stands.
"""

from __future__ import annotations

import asyncio
import contextlib
import contextvars
import math
import threading
from collections.abc import Callable, Coroutine
from typing import Any, Generic, TypeVar

from armdrive.arm import Arm
from armdrive.blocking import Wait, coroutine_of, has_ended, resume, run_blocking
from armdrive.runtime.clock import (
    ClockProgress,
    SignalsBetweenSteps,
    SimulatedClock,
    SimulatedPace,
)

R = TypeVar("R")

# A call that a task awaits. In simulated time the loop resumes the call after each of its waits. In
# real time the call gets a thread, because it opens ports, reads files and waits for locks.


class LoopCall(Generic[R]):
    """A running call. `ended` is done once the call has returned or raised."""

    def __init__(self, call: Coroutine[Any, Any, R], context: LoopContext) -> None:
        self.ended: asyncio.Future[None] = context.loop.create_future()
        self.error: BaseException | None = None
        self._value: R | None = None
        self._call = call
        self._context = context
        self._variables = contextvars.copy_context()
        self._cancelled = False

    def result(self) -> R:
        """Return the call's result, or raise its error."""
        if self.error is not None:
            raise self.error
        return self._value  # type: ignore[return-value]

    def cancel(self) -> None:
        """Raise `CancelledError` in the call, at its current wait or its next one."""
        self._cancelled = True

    def _settle(self) -> None:
        if not self.ended.done():
            self.ended.set_result(None)


class ThreadCall(LoopCall[R]):
    """A call in real time, on a thread of its own."""

    def begin(self) -> None:
        """Start the thread."""
        # a daemon thread, so that a program can exit without waiting for abandoned calls
        threading.Thread(
            target=self._variables.run, args=(self._run,), name="armdrive call", daemon=True
        ).start()

    def _run(self) -> None:
        try:
            self._value = run_blocking(self._call, self._wait)
        except BaseException as error:  # `result` raises it in the task that awaits the call
            self.error = error
        with contextlib.suppress(RuntimeError):  # the loop is closed, so no task awaits the call
            self._context.loop.call_soon_threadsafe(self._settle)

    def _wait(self, wait: Wait) -> bool:
        met = wait.pace.wait(lambda: self._cancelled or wait.done(), wait.timeout_s)
        if self._cancelled:
            self._cancelled = False
            raise asyncio.CancelledError
        return met


class SimulatedCall(LoopCall[R]):
    """A call in simulated time, on the loop's own thread."""

    def __init__(self, call: Coroutine[Any, Any, R], context: LoopContext) -> None:
        super().__init__(call, context)
        self.clock: SimulatedClock | None = None
        """The clock on which the call waits; None before its first wait and after its end."""
        self.waits_until_s = math.inf
        """The deadline of the current wait, on that clock."""
        self._done: Callable[[], bool] = bool
        self._over: Callable[[], bool] = bool

    def begin(self) -> None:
        """Run the call to its first wait, or to its end."""
        self._run(None)

    def ready(self) -> bool:
        """Return whether the current wait is over."""
        clock = self.clock
        return clock is not None and (
            self._cancelled or self._over() or clock.now_s >= self.waits_until_s
        )

    def resume(self, error: Exception | None = None) -> None:
        """Continue the call after its wait, raising `error` inside it if one ended the wait."""
        self._run(self._done() if error is None else error)

    def _run(self, outcome: bool | BaseException | None) -> None:
        """Run the call to its next wait in simulated time, or to its end."""
        while True:
            if self._cancelled:
                self._cancelled, outcome = False, asyncio.CancelledError()
            try:
                wait = self._variables.run(resume, self._call, outcome)
                if isinstance(wait.pace, SimulatedPace):
                    self._park(wait, wait.pace)
                    return
                outcome = wait.block()
            except StopIteration as end:
                self._value = end.value
                break
            except BaseException as error:
                if has_ended(self._call):  # `result` raises it in the task that awaits the call
                    self.error = error
                    break
                outcome = error  # Ctrl-C between two steps: raised inside the call
        self.clock = None
        self._settle()

    def _park(self, wait: Wait, pace: SimulatedPace) -> None:
        self._done = wait.done
        self._over = lambda: wait.done() or not pace.driving()
        self.waits_until_s = pace.clock.now_s + wait.timeout_s
        self.clock = pace.clock
        self._context.driver(pace.clock).admit(self)


# Advancing a simulated clock, turn by turn, while calls wait on it.
#
# Between two turns the loop runs other tasks. The turns are callbacks rather than a task, so that
# cancelling every task cannot stop the clock before the arms have stopped.

# Turns of the loop, after a call has continued, before time advances. They let every task that
# awaits the call, also through `gather` or nested tasks, start its next call at the same moment.
SETTLING = 10

STEPS_PER_TURN = (
    4  # clock steps per turn: fewer cost more overhead, more delay the loop's other tasks
)


class ClockDriver:
    """A simulated clock, and the calls that wait on it, in order of arrival."""

    def __init__(self, clock: SimulatedClock, loop: asyncio.AbstractEventLoop) -> None:
        self._clock = clock
        self._loop = loop
        self._waiting: list[SimulatedCall[Any]] = []
        self._progress = ClockProgress(clock)
        self._settling = 0
        self._due = False

    def admit(self, call: SimulatedCall[Any]) -> None:
        """Add a call to the end of the waiting list."""
        # at the end, so that calls take turns in the same order in every run
        self._waiting = [*(each for each in self._waiting if each is not call), call]
        self._progress = ClockProgress(self._clock)
        self._go_on()

    def _go_on(self) -> None:
        if self._waiting and not self._due:
            self._due = True
            self._loop.call_soon(self._turn)

    def _turn(self) -> None:
        self._due = False
        try:
            if self._settling:
                self._settling -= 1
            elif self._resumed():
                self._settling = SETTLING
            else:
                self._advance()
        except Exception as error:  # raised inside every waiting call, as without an event loop
            for call in tuple(self._waiting):
                call.resume(error)
        finally:
            self._waiting = [each for each in self._waiting if each.clock is self._clock]
            self._go_on()

    def _resumed(self) -> bool:
        """Resume the calls whose waits are over, one by one; return whether there were any."""
        any_ready = False
        for call in tuple(self._waiting):
            if call.ready():
                any_ready = True
                call.resume()
        return any_ready

    def _advance(self) -> None:
        """Run each arm's due work and advance the time, until a wait is over."""
        with SignalsBetweenSteps() as signals:
            for _ in range(STEPS_PER_TURN):
                with self._clock.lock:
                    next_s = self._clock.advance()
                    if self._any_ready():
                        return
                    until_s = min(each.waits_until_s for each in self._waiting)
                    self._progress.jump(next_s, until_s)
                signals.deliver()
                if self._any_ready():
                    return

    def _any_ready(self) -> bool:
        return any(call.ready() for call in self._waiting)


UNCERTAIN = "the arm did not confirm that it has stopped: look at it"

# the loop's attribute for its `LoopContext`; stored there, the context ends with the loop
CONTEXT = "_armdrive_context"


class LoopContext:
    """The state that the arms of one event loop share: a simulated clock, and clock drivers."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self.loop = loop
        self.clock = SimulatedClock()
        self._drivers: dict[SimulatedClock, ClockDriver] = {}

    def driver(self, clock: SimulatedClock) -> ClockDriver:
        """Return the driver of a clock for this loop."""
        return self._drivers.setdefault(clock, ClockDriver(clock, self.loop))

    async def carry(self, call: Coroutine[Any, Any, R], arm: Arm) -> R:
        """Run a call of an arm.

        If the task is cancelled, stop the arm and wait until it stands before raising
        `CancelledError`.
        """
        under_way = self._begun(call, simulated=in_simulated_time(arm))
        try:
            await ended(under_way)
        except asyncio.CancelledError as cancelled:
            arm.request_stop()  # first, because the rest takes time
            under_way.cancel()
            await ended(under_way, whatever_comes=True)
            if not await self._stands(arm):
                cancelled.add_note(UNCERTAIN)
            raise
        return under_way.result()

    async def carry_to_its_end(self, call: Coroutine[Any, Any, R], *, simulated: bool) -> R:
        """Run a call to its end, even if the task is cancelled; then raise `CancelledError`."""
        under_way = self._begun(call, simulated=simulated)
        cancelled = await ended(under_way, whatever_comes=True)
        if cancelled is not None:
            raise cancelled
        return under_way.result()

    async def connect(self, call: Coroutine[Any, Any, Arm], *, simulated: bool) -> Arm:
        """Run a call that connects an arm; if the task is cancelled, close the arm again."""
        under_way = self._begun(call, simulated=simulated)
        try:
            await ended(under_way)
        except asyncio.CancelledError:
            under_way.cancel()
            await ended(under_way, whatever_comes=True)
            if under_way.error is None:
                await self.close(under_way.result())
            raise
        return under_way.result()

    async def close(self, arm: Arm) -> None:
        """Close an arm, even if the task is cancelled."""
        await self.carry_to_its_end(coroutine_of(arm.close)(), simulated=in_simulated_time(arm))

    async def _stands(self, arm: Arm) -> bool:
        """Stop an arm again, and return whether it confirmed that it stands."""
        if arm.closed:
            return True
        under_way = self._begun(arm.parts.runner.stand_still(), simulated=in_simulated_time(arm))
        await ended(under_way, whatever_comes=True)
        return under_way.error is None and under_way.result()

    def _begun(self, call: Coroutine[Any, Any, R], *, simulated: bool) -> LoopCall[R]:
        under_way = SimulatedCall(call, self) if simulated else ThreadCall(call, self)
        under_way.begin()
        return under_way


async def ended(
    call: LoopCall[R], *, whatever_comes: bool = False
) -> asyncio.CancelledError | None:
    """Wait for the end of a call.

    With `whatever_comes`, a cancellation does not interrupt the wait and is returned instead.
    """
    cancelled = None
    while not call.ended.done():
        try:
            await asyncio.wait({call.ended})
        except asyncio.CancelledError as error:
            if not whatever_comes:
                raise
            cancelled = error
    return cancelled


def in_simulated_time(arm: Arm) -> bool:
    """Return whether an arm runs in simulated time, which the loop advances."""
    return not arm.parts.pace.real_time


def loop_context() -> LoopContext:
    """Return the context of the running event loop."""
    loop = asyncio.get_running_loop()
    found: LoopContext | None = getattr(loop, CONTEXT, None)
    if found is None:
        found = LoopContext(loop)
        setattr(loop, CONTEXT, found)
    return found
