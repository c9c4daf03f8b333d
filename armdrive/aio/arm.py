"""`AsyncArm`: an arm whose calls are awaited, each the twin of a call of `Arm`.

calls.py makes the twins. Type checkers read their signatures in arm.pyi, which
`python tests/armdrive/aio/async_twin.py` writes.
"""

from __future__ import annotations

import functools
from typing import Any, Self

from armdrive.aio.calls import AsyncCalls, AsyncConnection, Connecting, twin_of
from armdrive.arm import Arm
from armdrive.arm.arguments import RULES
from armdrive.arm.gripper import Gripper
from armdrive.connect.parts import ConnectOptions
from armdrive.errors.arguments import checked_calls


@twin_of(Gripper)
class AsyncGripper(AsyncCalls[Gripper]):
    """The fingers of an arm: the calls of `Gripper`, awaited."""


@checked_calls(RULES, "connect")
@twin_of(Arm)
class AsyncArm(AsyncConnection):
    """One arm, connected, for a program of coroutines; `sync` is the `Arm` itself.

    Each call is described at the call of that name of `Arm`. Whoever cancels an awaited call,
    `asyncio.timeout` too, stops the arm: the cancelling goes on once it stands. What never waits
    (`status`, `pause`, `estop`, ...) is not awaited.
    """

    config = property(lambda self: self.sync.config, doc="The arm's file.")
    simulated = property(lambda self: self.sync.simulated, doc="Whether it is a simulated arm.")
    twin = property(
        lambda self: self.sync.twin, doc="The simulated arm behind, with its physical world."
    )

    @property
    def gripper(self) -> AsyncGripper:
        """The fingers."""
        return AsyncGripper(self.sync.gripper, self._arm)

    @classmethod
    @functools.wraps(Arm.connect.__func__, assigned=())
    def connect(cls, target: str | None = None, **options: Any) -> Connecting[Self]:
        """Connect as `Arm.connect` does: `await` it, or use it in `async with`.

        Simulated arms of one event loop live on one clock, unless `pace` says otherwise. What
        simulated time an arm needs passes while its calls are awaited, and not in `asyncio.sleep`.
        """
        return Connecting(cls, target, ConnectOptions(**options))
