"""What the framework needs help with, each with its reason; its drivers have their own files."""

from __future__ import annotations

import asyncio
import math
import os
import signal
import sys
import time
from collections.abc import Callable, Mapping
from functools import cache

from textual import _time, events, on
from textual.app import App
from textual.content import Content
from textual.driver import Driver
from textual.filter import Monochrome
from textual.keys import KEY_NAME_REPLACEMENTS, Keys, _character_to_key, key_to_character
from textual.message import Message
from textual.widgets import Static

from armdrive.text.printable import printable_lines
from kinematics.errors import suggestion
from tui.lasting import lasting
from tui.served import ending, is_served
from tui.urgent import Urgent
from tui.waking import Waking

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
