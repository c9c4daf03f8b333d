"""The base of every app of the desk: how it handles keys, and the message that follows.

The way of a key from the terminal to its action:

1. The driver's thread reads it (`lasting_driver` in terminal.py) and calls `AppInput.was_read`. A
   stop key stops the arm there, however busy the app is.
2. In the app's thread, `KeyApp.on_event` asks `AppInput.handles` before any widget.
3. `AppInput._due` lets it wait for `person_s`. Of keys that come together, none does anything.
4. `AppInput._drops` drops what is old: typed before a stop that has acted, or while this program
   was suspended.
5. `KeyApp.hand_on` leaves the rest to the framework. It first finds the keys of the table that
   work everywhere; then a line that is typed into takes the key (`AppInput._types`); then come the
   other rows of the table. Their actions arrive at `KeyApp.run_action`.
6. Every action of a key or a click runs in `Calls.acting`, so one rule holds for all: the last
   message is cleared, a first press of another key no longer counts, and a refusal becomes the new
   message.
"""

from __future__ import annotations

import contextlib
import math
import os
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Protocol, TypeVar

from textual import _time, actions, events, on
from textual.actions import ActionParseResult
from textual.app import App
from textual.containers import VerticalScroll
from textual.dom import DOMNode
from textual.driver import Driver
from textual.errors import NoWidget
from textual.filter import Monochrome
from textual.message import Message
from textual.screen import ModalScreen
from textual.timer import Timer

from armdrive.errors import ArmError, BadRequest
from armdrive.errors.printable import in_words
from armdrive.motion.dead_man import GATE_S
from kinematics.errors import KinematicsError
from tui.arm_view import move_cameras
from tui.dialogs import PostureScreen, StillPalette, help_dialog
from tui.keys.keyboard import Keyboard
from tui.keys.presses import (
    BURST,
    BurstDetector,
    Confirmation,
    StaleInput,
    SuspensionDetector,
    UrgentKeys,
)
from tui.keys.table import STOP, TABLE, DeskKey, JogPair
from tui.safety import StopButton
from tui.settings import COLOURLESS, HIGH_CONTRAST, look_after, look_named
from tui.terminal import PlainLetters, lasting_driver
from tui.widgets import TypedText

STYLES = Path(__file__).with_name("desk.tcss")

Answer = TypeVar("Answer")
Found = TypeVar("Found")

# Interval between two looks at an arm's status.
POLL_S = 0.05

# An app that was idle for this long was suspended: it polls twenty times as often.
#
# Only the drivers of Unix terminals report a suspension.
SUSPENDED_S = 1.0

# An app that was idle for this long, on a busy computer, has kept keys in its queue.
#
# A held jog has ended by itself meanwhile (`HOLD_LONGEST_S`), and must not begin again from keys
# that have waited.
STARVED_S = 0.3


class Hand(Protocol):
    """What jogs by keys. Its dead-man switch decides which presses count."""

    def disarm(self, reason: str) -> None:
        """Let no key move anything."""

    def release(self) -> None:
        """End what is held."""


