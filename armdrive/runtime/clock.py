"""Clocks: real time, with a thread that calls the engine, and simulated time without a thread.

Simulated time passes only while a caller waits. Each turn advances every engine on the clock and
then jumps to the earliest of their deadlines, so that several arms move together, in the same way
in every run.
"""

from __future__ import annotations

import math
import os
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import FrameType, TracebackType
from typing import Any, Protocol, Self

from armdrive.errors import ArmError, BadRequest
from armdrive.errors.arguments import known_attributes
from armdrive.errors.kinematic import checked_number
from armdrive.runtime.engine import Engine
from armdrive.status import NEVER_WOKEN, SchedulingJitter

# Signals that end a program, delayed while a simulated engine takes a step.
#
# On simulated time the engine runs on the waiting thread, where Python also calls signal handlers,
# and these often raise. An engine interrupted in the middle of a step could send a motion twice, or
# wait for an answer that it has already received. A step takes a fraction of a millisecond.

_ENDING = ("SIGINT", "SIGTERM", "SIGHUP")


class SignalsBetweenSteps:
    """A context in which the handlers of ending signals run only at `deliver` and at its end.

    Only the main thread receives signals: on any other thread the context does nothing. A handler
    that raises while the context begins or ends may leave `_note` in place of another signal's
    handler. Outside the context `_note` therefore calls that handler.
    """

    def __init__(self) -> None:
        self._handlers: dict[int, Callable[[int, FrameType | None], Any]] = {}
        self._pending: list[int] = []
        self._deferring = False

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for name in _ENDING:
                number = getattr(signal, name, None)  # Windows has no SIGHUP
                handler = signal.getsignal(number) if number is not None else None
                if number is not None and callable(handler):
                    self._handlers[number] = handler
                    signal.signal(number, self._note)
        self._deferring = True
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._deferring = False
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self.deliver()

    def deliver(self) -> None:
        """Call the handlers of the pending signals; errors that they raise are raised here."""
        while self._pending:
            number = self._pending.pop(0)
            self._handlers[number](number, None)

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self._deferring:
            self._pending.append(number)
        else:
            self._handlers[number](number, frame)


STUCK_TURNS = 20_000  # more turns within `STUCK_S` of simulated time are a bug; tens are normal
STUCK_S = 1e-6


