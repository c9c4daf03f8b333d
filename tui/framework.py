"""Work-arounds of the framework, each with its reason."""

from __future__ import annotations

import asyncio
import codecs
import contextlib
import math
import os
import re
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType
from typing import IO, Any

from rich.color import ColorSystem
from rich.console import Console
from textual import _time, events, messages, on
from textual._compositor import ChopsUpdate, Compositor
from textual.app import App
from textual.content import Content
from textual.driver import Driver
from textual.filter import Monochrome
from textual.keys import KEY_NAME_REPLACEMENTS, Keys, _character_to_key, key_to_character
from textual.message import Message
from textual.screen import Screen
from textual.strip import Strip
from textual.timer import Timer
from textual.widgets import Static

from armdrive.errors.printable import printable_lines
from kinematics.errors import suggestion

if sys.platform != "win32":
    import termios

# Drivers that outlive the terminal that they paint on.

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
    if sys.platform == "win32":
        return None
    try:
        return termios.tcgetattr(terminal)
    except termios.error:
        return None


def set_mode(terminal: int, mode: Any) -> None:
    """Have a terminal treat what is typed like that."""
    if sys.platform != "win32" and mode is not None:
        with contextlib.suppress(termios.error):
            termios.tcsetattr(terminal, termios.TCSANOW, mode)


# The driver for browsers, made to end when the other end has gone. It reads and writes two pipes to
# the program that serves the page. When that has died, the framework's driver stops reading and
# leaves the app running, which would hold its arm for ever.


def is_served(driver: type[Driver]) -> bool:
    """Tell whether a driver is the one for browsers."""
    return hasattr(driver, "write_meta")


def ending(driver: type[Driver]) -> type[Driver]:
    """Return such a driver that ends its app with its reader."""

    class Ending(driver):  # type: ignore[misc, valid-type]
        def __init__(self, *words: Any, **more: Any) -> None:
            super().__init__(*words, **more)
            self._write: Any = lasting_write(self._write)

        def run_input_thread(self) -> None:
            super().run_input_thread()
            if not self.exit_event.is_set():
                self._app.post_message(messages.ExitApp())

        def process_message(self, message: Any) -> None:
            if not self.exit_event.is_set():  # whoever it was for has gone
                super().process_message(message)

    return Ending


def lasting_write(write: Callable[[bytes], int]) -> Callable[[bytes], int]:
    """Return what writes as long as somebody reads, and raises nothing when nobody does."""

    def written(data: bytes) -> int:
        try:
            return write(data)
        except OSError:
            return len(data)

    return written


# Keys that act in the thread that reads them, however busy the app is: those that stop the arm. The
# app takes such a key afterwards as any other, and does the rest of what it means. Keys that were
# typed before it and are still on their way would begin again what was just stopped: they are
# dropped.


class Urgent:
    """The keys that have acted and that the app has not taken yet. Shared by two threads."""

    def __init__(self) -> None:
        self._acted: deque[events.Key] = deque()

    def read(self, message: Message, deeds: Mapping[str, Callable[[], object]]) -> None:
        """Have a key act that was just read, if it has a deed here."""
        if isinstance(message, events.Key) and (deed := deeds.get(message.key)) is not None:
            self._acted.append(message)
            deed()

    def overtook(self, key: events.Key) -> bool:
        """Tell whether a key that the app takes now was typed before one that has acted."""
        if key not in self._acted:
            return bool(self._acted)
        while self._acted.popleft() is not key:
            pass
        return False


# Noticing that this program did not run, and which keys were waiting for it. A suspended program
# reads nothing, but its keyboard goes on: all that was typed arrives at once when the program goes
# on, or in pieces from a link that kept it back as well. What comes then is old until there was a
# silence. Times are in s, on any one clock.

SILENCE_S = 0.3
"""So long without any key, and the next one is new. A key that is held repeats sooner."""


class Waking:
    """Looks at two clocks, and takes the system's word for it where it has one."""

    def __init__(self) -> None:
        self._looked_s = math.inf
        self._busy_s = 0.0
        self._told = False
        self._old_s = -math.inf

    def tell(self) -> None:
        """Hear from the system that this program was suspended; safe in a signal handler."""
        self._told = True

    def look(self, now_s: float, busy_s: float) -> tuple[float, bool]:
        """Return for how long this program did nothing since the last look, and whether told so.

        `busy_s` is the processor time of the thread that looks: what it worked was no absence.
        """
        absent_s = (now_s - self._looked_s) - (busy_s - self._busy_s)
        self._looked_s, self._busy_s = now_s, busy_s
        told, self._told = self._told, False
        return max(absent_s, 0.0), told

    def wake(self, now_s: float) -> None:
        """Take whatever comes from now on for old, until there is a silence."""
        self._old_s = now_s

    def is_old(self, came_s: float, *, of_keyboard: bool = True) -> bool:
        """Tell whether what came then may have waited; a key that did lets the next one wait too.

        A mouse says so much that it would never be silent: it is old as long as the keys are.
        """
        if came_s - self._old_s >= SILENCE_S:
            return False
        if of_keyboard:
            self._old_s = max(self._old_s, came_s)
        return True