class AppInput:
    """Passes keys and clicks to an app: which of them count, in which order, and who handles them.

    The stop keys come before every widget. Keys typed before a stop that has already acted are
    dropped, and so is everything that was queued while the program was suspended. A key typed into
    a line goes there; all others go to the framework, which finds their action.
    """

    def __init__(self, app: KeyApp) -> None:
        self.urgent: Mapping[str, Callable[[], object]] = {}
        """What keys do in the thread that reads them, before the app handles them."""
        self.suspended_s = SUSPENDED_S
        self.starved_s = STARVED_S
        self.person_s = GATE_S
        """A key waits this long, and does nothing if another key arrives in that time."""
        self.hand: Callable[[], Hand | None] = lambda: None
        """Returns the jogging of the current screen; None if the screen has no jog keys."""
        self._app = app
        self._bursts = BurstDetector()
        self._waiting: events.Key | None = None
        self._alarm = HoldAlarm(app, lambda: app.call_later(self.act_on_waiting))
        self.monotonic_s: Callable[[], float] = _time.get_time
        self.busy_s: Callable[[], float] = time.thread_time
        self._key: events.Key | None = None
        self._suspension = SuspensionDetector()
        self._stale = StaleInput()
        self._why_stale = ""
        self._urgent_keys = UrgentKeys()

    def was_read(self, message: Message) -> None:
        """Take what a driver has just read, in its thread."""
        self._urgent_keys.read(message, self.urgent)

    def was_suspended(self) -> None:
        """Note that the system reports a suspension; safe in a signal handler."""
        self._suspension.report()

    def begin(self) -> None:
        """Detect suspensions from now on: a slow start is not a suspension."""
        self._suspension = SuspensionDetector()

    def alive(self) -> None:
        """Note that the app is running. Call it often, and before acting on any key."""
        now_s = self.monotonic_s()
        absent_s, reported = self._suspension.look(now_s, self.busy_s())
        suspended, hand = reported or absent_s > self.suspended_s, self.hand()
        # keys that waited for less time than that matter where they jog: they are many, if held
        if not suspended and (hand is None or absent_s <= self.starved_s):
            return
        self._stale.begin(now_s)
        self._app.capture_mouse(None)  # the release of its button may be dropped
        what = "suspended" if suspended else "kept waiting"
        self._why_stale = f"this program was {what} for {absent_s:.1f} s"
        if suspended:
            self._app.disarm(self._why_stale)
        elif hand is not None:
            hand.release()  # only a key that has waited disarms: perhaps there is none

    async def handles(self, event: events.Event) -> bool:
        """Handle a key or a click; return False to leave it to the framework."""
        if isinstance(event, events.Key):
            if event.is_forwarded:  # no widget wanted it
                return self._types(event)
            for key in self._due(event):
                await self._act_on(key)
            return True
        if isinstance(event, events.MouseEvent) and not event.is_forwarded:
            if isinstance(event, events.MouseDown) and self._is_on_stop(event):
                self._app.action_stop_arm()
                return True
            self.alive()
            return self._stale.is_stale(event.time, of_keyboard=False)
        return False

    def key_age_s(self) -> float:
        """Return the age of the key being handled; 0 if there is none.

        A busy app handles keys later than they arrived, and further apart.
        """
        return 0.0 if self._key is None else max(self.monotonic_s() - self._key.time, 0.0)

    # -- which keys count, and when -----------------------------------------------------------

    def _due(self, key: events.Key) -> list[events.Key]:
        """Take a key from the terminal; return the keys to handle now, in order.

        Keys that arrive together are pasted text or a backlog: they do nothing, nor does what
        follows them until there is a pause. Exempt are keys that only type a letter, and those that
        go to the dead-man switch, which decides by itself.
        """
        waited, at_once = self._waited(), self._acts_at_once(key)
        together = self._bursts.came_together(key.key, key.time, self.person_s)
        if key.key in self._app.stop_keys:
            return [key]  # what was typed before a stop begins nothing
        if together and (waited or not at_once):
            self._stale.begin(key.time)
            self._why_stale = BURST
            if (hand := self.hand()) is not None:
                hand.disarm(BURST)  # some of the keys may be on their way to the dead-man
            self._app.confirmation.refuse()  # nor do they confirm anything
            self._app.say(f"{BURST}: they were dropped")
            return []
        if at_once or not self.person_s:
            return [*waited, key]
        self._waiting = key
        self._alarm.after(max(key.time + self.person_s - self.monotonic_s(), 0.0))
        return waited

    def _acts_at_once(self, key: events.Key) -> bool:
        """Return whether a key types a letter or jogs; such keys may follow each other quickly."""
        if not self._app.screen_stack:
            return True  # the screens are already being taken down
        line, widget = self._line, self._app.focused
        types = line is not None and line.takes(key.character)
        consumed = widget is not None and widget.check_consume_key(key.key, key.character)
        jogs = self.hand() is not None and self._app.keys.jog_key(key.key) is not None
        return types or consumed or (jogs and len(self._app.screen_stack) == 1)

    def _waited(self) -> list[events.Key]:
        """Return the waiting key, if there is one; no other key has followed it so far."""
        waiting, self._waiting = self._waiting, None
        return [] if waiting is None else [waiting]

    async def act_on_waiting(self) -> None:
        """Act on a key that no other key has followed."""
        for key in self._waited():
            await self._act_on(key)

    async def _act_on(self, key: events.Key) -> None:
        """Act on a key, unless it is too old to count."""
        self._key = key  # and so how old it is
        try:
            dropped, stops = self._drops(key), key.key in self._app.stop_keys
            if stops or dropped:
                key.stop().prevent_default()
                if stops:
                    self._app.action_stop_arm()
            else:
                await self._app.hand_on(key)
        finally:
            self._key = None

    def _drops(self, key: events.Key) -> bool:
        """Return whether a key is too old to count."""
        self.alive()
        came_s = self.monotonic_s() - self.key_age_s()
        if self._urgent_keys.overtook(key):
            return True
        stale = self._stale.is_stale(came_s)
        if stale and key.key not in self.urgent:
            if (hand := self.hand()) is not None:
                hand.disarm(self._why_stale)
            # without a word, it would seem broken
            self._app.say(f"a key was dropped: {self._why_stale}; press again")
        return stale

    # -- what takes them ----------------------------------------------------------------------

    @property
    def _line(self) -> TypedText | None:
        """The line that has the typing, if there is one."""
        line: TypedText | None = getattr(self._app.screen, "typing", None)
        return line

    def _types(self, key: events.Key) -> bool:
        """Type a key into the current line, if there is one; return whether it was accepted."""
        line, character = self._line, key.character
        if line is None or character is None or not line.takes(character):
            return False
        key.stop().prevent_default()
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


