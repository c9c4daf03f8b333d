"""Carries calls of arms out for an event loop: in threads, on one simulated clock for them all."""

from __future__ import annotations

import asyncio
import contextlib
import contextvars
import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from armdrive.arm import Arm
from armdrive.runtime.clock import ClockProgress, SignalsBetweenSteps, SimulatedClock
from armdrive.runtime.drive import RealPace
from armdrive.runtime.workers import WorkerEnded, become

# A strand: the thread in which an event loop has one call of an arm carried out.
#
# One that goes *in turn* (simulated time) runs only while the loop waits for it: from its start to
# its first wait, and from the end of a wait to the next one. One in real time runs freely.

R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class Wait:
    """What a strand waits for, on which clock, and until when."""

    clock: SimulatedClock
    done: Callable[[], bool]
    end_s: float


class ThreadWorker(Generic[R]):
    """One call in its thread. `ended` is done once it has returned or raised."""

    def __init__(self, call: Callable[[], R], stage: LoopContext, *, in_turn: bool) -> None:
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
        """Raise `WorkerEnded` once where the call was given up."""
        if self._given_up:
            self._given_up = False
            raise WorkerEnded

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


# Drives one simulated clock for an event loop, turn by turn, while strands wait on it.
#
# Between two turns the loop does whatever else it has to do. It is a chain of callbacks and no
# task, so that nobody can cancel it while arms have yet to be stopped.

SETTLING = 10
"""After a call has gone on, the loop goes round so often before time does: whoever awaited it, also
through `gather` and tasks within tasks, asks for its next call at the same simulated moment."""


class ClockDriver:
    """One clock, and the strands that wait on it in the order in which they came."""

    def __init__(self, clock: SimulatedClock, loop: asyncio.AbstractEventLoop) -> None:
        self._clock = clock
        self._loop = loop
        self._parked: list[ThreadWorker[Any]] = []
        self._progress = ClockProgress(clock)
        self._settling = 0
        self._due = False

    def admit(self, strand: ThreadWorker[Any]) -> None:
        """Have a strand wait; called on the loop's thread."""
        self._parked.append(strand)
        self._progress = ClockProgress(self._clock)
        self._go_on()

    def _go_on(self) -> None:
        if self._parked and not self._due:
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
        except Exception as error:  # it is for those who wait, as it is without a loop
            for strand in self._taken():
                strand.resume(error)
        finally:
            self._go_on()

    def _resumed(self) -> bool:
        """Let run all whose wait is over, one after the other; tell whether there was any."""
        any_ready = False
        for strand in tuple(self._parked):
            if strand.ready():
                any_ready = True
                self._parked.remove(strand)
                strand.resume()
        return any_ready

    def _advance(self) -> None:
        """Have every arm do what is due; where nobody's wait is over, let time pass."""
        with SignalsBetweenSteps(), self._clock.lock:
            next_s = self._clock.advance()
            if not any(strand.ready() for strand in self._parked):
                self._progress.jump(next_s, min(each.waits_until_s for each in self._parked))

    def _taken(self) -> list[ThreadWorker[Any]]:
        taken, self._parked = self._parked, []
        return taken


UNCERTAIN = "the arm did not confirm that it stands; look at it"


class LoopContext:
    """What one event loop has: a simulated clock, and who drives which clock."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self.loop = loop
        self.clock = SimulatedClock()
        self._conductors: dict[SimulatedClock, ClockDriver] = {}

    def conductor(self, clock: SimulatedClock) -> ClockDriver:
        """Return who drives a clock for this loop."""
        return self._conductors.setdefault(clock, ClockDriver(clock, self.loop))

    async def carry(self, call: Callable[[], R], arm: Arm) -> R:
        """Carry out a call of an arm.

        Where its task is cancelled, the arm is stopped and has come to rest before that goes on.
        """
        strand = self._begun(call, in_turn=goes_in_turn(arm))
        try:
            await ended(strand)
        except asyncio.CancelledError as cancelled:
            arm.request_stop()  # before anything that takes time
            strand.give_up()
            await ended(strand, whatever_comes=True)
            if not await self._stands(arm):
                cancelled.add_note(UNCERTAIN)
            raise
        return strand.result()

    async def carry_to_its_end(self, call: Callable[[], R], *, in_turn: bool) -> R:
        """Carry out what has to be done whoever cancels it; that goes on afterwards."""
        strand = self._begun(call, in_turn=in_turn)
        cancelled = await ended(strand, whatever_comes=True)
        if cancelled is not None:
            raise cancelled
        return strand.result()

    async def connect(self, call: Callable[[], Arm], *, in_turn: bool) -> Arm:
        """Carry out a call that connects; where that is cancelled, nothing stays connected."""
        strand = self._begun(call, in_turn=in_turn)
        try:
            await ended(strand)
        except asyncio.CancelledError:
            strand.give_up()
            await ended(strand, whatever_comes=True)
            if strand.error is None:
                arm = strand.result()
                await self.carry_to_its_end(arm.close, in_turn=goes_in_turn(arm))
            raise
        return strand.result()

    async def _stands(self, arm: Arm) -> bool:
        """Stop an arm once more, and tell whether it was seen to stand."""
        if arm.closed:
            return True
        strand = self._begun(arm.runner.stand_still, in_turn=goes_in_turn(arm))
        await ended(strand, whatever_comes=True)
        return strand.error is None and strand.result()

    def _begun(self, call: Callable[[], R], *, in_turn: bool) -> ThreadWorker[R]:
        strand = ThreadWorker(call, self, in_turn=in_turn)
        strand.begin()
        return strand


async def ended(
    strand: ThreadWorker[R], *, whatever_comes: bool = False
) -> asyncio.CancelledError | None:
    """Wait for the end of a strand; with `whatever_comes`, return the cancelling that came."""
    cancelled = None
    while not strand.ended.done():
        try:
            await asyncio.wait({strand.ended})
        except asyncio.CancelledError as error:
            if not whatever_comes:
                raise
            cancelled = error
    return cancelled


def goes_in_turn(arm: Arm) -> bool:
    """Tell whether an arm lives in simulated time, which the loop drives."""
    return not isinstance(arm.pace, RealPace)


_STAGES: dict[asyncio.AbstractEventLoop, LoopContext] = {}
"""What belongs to a loop and ends with it. A loop has nowhere else to keep it."""


def stage() -> LoopContext:
    """Return the stage of the running event loop."""
    loop = asyncio.get_running_loop()
    if loop not in _STAGES:
        for ended_loop in [each for each in _STAGES if each.is_closed()]:
            del _STAGES[ended_loop]
        _STAGES[loop] = LoopContext(loop)
    return _STAGES[loop]
