"""A motion under way, as a coroutine sees it."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any, Generic, Protocol, TypeVar

from armdrive.handle import Handle

T = TypeVar("T")
R = TypeVar("R")


class Carry(Protocol):
    """Carries a call of an arm out for the event loop."""

    def __call__(self, call: Callable[[], R], /) -> Coroutine[Any, Any, R]:
        """Return what is to be awaited."""
        ...


class AsyncHandle(Generic[T]):
    """A motion under way, from an awaited call with `wait=False`."""

    def __init__(self, sync: Handle[T], carry: Carry) -> None:
        self.sync = sync
        self._carry = carry

    @property
    def done(self) -> bool:
        """Whether the motion has ended, well or not."""
        return self.sync.done

    async def wait(self, timeout_s: float | None = None) -> T:
        """Wait for the end and return what was done, or raise what went wrong.

        Raises `TimeoutError` after `timeout_s` of the arm's own time; the motion goes on. Who
        cancels this wait stops the arm.
        """
        return await self._carry(lambda: self.sync.wait(timeout_s))

    async def cancel(self) -> None:
        """Stop the motion, and wait until the arm stands."""
        await self._carry(self.sync.cancel)
