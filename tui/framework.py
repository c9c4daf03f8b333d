"""Everything that the framework needs help with, in one file, each with its reason."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import Callable, Mapping

from textual import events
from textual.app import App
from textual.content import Content
from textual.timer import Timer
from textual.widgets import Static

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


class FirstKeys(App[int]):
    """An app with keys that come before every widget.

    The framework gives printable keys, priority or not, to a text field that is being typed into;
    so a space there, also in the command palette, would be no stop.
    """

    def first_keys(self) -> Mapping[str, Callable[[], None]]:
        """Return these keys, with what they do."""
        return {}

    async def on_event(self, event: events.Event) -> None:
        """Take the first keys before anything else sees them."""
        if isinstance(event, events.Key) and not event.is_forwarded:
            deed = self.first_keys().get(event.key)
            if deed is not None:
                event.stop().prevent_default()
                deed()
                return
        await super().on_event(event)


class PlainText(Static):
    """Text that is shown as it is, and repainted only when it has changed.

    The framework's own widget would read square brackets as markup, and paint every update.
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
        if text != self._shown:
            self._shown = text
            self.update(Content(text))


class Alarm:
    """One timer that is moved to another time instead of being joined by a second one."""

    def __init__(self, app: App[int], call: Callable[[], None]) -> None:
        self._app = app
        self._call = call
        self._timer: Timer | None = None

    def after(self, delay_s: float) -> None:
        """Ring once after this delay; infinite means never."""
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if delay_s != float("inf"):
            self._timer = self._app.set_timer(max(delay_s, 0.001), self._call)
