"""Simulated time that outlives a program, and can end it, jump, or find that it hangs."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable

from armdrive.engine import Engine
from armdrive.pace import SimulatedPace

MOST_TURNS = 20_000
"""An engine that is called so often while no time passes goes round in a circle."""


class Killed(BaseException):
    """The program is no more: SIGKILL, a power cut."""


class Hangs(BaseException):
    """The engine goes round in a circle."""


class Agenda:
    """What happens to the host, at its time."""

    def __init__(self) -> None:
        self._due: list[tuple[float, int, Callable[[], None]]] = []
        self._number = itertools.count()

    @property
    def next_s(self) -> float:
        """When something happens next."""
        return self._due[0][0] if self._due else math.inf

    def at(self, time_s: float, action: Callable[[], None]) -> None:
        """Have something happen."""
        heapq.heappush(self._due, (time_s, next(self._number), action))

    def clear(self) -> None:
        """Have nothing more happen."""
        self._due.clear()

    def pass_to(self, now_s: float) -> None:
        """Have everything happen that is due."""
        while self.next_s <= now_s:
            heapq.heappop(self._due)[2]()


class CampaignPace(SimulatedPace):
    """One program's time, which goes on where the last program's ended."""

    def __init__(self, start_s: float, agenda: Agenda) -> None:
        super().__init__()
        self._now_s = start_s
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
        if self._turns > MOST_TURNS:
            raise Hangs(f"the engine was called {MOST_TURNS} times at {now_s:.3f} s")
        assert self._driven is not None
        now_s = max(self._now_s, now_s)
        if self._driven.broken is not None:
            self.meanwhile(now_s)
        return min(self._driven.advance(now_s), self._agenda.next_s)

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
        self._now_s += by_s
        if self._driven is not None:
            self._driven.absent(by_s)
