"""The runner of an arm's tasks: submits them to the engine, waits for their end, stops them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

from armdrive.blocking import Wait
from armdrive.errors import LinkLost, NoAnswer, Stopped
from armdrive.runtime.arm_state import Core
from armdrive.runtime.clock import Pace
from armdrive.runtime.engine import Engine
from armdrive.runtime.overrides import given_up
from armdrive.runtime.states import Event, after
from armdrive.tasks import Task, TaskBody

# A call that should take no time fails after this long.
PATIENCE_S = 60.0

SLICE_S = 1.0  # how often a wait for a motion looks whether the arm is paused or slowed
LEAST_S = 1e-3  # a shorter rest of a timeout is over: a clock may be too coarse to wait for it

T = TypeVar("T")


class TaskRunner:
    """Submits tasks to one arm's engine, waits for their end, and stops them.

    Every object that can command an arm holds its runner, and no other object does: an arm whose
    runner is gone has been lost by its program (`connect.connection`).

    The methods that wait are coroutines that await `Wait` objects; see blocking.py.
    """

    def __init__(self, core: Core, engine: Engine, pace: Pace) -> None:
        self.core = core
        self.engine = engine
        self.pace = pace
        self.stops = 0
        """The number of stops requested so far."""
        self.known_stops = 0
        """The number that this program knows of: its own, those that `Stopped` has reported, and
        those that its user knew of when deciding on a call."""

    # -- stopping -----------------------------------------------------------------------------

    def request_stop(self, *, hard: bool = False, elsewhere: bool = False) -> None:
        """Request a stop and return at once. Takes no lock: a signal handler may call this.

        `elsewhere`: for another program, so that this one does not know of it yet.
        """
        self.stops += 1
        if elsewhere:
            self.engine.stop_why = ": another program asked for it"
        else:
            self.known_stops += 1
        self.core.hold = None
        self.engine.stop_hard = self.engine.stop_hard or hard
        self.engine.stop_asked = True
        self.pace.wake()

    async def stop(self) -> None:
        """Stop, and wait until the arm stands. Raises `NoAnswer` if it does not confirm that."""
        if not await self.stand_still():
            raise NoAnswer("the arm did not confirm that it has stopped: look at it")

    async def stand_still(self) -> bool:
        """Stop; return whether the arm confirms that it stands."""
        self.request_stop()
        # the engine must have handled the stop, or it would stop the next motion
        return await Wait(self.pace, lambda: self.engine.at_rest, PATIENCE_S)

    # -- pausing ------------------------------------------------------------------------------

    def pause(self) -> None:
        """Pause the arm after its current burst or segment."""
        self.core.speed_override.pause()
        self.pace.wake()

    def resume(self) -> None:
        """Continue a paused arm."""
        self.core.speed_override.end_pause()
        self.pace.wake()

    # -- running ------------------------------------------------------------------------------

    def submit(
        self, body: TaskBody[T], *, alone: bool = False, within_s: float = math.inf
    ) -> Task[T]:
        """Submit a task to the engine. Raises `WrongState` while another task is waiting there.

        With `alone`, also raises while a task is running: a motion never waits for its turn. A task
        that takes longer than `within_s` ends with `NoAnswer`.
        """
        with self.pace.lock:
            task = self.engine.start(body, alone=alone, within_s=within_s)
        self.pace.wake()
        return task

    async def wait(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Wait for `done()`; return False after a timeout. An exception meanwhile stops the arm."""
        try:
            return await Wait(self.pace, done, timeout_s)
        except BaseException:
            await self.stand_still()
            raise

    async def wait_unpaused(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Wait like `wait`, not counting the time for which the arm is paused.

        Raises `WrongState` if the pause lasts too long.
        """
        override = self.core.speed_override
        simulated = not self.pace.real_time

        def resumed() -> bool:
            if simulated and override.paused and not done():
                override.breathe()
            return done() or not override.paused

        while timeout_s >= 0.0:
            began_s = self.pace.now_s()
            if not await self.wait(lambda: done() or override.paused, timeout_s):
                return False
            if done():
                return True
            timeout_s -= self.pace.now_s() - began_s
            if not await self.wait(resumed, override.longest_s):
                raise given_up(override.longest_s)
        return done()

    async def finish(self, task: Task[T], timeout_s: float) -> T:
        """Wait for a task to end."""
        if not await self._waited(task, timeout_s):
            await self.stand_still()
            raise NoAnswer(f"the motion had not ended after {timeout_s:.0f} s and was stopped")
        return self.result(task)

    def result(self, task: Task[T]) -> T:
        """Return the result of a task that has ended, or raise its error."""
        if isinstance(task.error, Stopped):
            self.know_of(self.stops)
        return task.result()

    async def perform(self, body: TaskBody[T], within_s: float | None = None) -> T:
        """Run a task that moves nothing, and return its result.

        The task takes at most `within_s`, by default `call_limit_s`. If a motion is running, it
        first waits up to a minute for the end of the motion.
        """
        limit_s = self.engine.call_limit_s if within_s is None else within_s
        return await self.finish(self.submit(body, within_s=limit_s), limit_s + PATIENCE_S)

    async def _waited(self, task: Task[Any], timeout_s: float) -> bool:
        """Wait for a task to end, with a timeout for its motion at full speed.

        Time in a pause does not count, and slowed time counts for less. Where the motion waits for
        the end of the pause by itself, it gives up first.
        """
        speed_override, simulated = self.core.speed_override, not self.pace.real_time

        def ended() -> bool:
            if simulated and speed_override.waits and not task.done:
                speed_override.breathe()
            return task.done

        paused_s, most_s = 0.0, speed_override.longest_s + PATIENCE_S
        while timeout_s > LEAST_S and paused_s < most_s:
            began_s, share = self.pace.now_s(), speed_override.override
            if await self.wait(ended, min(timeout_s / share, SLICE_S)):
                return True
            took_s = self.pace.now_s() - began_s
            if speed_override.paused:
                paused_s += took_s
            else:
                timeout_s -= took_s * share
        return False

    # -- requirements of a call ---------------------------------------------------------------

    def require(self, event: Event, action: str = "") -> None:
        """Raise unless the arm may do this now: as `require_link` does, or `WrongState`.

        `action` names the call in the error, if it differs from the event.
        """
        self.require_link()
        after(self.core.state, event, action)

    def require_link(self) -> None:
        """Raise `LinkLost` if the connection was lost, and `WrongState` if it was closed."""
        if (broken := self.engine.broken) is not None:
            raise type(broken)(str(broken))

    def require_reachable(self, request: str = "stop") -> None:
        """Raise `LinkLost` if a request of this kind cannot reach the arm."""
        broken = self.engine.broken
        if isinstance(broken, LinkLost):
            raise LinkLost(
                f"the {request} did not reach the arm ({broken}): look at the arm; only its own "
                "switch stops it now"
            )

    def require_no_stop(self, since: int | None, when: str) -> None:
        """Raise `Stopped` if a stop was requested since `stops` had the value `since`.

        None stands for the last stop that this program knows of.
        """
        if since is not None:
            self.know_of(since)
        if self.stops != (self.known_stops if since is None else since):
            by = " by another program" if self.stops != self.known_stops else ""
            self.know_of(self.stops)
            raise Stopped(f"a stop was requested{by} {when}")

    def know_of(self, stops: int) -> None:
        """Note that what follows was decided on when there had been this many stops."""
        self.known_stops = max(self.known_stops, stops)

    def absences(self) -> int:
        """Return how often this program or its computer was suspended."""
        with self.pace.lock:
            return self.engine.suspend_count

    def interrupted(self, stops: int, absences: int) -> bool:
        """Return whether a stop or a suspension has come since these counts were taken."""
        return self.stops != stops or self.absences() != absences

    def require_present(self, absences: int) -> None:
        """Raise `Stopped` if this program was suspended since that count was taken."""
        if self.absences() != absences:
            raise Stopped(
                "this program or its computer was suspended: after a suspension, nothing continues "
                "by itself"
            )
