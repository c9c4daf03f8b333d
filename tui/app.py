"""The base of every app of the desk: how it handles keys, and the message that follows.

The way of a key from the terminal to its action:

1. The driver's thread reads it (`lasting_driver` in terminal.py) and calls `AppInput.was_read`. A
   stop key stops the arm there, however busy the app is.
2. In the app's thread, `KeyApp.on_event` asks `AppInput.handles` before any widget. A stop key acts
   first. A key that is not fresh is dropped (`Freshness` in keys/presses.py): typed before a stop
   that has acted, while this program was suspended, or pasted.
3. The framework finds the keys of the table that work everywhere; then a line that is typed into
   takes the key (`AppInput._types`); then come the other rows of the table. Their actions arrive at
   `KeyApp.run_action`.
4. Every action of a key or a click runs in `Calls.acting`, so one rule holds for all: the last
   message is cleared, a first press of another key no longer counts, and a refusal becomes the new
   message.
5. What moves the arm by itself waits in `KeyApp.confirmation`, and is done at a later poll.
"""

from __future__ import annotations

import contextlib
import math
import os
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeVar, runtime_checkable

from textual import _time, actions, events, on
from textual._callback import invoke
from textual.actions import ActionParseResult, SkipAction
from textual.app import App
from textual.containers import VerticalScroll
from textual.dom import DOMNode
from textual.driver import Driver
from textual.errors import NoWidget
from textual.message import Message
from textual.screen import ModalScreen
from textual.timer import Timer

from armdrive.errors import ArmError, BadRequest
from armdrive.errors.printable import in_words
from kinematics.errors import KinematicsError
from tui.arm_view import move_cameras
from tui.dialogs import StillPalette, help_dialog
from tui.keys.keyboard import Keyboard
from tui.keys.presses import Confirmation, Freshness
from tui.keys.table import STOP, TABLE, DeskKey, JogPair
from tui.safety import StopButton
from tui.settings import COLOURLESS, HIGH_CONTRAST, LOOKS
from tui.terminal import PlainLetters, lasting_driver
from tui.widgets import TypedText

Answer = TypeVar("Answer")
Found = TypeVar("Found")

# Interval between two looks at an arm's status.
POLL_S = 0.05

# The framework's own names of parts in actions.
FRAMEWORK_PARTS = ("screen", "focused")

PASTED = "keys came as fast as pasted text"


class Hand(Protocol):
    """What jogs by keys. Its dead-man switch decides which presses count."""

    def disarm(self, reason: str) -> None:
        """Let no key move anything."""

    def release(self) -> None:
        """End what is held."""


