"""The flight recorder: turns the driver's events into entries, and writes a recording at a fault.

Recording an entry takes a few microseconds on the thread that owns the link; another thread formats
and writes the file. Nothing here may raise an error into the driver.
"""

from __future__ import annotations

import contextlib
import functools
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

from armdrive.blocking import blocking, waiting_part
from armdrive.config.arm import ArmConfig
from armdrive.dialects.words import named, plain, valued
from armdrive.errors import ArmError, StateFileError
from armdrive.status import State
from armdrive.tasks import (
    Alert,
    Event,
    MoveAlong,
    MoveBy,
    Progress,
    ProtocolWarning,
    ReadPosition,
    Registers,
    Request,
    Timeout,
)
from armdrive.trace.entries import (
    EntryCondition,
    EntryKind,
    EntryRing,
    TraceEntry,
    counts_text,
)
from kinematics.errors import KinematicsError

# The recorded methods of an arm: a wrapper around each one records its arguments and the error it
# raises. `stop` is not in the table: a signal handler may request a stop, and the engine records it
# instead.

C = TypeVar("C", bound=type)

# The calls of an arm (the first row) and of its parts that are recorded, by the part's name.
CALLS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "": (
            "home", "run", "start", "move_j", "move_to", "move_l", "move_c", "move_path",
            "move_motors", "park", "jog_j", "jog_l", "enable", "disable", "reset", "estop",
            "pause", "resume",
        ),
        "controller": ("read_program", "write_program", "fix_settings"),
        "gripper": ("open", "close", "grasp"),
        "io": ("read", "wait", "write"),
        "jogging": ("hold", "nudge", "release"),
        "reference": ("confirm", "confirm_restored", "declare", "verify"),
    }
)  # fmt: skip


def traced(part: str) -> Callable[[C], C]:
    """Wrap the methods of a class that `CALLS` lists, so that the arm's tracer records them.

    An object of the class keeps the parts of its arm as `_parts`.
    """

    def decorate(kind: C) -> C:
        for name in CALLS[part]:
            call = f"{part}.{name}" if part else name
            setattr(kind, name, _recorded(call, getattr(kind, name)))
        return kind

    return decorate


def _recorded(name: str, method: Callable[..., Any]) -> Callable[..., Any]:
    waiting = waiting_part(method)
    if waiting is None:

        @functools.wraps(method)
        def call(self: Any, /, *arguments: Any, **named: Any) -> Any:
            with _recording(self, name, arguments, named):
                return method(self, *arguments, **named)

        return call

    @functools.wraps(waiting)
    async def waiting_call(self: Any, /, *arguments: Any, **named: Any) -> Any:
        with _recording(self, name, arguments, named):
            return await waiting(self, *arguments, **named)

    return blocking(waiting_call)


@contextlib.contextmanager
def _recording(
    owner: Any, name: str, arguments: tuple[Any, ...], named: dict[str, Any]
) -> Iterator[None]:
    """Record a call and the error it raises. Takes no lock: an emergency stop never waits."""
    tracer: FlightRecorder = owner._parts.tracer  # noqa: SLF001 - see `traced`
    if tracer.on_call is not None:
        tracer.on_call(name, arguments, named)
    tracer.called(name, arguments, named)
    try:
        yield
    except BaseException as error:
        tracer.raised(error)
        raise


# The functions around a recorded call, which `armdrive run` looks for on the stack of a script.
WRAPPERS = ("call", "waiting_call")

# Takes a call's name and arguments before the call begins; may raise to refuse it.
CallListener = Callable[[str, tuple[Any, ...], dict[str, Any]], object]


# The attribute of an error that has been recorded: what marks the errors of that call.
_RECORDED_IN = "_recorded_in"

WRITE_TIMEOUT_S = 10.0  # closing the arm waits this long for a slow disk; the writer then goes on
LONGEST_TEXT = 400  # characters kept of an argument list or an error

# Arguments that a program passes to itself: the count of stops that a motion must not have missed.
INTERNAL_ARGUMENTS = ("stops",)


