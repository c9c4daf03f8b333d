"""What a flight recorder is told: by the driver, and by the calls of a program or a person.

The driver calls a `Tracer` wherever something happens. Which calls of an arm are noted is a table;
a wrapper around each notes what it raises as well. A stop is not in the table: a signal handler may
ask for one, and the engine sees it.
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

# The few calls by which the driver tells what happens.


class Tracer:
    """Hears of everything, and changes nothing. This one forgets it; a flight recorder does not.

    Called under the lock of the arm's pace, but for `called` and `raised`: those come from any
    thread, a signal handler too, and never wait.
    """

    def begin(
        self,
        config: ArmConfig,
        link: str,
        clock: Callable[[], float],
        look: Callable[[], EntryCondition],
    ) -> None:
        """Hear which arm it is, on which wire, by which clock, and how to look at it."""

    def opened(self) -> None:
        """Hear that the connection stands."""

    def tick(self, now_s: float, stop_asked: bool, stop_hard: bool) -> None:
        """Hear the time, and whether a stop is asked for."""

    def sent(self, data: bytes) -> None:
        """Hear what is about to be written."""

    def heard(self, data: bytes) -> None:
        """Hear what came in."""

    def asked(self, request: Request) -> None:
        """Hear of a request that begins."""

    def told(self, event: Event) -> None:
        """Hear of an answer, or of what the device said unasked."""

    def changed(self) -> None:
        """Look at the arm: state, trust or position may have changed."""

    def called(self, name: str, words: tuple[Any, ...], named: dict[str, Any]) -> None:
        """Hear of a call, with its arguments."""

    def raised(self, error: BaseException) -> None:
        """Hear of what a call ended with."""

    def ended(self, error: BaseException | None) -> None:
        """Hear of what a task ended with, if not well."""

    def lost(self, error: BaseException) -> None:
        """Hear that the wire is lost."""

    def failed(self, error: BaseException) -> None:
        """Hear that the engine itself has failed."""

    def snapshot(self, why: str) -> Callable[[Path | None], Path]:  # noqa: ARG002
        """Return what writes all that is remembered now, to a named file or one of its own.

        Raises `WrongState` where nothing is.
        """
        raise _nothing()

    @property
    def began_s(self) -> float:
        """The arm's clock when this began to look."""
        return 0.0

    def since(self, number: int, most: int, back: int) -> tuple[int, tuple[TraceEntry, ...]]:  # noqa: ARG002
        """Return entries from a number on, and the number of the first; see `EntryRing.since`.

        Raises `WrongState` where nothing is remembered.
        """
        raise _nothing()

    def close(self) -> None:
        """Finish what is being written."""


def _nothing() -> WrongState:
    return WrongState("this arm was connected without a flight recorder: nothing was recorded")


NO_TRACER = Tracer()


# The calls of a program or a person.

C = TypeVar("C", bound=type)

CALLS = (
    "home", "confirm_reference", "confirm_restored", "declare_posture",
    "run", "start", "move_j", "move_to", "move_l", "move_c", "move_path", "move_motors",
    "move_gripper", "park", "jog_j", "jog_l", "hold", "nudge", "release",
    "enable", "disable", "reset", "estop", "mend_settings", "set_outputs", "read_inputs",
    "wait_inputs", "grasp", "feel", "verify", "pause", "resume",
    "read_pendant_program", "write_pendant_program",
)  # fmt: skip
"""The methods of an arm or of its gripper whose calls are noted."""


def traced(kind: C) -> C:
    """Have the calls of a class noted by its arm's tracer."""
    for name in CALLS:
        method = getattr(kind, name, None)
        if method is not None:
            setattr(kind, name, _noted(name, method))
    return kind


def _noted(name: str, method: Callable[..., Any]) -> Callable[..., Any]:
    waiting = waiting_part(method)
    if waiting is None:

        @functools.wraps(method)
        def call(self: Any, /, *words: Any, **named: Any) -> Any:
            tracer = _tracer_of(self)
            tracer.called(name, words, named)
            try:
                return method(self, *words, **named)
            except BaseException as error:
                tracer.raised(error)
                raise

        return call

    @functools.wraps(waiting)
    async def waiting_call(self: Any, /, *words: Any, **named: Any) -> Any:
        tracer = _tracer_of(self)
        tracer.called(name, words, named)
        try:
            return await waiting(self, *words, **named)
        except BaseException as error:
            tracer.raised(error)
            raise

    return blocking(waiting_call)


def _tracer_of(owner: Any) -> Tracer:
    tracer: Tracer = getattr(owner, "_arm", owner).tracer  # no lock: an emergency stop never waits
    return tracer