class AppInput:
    """Passes keys and clicks to an app: which of them count, and who handles them."""

    def __init__(self, app: KeyApp) -> None:
        self.urgent: Mapping[str, Callable[[], object]] = {}
        """What keys do in the thread that reads them, before the app handles them."""
        self.hand: Callable[[], Hand | None] = lambda: None
        """Returns the jogging of the current screen; None if the screen has no jog keys."""
        self.fresh = Freshness()
        self.monotonic_s: Callable[[], float] = _time.get_time
        self.busy_s: Callable[[], float] = time.thread_time
        self._app = app
        self._key_s = math.inf
        self._quick = False  # whether the last key may be followed quickly

    def was_read(self, message: Message) -> None:
        """Take what a driver has just read, in its thread."""
        if isinstance(message, events.Key) and (act := self.urgent.get(message.key)) is not None:
            self.fresh.acted(message.time)
            act()

    def alive(self) -> None:
        """Note that the app is running. Call it often, and before acting on any key."""
        hand = self.hand()
        jogs = hand is not None
        absence = self.fresh.look(self.monotonic_s(), self.busy_s(), jogs=jogs)
        if absence:
            self._app.capture_mouse(None)  # the release of its button may be dropped
        if absence == "suspended":
            self._app.disarm(self.fresh.why)
        elif absence and hand is not None:
            hand.release()  # only a key that has waited disarms: perhaps there is none

    def key_age_s(self) -> float:
        """Return the age of the key being handled.

        A busy app handles keys later than they arrived, and further apart.
        """
        return max(self.monotonic_s() - self._key_s, 0.0)

    async def handles(self, event: events.Event) -> bool:
        """Handle a key or a click; return False to leave it to the framework."""
        if isinstance(event, events.Key):
            self._key_s = event.time
            if event.is_forwarded:  # no widget wanted it: now come the rows of its screen
                return self._types(event)
            if self._takes(event):
                await self._app.hand_on(event)
            return True
        if isinstance(event, events.MouseEvent) and not event.is_forwarded:
            if isinstance(event, events.MouseDown) and self._is_on_stop(event):
                self._app.action_stop_arm()
                return True
            self.alive()
            return self.fresh.stale(event.time, of_keyboard=False)
        return False

    def _takes(self, key: events.Key) -> bool:
        """Act on a stop key; return whether the framework may act on any other one."""
        self.alive()
        together = self.fresh.pasted(key.key, key.time)
        quick, self._quick = self._quick, self._may_be_quick(key)
        stale = self.fresh.stale(key.time)
        if key.key in self._app.stop_keys:
            self._app.action_stop_arm()
            return False
        if together and not (quick and self._quick):
            self.fresh.expire(key.time, PASTED)
            self._app.confirmation.refuse()  # nor do these keys confirm anything
            stale = True
        if self.fresh.overtaken(key):
            return False
        if stale:
            self._drop()
            # again behind a first key of the same paste, whose action may still wait there
            self._app.screen.call_later(self._app.call_later, self._drop)
        return not stale

    def _drop(self) -> None:
        """Disarm after a key that does not count. Without a word, the desk would seem broken."""
        if (hand := self.hand()) is not None:
            hand.disarm(self.fresh.why)
        self._app.say(f"a key was dropped: {self.fresh.why}; press again")

    def _may_be_quick(self, key: events.Key) -> bool:
        """Return whether a key types a letter or jogs; such keys may follow each other quickly."""
        if not self._app.screen_stack:
            return True  # the screens are already being taken down
        line, widget = self._line, self._app.focused
        types = line is not None and line.takes(key.character)
        consumed = widget is not None and widget.check_consume_key(key.key, key.character)
        jogs = self.hand() is not None and self._app.keys.jog_key(key.key) is not None
        return types or consumed or (jogs and len(self._app.screen_stack) == 1)

    @property
    def _line(self) -> TypedText | None:
        """The line that has the typing, if there is one."""
        line: TypedText | None = getattr(self._app.screen, "typing", None)
        return line

    @property
    def line(self) -> TypedText:
        """The line that has the typing; raises `BadRequest` without one."""
        if self._line is None:
            raise BadRequest("there is nothing here for this key")
        return self._line

    def _types(self, key: events.Key) -> bool:
        """Type a key into the current line, if there is one; return whether it was accepted."""
        line, character = self._line, key.character
        if line is None or character is None or not line.takes(character):
            return False
        with self._app.calls.acting():
            line.type(character)
        return True

    def _is_on_stop(self, event: events.MouseDown) -> bool:
        """Return whether the mouse is on the STOP button, which no dialog covers."""
        try:
            widget, _ = self._app.screen_stack[0].get_widget_at(int(event.x), int(event.y))
        except (NoWidget, IndexError):
            return False
        return isinstance(widget, StopButton)


# A call that may take a while. A text that it returns becomes the message.
Outcome = Callable[[], object]

# Errors that answer a request, with a sentence for the user.
REFUSALS = (ArmError, KinematicsError, OSError)


def words_of(error: BaseException) -> str:
    """Return the sentence of an error."""
    return str(in_words(error) if isinstance(error, OSError) else error)


@dataclass(slots=True)
class Job:
    """Work in a thread: busy until it has ended and its result has been kept."""

    busy: bool = False


class Calls:
    """Performs the actions of keys, and reports their results.

    What waits for the arm is made in a thread of its own: the app goes on taking keys, stops among
    them, and `ended` comes back into the app's thread.
    """

    def __init__(self, app: KeyApp) -> None:
        self._app = app

    @contextlib.contextmanager
    def acting(self, *, repeats: bool = False) -> Iterator[None]:
        """Perform the action of a key or a click; show its result, or why it is refused.

        The last message was about another key, and so was a first press that waits for its second
        one: both are cleared. Only keys that repeat while they are held leave the message alone:
        otherwise they would clear the reason why the arm no longer follows them.
        """
        confirmation = self._app.confirmation
        presses = confirmation.taken
        if not repeats:
            self._app.message = ""
        try:
            yield
        except REFUSALS as error:
            self._app.message = words_of(error)
        if confirmation.taken == presses:
            confirmation.forget()
        self._app.show()

    def work_out(self, work: Callable[[], Found], keep: Callable[[Found | None], object]) -> Job:
        """Compute something in a thread; keep it, or None after an error, and show the effect.

        `keep` is called in the app's own thread.
        """

        def ended(found: Found | None, wrong: str) -> None:
            keep(found)
            self._app.message = wrong or self._app.message
            self._app.show()

        return self._begin(work, ended)

    def make(self, call: Outcome, done: str = "") -> Job:
        """Make a call in a thread, then show `done`, the text that the call returns, or its error.

        With neither, the status shows enough.
        """

        def ended(found: object, wrong: str) -> None:
            if message := wrong or done or (found if isinstance(found, str) else ""):
                self._app.say(message)

        return self._begin(call, ended)

    def _begin(self, work: Callable[[], Found], ended: Callable[[Found | None, str], None]) -> Job:
        job = Job(busy=True)

        def working() -> None:
            found, wrong = None, ""
            try:
                found = work()
            except REFUSALS as error:
                wrong = words_of(error)
            except Exception as flaw:  # the desk and its stop key must live on
                wrong = f"an error in armdrive, please report it: {type(flaw).__name__}: {flaw}"
            self._app.call_from_thread(finish, found, wrong)

        def finish(found: Found | None, wrong: str) -> None:
            job.busy = False
            ended(found, wrong)

        self._app.run_worker(working, thread=True, exit_on_error=False)
        return job


