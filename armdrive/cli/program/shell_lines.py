"""Lines that a person types: with a history and completion where this system has readline."""

from __future__ import annotations

import contextlib
import signal
import sys
from collections.abc import Callable, Sequence
from types import FrameType, ModuleType, TracebackType
from typing import NoReturn, Self

from armdrive.storage import files as places
from armdrive.storage.files import DISK, replace_file

if sys.platform != "win32":
    import termios

READLINE: ModuleType | None
try:
    import readline
except ImportError:  # Windows
    READLINE = None
else:
    READLINE = readline

HISTORY = "shell_history"
LARGEST_BYTES = 1_000_000
LIBEDIT_MARK = "_HiStOrY_V2_"
"""The first line of a history that macOS's readline wrote itself, as it once did here."""
MOST_LINES = 1000
"""So many lines are remembered from one day to the next."""

BREAKS = ' \t\n(),=+-*/<>%"'
"""What stands between two words."""


class TypedLines:
    """Asks for lines. `words` is what there is to complete now."""

    def __init__(self, words: Callable[[], Sequence[str]]) -> None:
        self.interrupted = ""
        self._words = words
        self._found: list[str] = []
        self._readline = READLINE

    def __enter__(self) -> Self:
        if self._readline is not None:
            _prepare(self._readline, self._complete)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._readline is not None:
            with contextlib.suppress(OSError):  # a full disk keeps no history, and nothing worse
                _write_history(self._readline)
            self._readline.set_completer(None)

    def read(self, prompt: str) -> str | None:
        """Return the next line; None at the end of the input.

        Raises `KeyboardInterrupt`; then `interrupted` is what had been typed.
        """
        before = signal.signal(signal.SIGINT, self._interrupt)
        try:
            return input(prompt)
        except EOFError:
            return None
        finally:
            signal.signal(signal.SIGINT, before)

    def forget(self) -> None:
        """Forget what was typed or pasted beyond the line that was taken last."""
        if sys.platform != "win32":
            with contextlib.suppress(termios.error, OSError, ValueError):
                termios.tcflush(sys.stdin.fileno(), termios.TCIFLUSH)

    def _interrupt(self, number: int, frame: FrameType | None) -> NoReturn:  # noqa: ARG002
        self.interrupted = "" if self._readline is None else self._readline.get_line_buffer()
        raise KeyboardInterrupt

    def _complete(self, text: str, state: int) -> str | None:
        """Return the next word that goes on like this one, as readline asks for them."""
        if state == 0:
            low = text.lower()
            self._found = sorted({each for each in self._words() if each.lower().startswith(low)})
        return self._found[state] if state < len(self._found) else None


def _prepare(readline: ModuleType, complete: Callable[[str, int], str | None]) -> None:
    _read_history(readline)
    readline.set_history_length(MOST_LINES)
    readline.set_completer_delims(BREAKS)
    readline.set_completer(complete)
    libedit = "libedit" in (readline.__doc__ or "")
    readline.parse_and_bind("bind ^I rl_complete" if libedit else "tab: complete")


def _read_history(readline: ModuleType) -> None:
    """Recall what was typed before. readline's own reading follows links and waits for pipes."""
    try:
        data = DISK.read_own(places.states() / HISTORY, LARGEST_BYTES, end=True)
    except OSError:
        return
    for line in data.decode("utf-8", errors="replace").splitlines():
        if line != LIBEDIT_MARK:
            readline.add_history(line)


def _write_history(readline: ModuleType) -> None:
    """Keep the last lines. Raises `OSError`. readline's own writing follows links."""
    last = readline.get_current_history_length()
    numbers = range(max(last - MOST_LINES, 0) + 1, last + 1)
    lines = [readline.get_history_item(number) or "" for number in numbers]
    text = "\n".join(lines).encode("utf-8", errors="replace")  # a terminal may send any bytes
    replace_file(places.states() / HISTORY, text.decode("utf-8"))
