"""The flight recorder itself: turns what the driver tells into entries, and writes at a fault.

Noting is a few microseconds on the thread that owns the wire; formatting and writing are done by
another thread. Nothing here may raise into the driver.
"""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from armdrive.config.arm import ArmConfig
from armdrive.errors import ArmError, StateFileError
from armdrive.moves import Move
from armdrive.status import State
from armdrive.tasks import (
    Alert,
    Event,
    MoveAlong,
    MoveBy,
    Progress,
    ProtocolWarning,
    Registers,
    Request,
    Timeout,
)
from armdrive.text.json_forms import move_to_json
from armdrive.trace.calls import Tracer
from armdrive.trace.entries import EntryCondition, EntryKind, EntryRing, TraceEntry
from kinematics.errors import KinematicsError

PATIENCE_S = 10.0
"""A disk that takes longer keeps nobody from closing the arm; the thread goes on writing."""
LONGEST_WORDS = 400
"""Characters of an argument list or an error that are kept."""


class FlightRecorder(Tracer):
    """A `Tracer` that remembers. With a folder, a fault has it write a file there by itself."""

    def __init__(self, folder: Path | None = None, *, ring: EntryRing | None = None) -> None:
        self.folder = folder
        self.ring = ring or EntryRing()
        self.written: list[Path] = []
        self.trouble = ""
        self._config: ArmConfig | None = None
        self._link = ""
        self._clock: Callable[[], float] = lambda: 0.0
        self._look: Callable[[], EntryCondition] | None = None
        self._began: tuple[float, float] = (0.0, 0.0)
        self._now_s = 0.0
        self._stop: tuple[bool, bool] = (False, False)
        self._seen: EntryCondition | tuple[None, ...] = (None,) * len(_LOOKS)
        self._last_error = 0
        self._inbox: deque[tuple[float, EntryKind, str]] = deque()
        self._writers: list[threading.Thread] = []
        self._writing = threading.Lock()

    # -- what the driver tells ----------------------------------------------------------------

    def begin(
        self,
        config: ArmConfig,
        link: str,
        clock: Callable[[], float],
        look: Callable[[], EntryCondition],
    ) -> None:
        """Take up an arm, and note what is known of it."""
        self._config, self._link, self._clock, self._look = config, link, clock, look
        self._now_s = clock()
        self._began = (time.time(), self._now_s)
        self.changed()

    def opened(self) -> None:
        """Keep what there is so far for good."""
        self.ring.seal()

    def tick(self, now_s: float, stop_asked: bool, stop_hard: bool) -> None:
        """Take the time; note a stop when it is first seen."""
        if self._inbox:
            self._empty()
        if now_s > self._now_s:
            self._now_s = now_s
        if self._stop != (stop_asked, stop_hard):
            self._stop = (stop_asked, stop_hard)
            if stop_asked:
                self._note(EntryKind.STOP, "dead, whatever it costs" if stop_hard else "asked for")

    def sent(self, data: bytes) -> None:
        """Note bytes to the arm."""
        self.ring.add(TraceEntry(self._now_s, EntryKind.SENT, data))

    def heard(self, data: bytes) -> None:
        """Note bytes from the arm."""
        self.ring.add(TraceEntry(self._now_s, EntryKind.HEARD, data))

    def asked(self, request: Request) -> None:
        """Note a request."""
        self.changed()
        self._note(EntryKind.REQUEST, _request_words(request))

    def told(self, event: Event) -> None:
        """Note an answer or an alert; reports of a motion under way are in the bytes."""
        if isinstance(event, Progress):
            return
        self._note(*_event_words(event))
        self.changed()

    def changed(self) -> None:
        """Note whatever of the arm is not what it was."""
        if self._look is None:
            return
        seen, before = self._look(), self._seen
        if seen == before:
            return
        self._seen = seen
        for (kind, words), value, old in zip(_LOOKS, seen, before, strict=True):
            if value != old and (value or old):
                self._note(kind, words(value))
        if seen.state is State.ERROR_STOP and before[1] is not State.ERROR_STOP:
            self._write_soon("error-stop")

    def called(self, name: str, words: tuple[Any, ...], named: dict[str, Any]) -> None:
        """Note a call."""
        self._last_error = 0
        self._inbox.append((self._clock(), EntryKind.CALL, _call_words(name, words, named)))

    def raised(self, error: BaseException) -> None:
        """Note an error, once, however many calls it passes."""
        if id(error) != self._last_error:
            self._last_error = id(error)
            self._inbox.append((self._clock(), EntryKind.RAISED, _error_words(error)))

    def ended(self, error: BaseException | None) -> None:
        """Note how a task ended; an error that is no sentence for a person is a flaw of ours."""
        if error is None:
            return
        self.raised(error)
        if isinstance(error, Exception) and not isinstance(error, ArmError | KinematicsError):
            self._write_soon("engine-failed")

    def lost(self, error: BaseException) -> None:
        """Note that the wire is lost, and write."""
        self._note(EntryKind.LOST, _error_words(error))
        self._write_soon("link-lost")

    def failed(self, error: BaseException) -> None:
        """Note that the engine has failed, and write."""
        self._note(EntryKind.FAILED, _error_words(error))
        self._write_soon("engine-failed")

    # -- writing ------------------------------------------------------------------------------

    def snapshot(self, why: str) -> Callable[[Path | None], Path]:
        """Return what writes all that is remembered now; it raises `StateFileError`."""
        self._empty()
        config, entries = self._config, self.ring.entries()
        if config is None:
            raise StateFileError("nothing was recorded: the arm was never connected")

        def write(path: Path | None = None) -> Path:
            with self._writing:
                about = (config, self._link, why, self._began)
                target = _write_recording(path, self.folder, entries, *about)
                self.written.append(target)
            return target

        return write

    @property
    def began_s(self) -> float:
        """The arm's clock at the connection."""
        return self._began[1]

    def since(self, number: int, most: int, back: int) -> tuple[int, tuple[TraceEntry, ...]]:
        """Return entries from a number on, no more than `most` and none further `back`."""
        self._empty()
        return self.ring.since(number, most, back)

    def close(self) -> None:
        """Wait until what is being written is on the disk."""
        writers, self._writers = self._writers, []
        for writer in writers:
            writer.join(PATIENCE_S)

    def _write_soon(self, why: str) -> None:
        """Have another thread write what is remembered at this moment."""
        if self.folder is None:
            return
        self._writers = [each for each in self._writers if each.is_alive()]
        work = (self.snapshot(why),)
        writer = threading.Thread(target=self._try_to_write, args=work, name="armdrive-recorder")
        self._writers.append(writer)
        writer.start()

    def _try_to_write(self, write: Callable[[Path | None], Path]) -> None:
        try:
            write(None)
        except StateFileError as error:
            self.trouble = str(error)

    def _empty(self) -> None:
        """Take in what other threads have left."""
        while self._inbox:
            time_s, kind, words = self._inbox.popleft()
            self._now_s = max(self._now_s, time_s)
            self._add(kind, words)

    def _note(self, kind: EntryKind, words: str) -> None:
        self._empty()
        self._add(kind, words)

    def _add(self, kind: EntryKind, words: str) -> None:
        if len(words) > LONGEST_WORDS:
            words = f"{words[:LONGEST_WORDS]}..."
        self.ring.add(TraceEntry(self._now_s, kind, words))