class RecordingWriter:
    """Writes recordings in threads of their own, so that a slow disk delays no motion.

    `trouble` is the reason of the last failure, until `take_trouble` has returned it.
    """

    def __init__(self, folder: Path | None) -> None:
        self.folder = folder
        self.trouble = ""
        self._threads: list[threading.Thread] = []
        self._lock = threading.Lock()

    def write(
        self,
        path: Path | None,
        entries: Sequence[TraceEntry],
        config: ArmConfig,
        link: str,
        why: str,
        began: tuple[float, float],
    ) -> Path:
        """Write a recording to `path`, or to a new file; return its path.

        Raises `StateFileError` if the file cannot be written.
        """
        # most arms are closed without writing anything
        from armdrive.trace.files import free_path, header_of, write_recording

        with self._lock:
            header = header_of(config, link=link, why=why, began=began)
            target = path or free_path(self.folder, header)
            write_recording(target, header, entries, most=self.folder)
        return target

    def start(self, write: Callable[[Path | None], Path]) -> None:
        """Call `write(None)` in another thread; keep the reason if it fails."""
        self._threads = [each for each in self._threads if each.is_alive()]
        thread = threading.Thread(target=self._try, args=(write,), name="armdrive-recorder")
        try:
            thread.start()
        except RuntimeError as error:  # out of threads, or the interpreter is shutting down
            self.trouble = str(error)
        else:
            self._threads.append(thread)

    def _try(self, write: Callable[[Path | None], Path]) -> None:
        try:
            write(None)
        except StateFileError as error:
            self.trouble = str(error)

    def take_trouble(self) -> str:
        """Return why the last recording could not be written, once; otherwise an empty string."""
        trouble, self.trouble = self.trouble, ""
        return f"the flight recorder could not write a recording: {trouble}" if trouble else ""

    def finish(self) -> None:
        """Wait until every recording is on the disk, at most `WRITE_TIMEOUT_S` for each."""
        threads, self._threads = self._threads, []
        for thread in threads:
            thread.join(WRITE_TIMEOUT_S)


class FlightRecorder:
    """Keeps the events of one arm from the last minutes. It never influences the arm.

    With a folder, it writes a file there by itself after a fault. Any thread may call `snapshot`
    and `since`, which take the lock of the arm's pace, and `called` and `raised`, also from a
    signal handler: these two never wait. Everything else is called under that lock.
    """

    def __init__(self, folder: Path | None = None, *, ring: EntryRing | None = None) -> None:
        self.on_call: CallListener | None = None
        self.files = RecordingWriter(folder)
        self.ring = ring or EntryRing()
        self._config: ArmConfig | None = None
        self._link = ""
        self._clock: Callable[[], float] = lambda: 0.0
        self._lock = threading.RLock()
        self._inspect: Callable[[], EntryCondition] | None = None
        self._began: tuple[float, float] = (0.0, 0.0)
        self._now_s = 0.0
        self._stop: tuple[bool, bool] = (False, False)
        self._condition: EntryCondition | tuple[None, ...] = (None,) * len(_CONDITION)
        self._call = object()
        """Marks the errors that were recorded since the latest call began."""
        self._inbox: deque[tuple[float, EntryKind, str]] = deque()

    # -- events from the driver -----------------------------------------------------------------

    def begin(
        self,
        config: ArmConfig,
        link: str,
        clock: Callable[[], float],
        look: Callable[[], EntryCondition],
        lock: threading.RLock,
    ) -> None:
        """Begin with an arm's present condition.

        `link` describes its link, `clock` returns its time, and `look` its condition; `lock` is
        that of its pace.
        """
        self._config, self._link, self._clock, self._inspect = config, link, clock, look
        self._lock = lock
        self._now_s = clock()
        self._began = (time.time(), self._now_s)
        self.changed()

    def opened(self) -> None:
        """Protect the entries so far from being dropped: a replay begins with them."""
        self.ring.seal()

    def tick(self, now_s: float, stop_asked: bool, stop_hard: bool) -> None:
        """Take the time; record a stop request when it first appears."""
        if self._inbox:
            self._take_inbox()
        if now_s > self._now_s:
            self._now_s = now_s
        if self._stop != (stop_asked, stop_hard):
            self._stop = (stop_asked, stop_hard)
            if stop_asked:
                self._note(EntryKind.STOP, "emergency stop" if stop_hard else "normal stop")

    def sent(self, data: bytes) -> None:
        """Record bytes to the arm."""
        self.ring.add(TraceEntry(self._now_s, EntryKind.SENT, data))

    def received(self, data: bytes) -> None:
        """Record bytes from the arm."""
        self.ring.add(TraceEntry(self._now_s, EntryKind.RECEIVED, data))

    def requested(self, request: Request) -> None:
        """Record a request."""
        self.changed()
        self._note(EntryKind.REQUEST, _request_text(request))

    def reported(self, event: Event) -> None:
        """Record a reply or an alert. Progress reports are left out: their bytes are recorded."""
        if isinstance(event, Progress):
            return
        self._note(*_event_text(event))
        self.changed()

    def changed(self) -> None:
        """Record every part of the arm's condition that has changed."""
        if self._inspect is None:
            return
        condition, before = self._inspect(), self._condition
        if condition == before:
            return
        self._condition = condition
        for (kind, text), value, old in zip(_CONDITION, condition, before, strict=True):
            if value != old and (value or old):
                self._note(kind, text(value))
        if condition.state is State.ERROR_STOP and before[1] is not State.ERROR_STOP:
            self._write_after("error-stop")

    def called(self, name: str, arguments: tuple[Any, ...], named: dict[str, Any]) -> None:
        """Record a call."""
        self._call = object()
        self._inbox.append((self._clock(), EntryKind.CALL, _call_text(name, arguments, named)))

    def raised(self, error: BaseException) -> None:
        """Record an error once, however many calls it passes through."""
        # The mark is kept on the error: to keep the error here would keep its arm from being freed,
        # and another error may get its id once it is gone.
        if vars(error).get(_RECORDED_IN) is not self._call:
            vars(error)[_RECORDED_IN] = self._call
            self._inbox.append((self._clock(), EntryKind.RAISED, _error_text(error)))

    def ended(self, error: BaseException | None) -> None:
        """Record the error that ended a task, and write a file if the error is a bug of ours."""
        if error is None:
            return
        self.raised(error)
        if isinstance(error, Exception) and not isinstance(error, ArmError | KinematicsError):
            self._write_after("engine-failed")

    def lost(self, error: BaseException) -> None:
        """Record the loss of the link, and write a file."""
        self._note(EntryKind.LOST, _error_text(error))
        self._write_after("link-lost")

    def failed(self, error: BaseException) -> None:
        """Record a failure of the engine, and write a file."""
        self._note(EntryKind.FAILED, _error_text(error))
        self._write_after("engine-failed")

    # -- access to the entries ------------------------------------------------------------------

    def snapshot(self, why: str) -> Callable[[Path | None], Path]:
        """Return a function that writes a recording of the entries so far.

        The function takes the path of the file, or None to choose one, and returns the path. It
        raises `StateFileError` if the file cannot be written.
        """
        with self._lock:
            self._take_inbox()
            config, entries = self._config, self.ring.entries()
        if config is None:
            raise StateFileError("nothing was recorded: the arm was never connected")
        link, began = self._link, self._began
        return lambda path: self.files.write(path, entries, config, link, why, began)

    @property
    def began_s(self) -> float:
        """The arm's clock at the connection."""
        return self._began[1]

    def since(self, number: int, most: int, back: int) -> tuple[int, tuple[TraceEntry, ...]]:
        """Return at most `most` entries from a number on; see `EntryRing.since`."""
        with self._lock:
            self._take_inbox()
            return self.ring.since(number, most, back)

    def close(self) -> None:
        """Wait until every recording is on the disk."""
        self.files.finish()

    def _write_after(self, why: str) -> None:
        """Let another thread write the entries so far, if files are wanted."""
        if self.files.folder is not None:
            self.files.start(self.snapshot(why))

    def _take_inbox(self) -> None:
        """Add the entries that other threads have left."""
        while self._inbox:
            time_s, kind, text = self._inbox.popleft()
            self._now_s = max(self._now_s, time_s)
            self._add(kind, text)

    def _note(self, kind: EntryKind, text: str) -> None:
        self._take_inbox()
        self._add(kind, text)

    def _add(self, kind: EntryKind, text: str) -> None:
        if len(text) > LONGEST_TEXT:
            text = f"{text[:LONGEST_TEXT]}..."
        self.ring.add(TraceEntry(self._now_s, kind, text))