# The keys of the table act through the framework's actions. It looks for them on the app and on
# widgets alone; ours may also be methods of the parts that an app or a screen is made of.

# The framework's own namespaces of actions.
NODES = ("app", "screen", "focused")

# Represents a part that a node does not have.
NO_PART = object()


def _refuse() -> None:
    """Refuse an action: its part does not exist at present."""
    raise BadRequest("there is nothing here for this key")


def action_call(action: str | ActionParseResult, node: object) -> Callable[[], object] | None:
    """Return the call for an action of a node, None if there is none.

    `name(1)` is the node's own `action_name`, `part.name(1)` is `name` of one of its parts. A part
    may be None at times, as the line that is typed into: a key for it is then refused.
    """
    part, name, words = actions.parse(action) if isinstance(action, str) else action
    holder = getattr(node, part, NO_PART) if part else node
    if holder is None:
        return _refuse
    found = getattr(holder, name if part else f"action_{name}", None)
    return partial(found, *words) if callable(found) else None


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
        """Do work in a thread, without keeping the stop key waiting.

        Then `ended` is called in the app's own thread, with what the work has found, or with the
        words of its error.
        """
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


class Dialogs:
    """The dialogs above the current screen, whose keys do not move the arm meanwhile."""

    def __init__(self, app: KeyApp) -> None:
        self._app = app

    def open(
        self,
        dialog: ModalScreen[Answer],
        answered: Callable[[Answer | None], None] | None = None,
        reason: str = "a question is open",
    ) -> None:
        """Open a dialog above the current screen; `reason` explains why its keys are disarmed."""
        self._app.disarm(reason)
        self._app.push_screen(dialog, answered)

    def close_all(self) -> None:
        """Close all dialogs; a question in them stays unanswered."""
        while len(self._app.screen_stack) > 1:
            self._app.pop_screen()

    def close_questions(self) -> None:
        """Close the topmost question; it stays unanswered."""
        while isinstance(self._app.screen, PostureScreen):
            self._app.pop_screen()

    def help(self) -> None:
        """Show all keys."""
        dialog = help_dialog(self._app.keys, self._app.place, self._app.pairs)
        self.open(dialog, reason="the help is shown")

    def palette(self) -> None:
        """Show the command palette."""
        self._app.disarm("the commands are shown")
        if not isinstance(self._app.screen, StillPalette):
            self._app.push_screen(StillPalette())


class Looks:
    """The theme of an app, and how it is changed."""

    def __init__(self, app: KeyApp, name: str) -> None:
        self._app = app
        self.name = name
        """The name of the app's theme."""

    def put_on(self, name: str) -> None:
        """Set the theme; without colours there is only one."""
        look = COLOURLESS if self._app.no_color else look_named(name)
        if HIGH_CONTRAST.name not in self._app.available_themes:
            self._app.register_theme(HIGH_CONTRAST)
        self._app.theme = look.theme
        self.name = look.name

    def put_on_next(self) -> None:
        """Switch to the next theme."""
        self.put_on(look_after(self.name).name)
        colourless = " NO_COLOR is set: no others are shown." if self._app.no_color else ""
        self._app.say(f"look: {self.name}.{colourless}")


