"""Simulated time that outlives a program, and can end it, jump, or find that it hangs."""

from __future__ import annotations

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

MOST_TURNS = 10_000
"""An engine that is called so often while no time passes goes round in a circle. The simulated
clock finds that out for itself, later, and ends it with an error that looks like a good end."""

CPU_S = 900.0
"""Of this process in one mission. It is no time of day: a busy computer does not shorten it. The
longest missions take a minute; only code that never lets the engine take a turn is ended by it."""

GRACE_S = 5.0
"""A call may end this late to be told by how much; then it hangs."""
CALL_TURNS = 1_000_000
"""Turns of the engine in one call: CAN drives in a pause of ten minutes take 200,000."""
MISSION_TURNS = 4_000_000
MISSION_S = 4 * 3600.0
"""The same for a whole mission, and its simulated time, without that of suspensions."""


class Killed(BaseException):
    """The program is no more: SIGKILL, a power cut."""


class Hangs(BaseException):
    """A call does not end: no time passes, or too much of it."""


@contextmanager
def cpu_limit(most_s: float = CPU_S) -> Iterator[None]:
    """Have `Hangs` raised in what uses up so much of a processor, on the main thread of Unix."""
    there = hasattr(signal, "setitimer")
    if not there or threading.current_thread() is not threading.main_thread():
        yield
        return

    def hangs(_number: int, _frame: FrameType | None) -> None:
        raise Hangs(f"the driver has computed for {most_s:g} s of processor time")

    before = signal.signal(signal.SIGVTALRM, hangs)
    # and again, until the driver has let go: it may want to stop the arm first
    signal.setitimer(signal.ITIMER_VIRTUAL, most_s, most_s / 10.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


class Agenda:
    """What happens to the host, at its time."""

    def __init__(self) -> None:
        self._due: TimeQueue[Callable[[], None]] = TimeQueue()
        self.patience = Patience()

    @property
    def next_s(self) -> float:
        """When something happens next."""
        return self._due.next_s

    def at(self, time_s: float, action: Callable[[], None]) -> None:
        """Have something happen."""
        self._due.put(time_s, action)

    def clear(self) -> None:
        """Have nothing more happen."""
        self._due.clear()

    def pass_to(self, now_s: float) -> None:
        """Have everything happen that is due."""
        for action in self._due.due(now_s):
            action()


class Patience:
    """How long a mission and the call that it is at may last: in simulated time, and in turns."""

    def __init__(self) -> None:
        self._call = ""
        self._turns = self._call_turns = 0
        self._until_s, self._mission_until_s = math.inf, MISSION_S

    def begin(self, call: str, until_s: float) -> None:
        """Hear of a call, and when it has to have ended."""
        self._call, self._until_s, self._call_turns = call, until_s + GRACE_S, 0

    def end(self) -> None:
        """Hear that the call has ended."""
        self._call, self._until_s, self._call_turns = "", math.inf, 0

    def postpone(self, by_s: float) -> None:
        """Hear of time in which the program was suspended."""
        self._until_s += by_s
        self._mission_until_s += by_s

    def turn(self, now_s: float) -> None:
        """Count a turn of the engine. Raises `Hangs`."""
        self._turns += 1
        self._call_turns += 1
        late = now_s > min(self._until_s, self._mission_until_s)
        if late or self._call_turns > CALL_TURNS or self._turns > MISSION_TURNS:
            raise Hangs(
                f"{self._call or 'the mission'} had not ended at {now_s:.1f} s, after "
                f"{self._call_turns} turns of the engine in this call and {self._turns} in all"
            )


class CampaignPace(SimulatedPace):
    """One program's time, which goes on where the last program's ended."""

    def __init__(self, start_s: float, agenda: Agenda) -> None:
        super().__init__(SimulatedClock(start_s))
        self._agenda = agenda
        self._driven: Engine | None = None
        self._turns = 0
        self._turned_s = -math.inf
        self.dead = False
        self.dying: Callable[[], None] = lambda: None
        """Called once when the program is killed."""
        self.meanwhile: Callable[[float], None] = lambda _: None
        """The world, which goes on also where no wire leads to it."""

    def start(self, engine: Engine) -> None:
        """Begin to drive an engine: it is this pace that is called in its place."""
        self._driven = engine
        super().start(self)  # type: ignore[arg-type]

    def advance(self, now_s: float) -> float:
        """Let happen what is due, then the engine's turn."""
        self.live()
        self._agenda.pass_to(now_s)
        self.live()
        self._turns = self._turns + 1 if now_s <= self._turned_s else 0
        self._turned_s = now_s
        self._agenda.patience.turn(now_s)
        if self._turns > MOST_TURNS:
            raise Hangs(f"the engine was called {MOST_TURNS} times at {now_s:.3f} s")
        assert self._driven is not None
        now_s = max(self.clock.now_s, now_s)
        if self._driven.broken is not None:
            self.meanwhile(now_s)
        return min(self._driven.advance(now_s), self._agenda.next_s)

    due_s = -math.inf
    """As an engine, it takes a turn at everything that a device does."""

    @property
    def link(self) -> Link:
        """The wire of the engine."""
        assert self._driven is not None
        return self._driven.link

    def close(self) -> None:
        """Let go of the engine, and with it of all that the program had in memory."""
        super().close()
        self._driven = None

    def die(self) -> None:
        """End the program, whatever it is at; it goes as soon as it takes its next step."""
        if not self.dead:
            self.dying()
            self.dead = True

    def live(self) -> None:
        """Raise `Killed` in a program that has ended."""
        if self.dead:
            raise Killed

    def jump(self, by_s: float) -> None:
        """Let time pass while the program was suspended, as a thread in real time sees it."""
        self.clock.now_s += by_s
        self._agenda.patience.postpone(by_s)
        if self._driven is not None:
            self._driven.suspended(by_s)
