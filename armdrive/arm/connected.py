"""The base of an arm's parts, its flight recorder, and the handles of motions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from armdrive.arm.arguments import RULES
from armdrive.blocking import blocking, coroutine_of
from armdrive.connect.parts import Parts
from armdrive.connect.runner import TaskRunner
from armdrive.errors import WaitTimeout
from armdrive.errors.arguments import BASIC, checked_calls, known_attributes
from armdrive.storage.files import require_free
from armdrive.tasks import Task

if TYPE_CHECKING:
    from armdrive.trace.log import LogReader

T = TypeVar("T")

# When a stop was requested that keeps a motion from starting.
BEFORE = "before the motion started"

# A motion that lasts this many times longer than planned, and `PATIENCE_S` more, is stopped.
PATIENCE = 4.0


class ArmPart:
    """A part of an arm that has calls of its own, such as `arm.io`.

    `armdrive.trace.recorder.traced` records its calls, with the tracer of `_parts`.
    """

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._core = parts.core

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self._parts.config.name}>"


@known_attributes
@checked_calls(RULES)
class Recorder(ArmPart):
    """The flight recorder of an arm: what passed on the wire, and what the driver made of it."""

    def save(self, path: Path | str | None = None, *, overwrite: bool = False) -> Path:
        """Save the contents of the flight recorder, and return the path of the file.

        Without a path, the file goes into the folder of recordings. Raises `BadRequest` if the
        folder in the path does not exist or, without `overwrite`, the file does, and
        `StateFileError` if the file cannot be written.
        """
        if path is not None:
            require_free(Path(path), overwrite=overwrite)
        write = self._parts.tracer.snapshot("on request")
        return write(None if path is None else Path(path))

    def log(self, *, back: int | None = None) -> LogReader:
        """Return a reader of the log: the traffic on the wire and the driver's events, in words.

        The reader starts with the latest `back` entries (2000 by default), and each `read()`
        continues where the last one ended.
        """
        from armdrive.trace.log import FURTHEST_BEHIND, LogReader  # few programs read the log

        back = FURTHEST_BEHIND if back is None else back
        dialect, tracer = self._parts.config.connection.dialect, self._parts.tracer
        return LogReader(tracer.since, dialect, tracer.began_s, back=back)


# The handle of a running motion, which a call with `wait=False` returns.

T_co = TypeVar("T_co", covariant=True)


@known_attributes
@checked_calls(BASIC)
class Handle(Generic[T_co]):
    """A running motion, returned by a call with `wait=False`."""

    def __init__(self, runner: TaskRunner, task: Task[T_co], timeout_s: float) -> None:
        self._runner = runner
        self._task = task
        self._timeout_s = timeout_s

    def __repr__(self) -> str:
        error = self._task.error
        end = "done" if error is None else f"ended by {type(error).__name__}"
        return f"<{type(self).__name__}: {end if self.done else 'under way'}>"

    @property
    def done(self) -> bool:
        """Whether the motion has ended, successfully or not."""
        return self._task.done

    @blocking
    async def wait(self, timeout_s: float | None = None) -> T_co:
        """Wait for the end of the motion; return its result or raise its error.

        Raises `WaitTimeout` after `timeout_s`; the motion continues. Without `timeout_s`, the
        motion has a deadline that is computed from its duration; when it passes, the arm is
        stopped.
        """
        if timeout_s is None:
            return await self._runner.finish(self._task, self._timeout_s)
        if not await self._runner.wait(lambda: self._task.done, timeout_s):
            raise WaitTimeout(f"the motion had not ended after {timeout_s:g} s")
        return self._runner.result(self._task)

    @blocking
    async def cancel(self) -> None:
        """Stop the motion."""
        if not self._task.done:
            await self._runner.stop()


async def finished(handle: Handle[T]) -> T:
    """Wait for the end of a motion; see `Handle.wait`."""
    return await coroutine_of(handle.wait)()
