"""Simulated time, and the engines of all arms that live in it. It passes only while one waits.

Each turn has every engine do what is due by now, and then jumps to the earliest moment at which
one of them wants to go on: several arms move side by side, in the same way every time.
"""

from __future__ import annotations

import math
import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, Self

from armdrive.errors import ArmError
from armdrive.runtime.engine import Engine

# Signals that end a program, kept back while a simulated engine takes a step.
#
# On simulated time the engine runs on the thread that waits, and that is where Python calls signal
# handlers, which often raise. An engine torn apart in mid-step would send a motion twice or wait
# for an answer that it has already heard; a step lasts a fraction of a millisecond.

_ENDING = ("SIGINT", "SIGTERM", "SIGHUP")


class SignalsBetweenSteps:
    """While entered, handlers of ending signals run at `deliver` and at the end, nowhere else.

    Only the main thread hears signals: on any other thread this does nothing.
    """

    def __init__(self) -> None:
        self._handlers: dict[int, Callable[[int, FrameType | None], Any]] = {}
        self._heard: list[int] = []

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for name in _ENDING:
                number = getattr(signal, name, None)  # Windows has no SIGHUP
                handler = signal.getsignal(number) if number is not None else None
                if number is not None and callable(handler):
                    self._handlers[number] = handler
                    signal.signal(number, self._note)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self.deliver()

    def deliver(self) -> None:
        """Call the handlers of what has been heard; whatever they raise is raised here."""
        while self._heard:
            number = self._heard.pop(0)
            self._handlers[number](number, None)

    def _note(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002
        self._heard.append(number)


STUCK_TURNS = 20_000
"""So many turns of the engines within `STUCK_S` of simulated time are a flaw; real ones need tens.
"""
STUCK_S = 1e-6


class SimulatedClock:
    """One simulated time for one arm or several: `Arm.connect("sim:robko01", pace=clock)`.

    Whichever arm is waited for, time passes for all of them. `lock` is held while they take a
    turn. Where several threads wait at once, each drives it, and nothing is repeatable any more.
    """

    def __init__(self, now_s: float = 0.0) -> None:
        self.lock = threading.RLock()
        self.now_s = now_s
        self._engines: tuple[Engine, ...] = ()

    @property
    def engines(self) -> tuple[Engine, ...]:
        """The engines that live in this time, in the order in which they came."""
        return self._engines

    def add(self, engine: Engine) -> None:
        """Have an engine live in this time."""
        with self.lock:
            self._engines = (*self._engines, engine)

    def remove(self, engine: Engine) -> None:
        """Let go of an engine; the others go on."""
        with self.lock:
            self._engines = tuple(each for each in self._engines if each is not engine)

    def advance(self) -> float:
        """Have every engine do what is due; return when one wants to be called again."""
        now_s = self.now_s
        if len(self._engines) == 1:
            return self._engines[0].advance(now_s)
        return min([engine.advance(now_s) for engine in self._engines], default=math.inf)

    def wait(self, done: Callable[[], bool], end_s: float, there: Callable[[], bool]) -> bool:
        """Jump from deadline to deadline until `done()`; False at `end_s`, or while not `there()`.

        Raises `ArmError` where nothing is left that could ever happen, or time does not pass.
        """
        progress = ClockProgress(self)
        with SignalsBetweenSteps() as signals:
            while not done():
                with self.lock:
                    if not there():
                        return False
                    next_s = self.advance()
                    if done():
                        break
                    if self.now_s >= end_s:
                        return False
                    progress.jump(next_s, end_s)
                signals.deliver()
        return True


class ClockProgress:
    """Jumps of a clock during one wait, and whether time passes between them."""

    def __init__(self, clock: SimulatedClock) -> None:
        self._clock = clock
        self._since_s, self._turns = clock.now_s, 0

    def jump(self, next_s: float, end_s: float) -> None:
        """Go on to the next deadline, at most to `end_s`."""
        clock = self._clock
        if math.isinf(next_s) and math.isinf(end_s):
            raise ArmError("the simulated arm has nothing left to do")
        clock.now_s = max(clock.now_s, min(next_s, end_s))
        self._turns += 1
        if clock.now_s > self._since_s + STUCK_S:
            self._since_s, self._turns = clock.now_s, 0
        elif self._turns > STUCK_TURNS:
            raise ArmError(_stuck(clock))


def _stuck(clock: SimulatedClock) -> str:
    """Say who wants to go on at once, over and over."""
    guilty = [words for engine in clock.engines if (words := _hurry(engine, clock.now_s))]
    who = guilty or [f"a task {_on(engine)}" for engine in clock.engines]
    return (
        f"simulated time does not pass at {clock.now_s:.6f} s: {'; '.join(who)}. This is a flaw of "
        "armdrive: please report it"
    )


def _hurry(engine: Engine, now_s: float) -> str:
    wanting = {"the wire": engine.link.next_s(), "the controller": engine.controller.next_s()}
    who = [name for name, due_s in wanting.items() if due_s <= now_s + STUCK_S]
    return f"{' and '.join(who)} {_on(engine)}" if who else ""


def _on(engine: Engine) -> str:
    return (
        f"on {engine.link.description} wants to go on at once, again and again; "
        f"`{engine.last_sent}` was sent last"
    )
