"""The simulated time of programs, which can be killed or suspended, or hang.

A `ProgramTime` drives the engine of one program. The `Timeline` outlives programs: it has what is
due at moments of the simulated time, and the deadline of the present call.
"""

import math
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from armdrive.runtime.clock import SimulatedClock, SimulatedPace
from armdrive.runtime.engine import Engine
from armdrive.sim.wire import TimeQueue
from armdrive.transports.link import Link

MAX_TURNS_AT_ONCE = 10_000
"""An engine that takes more turns than this while no time passes hangs. The simulated clock notices
that too, later, but ends the call with an error that looks like a normal one."""
CALL_TURNS = 1_000_000
"""The most turns of the engine in one call. CAN drives take 200,000 in a pause of ten minutes."""
GRACE_S = 5.0
"""A call that is this late hangs. One that is less late is reported with how late it was."""
CPU_S = 900.0
"""The processor time that one mission may take. A busy computer does not shorten it. The longest
missions take a minute; the limit is for code that never lets the engine take a turn."""


class ProgramKilled(BaseException):
    """The program was killed, by SIGKILL or by a power cut."""


class Hang(BaseException):
    """A call does not end: no time passes, or too much does."""


@contextmanager
def cpu_limit(most_s: float = CPU_S) -> Iterator[None]:
    """Raise `Hang` in a block that takes more processor time, on the main thread of Unix."""
    there = hasattr(signal, "setitimer")
    if not there or threading.current_thread() is not threading.main_thread():
        yield
        return

    def hangs(_number: int, _frame: FrameType | None) -> None:
        raise Hang(f"the driver has computed for {most_s:g} s of processor time")

    before = signal.signal(signal.SIGVTALRM, hangs)
    # again and again, because the driver may catch the first ones to stop the arm
    signal.setitimer(signal.ITIMER_VIRTUAL, most_s, most_s / 10.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


class Timeline:
    """Actions that are due at moments of the simulated time, and the deadline of a call."""

    def __init__(self) -> None:
        self._due: TimeQueue[Callable[[], object]] = TimeQueue()
        self._call, self._until_s, self._turns = "", math.inf, 0

    @property
    def next_s(self) -> float:
        """When the next action is due."""
        return self._due.next_s

    def at(self, time_s: float, action: Callable[[], object]) -> None:
        """Run an action at a time."""
        self._due.put(time_s, action)

    def clear(self) -> None:
        """Drop all actions."""
        self._due.clear()

    def run_due(self, now_s: float) -> None:
        """Run all actions that are due."""
        for action in self._due.due(now_s):
            action()

    def begin_call(self, call: str, until_s: float) -> None:
        """Begin a call that has to end by a time."""
        self._call, self._until_s, self._turns = call, until_s + GRACE_S, 0

    def end_call(self) -> None:
        """End the call."""
        self._call, self._until_s = "", math.inf

    def postpone(self, by_s: float) -> None:
        """Give the call more time: its program was suspended."""
        self._until_s += by_s

    def count_turn(self, now_s: float) -> None:
        """Count a turn of the engine. Raises `Hang` if the present call takes too many, or late."""
        self._turns += 1
        if self._call and (now_s > self._until_s or self._turns > CALL_TURNS):
            raise Hang(f"{self._call} had not ended at {now_s:.1f} s, after {self._turns} turns")


class ProgramTime(SimulatedPace):
    """The time of one program, which starts where the last program's time ended."""

    def __init__(self, start_s: float, timeline: Timeline) -> None:
        super().__init__(SimulatedClock(start_s))
        self._timeline = timeline
        self._driven_engine: Engine | None = None
        self._turns, self._turned_s = 0, -math.inf
        self.dead = False
        self.on_kill: Callable[[], None] = lambda: None
        """Called once when the program is killed."""
        self.advance_world: Callable[[float], None] = lambda _: None
        """Lets time pass for the simulated device while the engine has lost its wire."""

    def start(self, engine: Engine) -> None:
        """Drive an engine through this object, so that every turn runs what is due first."""
        self._driven_engine = engine
        super().start(self)  # type: ignore[arg-type]

    def advance(self, now_s: float) -> float:
        """Run the actions that are due, and then the engine's turn."""
        self.check_alive()
        self._timeline.run_due(now_s)
        self.check_alive()
        self._turns = self._turns + 1 if now_s <= self._turned_s else 0
        self._turned_s = now_s
        self._timeline.count_turn(now_s)
        if self._turns > MAX_TURNS_AT_ONCE:
            raise Hang(f"the engine was called {MAX_TURNS_AT_ONCE} times at {now_s:.3f} s")
        assert self._driven_engine is not None
        now_s = max(self.clock.now_s, now_s)
        if self._driven_engine.broken is not None:
            self.advance_world(now_s)
        return min(self._driven_engine.advance(now_s), self._timeline.next_s)

    due_s = -math.inf
    """Take a turn at every event of the device, as an engine does."""

    @property
    def link(self) -> Link:
        """The engine's wire."""
        assert self._driven_engine is not None
        return self._driven_engine.link

    def close(self) -> None:
        """Release the engine, and with it all that the program had in memory."""
        super().close()
        self._driven_engine = None

    def kill(self) -> None:
        """Kill the program: its next step raises `ProgramKilled`."""
        if not self.dead:
            self.on_kill()
            self.dead = True

    def check_alive(self) -> None:
        """Raise `ProgramKilled` in a program that was killed."""
        if self.dead:
            raise ProgramKilled

    def suspend(self, by_s: float) -> None:
        """Let `by_s` pass at once, as a program sees it that was suspended meanwhile."""
        self.clock.now_s += by_s
        self._timeline.postpone(by_s)
        if self._driven_engine is not None:
            self._driven_engine.suspended(by_s)
