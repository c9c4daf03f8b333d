"""The events that a flight recorder receives, from the driver and from calls on an arm.

The driver calls a `Tracer` wherever something happens. `CALLS` lists the methods of an arm that are
recorded; a wrapper around each one records its arguments and the error it raises. `stop` is not in
the table: a signal handler may request a stop, and the engine records it instead.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from armdrive.blocking import blocking, waiting_part
from armdrive.config.arm import ArmConfig
from armdrive.errors import WrongState
from armdrive.tasks import Event, Request
from armdrive.trace.entries import EntryCondition, TraceEntry

# The interface between the driver and a flight recorder.


class Tracer:
    """Receive every event of one arm and ignore it. `FlightRecorder` keeps the events.

    A tracer never influences the arm. Its methods are called under the lock of the arm's pace,
    except `called` and `raised`, which any thread or signal handler may call: these two never wait.
    """

    def begin(
        self,
        config: ArmConfig,
        link: str,
        clock: Callable[[], float],
        look: Callable[[], EntryCondition],
    ) -> None:
        """Start tracing an arm: its configuration, its link, its clock, and how to inspect it."""

    def opened(self) -> None:
        """Note that the connection is complete."""

    def tick(self, now_s: float, stop_asked: bool, stop_hard: bool) -> None:
        """Note the time, and whether a stop has been requested."""

    def sent(self, data: bytes) -> None:
        """Note bytes that are about to be written."""

    def received(self, data: bytes) -> None:
        """Note bytes that arrived."""

    def requested(self, request: Request) -> None:
        """Note a request that the controller begins to carry out."""

    def reported(self, event: Event) -> None:
        """Note a reply, or a message that the device sent without a request."""

    def changed(self) -> None:
        """Inspect the arm: its state, trust or position may have changed."""

    def called(self, name: str, arguments: tuple[Any, ...], named: dict[str, Any]) -> None:
        """Note a call and its arguments."""

    def raised(self, error: BaseException) -> None:
        """Note the error that a call raised."""

    def ended(self, error: BaseException | None) -> None:
        """Note the end of a task, with its error if it failed."""

    def lost(self, error: BaseException) -> None:
        """Note that the link is lost."""

    def failed(self, error: BaseException) -> None:
        """Note that the engine itself has failed."""

    def snapshot(self, why: str) -> Callable[[Path | None], Path]:  # noqa: ARG002
        """Return a function that writes a recording of everything kept so far.

        The function takes the path of the file, or None to choose one, and returns the path.
        Raises `WrongState` if nothing is recorded.
        """
        raise _no_recorder()

    @property
    def began_s(self) -> float:
        """The arm's clock when tracing began."""
        return 0.0

    def since(self, number: int, most: int, back: int) -> tuple[int, tuple[TraceEntry, ...]]:  # noqa: ARG002
        """Return entries from a number on, and the number of the first; see `EntryRing.since`.

        Raises `WrongState` if nothing is recorded.
        """
        raise _no_recorder()

    def close(self) -> None:
        """Finish writing recordings."""


def _no_recorder() -> WrongState:
    return WrongState("this arm was connected without a flight recorder: nothing was recorded")


NO_TRACER = Tracer()


# The recorded methods of an arm.

C = TypeVar("C", bound=type)

CALLS = (
    "home", "confirm_reference", "confirm_restored", "declare_posture",
    "run", "start", "move_j", "move_to", "move_l", "move_c", "move_path", "move_motors",
    "move_gripper", "park", "jog_j", "jog_l", "hold", "nudge", "release",
    "enable", "disable", "reset", "estop", "mend_settings", "set_outputs", "read_inputs",
    "wait_inputs", "grasp", "feel", "verify", "pause", "resume",
    "read_pendant_program", "write_pendant_program",
)  # fmt: skip
"""Methods of an arm or of its gripper that are recorded when called."""


def traced(kind: C) -> C:
    """Wrap the methods of a class that `CALLS` lists, so that the arm's tracer records them."""
    for name in CALLS:
        method = getattr(kind, name, None)
        if method is not None:
            setattr(kind, name, _recorded(name, method))
    return kind


def _recorded(name: str, method: Callable[..., Any]) -> Callable[..., Any]:
    waiting = waiting_part(method)
    if waiting is None:

        @functools.wraps(method)
        def call(self: Any, /, *arguments: Any, **named: Any) -> Any:
            tracer = _tracer_of(self)
            tracer.called(name, arguments, named)
            try:
                return method(self, *arguments, **named)
            except BaseException as error:
                tracer.raised(error)
                raise

        return call

    @functools.wraps(waiting)
    async def waiting_call(self: Any, /, *arguments: Any, **named: Any) -> Any:
        tracer = _tracer_of(self)
        tracer.called(name, arguments, named)
        try:
            return await waiting(self, *arguments, **named)
        except BaseException as error:
            tracer.raised(error)
            raise

    return blocking(waiting_call)


def _tracer_of(owner: Any) -> Tracer:
    tracer: Tracer = getattr(owner, "_arm", owner).tracer  # no lock: an emergency stop never waits
    return tracer