ENDING_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)
)
"""The second says that the terminal was closed; Windows has none."""


def on_ending_signals(call: Callable[[int], None]) -> None:
    """Have these signals call back in the running event loop.

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

    Else the interpreter fails to paint it while it ends, and ends with an exit code of its own.
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


def key_named(word: str) -> str:
    """Return the framework's name of a key that is given by it, or as it is printed on the key.

    Raises `ValueError` for what is neither. The framework itself takes any word for a key.
    """
    if len(word) == 1:
        return _character_to_key(word)
    *modifiers, key = word.split("+")
    known = len(key) == 1 or key in _key_names() or key_to_character(key) is not None
    if known and all(each in _MODIFIERS for each in modifiers):
        return word
    raise ValueError(f"{word!r} is no key{suggestion(word, _key_names())}")


_MODIFIERS = ("ctrl", "shift", "alt")


_UNICODE_NAMES = {name: unicode for unicode, name in KEY_NAME_REPLACEMENTS.items()}


@cache
def _key_names() -> frozenset[str]:
    names = {key.value for key in Keys if not key.value.startswith("<")}
    return frozenset(names | set(KEY_NAME_REPLACEMENTS.values()) | {"space"})


def printed(key: str) -> str:
    """Return what is printed on a key, by the framework's name of it."""
    character = key_to_character(_UNICODE_NAMES.get(key, key))
    return character if character and character.isprintable() and character != " " else key


class FirstKeys(App[int], inherit_bindings=False):
    """An app with keys that come before every widget, and without the framework's own ones.

    The framework gives printable keys, priority or not, to a text field that is being typed into;
    so a space there, also in the command palette, would be no stop. Its own bindings would leave
    without a stop where a file of keys has moved ours.
    """

    ABSENT_S = math.inf
    """An app that did nothing for so long was suspended; those that look often say less."""
    STARVED_S = math.inf
    """An app that did nothing for so long has kept its keys waiting."""

    def __init__(self) -> None:
        self._key: events.Key | None = None
        self._waking = Waking()
        self._urgent = Urgent()
        self.monotonic_s: Callable[[], float] = _time.get_time
        self.busy_s: Callable[[], float] = time.thread_time
        # its other way to do without colours sends them all, as shades of grey
        super().__init__(ansi_color=True if os.environ.get("NO_COLOR") else None)
        if not self.no_color or os.environ.get("NO_COLOR"):
            return
        self.no_color = False  # set, but to nothing: no-color.org counts that as not set
        self._filters = [each for each in self._filters if not isinstance(each, Monochrome)]

    def run_or_raise(self) -> None:
        """Run until somebody leaves. Raises what ended the app against its will."""
        self.run()
        if self._exception is not None:
            raise self._exception

    def _fatal_error(self) -> None:
        """End, and print nothing: `run_or_raise` raises the error, and its caller tells it.

        The framework would print a traceback with the local variables, whatever text they hold.
        """
        self._close_messages_no_wait()

    def get_driver_class(self) -> type[Driver]:
        """Return the system's own driver, made to outlive its terminal."""
        driver = lasting(super().get_driver_class())
        return ending(driver) if is_served(driver) else driver

    def first_keys(self) -> Mapping[str, Callable[[], None]]:
        """Return these keys, with what they do."""
        return {}

    def urgent_keys(self) -> Mapping[str, Callable[[], object]]:
        """Return what keys do in the thread that reads them, before the app takes them."""
        return {}

    def was_read(self, message: Message) -> None:
        """Hear what a driver has just read, in its thread."""
        self._urgent.read(message, self.urgent_keys())

    def key_age_s(self) -> float:
        """Return how long ago the key came that is being acted on; 0 while none is.

        A busy app acts on keys later than they came, and further apart.
        """
        return 0.0 if self._key is None else max(self.monotonic_s() - self._key.time, 0.0)

    def woken(self, time_s: float) -> None:
        """Hear that this program was suspended, about so long; what was typed since is dropped."""

    def starved(self, time_s: float) -> None:
        """Hear that this program was kept from its work for so long: keys may be late."""

    def was_suspended(self) -> None:
        """Hear from the system that this program goes on; safe in a signal handler."""
        self._waking.tell()

    def alive(self) -> None:
        """Note that the app goes on; to be called often, and before any key is acted on."""
        now_s = self.monotonic_s()
        absent_s, told = self._waking.look(now_s, self.busy_s())
        if told or absent_s > self.ABSENT_S:
            self._waking.wake(now_s)
            self.woken(absent_s)
        elif absent_s > self.STARVED_S:
            self.starved(absent_s)

    @on(Driver.SignalResume)
    def _paint_anew(self) -> None:
        """Paint everything: the terminal may have shown something else meanwhile."""
        self.refresh(layout=True)

    async def on_event(self, event: events.Event) -> None:
        """Take the first keys before anything else sees them, and drop what is old."""
        if isinstance(event, events.MouseEvent) and not event.is_forwarded:
            self.alive()
            if self._waking.is_old(event.time, of_keyboard=False):
                return
        if not isinstance(event, events.Key):
            await super().on_event(event)
            return
        self._key = event
        try:
            await self._on_key_event(event)
        finally:
            self._key = None

    async def _on_key_event(self, event: events.Key) -> None:
        """Take a key that has come, or that no widget wanted."""
        if not event.is_forwarded:
            self.alive()
            deed = self.first_keys().get(event.key)
            old = self._urgent.overtook(event)
            old = old or self._waking.is_old(self.monotonic_s() - self.key_age_s())
            if deed is None and old:
                deed = _nothing
            if deed is not None:
                event.stop().prevent_default()
                deed()
                return
        await super().on_event(event)