@known_attributes
class SimulatedClock:
    """Simulated time, `now_s`, for one arm or several: `Arm.connect("sim:grbl", pace=clock)`.

    While a caller waits for any arm, time passes for all of them. `lock` is held during a turn. If
    several threads wait at once, each of them advances the clock, and runs are not repeatable.
    """

    def __init__(self, now_s: float = 0.0) -> None:
        self.lock = threading.RLock()
        self.now_s = checked_number("now_s", now_s)
        self.engines: tuple[Engine, ...] = ()
        """The engines on this clock, in the order in which they were added."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.now_s:g})"

    def add(self, engine: Engine) -> None:
        """Put an engine on this clock."""
        with self.lock:
            self.engines = (*self.engines, engine)

    def remove(self, engine: Engine) -> None:
        """Take an engine off this clock."""
        with self.lock:
            self.engines = tuple(each for each in self.engines if each is not engine)

    def advance(self) -> float:
        """Advance every engine to the present time; return the earliest of their deadlines."""
        now_s = self.now_s
        if len(self.engines) == 1:
            return self.engines[0].advance(now_s)
        return min([engine.advance(now_s) for engine in self.engines], default=math.inf)

    def wait(self, done: Callable[[], bool], end_s: float, there: Callable[[], bool]) -> bool:
        """Jump from deadline to deadline until `done()`, and return True.

        Return False at `end_s`, or when `there()` becomes false. Raises `ArmError` if no deadline
        is left, or if time does not pass.
        """
        progress = ClockProgress(self)
        with SignalsBetweenSteps() as signals:
            while not done():
                with self.lock:
                    if not there():
                        return False
                    # The present moment is finished before time moves on, so that what is due at
                    # `end_s` still happens.
                    next_s = self.advance()
                    if done():
                        break
                    if self.now_s >= end_s:
                        return False
                    progress.jump(next_s, end_s)
                signals.deliver()
        return True


class ClockProgress:
    """The jumps of a clock during one wait, with a check that time passes."""

    def __init__(self, clock: SimulatedClock) -> None:
        self._clock = clock
        self._since_s, self._turns = clock.now_s, 0

    def jump(self, next_s: float, end_s: float) -> None:
        """Jump to the next deadline, at most to `end_s`."""
        clock = self._clock
        if math.isinf(next_s) and math.isinf(end_s):
            raise ArmError("the simulated arm has nothing left to do")
        if len(clock.engines) == 1:  # several would have to stop at each other's deadlines
            engine = clock.engines[0]
            driver_s = min(engine.due_s, end_s)
            if next_s < driver_s:  # only the device has something to do before then
                next_s = engine.link.run(driver_s)
        clock.now_s = max(clock.now_s, min(next_s, end_s))  # a deadline may lie in the past
        self._turns += 1
        if clock.now_s > self._since_s + STUCK_S:
            self._since_s, self._turns = clock.now_s, 0
        elif self._turns > STUCK_TURNS:
            last = ", ".join(f"`{each.last_sent}`" for each in clock.engines)
            raise ArmError(
                f"simulated time is stuck at {clock.now_s:.6f} s: a deadline always lies in the "
                f"past, after {last} was sent. This is a bug in armdrive: please report it"
            )


# Paces: what calls an arm's engine.
#
# `RealPace` runs a thread that sleeps on the wire until the engine's next deadline. `SimulatedPace`
# has no thread: a waiting call advances the engines and jumps from deadline to deadline, so that a
# script runs as fast as the computer allows.

LONGEST_SLEEP_S = 0.25  # the real-time thread calls the engine at least this often
LONGEST_STEP_S = 0.1  # an accelerated clock runs ahead of its engine by this much real time at most

# A round longer than this means that the program or the computer was suspended: stop any motion.
#
# The planned sleep counts towards the round, because the wire may have ended it early.
SUSPENDED_S = 1.0


class Pace(Protocol):
    """Calls an engine as time passes. Hold `lock` while using anything that the engine owns."""

    lock: threading.RLock
    scheduling_jitter: SchedulingJitter

    @property
    def real_time(self) -> bool:
        """Whether time passes by itself, and not only while a caller waits."""

    def now_s(self) -> float:
        """Return the arm's own time in seconds, from an arbitrary start."""

    def start(self, engine: Engine) -> None:
        """Start calling an engine."""

    def wait(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Let time pass until `done()`; return False if the timeout comes first."""

    def wake(self) -> None:
        """Make the engine look for new requests at once; may be called from any thread."""

    def close(self) -> None:
        """Stop calling the engine."""


class SimulatedPace:
    """Simulated time, which passes only while a caller waits. Several arms may share a clock."""

    real_time = False

    def __init__(self, clock: SimulatedClock | None = None) -> None:
        self.clock = clock or SimulatedClock()
        self.lock = self.clock.lock
        self.scheduling_jitter = NEVER_WOKEN
        self._engine: Engine | None = None

    def now_s(self) -> float:
        """Return the simulated time."""
        return self.clock.now_s

    def start(self, engine: Engine) -> None:
        """Start calling an engine."""
        self._engine = engine
        self.clock.add(engine)

    def wait(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Jump from deadline to deadline until `done()` or the time is over."""
        end_s = self.clock.now_s + timeout_s
        return self.clock.wait(done, end_s, self.driving)

    def wake(self) -> None:
        """Call the engine at the next thing that the device does."""
        if self._engine is not None:
            self._engine.link.wake()

    def close(self) -> None:
        """Stop calling the engine."""
        engine, self._engine = self._engine, None
        if engine is not None:
            self.clock.remove(engine)

    def driving(self) -> bool:
        """Return whether the pace has an engine: False before `start` and after `close`."""
        return self._engine is not None


def _drivable(engine: Engine) -> bool:
    """Return whether an engine has a link, or a way to reconnect a lost one."""
    return engine.broken is None or engine.reconnect is not None


@dataclass(frozen=True, slots=True)
class _Mark:
    """A moment on the arm's clock and on the computer's; `driven` while the thread runs."""

    arm_s: float
    real_s: float
    driven: bool = False


class RealPace:
    """Real time: a thread advances the engine by the monotonic clock and sleeps in between."""

    real_time = True

    def __init__(self, *, speed: float = 1.0) -> None:
        """Create a pace; `speed` makes an in-process simulated arm's clock run faster."""
        self.lock = threading.RLock()
        self.scheduling_jitter = NEVER_WOKEN
        self._speed = speed
        self._mark = _Mark(0.0, time.monotonic())
        self._waiting: list[threading.Lock] = []
        """What each waiting call sleeps on: released after every round of the engine's thread."""
        self._engine: Engine | None = None
        self._thread: threading.Thread | None = None
        self._failure: BaseException | None = None

    def now_s(self) -> float:
        """Return the monotonic time since the start, times the speed.

        An accelerated clock waits for its engine. Otherwise minutes of simulated time could pass
        without a call of the engine whenever the computer is busy for a moment.
        """
        return self._shown_s(time.monotonic())

    def _shown_s(self, real_s: float) -> float:
        """Return the arm's time at a moment of the computer's clock."""
        mark = self._mark
        passed_s = real_s - mark.real_s
        if self._speed > 1.0 and mark.driven:
            passed_s = min(passed_s, LONGEST_STEP_S)
        return mark.arm_s + passed_s * self._speed

    def start(self, engine: Engine) -> None:
        """Start a thread that calls the engine."""
        self._engine = engine
        engine.asleep_s, engine.round_s = self._asleep_s, self._lasted_s
        engine.process = os.getpid()
        self._thread = threading.Thread(target=self._drive, name="armdrive", daemon=True)
        self._thread.start()

    def wait(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Sleep until `done()`, or return False at the timeout.

        A signal handler may raise at any moment of it. So it sleeps on a plain lock: a `Condition`
        that is interrupted may keep its lock from the engine's thread, or release it twice.
        """
        end_s = self.now_s() + timeout_s
        round_ended = threading.Lock()
        round_ended.acquire()
        try:
            self._waiting.append(round_ended)
            while True:
                with self.lock:
                    if done():
                        return True
                    if self._failure is not None:
                        raise ArmError(f"the engine's thread ended: {self._failure}")
                left_s = (end_s - self.now_s()) / self._speed
                if left_s <= 0.0:
                    return False
                # a bounded sleep, because Windows does not interrupt an endless one at Ctrl-C
                round_ended.acquire(timeout=min(left_s, LONGEST_SLEEP_S))
        finally:
            if round_ended in self._waiting:
                self._waiting.remove(round_ended)

    def _wake_waiting(self) -> None:
        for round_ended in tuple(self._waiting):
            if round_ended.locked():
                round_ended.release()

    def wake(self) -> None:
        """End the thread's sleep."""
        engine = self._engine
        if engine is not None:
            engine.link.wake()

    def close(self) -> None:
        """End the thread. The device ends by itself what it was sent."""
        engine, self._engine = self._engine, None
        if engine is not None:
            engine.link.wake()
        thread, self._thread = self._thread, None
        # a callback of the engine may close its own arm; a thread cannot wait for itself
        if thread is not None and thread is not threading.current_thread():
            thread.join(timeout=2.0)

    def _asleep_s(self) -> float:
        """Return how long the current round has been suspended; 0 in a normal round."""
        round_s = self._lasted_s()
        return round_s if round_s > SUSPENDED_S else 0.0

    def _lasted_s(self) -> float:
        """Return the duration of the current round so far."""
        return time.monotonic() - self._mark.real_s

    def _drive(self) -> None:
        began_s, pause_s = time.monotonic(), 0.0
        try:
            while (engine := self._engine) is not None and _drivable(engine):
                # measured from round to round: a suspension may fall anywhere between two
                last_s, began_s = began_s, time.monotonic()
                round_s = began_s - last_s
                with self.lock:
                    self._set_mark(driven=True)
                    if round_s > SUSPENDED_S:
                        engine.suspended(round_s - pause_s)
                    next_s = engine.advance(self.now_s())
                self._wake_waiting()
                longest_s = LONGEST_SLEEP_S if self._speed <= 1.0 else LONGEST_STEP_S / 2
                pause_s = min((next_s - self.now_s()) / self._speed, longest_s)
                pause_s = max(pause_s, 0.0)
                if self._asleep_s():
                    pause_s = 0.0  # this round was suspended: call the engine again at once
                if pause_s > 0.0:
                    self._rest(engine, pause_s)
        except BaseException as failure:
            self._failure = failure
            self._wake_waiting()
        finally:
            self._set_mark(driven=False)

    def _set_mark(self, *, driven: bool) -> None:
        real_s = time.monotonic()  # read once: the arm's clock would lose time between two readings
        self._mark = _Mark(self._shown_s(real_s), real_s, driven)

    def _rest(self, engine: Engine, pause_s: float) -> None:
        """Sleep on the wire; if the deadline ended the sleep, record how late the wake-up was."""
        due_s = time.monotonic() + pause_s
        engine.link.wait(pause_s)
        late_s = time.monotonic() - due_s
        if 0.0 <= late_s <= SUSPENDED_S:  # earlier: data arrived; later: a suspension
            self.scheduling_jitter = self.scheduling_jitter.after(late_s)


# The argument `pace=` of a connection.

# One of "simulated", "real", a factor of real time, a clock, or None.
#
# None means simulated time of the arm's own; for an `AsyncArm`, the time of its event loop.
PaceChoice = str | float | SimulatedClock | None


def pace_of(choice: PaceChoice) -> Pace:
    """Return the pace for a simulated arm. Raises `BadRequest`."""
    if isinstance(choice, SimulatedClock):
        return SimulatedPace(choice)
    if choice is None or choice == "simulated":
        return SimulatedPace()
    if choice == "real":
        return RealPace()
    if isinstance(choice, int | float) and choice > 0:
        return RealPace(speed=float(choice))
    raise BadRequest(
        'pace must be "simulated", "real", a factor of real time or a SimulatedClock, '
        f"not {choice!r}"
    )
