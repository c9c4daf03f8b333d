"""The parts of the async classes: the generated methods, and the connection of an arm."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Coroutine, Generator
from dataclasses import replace
from types import TracebackType
from typing import Any, Generic, Protocol, Self, TypeVar

from armdrive.aio.loop import loop_context
from armdrive.arm import Arm, connected, connections_overridden
from armdrive.arm.connected import Handle
from armdrive.blocking import coroutine_of, waiting_part
from armdrive.connect.parts import ConnectOptions
from armdrive.connect.target import DEFAULT_TARGET, SIM, simulation_forced
from armdrive.errors.arguments import BASIC, checked_calls, known_attributes, made_of
from armdrive.runtime.clock import PaceChoice

R = TypeVar("R")
S = TypeVar("S", covariant=True)
C = TypeVar("C", bound=type)
T_co = TypeVar("T_co", covariant=True)


class Carry(Protocol):
    """Runs a call of an arm for the event loop."""

    def __call__(self, call: Coroutine[Any, Any, R], /) -> Coroutine[Any, Any, R]:
        """Return a coroutine that the event loop can run."""
        ...


@known_attributes
@checked_calls(BASIC)
class AsyncHandle(Generic[T_co]):
    """A running motion, returned by an awaited call with `wait=False`."""

    def __init__(self, sync: Handle[T_co], carry: Carry) -> None:
        self.sync = sync
        self._carry = carry

    def __repr__(self) -> str:
        return f"<Async{repr(self.sync)[1:]}"

    @property
    def done(self) -> bool:
        """Whether the motion has ended, successfully or not."""
        return self.sync.done

    async def wait(self, timeout_s: float | None = None) -> T_co:
        """Wait for the end of the motion; return its result or raise its error.

        Raises `WaitTimeout` after `timeout_s` of the arm's own time; the motion continues.
        Cancelling this wait stops the arm.
        """
        return await self._carry(coroutine_of(self.sync.wait)(timeout_s))

    async def cancel(self) -> None:
        """Stop the motion, and wait until the arm stands."""
        await self._carry(coroutine_of(self.sync.cancel)())


class AsyncCalls(Generic[S]):
    """The async version of an arm or of one of its parts; `sync` is the original object."""

    def __init__(self, sync: S, arm: Arm) -> None:
        self.sync = sync
        self._arm = arm

    def __repr__(self) -> str:
        return f"<Async{repr(self.sync)[1:]}"

    async def carry(self, call: Coroutine[Any, Any, R]) -> R:
        """Run a call; cancelling it stops the arm."""
        return await loop_context().carry(call, self._arm)


# The async version of each call follows from the way the call is written.

# Calls that never wait: their async versions are not awaited.
AT_ONCE = frozenset(("estop", "log", "pause", "pose_in", "request", "request_stop", "resume"))

# Calls that do not wait for an arm, but compute or write for a while, and so are awaited too.
LONG = frozenset(("preview", "save", "start"))


def twin_of(kind: type) -> Callable[[C], C]:
    """Add the async version of each public call and property of `kind` that a class lacks.

    A call that waits for the arm is awaited. Raises `LookupError` for a call that is neither
    blocking nor listed in AT_ONCE or LONG.
    """

    def decorate(twin: C) -> C:
        for name, found in vars(kind).items():
            if name.startswith("_") or hasattr(twin, name):
                continue
            if isinstance(found, property):
                setattr(twin, name, _same_property(name, found))
            elif inspect.isfunction(found):
                setattr(twin, name, _twin_call(found))
        return twin

    return decorate


def _same_property(name: str, found: property) -> property:
    def get(self: AsyncCalls[Any]) -> Any:
        return getattr(self.sync, name)

    def put(self: AsyncCalls[Any], value: object) -> None:
        setattr(self.sync, name, value)

    return property(get, put if found.fset else None, doc=found.__doc__)


def _twin_call(method: Callable[..., Any]) -> Callable[..., Any]:
    if method.__name__ in AT_ONCE:

        @functools.wraps(method)
        def at_once(self: AsyncCalls[Any], /, *words: Any, **named: Any) -> Any:
            return method(self.sync, *words, **named)

        return at_once

    if method.__name__ not in LONG and waiting_part(method) is None:
        raise LookupError(
            f"{method.__name__}: make the call `blocking`, or list it in AT_ONCE or LONG"
        )
    function = coroutine_of(method)

    @functools.wraps(method)
    async def awaited(self: AsyncCalls[Any], /, *words: Any, **named: Any) -> Any:
        result = await self.carry(function(self.sync, *words, **named))
        return AsyncHandle(result, self.carry) if isinstance(result, Handle) else result

    return awaited


# Connecting and closing an arm.


class AsyncConnection(AsyncCalls[Arm]):
    """A connected arm, which `async with` enables and closes."""

    def __init__(self, sync: Arm) -> None:
        """Wrap a connected arm."""
        made_of(Arm, "a connected arm", f'AsyncArm.connect("{DEFAULT_TARGET}")')("sync", sync)
        super().__init__(sync, sync)

    async def __aenter__(self) -> Self:
        await self.carry(coroutine_of(self.sync.__enter__)())
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Stop, save the position, and release the port, even if the task is cancelled."""
        await loop_context().close(self.sync)


A = TypeVar("A", bound=AsyncConnection)


class Connecting(Generic[A]):
    """A pending connection: `await` it for the arm, or use it in `async with` to close it too."""

    def __init__(
        self, made: Callable[[Arm], A], target: str | None, options: ConnectOptions
    ) -> None:
        """`made` wraps the connected arm in its async version."""
        self._made = made
        self._target = target
        self._options = options
        self._arm: A | None = None

    def __await__(self) -> Generator[Any, None, A]:
        return self._connected().__await__()

    async def __aenter__(self) -> A:
        self._arm = await self._connected()
        return await self._arm.__aenter__()  # closes the arm if that fails

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._arm is not None:
            await self._arm.close()

    async def _connected(self) -> A:
        context = loop_context()
        options = replace(self._options, clock=context.clock)
        simulated = _in_simulated_time(self._target, options.pace)
        arm = await context.connect(connected(self._target, options), simulated=simulated)
        return self._made(arm)


def _in_simulated_time(target: str | None, pace: PaceChoice) -> bool:
    """Return whether a connection needs no thread, because it opens no port and never blocks."""
    if isinstance(pace, str | float | int):
        return pace == "simulated"
    return (
        simulation_forced() or connections_overridden() or target is None or target.startswith(SIM)
    )
