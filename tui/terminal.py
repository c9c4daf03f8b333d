"""The terminal that an app paints on: it may show few letters, be suspended, or go away.

Works around the framework's own drivers, each time with the reason. Signals that end the program
belong here as well: one of them says that the terminal was closed.

`KeyApp.get_driver_class` makes every app use `lasting_driver`.
"""

from __future__ import annotations

import asyncio
import codecs
import contextlib
import os
import re
import signal
import sys
from collections.abc import Callable, Iterable
from typing import IO, Any

from rich.segment import Segment
from textual._xterm_parser import XTermParser
from textual.color import Color
from textual.driver import Driver
from textual.filter import LineFilter
from textual.message import Message

if sys.platform != "win32":
    import termios

# Letters of ASCII, each as wide as the sign that it stands for.
PLAIN = str.maketrans(
    {
        "°": "d",
        "…": ".",
        "✓": "x",
        "●": "o",
        "○": "o",
        **dict.fromkeys("─━▔", "-"),
        **dict.fromkeys("│┃▎▊▌▐", "|"),
    }
    | dict.fromkeys("┌┐└┘├┤┬┴┼╭╮╰╯┏┓┗┛", "+")
    | dict.fromkeys(("■", *map(chr, range(0x2580, 0x258A))), "#")
)


class PlainLetters(LineFilter):
    """Draws with plain letters, on a terminal whose font may have no others.

    What a person or a device has written stays as it is: a terminal shows its own language.
    """

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:  # noqa: ARG002
        """Return the segments with plain letters."""
        return [Segment(text.translate(PLAIN), style, control) for text, style, control in segments]


class LastingFile:
    """A terminal to write to, that takes whatever it is given once it is gone.

    The framework writes in a thread, which ends with the first error. Once its queue is full, the
    app would wait for that thread forever, and a desk whose terminal was closed would not end.
    """

    def __init__(self, file: IO[str]) -> None:
        self._file = file
        encoding = getattr(file, "encoding", None) or "utf-8"
        self._encoding = "" if codecs.lookup(encoding).name.startswith("utf") else encoding

    def write(self, text: str) -> int:
        """Write, if the terminal is still there."""
        if self._encoding:  # one sign for each letter, so that nothing after it moves
            text = text.encode(self._encoding, "replace").decode(self._encoding)
        with contextlib.suppress(OSError, ValueError):
            return self._file.write(text)
        return len(text)

    def flush(self) -> None:
        """Flush, if the terminal is still there."""
        with contextlib.suppress(OSError, ValueError):
            self._file.flush()

    def __getattr__(self, name: str) -> Any:
        """Leave everything else to the file itself."""
        return getattr(self._file, name)


# Releases of keys, which the framework's parser cannot read. A terminal with kitty's keyboard
# protocol reports them once it is asked to: `CSI 113;1:3 u` is the release of q, `1:2` its repeat.
# https://sw.kovidgoyal.net/kitty/keyboard-protocol/

# Adds the reports of repeats and releases to what the framework has asked for.
REPORT_RELEASES = "\x1b[=2;2u"

RELEASED = "3"
_EVENT_TYPE = re.compile(r"(\x1b\[[\d:]*;\d*):(\d)(.*)", re.DOTALL)


class KeyUp(Message):
    """A key was let go."""

    def __init__(self, key: str) -> None:
        super().__init__()
        self.key = key


class ReleaseParser(XTermParser):
    """The framework's parser, which also distinguishes releases from presses and repeats."""

    def _sequence_to_key_events(self, sequence: str, alt: bool = False) -> Iterable[Any]:
        found = _EVENT_TYPE.fullmatch(sequence)
        if found is None:
            yield from super()._sequence_to_key_events(sequence, alt)
            return
        before, kind, after = found.groups()
        for event in super()._sequence_to_key_events(f"{before}{after}", alt):
            yield KeyUp(event.key) if kind == RELEASED else event