@runtime_checkable
class ShowingScreen(Protocol):
    """A screen that shows what its app knows."""

    def show(self) -> None:
        """Show what has changed; called at each poll while it is the current screen."""


class KeyApp(App[int], inherit_bindings=False):
    """An app whose stop keys come before every widget, and without the framework's own keys.

    The framework passes printable keys, priority or not, to the text field being typed into; so a
    space there, also in the command palette, would not stop the arm. Its own bindings would leave
    without a stop.
    """

    CSS_PATH = Path(__file__).with_name("desk.tcss")
    ENABLE_COMMAND_PALETTE = False  # it would add a key of its own; ours stands in the table
    # instance variables, as App declares them
    HORIZONTAL_BREAKPOINTS: list[tuple[int, str]] = [(0, "-narrow"), (100, "-wide")]  # noqa: RUF012
    VERTICAL_BREAKPOINTS: list[tuple[int, str]] = [(0, "-short"), (32, "-tall")]  # noqa: RUF012
    pairs: tuple[JogPair, ...] = ()
    """The jog keys that the help explains."""
    keys_bound: Sequence[DeskKey] = TABLE
    """The rows that the bindings of the app and its screens were made from."""

    def __init__(
        self,
        keys: Keyboard,
        *,
        braille: bool,
        look: str = "",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Without `braille` everything is drawn in ASCII."""
        self.input = AppInput(self)
        self.clock = clock
        self.keys = keys
        self.stop_keys: Collection[str] = keys.of(STOP)
        """The keys that no widget may keep for itself."""
        self.look = look
        """The name of the app's theme."""
        self.calls = Calls(self)
        self.confirmation = Confirmation(clock, keys.label)
        """What the last key does after a second press, or a pause."""
        self.message = ""
        """The last message: about the last key, or about a later event."""
        colourless = bool(os.environ.get("NO_COLOR"))
        if not colourless:  # set, but to nothing: no-color.org counts that as not set
            os.environ.pop("NO_COLOR", None)
        # the framework's other way to do without colours sends them all, as shades of grey
        super().__init__(ansi_color=True if colourless else None)
        self.braille = braille
        if not braille:
            self._filters.append(PlainLetters())

    def on_mount(self) -> None:
        """Apply the user's own keys and theme."""
        self.register_theme(HIGH_CONTRAST)
        self.set_keymap(self.keys.keymap(self.keys_bound))
        self.put_on(self.look)

    # -- what is shown ------------------------------------------------------------------------

    def say(self, message: str) -> None:
        """Show a message on the current screen."""
        self.message = message
        self.show()

    def show(self) -> None:
        """Show what has changed on the current screen; dialogs may lie above it."""
        if self.is_running and self.screen_stack:  # else the screens are already being removed
            screen = self.screen_stack[0]
            laid_out = screen.is_mounted and screen.is_attached
            if laid_out and isinstance(screen, ShowingScreen):
                screen.show()

    def put_on(self, look: str) -> None:
        """Set the theme, the first one for an unknown name; without colours there is only one."""
        self.look = COLOURLESS if self.no_color else look if look in LOOKS else next(iter(LOOKS))
        self.theme, _ = LOOKS[self.look]

    def action_next_look(self) -> str:
        """Switch to the next theme."""
        names = [*LOOKS]
        self.put_on(names[(names.index(self.look) + 1) % len(names)])
        colourless = " NO_COLOR is set: no others are shown." if self.no_color else ""
        return f"look: {self.look}.{colourless}"

    def action_view(self, what: str) -> None:
        """Move the camera about the arm that is drawn."""
        if not move_cameras(self.screen, what):
            raise BadRequest("no arm is drawn here")

    def action_scroll(self, by: int) -> None:
        """Scroll the panels of the current screen by half of what is in view."""
        panels = [each for each in self.screen_stack[0].query(VerticalScroll) if each.max_scroll_y]
        if not panels:
            raise BadRequest("nothing is out of view here")
        for panel in panels:
            by_rows = by * max(panel.size.height // 2, 1)
            panel.scroll_relative(y=by_rows, animate=False, immediate=True)

    @on(Driver.SignalResume)
    def _repaint(self) -> None:
        """Repaint everything: the terminal may have shown something else meanwhile."""
        self.refresh(layout=True)

    # -- dialogs, whose keys do not move the arm ----------------------------------------------

    def open_dialog(
        self,
        dialog: ModalScreen[Answer],
        answered: Callable[[Answer | None], None] | None = None,
        reason: str = "a question is open",
    ) -> None:
        """Open a dialog above the current screen; `reason` explains why its keys are disarmed."""
        self.disarm(reason)
        self.push_screen(dialog, answered)

    def close_dialogs(self, kind: type[ModalScreen[bool]] | None = None) -> None:
        """Close dialogs, all or only the topmost ones of a kind; none of them is answered."""
        while len(self.screen_stack) > 1 and (kind is None or isinstance(self.screen, kind)):
            self.pop_screen()

    def action_help(self) -> None:
        """Show all keys."""
        self.open_dialog(help_dialog(self.keys, self.place, self.pairs), reason="the help is shown")

    def action_palette(self) -> None:
        """Show the command palette."""
        if not isinstance(self.screen, StillPalette):
            self.open_dialog(StillPalette(), reason="the commands are shown")

    # -- actions ------------------------------------------------------------------------------

    def action_erase(self) -> None:
        """Delete the last character of the line that is typed into."""
        self.input.line.erase()

    @property
    def place(self) -> str:
        """The id of the current screen in the table of keys."""
        return getattr(self.screen_stack[0], "place", "")

    def action_show_screen(self, place: str) -> None:
        """Go to a screen by its id, if there are several."""

    def action_stop_arm(self) -> None:
        """Act as the stop keys do."""
        raise NotImplementedError

    def require(self, action: str | ActionParseResult) -> None:
        """Raise `BadRequest` if the action of a key would do nothing now."""

    def disarm(self, reason: str) -> None:  # noqa: ARG002 - for apps whose keys move something
        """Let no key of the current screen move anything."""
        self.confirmation.forget()

    def act_on_confirmed(self) -> None:
        """Do what enough presses have confirmed."""
        if (act := self.confirmation.due()) is not None:
            with self.calls.acting():
                act()

    async def action_do_row(self, name: str) -> None:
        """Perform the action of a binding, by its id, as if its key had been pressed."""
        row, action = self.keys.action(name)
        if row.places and not row.counts_at(self.place):
            self.action_show_screen(row.places.split()[0])
        await self.run_action(action, self.screen_stack[0] if row.places else self)

    async def run_action(
        self,
        action: str | ActionParseResult,
        default_namespace: DOMNode | None = None,
        namespaces: Mapping[str, DOMNode] | None = None,
    ) -> bool:
        """Perform an action of a node, or of one of its parts: `part.name(1)`."""
        part, name, words = actions.parse(action) if isinstance(action, str) else action
        node = self if default_namespace is None else default_namespace
        with self.calls.acting(repeats=name == "jog"):
            self.require(action)
            if part in ("", "app"):
                node, name = self if part else node, f"action_{name}"
            elif part not in FRAMEWORK_PARTS:
                node = getattr(node, part)
            call = getattr(node, name, None)
            if call is None:
                return await super().run_action(action, default_namespace, namespaces)
            try:
                answer = await invoke(call, *words)
            except SkipAction:  # one of the framework's own, of which it is none here
                return False
            if isinstance(answer, str):
                self.message = answer
        return True

    # -- running ------------------------------------------------------------------------------

    def run_or_raise(self) -> None:
        """Run until the user leaves. Raises the error that ended the app, if one did."""
        self.run()
        if self._exception is not None:
            raise self._exception

    def _fatal_error(self) -> None:
        """End, and print nothing: `run_or_raise` raises the error, and its caller reports it.

        The framework would print a traceback with the local variables, whatever text they hold.
        """
        self._close_messages_no_wait()

    def get_driver_class(self) -> type[Driver]:
        """Return the system's own driver, made to outlive its terminal."""
        return lasting_driver(super().get_driver_class())

    async def on_event(self, event: events.Event) -> None:
        """Handle the stop keys before anything else, and drop stale input."""
        if not await self.input.handles(event):
            await self.hand_on(event)

    async def hand_on(self, event: events.Event) -> None:
        """Let the framework act on an event."""
        await super().on_event(event)


class HoldAlarm:
    """A single timer: a new time replaces the previous one."""

    def __init__(self, app: KeyApp, call: Callable[[], object]) -> None:
        self._app = app
        self._call = call
        self._timer: Timer | None = None

    def after(self, delay_s: float) -> None:
        """Fire once after this delay; infinite means never."""
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if delay_s != math.inf:
            self._timer = self._app.set_timer(max(delay_s, 0.001), self._ring)

    def _ring(self) -> None:
        self._app.input.alive()  # a key held before a suspension is not held after it
        # behind the keys that a busy app has yet to handle: the next repeat may be among them
        self._app.call_later(self._call)