class KeyApp(App[int], inherit_bindings=False):
    """An app whose stop keys come before every widget, and without the framework's own keys.

    The framework passes printable keys, priority or not, to the text field being typed into; so a
    space there, also in the command palette, would not stop the arm. Its own bindings would leave
    without a stop.
    """

    CSS_PATH = STYLES
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
        self.looks = Looks(self, look)
        self.dialogs = Dialogs(self)
        self.calls = Calls(self)
        self.confirmation = Confirmation(clock, keys.label)
        """What the last key does after a second press, or a pause."""
        self.message = ""
        """The last message: about the last key, or about a later event."""
        # its other way to do without colours sends them all, as shades of grey
        super().__init__(ansi_color=True if os.environ.get("NO_COLOR") else None)
        self.braille = braille
        if not braille:
            self._filters.append(PlainLetters())
        if not self.no_color or os.environ.get("NO_COLOR"):
            return
        self.no_color = False  # set, but to nothing: no-color.org counts that as not set
        self._filters = [each for each in self._filters if not isinstance(each, Monochrome)]

    def on_mount(self) -> None:
        """Apply the user's own keys and theme."""
        self.set_keymap(self.keys.keymap(self.keys_bound))
        self.looks.put_on(self.looks.name)

    def say(self, message: str) -> None:
        """Show a message on the current screen."""
        self.message = message
        self.show()

    def show(self) -> None:
        """Show what has changed."""

    def disarm(self, reason: str) -> None:  # noqa: ARG002 - for apps whose keys move something
        """Let no key of the current screen move anything."""
        self.confirmation.forget()

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

    def action_stop_arm(self) -> None:
        """Act as the stop keys do."""
        raise NotImplementedError

    @property
    def place(self) -> str:
        """The id of the current screen in the table of keys."""
        return getattr(self.screen_stack[0], "place", "")

    def show_place(self, place: str) -> None:
        """Go to the screen on which a row of the table of keys counts, if there are several."""

    def require(self, action: str | ActionParseResult) -> None:
        """Raise `BadRequest` if the action of a key would do nothing now."""

    async def action_do_row(self, name: str) -> None:
        """Perform a row of the table of keys, as if its key had been pressed on its screen."""
        row = self.keys.row(name)
        if row.places and not row.counts_at(self.place):
            self.show_place(row.places.split()[0])
        await self.run_action(row.action, self.screen_stack[0] if row.places else self)

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

    async def run_action(
        self,
        action: str | ActionParseResult,
        default_namespace: DOMNode | None = None,
        namespaces: Mapping[str, DOMNode] | None = None,
    ) -> bool:
        """Perform an action of a node, or of one of its parts."""
        part, name, _ = actions.parse(action) if isinstance(action, str) else action
        node = self if default_namespace is None else default_namespace
        with self.calls.acting(repeats=name == "jog"):
            self.require(action)
            call = action_call(action, node) if part and part not in NODES else None
            if call is None:  # the framework's, or a row that names nothing: it raises then
                return await super().run_action(action, default_namespace, namespaces)
            answer = call()
            if isinstance(answer, str):
                self.message = answer
        return True

    async def on_event(self, event: events.Event) -> None:
        """Handle the stop keys before anything else, and drop stale input."""
        if not await self.input.handles(event):
            await self.hand_on(event)

    async def hand_on(self, event: events.Event) -> None:
        """Let the framework act on an event."""
        await super().on_event(event)


# If a timer fires this late, the app was busy, and keys may be waiting in its queue.
BUSY_S = 0.02

# The time that events queued while the app was busy need to be processed: the release of a key, or
# its next repeat, may be among them.
SETTLE_S = 0.03


class HoldAlarm:
    """A single timer: a new time replaces the previous one.

    If the app was too busy to fire it in time, it handles queued events first.
    """

    def __init__(self, app: KeyApp, call: Callable[[], object]) -> None:
        self._app = app
        self._call = call
        self._timer: Timer | None = None
        self._due_s = math.inf

    def after(self, delay_s: float) -> None:
        """Fire once after this delay; infinite means never."""
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if delay_s != math.inf:
            delay_s = max(delay_s, 0.001)
            self._due_s = time.monotonic() + delay_s
            self._timer = self._app.set_timer(delay_s, self._ring)

    def _ring(self) -> None:
        self._app.input.alive()  # a key held before a suspension is not held after it
        if time.monotonic() - self._due_s > BUSY_S:
            self.after(SETTLE_S)
        else:
            self._call()