def _nothing() -> None:
    """Do nothing: what a key does that is dropped."""


class PlainText(Static):
    """Text that is shown as it is, and repainted only when it has changed.

    The framework's own widget would read square brackets as markup, paint every update, and send
    an escape sequence in the text to the terminal: text may come from a file or a device.
    """

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__("", id=id, markup=False)
        self._shown = ""

    @property
    def shown(self) -> str:
        """The text as it stands."""
        return self._shown

    def show(self, text: str) -> None:
        """Show this text from now on."""
        shown = printable_lines(text)
        if shown != self._shown:
            self._shown = shown
            self.update(Content(shown))


# Sending only the spans that changed, not each row from its beginning. When a widget asks for a
# part of a row to be painted again, the framework finds the row's part, but crops it on the right
# only (`ChopsUpdate.render_segments`, "crop to x extents"). A picture in which a little changes in
# many rows then costs three times as many bytes.

_ONE_CELL_EACH = re.compile(
    "[ -~\\xa0-\\xac\\xae-\\u02ff\\u2500-\\u259f\\u2800-\\u28ff]*"
).fullmatch
"""Latin letters, lines and blocks, braille."""


class SpansUpdate(ChopsUpdate):
    """Spans of rows, cropped on both sides."""

    def render_segments(self, console: Console) -> str:
        """Return what is to be written to the terminal."""
        written: list[str] = []
        for y, left, right in self.spans:
            for end, (x, strip) in zip(self.chop_ends[y], self.chops[y].items(), strict=False):
                first, last = max(x, left), min(end, right)
                if strip is None or first >= last:
                    continue
                written.append(f"\x1b[{y + 1};{first + 1}H")
                written.append(_cut(strip, first - x, last - x, console))
        return "".join(written)


def _cut(strip: Strip, left: int, right: int, console: Console) -> str:
    """Return a part of a strip as it is written to the terminal.

    `Strip.crop` and `render` do the same by way of a strip of its own for each span, with caches
    that are never asked. Letters that may not be one cell wide are left to them.
    """
    if not all(_ONE_CELL_EACH(segment.text) for segment in strip):
        return strip.crop(left, right).render(console)
    colours = console._color_system or ColorSystem.TRUECOLOR  # noqa: SLF001 - as Strip.render
    written, x = [], 0
    for text, style, _ in strip:
        piece = text[max(left - x, 0) : right - x] if x < right else ""
        x += len(text)
        if piece:
            drawn = Strip.render_style(style, piece, colours) if style is not None else piece
            written.append(drawn)
    return "".join(written)


class SpansCompositor(Compositor):
    """The framework's compositor with partial updates of its own."""

    def render_partial_update(self) -> ChopsUpdate | None:
        """Return what changed since the last update, None where nothing did."""
        update = super().render_partial_update()
        if update is None:
            return None
        return SpansUpdate(update.chops, update.spans, update.chop_ends)


def send_spans_alone(screen: Screen[Any]) -> None:
    """Have a screen that is not shown yet send spans from now on."""
    screen._compositor = SpansCompositor()  # noqa: SLF001 - there is no other way in


# A timer that can be moved; where it is late, it first takes in what came before.

BUSY_S = 0.02
"""A timer that is so much later than it should be found the app busy."""

SETTLE_S = 0.03
"""What came while the app was busy has gone through its queues after this."""


class HoldAlarm:
    """One timer that is moved to another time instead of being joined by a second one.

    Where the app was too busy to ring in time, what came meanwhile is taken in before it rings.
    """

    def __init__(self, app: FirstKeys, call: Callable[[], None]) -> None:
        self._app = app
        self._call = call
        self._timer: Timer | None = None
        self._due_s = math.inf

    def after(self, delay_s: float) -> None:
        """Ring once after this delay; infinite means never."""
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if delay_s != math.inf:
            delay_s = max(delay_s, 0.001)
            self._due_s = time.monotonic() + delay_s
            self._timer = self._app.set_timer(delay_s, self._ring)

    def _ring(self) -> None:
        self._app.alive()  # what was held when this program was suspended is held no more
        if time.monotonic() - self._due_s > BUSY_S:
            self.after(SETTLE_S)
        else:
            self._call()
