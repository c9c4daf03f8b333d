"""Calls that wait for an arm. Each is written once, as a coroutine, and used in two ways.

Such a coroutine awaits nothing but a `Wait`. `blocking` turns the coroutine function into an
ordinary function that blocks its thread. An event loop takes the coroutine itself (`coroutine_of`)
and resumes it after each wait, so that other tasks can run meanwhile (aio/loop.py).
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Coroutine, Generator
from typing import Any, ParamSpec, Protocol, TypeVar, cast

P = ParamSpec("P")
R = TypeVar("R")


class Waiter(Protocol):
    """Waits in the time of one arm, real or simulated."""

    def wait(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Wait until `done()` is true; return False if the timeout passes first."""


class Wait:
    """A wait for `done()`. Awaiting it returns False if `timeout_s` passes first."""

    def __init__(self, pace: Waiter, done: Callable[[], bool], timeout_s: float) -> None:
        self.pace = pace
        self.done = done
        self.timeout_s = timeout_s

    def __await__(self) -> Generator[Wait, bool, bool]:
        return (yield self)

    def block(self) -> bool:
        """Wait on the current thread."""
        return self.pace.wait(self.done, self.timeout_s)


def run_blocking(call: Coroutine[Any, Any, R], wait: Callable[[Wait], bool] = Wait.block) -> R:
    """Run a waiting call to its end on the current thread.

    An exception that interrupts a wait (Ctrl-C, an error in the engine) is raised inside the call,
    where it waits.
    """
    outcome: bool | BaseException | None = None
    while True:
        try:
            outcome = wait(resume(call, outcome))
        except StopIteration as end:
            return cast("R", end.value)
        except BaseException as error:
            if has_ended(call):
                raise
            outcome = error


def resume(call: Coroutine[Any, Any, Any], outcome: bool | BaseException | None) -> Wait:
    """Resume a call with the outcome of its wait, or None to start it; return its next wait.

    When the call returns, raises `StopIteration` with the result. Errors of the call pass through.
    """
    if isinstance(outcome, BaseException):
        return cast("Wait", call.throw(outcome))
    return cast("Wait", call.send(outcome))


def has_ended(call: Coroutine[Any, Any, Any]) -> bool:
    """Return whether a call has returned or raised."""
    return inspect.getcoroutinestate(call) == inspect.CORO_CLOSED


def blocking(function: Callable[P, Coroutine[Any, Any, R]]) -> Callable[P, R]:
    """Turn a coroutine function that waits for an arm into an ordinary function."""

    @functools.wraps(function)
    def call(*words: P.args, **named: P.kwargs) -> R:
        return run_blocking(function(*words, **named))

    return call


def waiting_part(call: Callable[..., Any]) -> Callable[..., Coroutine[Any, Any, Any]] | None:
    """Return the coroutine function inside a function made by `blocking`, else None."""
    function = getattr(call, "__wrapped__", None)
    made = inspect.iscoroutinefunction(function) and not inspect.iscoroutinefunction(call)
    return function if made else None


def coroutine_of(call: Callable[P, R]) -> Callable[P, Coroutine[Any, Any, R]]:
    """Return the coroutine function of a blocking call; wrap any other call as one."""
    function = waiting_part(call)
    if function is not None:
        owner = getattr(call, "__self__", None)
        return function if owner is None else functools.partial(function, owner)

    @functools.wraps(call)
    async def made(*words: P.args, **named: P.kwargs) -> R:
        return call(*words, **named)

    return made
