"""Who calls the engine, and by which clock: a thread in real time, or whoever waits.

Simulated time passes only while one waits. Each turn has every engine do what is due by now, and
then jumps to the earliest moment at which one of them wants to go on: several arms move side by
side, in the same way every time.
"""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import FrameType, TracebackType
from typing import Any, Protocol, Self

from armdrive.errors import ArmError, BadRequest
from armdrive.runtime.engine import Engine
from armdrive.status import Lateness
from armdrive.transports.in_process import MemoryLink

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
        engines = clock.engines
        if len(engines) == 1 and isinstance(link := engines[0].link, MemoryLink):
            alone_s = min(engines[0].due_s, end_s)
            if next_s < alone_s:  # the device wants to go on, and its driver does not
                next_s = link.run(alone_s)
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


# Who calls the engine, and by which clock: a thread in real time, or whoever waits.
#
# `RealPace` runs one thread that sleeps on the wire until the engine's next deadline.
# `SimulatedPace` has no thread: a call that waits drives the engines on its clock and jumps from
# deadline to deadline, so that a script runs as fast as the computer can.

LONGEST_SLEEP_S = 0.25
"""The real-time thread looks around at least this often."""

LONGEST_STEP_S = 0.1
"""An accelerated clock advances by so much real time at most until its engine has seen it."""

ABSENT_S = 1.0
"""A round that took so long was suspended, or its computer was: what moves then is stopped.

The sleep that it had meant to take counts as well: the wire may have ended that early.
"""


