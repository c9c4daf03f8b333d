"""`AsyncArm`: the async version of `Arm`, whose calls are coroutines.

In simulated time everything runs on the event loop's thread, so that a program is
repeatable. In real time each call has a thread.

calls.py generates the methods from those of `Arm`. Type checkers read their signatures in
__init__.pyi, which `python tests/armdrive/aio/async_twin.py` writes.
"""

from __future__ import annotations

import functools
from typing import Any, Self

from armdrive.aio.calls import AsyncCalls, AsyncConnection, Connecting, twin_of
from armdrive.arm import Arm
from armdrive.arm.arguments import RULES
from armdrive.arm.connected import Recorder
from armdrive.arm.device import ControllerMemory, InputsOutputs
from armdrive.arm.moving import Gripper
from armdrive.arm.reference import ArmReference
from armdrive.connect.parts import ConnectOptions
from armdrive.errors.arguments import checked_calls, known_attributes


@known_attributes
@twin_of(Gripper)
class AsyncGripper(AsyncCalls[Gripper]):
    """The gripper of an arm: the calls of `Gripper`, as coroutines."""


@known_attributes
@twin_of(InputsOutputs)
class AsyncInputsOutputs(AsyncCalls[InputsOutputs]):
    """The inputs and outputs of an arm: the calls of `InputsOutputs`, as coroutines."""


@known_attributes
@twin_of(ArmReference)
class AsyncReference(AsyncCalls[ArmReference]):
    """The reference of an arm: the calls of `ArmReference`, as coroutines."""


@known_attributes
@twin_of(ControllerMemory)
class AsyncControllerMemory(AsyncCalls[ControllerMemory]):
    """What the controller stores: the calls of `ControllerMemory`, as coroutines."""


@known_attributes
@twin_of(Recorder)
class AsyncRecorder(AsyncCalls[Recorder]):
    """The flight recorder of an arm: the calls of `Recorder`, as coroutines."""


@known_attributes
@checked_calls(RULES, "connect")
@twin_of(Arm)
class AsyncArm(AsyncConnection):
    """A connected arm for asyncio programs; `sync` is the underlying `Arm`.

    `Arm` documents each call. Cancelling an awaited call, also with `asyncio.timeout`, stops the
    arm; `CancelledError` follows once the arm stands. Calls that never wait (`status`, `pause`,
    `estop`, `jogging.hold`, ...) are not awaited.
    """

    config = property(lambda self: self.sync.config, doc="The contents of the arm file.")
    simulated = property(lambda self: self.sync.simulated, doc="Whether the arm is simulated.")
    twin = property(
        lambda self: self.sync.twin, doc="The simulated device, with its physical world."
    )

    @property
    def gripper(self) -> AsyncGripper:
        """The fingers."""
        return AsyncGripper(self.sync.gripper, self._arm)

    @property
    def io(self) -> AsyncInputsOutputs:
        """The inputs and outputs."""
        return AsyncInputsOutputs(self.sync.io, self._arm)

    @property
    def reference(self) -> AsyncReference:
        """What the position rests on."""
        return AsyncReference(self.sync.reference, self._arm)

    @property
    def controller(self) -> AsyncControllerMemory:
        """What the controller stores."""
        return AsyncControllerMemory(self.sync.controller, self._arm)

    @property
    def recorder(self) -> AsyncRecorder:
        """The flight recorder."""
        return AsyncRecorder(self.sync.recorder, self._arm)

    @classmethod
    @functools.wraps(Arm.connect.__func__, assigned=())
    def connect(cls, target: str | None = None, **options: Any) -> Connecting[Self]:
        """Connect like `Arm.connect`: `await` the call, or use it in `async with`.

        Simulated arms of one event loop share a clock, unless `pace` says otherwise. Simulated
        time passes while an arm's calls are awaited, but not in `asyncio.sleep`.
        """
        return Connecting(cls, target, ConnectOptions(**options))
