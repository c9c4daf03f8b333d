"""Reads a gamepad in a thread of its own, and looks for one while there is none.

The thread only forwards events: whether anything moves is decided where the keys are.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from armdrive.errors import ArmError

LOOK_EVERY_S = 2.0
"""The reader looks for a gamepad at this interval while there is none."""


NONE_THERE = "plug one in; it is looked for (your user has to be in the group `input`)"


@dataclass(frozen=True, slots=True)
class PadEvent:
    """An event of a button (1: pressed), or of a stick (from -1 to 1)."""

    code: int
    value: float
    button: bool = False


class Pad(Protocol):
    """One gamepad that is open."""

    @property
    def name(self) -> str:
        """The name that the device reports."""

    def sticks(self) -> Mapping[int, float]:
        """Return where its sticks stand, from -1 to 1."""

    def events(self) -> Iterator[PadEvent | None]:
        """Yield events, and None from time to time while there are none.

        Raises `OSError` when it was unplugged, and `Uncounted` when events were lost.
        """

    def close(self) -> None:
        """Close it."""


class Uncounted(Exception):
    """The system lost events, so the positions of the sticks are unknown."""


@dataclass(frozen=True, slots=True)
class Came:
    """A gamepad is there."""

    name: str
    sticks: Mapping[int, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Gone:
    """The gamepad was unplugged, or none can be opened, for this reason."""

    reason: str


PadNews = PadEvent | Came | Gone
"""An event of a gamepad, or that it was plugged in or unplugged."""


class PadReader:
    """Forwards the events of a gamepad until it is closed."""

    def __init__(self, find: Callable[[], Pad | None], tell: Callable[[PadNews], None]) -> None:
        """`find` opens a gamepad, or returns None; `tell` is called in the reader's own thread."""
        self._find = find
        self._tell = tell
        self._closed = threading.Event()
        self._said = ""

    def start(self) -> None:
        """Begin to look for one."""
        threading.Thread(target=self._run, name="armdrive-gamepad", daemon=True).start()

    def close(self) -> None:
        """Forward no more events."""
        self._closed.set()

    def _run(self) -> None:
        while not self._closed.is_set():
            try:
                pad = self._find()
            except (ArmError, OSError) as error:
                self._say_once(str(error))
                pad = None
            else:
                if pad is None:
                    self._say_once(NONE_THERE)
            if pad is not None:
                self._said = ""
                self._read(pad)
            self._closed.wait(LOOK_EVERY_S)

    def _say_once(self, reason: str) -> None:
        if reason != self._said:
            self._said = reason
            self._tell(Gone(reason))

    def _read(self, pad: Pad) -> None:
        reason = "unplugged"
        try:
            self._tell(Came(pad.name, pad.sticks()))
            for event in pad.events():
                if self._closed.is_set():
                    return
                if event is not None:
                    self._tell(event)
        except Uncounted:
            reason = "some of its events were lost"
        except OSError as error:
            reason = error.strerror or reason
        finally:
            self._tell(Gone(f"{pad.name}: {reason}"))
            pad.close()
