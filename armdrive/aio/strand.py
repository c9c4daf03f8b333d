"""A strand: the thread in which an event loop has one call of an arm carried out.

One that goes *in turn* (simulated time) runs only while the loop waits for it: from its start to
its first wait, and from the end of a wait to the next one. One in real time runs freely.
"""

from __future__ import annotations

import asyncio
import contextlib
import contextvars
import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from armdrive.strands import GivenUp, become

if TYPE_CHECKING:
    from armdrive.aio.stage import Stage
    from armdrive.clock import SimulatedClock

R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class Wait:
    """What a strand waits for, on which clock, and until when."""

    clock: SimulatedClock
    done: Callable[[], bool]
    end_s: float


class ThreadStrand(Generic[R]):
    """One call in its thread. `ended` is done once it has returned or raised."""

    def __init__(self, call: Callable[[], R], stage: Stage, *, in_turn: bool) -> None:
        self.ended: asyncio.Future[None] = stage.loop.create_future()
        self.error: BaseException | None = None
        self._value: R | None = None
        self._call = call
        self._stage = stage
        self._in_turn = in_turn
        self._over = False
        self._given_up = False
        self._parked = False
        self._wait = Wait(stage.clock, bool, math.inf)
        self._outcome: bool | BaseException = False
        self._go, self._back = threading.Semaphore(0), threading.Semaphore(0)

    # -- on the loop's thread -----------------------------------------------------------------

    def begin(self) -> None:
        """Have the call begin; in turn, return at its first wait or its end."""
        context: Callable[..., Any] = contextvars.copy_context().run
        # a daemon: whoever leaves a program in a hurry does not wait for what it has left behind
        threading.Thread(
            target=context, args=(self._run,), name="armdrive call", daemon=True
        ).start()
        if self._in_turn:
            self._let_it_run()

    def result(self) -> R:
        """Return what the call has returned, or raise what it raised."""
        if self.error is not None:
            raise self.error
        return self._value  # type: ignore[return-value]

    def give_up(self) -> None:
        """Have the call end as soon as it waits for anything, as if by Ctrl-C."""
        self._given_up = True

    @property
    def waits_until_s(self) -> float:
        """The end of its present wait, on the clock that it waits on."""
        return self._wait.end_s

    def ready(self) -> bool:
        """Tell whether its present wait is over."""
        wait = self._wait
        return self._given_up or wait.done() or wait.clock.now_s >= wait.end_s

    def resume(self, error: BaseException | None = None) -> None:
        """Let it run on behind its wait, with an error where one has come instead of the end."""
        self._outcome = self._wait.done() if error is None else error
        self._parked = False
        self._go.release()
        self._let_it_run()

    def _let_it_run(self) -> None:
        try:
            self._back.acquire()
        except BaseException:
            self._set_free()
            raise
        if self._over:
            self._settle()
        elif self._parked:
            self._stage.conductor(self._wait.clock).admit(self)

    def _set_free(self) -> None:
        """Let it run freely from now on: a second Ctrl-C has torn the loop away from it."""
        self._in_turn = False
        self._go.release()
        if self._over:
            self._settle()

    def _settle(self) -> None:
        if not self.ended.done():
            self.ended.set_result(None)

    # -- on its own thread --------------------------------------------------------------------

    @property
    def clock(self) -> SimulatedClock:
        """The simulated time of the loop."""
        return self._stage.clock

    def check(self) -> None:
        """Raise `GivenUp` once where the call was given up."""
        if self._given_up:
            self._given_up = False
            raise GivenUp

    def park(self, clock: SimulatedClock, done: Callable[[], bool], end_s: float) -> bool | None:
        """Hand the turn back to the loop until `done()` or `end_s`; None where it runs freely."""
        self.check()
        if not self._in_turn:
            return None
        self._wait, self._parked = Wait(clock, done, end_s), True
        self._back.release()
        self._go.acquire()
        self.check()
        if isinstance(self._outcome, BaseException):
            raise self._outcome
        return self._outcome

    def _run(self) -> None:
        become(self)
        try:
            self._value = self._call()
        except BaseException as error:  # it is raised where the call is awaited
            self.error = error
        self._over = True
        if self._in_turn:
            self._back.release()
            return
        with contextlib.suppress(RuntimeError):  # the loop has been closed: nobody awaits it
            self._stage.loop.call_soon_threadsafe(self._settle)
