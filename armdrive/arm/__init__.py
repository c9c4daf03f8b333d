"""`Arm`: all that a program calls. The calls themselves are in this package, a file a family.

All of them may be called from any thread; `stop`, `estop` and `status` while another call waits.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Self

from armdrive.arm.arguments import RULES
from armdrive.arm.connected import Overrides, Reconnecting
from armdrive.arm.devices import IoCalls, PendantCalls
from armdrive.arm.gripper import Gripper
from armdrive.arm.jogging import JogCalls
from armdrive.arm.moving import PreviewCalls, RouteCalls
from armdrive.arm.reference import VerifyCalls
from armdrive.connect.control_socket import serve
from armdrive.connect.parts import PATIENCE_S, Parts
from armdrive.connect.target import ConnectOptions, connect
from armdrive.dialog import Operator
from armdrive.errors.arguments import checked_calls
from armdrive.motion import device as comparing
from armdrive.motion import reference as referencing
from armdrive.runtime.drive import PaceChoice
from armdrive.runtime.states import Event, after
from armdrive.status import State
from armdrive.tasks import DeviceSettings
from armdrive.trace.calls import witnessed

if TYPE_CHECKING:  # a real arm loads no simulation
    from armdrive.sim.simulated_arm import SimulatedArm


@witnessed
@checked_calls(RULES)
class Arm(
    VerifyCalls, RouteCalls, PreviewCalls, JogCalls, Reconnecting, Overrides, PendantCalls, IoCalls
):
    """One arm, connected. Make one with `Arm.connect`; use it in a `with` statement."""

    def __init__(self, parts: Parts) -> None:
        """Take the parts of a connected arm; `Arm.connect` makes them."""
        super().__init__(parts)
        if parts.lock is not None:
            serve(parts.lock, self)
        for call in parts.closers:
            self.on_close(call)

    @classmethod
    def connect(
        cls,
        target: str | None = None,
        *,
        dialect: str | None = None,
        baud: int | None = None,
        pace: PaceChoice = None,
        allow_restored: bool = False,
        operator: Operator | None = None,
        twin: SimulatedArm | None = None,
        reconnect: bool | None = None,
    ) -> Arm:
        """Connect to an arm by the name of its arm file, a port with `dialect=`, or `sim:NAME`.

        Without any it is the simulated TeachMover, and in a script under `armdrive run` the arm
        that the command names.
        Options: `dialect`, `baud`, `pace` ("simulated", "real", a factor of real time, or a
        `SimulatedClock` that several simulated arms share), `allow_restored`, `operator`,
        `reconnect` (look for a lost wire until it is back; by default as the arm file says). With
        `ARMDRIVE_FORCE_SIM=1` in the environment every arm is its simulated twin. Raises
        `PortUnavailable`, `ArmFileError`, `BadRequest`, `NoAnswer`.
        """
        options = ConnectOptions(
            dialect=dialect,
            baud=baud,
            pace=pace,
            allow_restored=allow_restored,
            operator=operator,
            twin=twin,
            reconnect=reconnect,
        )
        instead = stood_in(target, options)
        return Arm(connect(target, options)) if instead is None else instead

    def __enter__(self) -> Self:
        if self.core.state is State.DISABLED:
            self.enable()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def gripper(self) -> Gripper:
        """The fingers."""
        return Gripper(self)

    def enable(self) -> None:
        """Switch the motors on where that can be done, and allow motion. Moves nothing."""
        self.perform(referencing.enable(self.wire))

    def disable(self) -> None:
        """Switch the motor current off: **the arm can sag**, so `park` first.

        The position is suspect from then on. On a TeachMover this is `@RESET`.
        """
        after(self.core.state, Event.DISABLE)
        self.perform(referencing.disable(self.wire))

    def mend_settings(self, lines: Sequence[str] | None = None) -> DeviceSettings:
        """Write the lines that bring the device's settings to what the arm file says.

        Without `lines`, all that `status.notice` and `armdrive doctor` show. Moves nothing.
        """
        chosen = [each.mend for each in self.core.differences] if lines is None else lines
        return self.perform(comparing.mend_settings(self.wire, tuple(chosen)), PATIENCE_S)


# Who connects in the place of a program's own connections: a rehearsal, a run, a test.
#
# What stands in is of the whole process on purpose: a thread that the program starts is no way
# around it, since in a rehearsal its connection would move the real arm.

Standin = Callable[[str | None, ConnectOptions], Arm | None]
"""Gets what `Arm.connect` was called with; returns an arm, or None to let it go on as it says.

The target is None where the program named none.
"""

_PRESENT: list[Standin] = []


@contextlib.contextmanager
def standing_in(standin: Standin) -> Iterator[None]:
    """Have every connection of this process made by somebody else meanwhile; the latest counts."""
    _PRESENT.append(standin)
    try:
        yield
    finally:
        _PRESENT.remove(standin)


def stood_in(target: str | None, options: ConnectOptions) -> Arm | None:
    """Return the arm that somebody gives instead; None where nobody stands in."""
    return _PRESENT[-1](target, options) if _PRESENT else None


def anybody() -> bool:
    """Tell whether somebody stands in at present."""
    return bool(_PRESENT)