# For each field of `EntryCondition`, in order: the kind of its entry, and its text.
_CONDITION: tuple[tuple[EntryKind, Callable[[Any], str]], ...] = (
    (EntryKind.OFFSET, counts_text),
    (EntryKind.STATE, lambda state: str(state.value)),
    (EntryKind.TRUST, lambda belief: f"{belief[0].value}: {belief[1]}"),
    (EntryKind.CURRENT, lambda current: str(current.value)),
    (EntryKind.NOTICE, str),
    (EntryKind.ERROR, str),
)


# The text of requests, replies, calls and errors in a recording.


def _request_text(request: Request) -> str:
    """Return a request in words, in brackets after the name of its class.

    A replay finds requests by that name. The functions and iterators that a request carries are
    left out.
    """
    name = type(request).__name__
    if isinstance(request, MoveBy):
        return f"{name}({counts_text(request.steps)}; {request.rate_hz:g} steps/s)"
    if isinstance(request, ReadPosition):
        return f"{name}({'midway' if request.midway else ''})"
    if isinstance(request, MoveAlong):
        return f"{name}({'jogging, ' if request.jog else ''}{request.ahead_s:g} s ahead)"
    return f"{name}({plain(request).partition(': ')[2]})"


def _event_text(event: Event) -> tuple[EntryKind, str]:
    """Return the kind and the text of a reply or an alert; position counts come first."""
    if isinstance(event, Registers):
        return EntryKind.REGISTERS, f"{counts_text(event.positions)}; {event}"
    if isinstance(event, Alert):
        return EntryKind.ALERT, f"{event.kind.value}: {event.text}"
    if isinstance(event, ProtocolWarning):
        return EntryKind.WARNING, event.text
    return EntryKind.TIMEOUT if isinstance(event, Timeout) else EntryKind.REPLY, str(event)


def _call_text(name: str, arguments: tuple[Any, ...], named_ones: Mapping[str, Any]) -> str:
    """Return a call in words: `hold shoulder +1, speed 0.25, for 0.25 s`."""
    shown = {key: value for key, value in named_ones.items() if key not in INTERNAL_ARGUMENTS}
    words = (*map(valued, arguments), *(named(key, value) for key, value in shown.items()))
    return f"{name} {', '.join(filter(None, words))}".rstrip()


def _error_text(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
