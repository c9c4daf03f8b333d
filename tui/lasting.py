"""Drivers of the framework's that outlive the terminal that they paint on."""

from __future__ import annotations

import codecs
import contextlib
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import IO, Any

from textual.driver import Driver

PLAIN: Mapping[str, str] = MappingProxyType(
    {"°": "d", "…": ".", "✓": "x", **dict.fromkeys("─━▔", "-"), **dict.fromkeys("│┃▎▊▌▐", "|")}
    | dict.fromkeys("┌┐└┘├┤┬┴┼╭╮╰╯", "+")
    | dict.fromkeys(("■", *map(chr, range(0x2580, 0x258A))), "#")
)
"""Letters as wide as those that a terminal of another encoding than UTF-8 cannot show."""

PLAINLY = "armdrive-plainly"


def plainly(error: UnicodeError) -> tuple[str, int]:
    """Put one letter in the place of one: else whatever is behind it would be moved."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return PLAIN.get(error.object[error.start], "?"), error.start + 1


class LastingFile:
    """A terminal to write to, that takes whatever it is given once it is gone.

    The framework writes in a thread, which ends with the first error; who writes then waits for it
    for ever as soon as its queue is full: a desk whose terminal was closed did not always end.
    """

    def __init__(self, file: IO[str]) -> None:
        self._file = file
        encoding = getattr(file, "encoding", None) or "utf-8"
        self._encoding = "" if codecs.lookup(encoding).name.startswith("utf") else encoding
        codecs.register_error(PLAINLY, plainly)

    def write(self, text: str) -> int:
        """Write, if there is still somebody to read it."""
        if self._encoding:
            text = text.encode(self._encoding, PLAINLY).decode(self._encoding)
        with contextlib.suppress(OSError, ValueError):
            return self._file.write(text)
        return len(text)

    def flush(self) -> None:
        """Flush, if there is still somebody to read it."""
        with contextlib.suppress(OSError, ValueError):
            self._file.flush()

    def __getattr__(self, name: str) -> Any:
        """Leave everything else to the file itself."""
        return getattr(self._file, name)


def lasting(driver: type[Driver]) -> type[Driver]:
    """Return such a driver that outlives its terminal, and goes on after a suspension."""

    class Lasting(driver):  # type: ignore[misc, valid-type]
        def __init__(self, *words: Any, **more: Any) -> None:
            super().__init__(*words, **more)
            self._mode: Any = None
            file: Any = getattr(self, "_file", None)  # a headless one has none
            if file is not None:
                self._file: Any = LastingFile(file)

        def process_message(self, message: Any) -> None:
            self._app.was_read(message)
            super().process_message(message)

        def start_application_mode(self) -> None:
            super().start_application_mode()
            if suspends(driver):
                self._mode = mode_of(self.fileno)

        def _sigtstp_application(self, *_: Any) -> None:
            self._soon(super()._sigtstp_application)

        def _sigcont_application(self, *_: Any) -> None:
            self._app.was_suspended()
            self._soon(self._go_on)

        def _soon(self, call: Callable[[], None]) -> None:
            """Do it outside of the signal's handler.

            The framework does it within: where that has interrupted its own writing, it waits for
            a lock that it holds itself, for ever.
            """
            if not self._loop.is_closed():
                self._loop.call_soon_threadsafe(call)

        def _go_on(self) -> None:
            if not self._app.is_running or self._writer_thread is None:
                return  # the terminal is not ours
            if self._must_signal_resume:  # by SIGTSTP: it was given back, and is taken anew
                super()._sigcont_application()
            else:
                self._take_terminal()

        def _take_terminal(self) -> None:
            """Take up a terminal that a SIGSTOP has kept this program from giving back.

            The framework would begin anew: with a second thread that reads the keys, and so that
            it leaves the terminal in the end as it stands now, not as it was before.
            """
            set_mode(self.fileno, self._mode)
            self.write("\x1b[?1049h\x1b[?25l\x1b[?1004h")  # other screen, no cursor, focus told
            self._enable_mouse_support()
            self._enable_bracketed_paste()
            self._disable_line_wrap()
            self._app.post_message(self.SignalResume())

    return Lasting


def suspends(driver: type[Driver]) -> bool:
    """Tell whether a driver is one of those that hear of their suspension: on Unix terminals."""
    return hasattr(driver, "_sigcont_application")


def mode_of(terminal: int) -> Any:
    """Return how a terminal treats what is typed; None of what is none."""
    import termios

    try:
        return termios.tcgetattr(terminal)
    except termios.error:
        return None


def set_mode(terminal: int, mode: Any) -> None:
    """Have a terminal treat what is typed like that."""
    import termios

    if mode is not None:
        with contextlib.suppress(termios.error):
            termios.tcsetattr(terminal, termios.TCSANOW, mode)
