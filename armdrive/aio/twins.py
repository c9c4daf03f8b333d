"""How a call becomes its async twin, with the same name and the same typed signature."""

from __future__ import annotations

import functools
from collections.abc import Callable, Coroutine
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar

from armdrive.aio.handle import AsyncHandle
from armdrive.aio.stage import stage
from armdrive.arm import Arm
from armdrive.handle import Handle

S = TypeVar("S", covariant=True)
R = TypeVar("R")
P = ParamSpec("P")


class Twin(Generic[S]):
    """The async twin of an arm or of a part of it. `sync` is what it is the twin of."""

    def __init__(self, sync: S, arm: Arm) -> None:
        self.sync = sync
        self._arm = arm

    async def carry(self, call: Callable[[], R]) -> R:
        """Carry out a call; cancelling it stops the arm."""
        return await stage().carry(call, self._arm)


def awaited(
    method: Callable[Concatenate[S, P], R],
) -> Callable[Concatenate[Twin[S], P], Coroutine[Any, Any, R]]:
    """Make the twin of a call that waits for the arm, or takes long to compute."""

    @functools.wraps(method)
    async def call(self: Twin[S], /, *words: P.args, **named: P.kwargs) -> R:
        return await self.carry(functools.partial(method, self.sync, *words, **named))

    return call


def begun(
    method: Callable[Concatenate[S, P], Handle[R]],
) -> Callable[Concatenate[Twin[S], P], Coroutine[Any, Any, AsyncHandle[R]]]:
    """Make the twin of a call that begins a motion and returns its handle."""

    @functools.wraps(method)
    async def call(self: Twin[S], /, *words: P.args, **named: P.kwargs) -> AsyncHandle[R]:
        handle = await self.carry(functools.partial(method, self.sync, *words, **named))
        return AsyncHandle(handle, self.carry)

    return call


def at_once(
    method: Callable[Concatenate[S, P], R],
) -> Callable[Concatenate[Twin[S], P], R]:
    """Make the twin of a call that never waits: it is the same call, and is not awaited."""

    @functools.wraps(method)
    def call(self: Twin[S], /, *words: P.args, **named: P.kwargs) -> R:
        return method(self.sync, *words, **named)

    return call
