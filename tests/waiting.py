"""Waiting for another thread, process or terminal: for an observation, never for a time.

This is the only module of the everyday tests that reads the wall clock or sleeps
(`test_independence.py` sees to that). Its one limit ends a hang; it is so long that a busy
computer never reaches it, and no test asserts how long anything took. Check bounds on times in
simulated time, or by the clock of the simulated device.
"""

import asyncio
import threading
import time
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from pathlib import Path
from typing import Any, TypeVar

LONG_S = 60.0
"""Ends a wait for something that never happens: a hundred times what a busy computer takes."""

LOOK_S = 0.01
"""How often a test looks. Only its speed depends on this: a look often asks another thread."""

AGAIN_S = 0.5
"""The time between two attempts: longer than any keyboard takes to repeat a key."""

T = TypeVar("T")


class NeverHappened(AssertionError):
    """What a test waited for did not happen."""


def looks(what: str = "it never happened", every_s: float = LOOK_S) -> Iterator[None]:
    """Yield for each look of a caller who waits; raise `NeverHappened` instead of hanging.

    Leave the loop when the event is seen. Use a larger `every_s` if a look is expensive.
    """
    end_s = time.monotonic() + LONG_S
    while True:
        yield
        if time.monotonic() > end_s:
            raise NeverHappened(what)
        time.sleep(every_s)


def until(happened: Callable[[], Any], what: str = "it never happened") -> None:
    """Wait until a predicate is true."""
    for _ in looks(what):
        if happened():
            return


def tried(
    attempt: Callable[[], object],
    happened: Callable[[], Any],
    what: str,
    every_s: float = LOOK_S,
) -> None:
    """Repeat an attempt until it is seen to have worked.

    Use it for requests that a busy program may rightly ignore, such as a key that comes too late.
    """
    again_s = -1.0
    for _ in looks(what, every_s):
        if happened():
            return
        if time.monotonic() > again_s:
            attempt()
            again_s = time.monotonic() + AGAIN_S


def at_last(
    attempt: Callable[[], T],
    fix: Callable[[], object],
    late: type[BaseException] | tuple[type[BaseException], ...],
) -> T:
    """Repeat an attempt until it succeeds, and return its result; call `fix` before each new one.

    Use it for real-time conversations with a simulated device: a busy computer may delay one side
    for longer than the other one rightly waits.
    """
    failed = False
    for _ in looks("it never succeeded"):
        try:
            if failed:
                fix()
            return attempt()
        except late:
            failed = True
    raise NeverHappened


def returns(call: Callable[[], T], what: str = "the call never returned") -> T:
    """Return what a call returns, or raise what it raises; fail if it hangs.

    Give the call itself a wait of `FOREVER_S`: that it returns proves that something ended it.
    """
    outcome: list[Callable[[], T]] = []

    def run() -> None:
        try:
            returned = call()
        except BaseException as error:
            raised = error
            outcome.append(lambda: _raise(raised))
        else:
            outcome.append(lambda: returned)

    thread = threading.Thread(target=run, name="test-returns", daemon=True)
    thread.start()
    thread.join(LONG_S)
    if not outcome:
        raise NeverHappened(what)
    return outcome[0]()


FOREVER_S = 100.0 * LONG_S
"""A time that no test lets pass."""


async def ends(talk: Coroutine[Any, Any, T]) -> T:
    """Return what a coroutine returns; fail if it hangs."""
    return await asyncio.wait_for(talk, LONG_S)


async def until_seen(
    happened: Callable[[], Any],
    turn: Callable[[], Awaitable[object]],
    what: str = "it was never seen",
) -> None:
    """Let an event loop turn until a predicate is true; `turn` may be a pilot's `pause`."""
    end_s = time.monotonic() + LONG_S
    while not happened():
        if time.monotonic() > end_s:
            raise NeverHappened(what)
        await turn()
        await asyncio.sleep(LOOK_S)


def _raise(error: BaseException) -> Any:
    raise error


def soon(call: Callable[..., object], *args: object) -> threading.Thread:
    """Have another thread make a call a moment later; return that thread.

    Use it only if the test holds whichever comes first, the call or the code that follows here. The
    delay only makes it likely that the thread to be woken already sleeps.
    """
    timer = threading.Timer(2.0 * LOOK_S, call, args)
    timer.daemon = True
    timer.start()
    return timer


TURN_S = 0.1
"""The time that passes between two turns of a device at most: a third of the shortest timeout."""


class PatientClock:
    """The computer's clock, which waits for a device that a busy computer keeps from its turn.

    So no timeout of a driver ends before the device had several turns to answer. Without a device
    this is `time.monotonic`. It never goes back.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._waited_s = 0.0
        self._turns: dict[threading.Thread, float] = {}
        """When each device had its latest turn."""

    def wait_for(self, device: threading.Thread) -> None:
        """Wait for the turns of this thread, as long as it is alive."""
        with self._lock:
            self._turns[device] = self._now_s()

    def monotonic(self) -> float:
        """Return the time in s; in the thread of a device this is one of its turns."""
        with self._lock:
            now_s, thread = self._now_s(), threading.current_thread()
            if thread in self._turns:
                self._turns[thread] = now_s
            return now_s

    def _now_s(self) -> float:
        self._turns = {device: s for device, s in self._turns.items() if device.is_alive()}
        now_s = time.monotonic() - self._waited_s
        latest_s = min(self._turns.values(), default=now_s) + TURN_S
        self._waited_s += max(now_s - latest_s, 0.0)
        return min(now_s, latest_s)


def suspended(pid: int) -> bool:
    """Return whether a process of this computer is stopped, as by SIGSTOP (Linux only)."""
    text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
    return text.rpartition(")")[2].split()[0] == "T"
