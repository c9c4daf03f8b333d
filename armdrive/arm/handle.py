"""A motion under way: what a call with `wait=False` returns."""

from __future__ import annotations

from typing import Generic, TypeVar

from armdrive.blocking import Wait, blocking, coroutine_of
from armdrive.connect.parts import TaskRunner
from armdrive.errors import WaitTimeout
from armdrive.errors.arguments import BASIC, checked_calls
from armdrive.tasks import Task

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


@checked_calls(BASIC)
class Handle(Generic[T_co]):
    """A motion under way, from a call with `wait=False`."""

    def __init__(self, runner: TaskRunner, task: Task[T_co], timeout_s: float) -> None:
        self._runner = runner
        self._task = task
        self._timeout_s = timeout_s

    @property
    def done(self) -> bool:
        """Whether the motion has ended, well or not."""
        return self._task.done

    @blocking
    async def wait(self, timeout_s: float | None = None) -> T_co:
        """Wait for the end and return what was done, or raise what went wrong.

        Raises `WaitTimeout` after `timeout_s`; the motion goes on. Without a timeout the wait
        still ends: its deadline is computed from the motion, and passing it stops the arm.
        """
        if timeout_s is None:
            return await self._runner.finish(self._task, self._timeout_s)
        if not await Wait(self._runner.pace, lambda: self._task.done, timeout_s):
            raise WaitTimeout(f"the motion had not ended after {timeout_s:g} s")
        return self._task.result()

    @blocking
    async def cancel(self) -> None:
        """Stop the motion."""
        if not self._task.done:
            await self._runner.stop()


async def finished(handle: Handle[T]) -> T:
    """Wait for the end of a motion; see `Handle.wait`."""
    return await coroutine_of(handle.wait)()