_LOOKS: tuple[tuple[EntryKind, Callable[[Any], str]], ...] = (
    (EntryKind.OFFSET, lambda offset: " ".join(map(str, offset))),
    (EntryKind.STATE, lambda state: str(state.value)),
    (EntryKind.TRUST, lambda belief: f"{belief[0].value}: {belief[1]}"),
    (EntryKind.CURRENT, lambda current: str(current.value)),
    (EntryKind.NOTICE, str),
    (EntryKind.ERROR, str),
)
"""What `changed` looks at, in this order, and the words for it."""


def _write_recording(
    path: Path | None,
    folder: Path | None,
    entries: Sequence[TraceEntry],
    config: ArmConfig,
    link: str,
    why: str,
    began: tuple[float, float],
) -> Path:
    """Write a recording, under a name of its own where no path is given; return where it is."""
    # most arms are closed with nothing written
    from armdrive.trace.files import free_path, header_of, write_recording

    header = header_of(config, link=link, why=why, began=began)
    target = path or free_path(folder, header)
    write_recording(target, header, entries, most=folder)
    return target


# Requests, answers, calls and errors in the words that a recording keeps.


def _request_words(request: Request) -> str:
    """Return a request in words; what is a program of its own is left out."""
    if isinstance(request, MoveBy):
        return f"MoveBy({_counts(request.steps)}; {request.rate_hz:g} steps/s)"
    if isinstance(request, MoveAlong):
        return f"MoveAlong({'jogging, ' if request.jog else ''}{request.ahead_s:g} s ahead)"
    return repr(request)


def _event_words(event: Event) -> tuple[EntryKind, str]:
    """Return the kind of an answer or an alert, and its words; counts of motors come first."""
    if isinstance(event, Registers):
        return EntryKind.REGISTERS, f"{_counts(event.positions)}; {event}"
    if isinstance(event, Alert):
        return EntryKind.ALERT, f"{event.kind.value}: {event.text}"
    if isinstance(event, ProtocolWarning):
        return EntryKind.ODDITY, event.text
    return EntryKind.SILENCE if isinstance(event, Timeout) else EntryKind.REPLY, str(event)


def _call_words(name: str, words: tuple[Any, ...], named: Mapping[str, Any]) -> str:
    """Return a call as it would be written; a move in its JSON form."""
    shown = [_argument(word) for word in words]
    shown += [f"{key}={_argument(value)}" for key, value in named.items()]
    return f"{name}({', '.join(shown)})"


def _argument(value: object) -> str:
    return json.dumps(move_to_json(value)) if isinstance(value, get_args(Move)) else repr(value)


def _error_words(error: BaseException) -> str:
    """Return an error in words."""
    return f"{type(error).__name__}: {error}"


def _counts(counts: tuple[int, ...]) -> str:
    return " ".join(map(str, counts))