class Pace(Protocol):
    """Drives an engine through time. Hold `lock` while touching what the engine owns."""

    lock: threading.RLock
    lateness: Lateness

    def now_s(self) -> float:
        """Return the arm's own time in seconds, from an arbitrary start."""

    def start(self, engine: Engine) -> None:
        """Begin to drive an engine."""

    def wait(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Let time pass until `done()`; False when the time is over first."""

    def wake(self) -> None:
        """Have the engine look at what was asked of it, from any thread."""

    def close(self) -> None:
        """Stop driving."""


class SimulatedPace:
    """An arm's place in simulated time, which passes only while somebody waits.

    As fast as the engines get through it. Several arms may live on one clock.
    """

    def __init__(self, clock: SimulatedClock | None = None) -> None:
        self.clock = clock or SimulatedClock()
        self.lock = self.clock.lock
        self.lateness = Lateness()
        self._engine: Engine | None = None

    @property
    def _now_s(self) -> float:
        return self.clock.now_s

    @_now_s.setter
    def _now_s(self, now_s: float) -> None:
        self.clock.now_s = now_s

    def now_s(self) -> float:
        """Return the simulated time."""
        return self.clock.now_s

    def start(self, engine: Engine) -> None:
        """Begin to drive an engine."""
        self._engine = engine
        self.clock.add(engine)

    def wait(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Jump from deadline to deadline until `done()` or the time is over."""
        end_s = self.clock.now_s + timeout_s
        return self.clock.wait(done, end_s, self.driving)

    def wake(self) -> None:
        """Have the engine take a turn at what the device does next."""
        if self._engine is not None:
            self._engine.link.wake()

    def close(self) -> None:
        """Let go of the engine."""
        engine, self._engine = self._engine, None
        if engine is not None:
            self.clock.remove(engine)

    def driving(self) -> bool:
        """Return whether it has an engine to drive: False before `start` and after `close`."""
        return self._engine is not None


def _drivable(engine: Engine) -> bool:
    """Tell whether an engine has anything left to do: a wire, or somebody who looks for it."""
    return engine.broken is None or engine.reconnect is not None


@dataclass(frozen=True, slots=True)
class _Mark:
    """What an arm's clock showed at a moment; `driven` while a thread drives its engine on."""

    arm_s: float
    real_s: float
    driven: bool = False


class RealPace:
    """A thread that advances the engine by the monotonic clock and sleeps on the wire between."""

    def __init__(self, *, speed: float = 1.0) -> None:
        """`speed` makes an in-process simulated arm's clock run that much faster than real."""
        self.lock = threading.RLock()
        self.lateness = Lateness()
        self._speed = speed
        self._mark = _Mark(0.0, time.monotonic())
        self._turn = threading.Condition(self.lock)
        self._engine: Engine | None = None
        self._thread: threading.Thread | None = None
        self._failure: BaseException | None = None

    def now_s(self) -> float:
        """Return the monotonic time since the start, times the speed.

        A clock that runs faster than real waits for its engine. Else a computer that is busy for
        a moment would let minutes pass on an arm that nobody drives meanwhile.
        """
        return self._shown_s(time.monotonic())

    def _shown_s(self, real_s: float) -> float:
        """Return what the arm's clock shows at a moment of the computer's clock."""
        mark = self._mark
        passed_s = real_s - mark.real_s
        if self._speed > 1.0 and mark.driven:
            passed_s = min(passed_s, LONGEST_STEP_S)
        return mark.arm_s + passed_s * self._speed

    def start(self, engine: Engine) -> None:
        """Begin to drive an engine in a thread of its own."""
        self._engine = engine
        engine.asleep_s, engine.round_s = self._asleep_s, self._lasted_s
        self._thread = threading.Thread(target=self._drive, name="armdrive", daemon=True)
        self._thread.start()

    def wait(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Sleep until `done()` or the time is over."""
        end_s = self.now_s() + timeout_s
        with self._turn:
            while not done():
                if self._failure is not None:
                    raise ArmError(f"the engine's thread ended: {self._failure}")
                left_s = (end_s - self.now_s()) / self._speed
                if left_s <= 0.0:
                    return False
                # a bounded sleep, so that Ctrl-C is seen on every system
                self._turn.wait(min(left_s, LONGEST_SLEEP_S))
        return True

    def wake(self) -> None:
        """End the thread's sleep on the wire."""
        engine = self._engine
        if engine is not None:
            engine.link.wake()

    def close(self) -> None:
        """End the thread; what the device is doing by then is bounded by its last burst."""
        engine, self._engine = self._engine, None
        if engine is not None:
            engine.link.wake()
        thread, self._thread = self._thread, None
        if thread is not None and thread is not threading.current_thread():
            thread.join(timeout=2.0)

    def _asleep_s(self) -> float:
        """Return for how long this very round has stood still; 0 while it goes on as it should."""
        round_s = self._lasted_s()
        return round_s if round_s > ABSENT_S else 0.0

    def _lasted_s(self) -> float:
        """Return how long ago this round began."""
        return time.monotonic() - self._mark.real_s

    def _drive(self) -> None:
        began_s, pause_s = time.monotonic(), 0.0
        try:
            while (engine := self._engine) is not None and _drivable(engine):
                # counted from one round to the next: a suspension may fall anywhere between
                last_s, began_s = began_s, time.monotonic()
                round_s = began_s - last_s
                with self._turn:
                    self._set_mark(driven=True)
                    if round_s > ABSENT_S:
                        engine.absent(round_s - pause_s)
                    next_s = engine.advance(self.now_s())
                    self._turn.notify_all()
                longest_s = LONGEST_SLEEP_S if self._speed <= 1.0 else LONGEST_STEP_S / 2
                pause_s = min((next_s - self.now_s()) / self._speed, longest_s)
                pause_s = max(pause_s, 0.0)
                if self._asleep_s():
                    pause_s = 0.0  # it was suspended in this very round: look at once
                if pause_s > 0.0:
                    self._rest(engine, pause_s)
        except BaseException as failure:
            with self._turn:
                self._failure = failure
                self._turn.notify_all()
        finally:
            self._set_mark(driven=False)

    def _set_mark(self, *, driven: bool) -> None:
        real_s = time.monotonic()  # read once: between two readings the arm's clock would stand
        self._mark = _Mark(self._shown_s(real_s), real_s, driven)

    def _rest(self, engine: Engine, pause_s: float) -> None:
        """Sleep on the wire; where only the deadline ended that, count how late it was."""
        due_s = time.monotonic() + pause_s
        engine.link.wait(pause_s)
        late_s = time.monotonic() - due_s
        if 0.0 <= late_s <= ABSENT_S:  # earlier, the wire had something; later, it was suspended
            self.lateness.add(late_s)


# What `pace=` of a connection may be, and the pace that each of them is.

PaceChoice = str | float | SimulatedClock | SimulatedPace | None
"""What `pace` may be: "simulated", "real", a factor of real time, a clock, or another arm's pace.

Without any, simulated time of the arm's own; of an `AsyncArm`, that of its event loop.
"""


def pace_of(choice: PaceChoice) -> Pace:
    """Return the pace of a simulated arm. Raises `BadRequest`."""
    if isinstance(choice, SimulatedClock):
        return SimulatedPace(choice)
    if isinstance(choice, SimulatedPace):
        return SimulatedPace(choice.clock)
    if choice is None or choice == "simulated":
        return SimulatedPace()
    if choice == "real":
        return RealPace()
    if isinstance(choice, int | float) and choice > 0:
        return RealPace(speed=float(choice))
    raise BadRequest(
        f'pace is "simulated", "real", a factor of real time or a SimulatedClock, not {choice!r}'
    )
