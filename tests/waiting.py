"""Waiting for another thread, process or terminal: for an observation, never for a time.

This is the only module of the everyday tests that reads the wall clock or sleeps
(`test_independence.py` sees to that). Its one limit ends a hang; it is so long that a busy
computer never reaches it, and no test asserts how long anything took. A bound on a time belongs
in simulated time, or on the clock of the simulated device.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from collections.abc import Awaitable, Callable, Iterator
from typing import Any, TypeVar

LONG_S = 60.0
"""Ends a wait for something that never happens: a hundred times what a busy computer takes."""

LOOK_S = 0.002
"""How often a test looks. Only its speed depends on this."""

T = TypeVar("T")


class NeverHappened(AssertionError):
    """What a test waited for did not happen."""


def looks(what: str = "it never happened") -> Iterator[None]:
    """Yield for each look of a caller who waits; raise `NeverHappened` instead of hanging."""
    end_s = time.monotonic() + LONG_S
    while True:
        yield
        if time.monotonic() > end_s:
            raise NeverHappened(what)
        time.sleep(LOOK_S)


def until(happened: Callable[[], Any], what: str = "it never happened") -> None:
    """Wait until a predicate is true."""
    for _ in looks(what):
        if happened():
            return


def ends(call: Callable[[], T], what: str = "the call never returned") -> T:
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

    thread = threading.Thread(target=run, name="test-waits", daemon=True)
    thread.start()
    thread.join(LONG_S)
    if not outcome:
        raise NeverHappened(what)
    return outcome[0]()


FOREVER_S = 100.0 * LONG_S
"""A time that no test lets pass."""


@contextlib.contextmanager
def meanwhile(call: Callable[[], object]) -> Iterator[None]:
    """Have another thread make a call while the block runs, and join it."""
    thread = threading.Thread(target=call, name="test-meanwhile", daemon=True)
    thread.start()
    try:
        yield
    finally:
        thread.join(LONG_S)
        if thread.is_alive():
            raise NeverHappened("what another thread was asked for never ended")


async def until_seen(
    happened: Callable[[], Any],
    turn: Callable[[], Awaitable[object]],
    what: str = "it was never seen",
) -> None:
    """Let an event loop turn until a predicate is true; `turn` is a pilot's `pause`, say."""
    end_s = time.monotonic() + LONG_S
    while not happened():
        if time.monotonic() > end_s:
            raise NeverHappened(what)
        await turn()
        await asyncio.sleep(LOOK_S)


def _raise(error: BaseException) -> Any:
    raise error