def lasting_driver(driver: type[Driver]) -> type[Driver]:
    """Return a driver that outlives its terminal, and goes on after a suspension."""
    if suspends(driver):
        sys.modules[driver.__module__].XTermParser = ReleaseParser  # type: ignore[attr-defined]

    class Lasting(driver):  # type: ignore[misc, valid-type]
        def __init__(self, *words: Any, **more: Any) -> None:
            super().__init__(*words, **more)
            self._mode: Any = None
            file: Any = getattr(self, "_file", None)  # a headless one has none
            if file is not None:
                self._file: Any = LastingFile(file)

        def process_message(self, message: Any) -> None:
            self._app.input.was_read(message)
            super().process_message(message)

        def start_application_mode(self) -> None:
            super().start_application_mode()
            if suspends(driver):
                self._mode = mode_of(self.fileno)
                self.write(REPORT_RELEASES)
                self.flush()

        def _sigtstp_application(self, *_: Any) -> None:
            self._soon(super()._sigtstp_application)

        def _sigcont_application(self, *_: Any) -> None:
            self._app.input.fresh.suspended()
            self._soon(self._go_on)

        def _soon(self, call: Callable[[], None]) -> None:
            """Do it outside of the signal's handler.

            The framework does it in the handler: if that interrupts its own writing, it waits
            forever for a lock that it holds itself.
            """
            if not self._loop.is_closed():
                self._loop.call_soon_threadsafe(call)

        def _go_on(self) -> None:
            if not self._app.is_running or self._writer_thread is None:
                return  # the terminal is not ours
            if self._must_signal_resume:  # by SIGTSTP: it was given back, and is taken again
                super()._sigcont_application()
            else:
                self._take_terminal()

        def _take_terminal(self) -> None:
            """Take up a terminal that a SIGSTOP has kept this program from giving back.

            The framework would start over: with a second thread that reads the keys, and so that
            it leaves the terminal in the end as it stands now, not as it was before.
            """
            set_mode(self.fileno, self._mode)
            self.write("\x1b[?1049h\x1b[?25l\x1b[?1004h")  # other screen, no cursor, report focus
            self._enable_mouse_support()
            self._enable_bracketed_paste()
            self._disable_line_wrap()
            self._app.post_message(self.SignalResume())

    return Lasting


def suspends(driver: type[Driver]) -> bool:
    """Return whether a driver reports a suspension: those of Unix terminals do."""
    return hasattr(driver, "_sigcont_application")


def mode_of(terminal: int) -> Any:
    """Return a terminal's input mode; None if it is no terminal."""
    if sys.platform == "win32":
        return None
    try:
        return termios.tcgetattr(terminal)
    except termios.error:
        return None


def set_mode(terminal: int, mode: Any) -> None:
    """Set a terminal's input mode."""
    if sys.platform != "win32" and mode is not None:
        with contextlib.suppress(termios.error):
            termios.tcsetattr(terminal, termios.TCSANOW, mode)


# The second says that the terminal was closed; Windows has none.
ENDING_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)
)


def on_ending_signals(call: Callable[[int], None]) -> None:
    """Make these signals call back in the running event loop.

    The framework runs no clean-up at all when one of them ends the process.
    """
    loop = asyncio.get_running_loop()
    for number in ENDING_SIGNALS:
        _handle(loop, number, call)


def _handle(
    loop: asyncio.AbstractEventLoop, number: signal.Signals, call: Callable[[int], None]
) -> None:
    try:
        loop.add_signal_handler(number, call, int(number))
    except NotImplementedError:  # the event loop of Windows has no such call
        signal.signal(number, lambda *_: loop.call_soon_threadsafe(call, int(number)))


def forget_a_closed_terminal() -> None:
    """Send what is still to be painted nowhere if the terminal is gone.

    Otherwise the interpreter fails to write it at exit, and sets its own exit code.
    """
    for stream in (sys.__stdout__, sys.__stderr__):
        if stream is None:
            continue
        try:
            stream.flush()
        except OSError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)
