"""The desk itself: it puts the screens and their helpers together, polls the arm and stops it."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import ClassVar

from textual import events
from textual.app import SystemCommand
from textual.binding import BindingType
from textual.screen import Screen

from armdrive.errors import ArmError
from armdrive.status import Status, Trust
from kinematics.spaces import Joints
from tui.app import SUSPENDED_S, KeyApp
from tui.arm_port import DeskArm, Done, outcome
from tui.arm_view import move_cameras
from tui.control import ArmControl, ArmLink
from tui.dialogs import Dialogs, FirstScreen, commands
from tui.gamepad.jogging import PadDesk
from tui.gamepad.reader import Pad
from tui.jog.screen import JogScreen
from tui.keys.keyboard import DEFAULT_KEYS, Keyboard, bindings
from tui.keys.rows import STOP
from tui.keys.table import SCREENS, jog_pairs, spoken
from tui.log.screen import LogScreen
from tui.look import Looks
from tui.move.screen import MoveScreen
from tui.points.screen import PointsScreen
from tui.screens import DeskScreen, ScreenHost, Screens
from tui.settings import (
    REAL_SPEED,
    SIMULATED_SPEED,
    ArmMemory,
    DeskMemory,
    JogSettings,
    Manner,
    left_at,
    manner_of,
    recall,
    remember,
    set_as,
)
from tui.terminal import KeyUp, on_ending_signals

POLL_S = 0.05
"""How often the arm's latest status is looked at, however often it changes."""

STARVED_S = 0.3
"""A desk that did nothing for this long has kept its keys waiting."""

_SIGNAL_EXIT = 128  # a shell's way to say which signal ended a program


def _late_screen(place: str) -> DeskScreen:
    """Make a screen whose modules take as long to load as the desk itself."""
    from tui.late_screens import LATE_SCREENS

    return LATE_SCREENS[place]()


def dropped_words(time_s: float) -> str:
    """Say why a key had no effect: a key that is dropped without a word seems broken."""
    return f"a key was dropped: this program was suspended for {time_s:.1f} s; press again"


def _first_screen(status: Status, left: ArmMemory) -> str:
    """Return the screen to begin at: the last one, but the jog screen without a position."""
    return "" if status.trust is Trust.UNKNOWN else left.screen


class Desk(KeyApp):
    """One arm and its screens. Every way out of it, and every change of screen, stops a jog."""

    TITLE = "armdrive"
    BINDINGS: ClassVar[list[BindingType]] = bindings("")
    MODES: ClassVar = {
        "jog": JogScreen,
        "move": MoveScreen,
        "points": PointsScreen,
        "log": LogScreen,
        **{place: partial(_late_screen, place) for place in ("setup", "theory", "program")},
    }
    DEFAULT_MODE = SCREENS[0].id

    def __init__(
        self,
        arm: DeskArm,
        *,
        braille: bool,
        clock: Callable[[], float] = time.monotonic,
        handle_signals: bool = False,
        keys: Keyboard = DEFAULT_KEYS,
        memory: Path | None = None,
        first: str = "",
        find_pad: Callable[[], Pad | None] | None = None,
        program: Path | None = None,
    ) -> None:
        """`find_pad` opens a gamepad, or returns None; without it none is looked for.

        `program` is the file that the program screen begins with.
        """
        super().__init__()
        self.arm = arm
        self.braille = braille
        self.clock = clock
        self.keys = keys
        self.stop_keys = keys.of(STOP)
        self._handle_signals = handle_signals
        self._memory = memory
        self._left = DeskMemory(instructed=True) if memory is None else recall(memory)
        left = self._left.of(arm.status)
        self._first = first or _first_screen(arm.status, left)
        geometry = arm.model.arm
        pairs = jog_pairs(geometry.joint_names, has_yaw=geometry.has_yaw)
        self._joint_names = geometry.joint_names
        speed = SIMULATED_SPEED if arm.status.simulated else REAL_SPEED
        self.settings = set_as(JogSettings(pairs=pairs, frames=arm.frames, speed=speed), left)
        self.manner = manner_of(left, Manner() if arm.status.simulated else Manner(speed=0.25))
        """How the move screen's goals are given and gone to."""
        self.message = ""
        """The last message; each screen has a hint of its own for when there is none."""
        self.goal: Joints | None = None
        """A posture that one screen has left for the move screen."""
        self.program = program
        self.programs = Path.cwd()
        self.reopens = False
        """Whether the program that runs this desk would open the next one on another arm file."""
        self.opens: Path | None = None
        self.screens = Screens(self)
        disarm, say = self.screens.disarm, self.say
        self.input.urgent = dict.fromkeys(self.stop_keys, arm.request_stop)
        self.input.suspended_s, self.input.starved_s = SUSPENDED_S, STARVED_S
        self.input.on_resumed, self.input.on_starved = self.screens.resumed, self.screens.starved
        self.input.on_dropped = lambda time_s: say(dropped_words(time_s))
        self.link = ArmLink(
            arm, keys, say=say, disarm=disarm, close_dialogs=self.screens.close_dialogs
        )
        self.dialogs = Dialogs(
            self, keys, pairs, place=lambda: self.screens.current.place, disarm=disarm
        )
        self.control = ArmControl(
            arm,
            keys,
            self.link,
            self.dialogs,
            braille=braille,
            spoken=self.spoken,
            say=say,
            call=self.call,
            disarm=disarm,
        )
        colourless = " NO_COLOR is set: no others are shown." if self.no_color else ""
        self.looks = Looks(self, self._left.look, lambda name: say(f"look: {name}.{colourless}"))
        self.pad = None if find_pad is None else PadDesk(self, find_pad)

    @property
    def place(self) -> DeskScreen:
        """The screen that the desk is at; dialogs may lie over it."""
        return self.screens.current

    @property
    def armed(self) -> bool:
        """Whether keys move the arm at once."""
        return self.place.armed

    # -- what is shown ------------------------------------------------------------------------

    def on_mount(self) -> None:
        """Begin to watch the arm."""
        if self._handle_signals:
            on_ending_signals(self._end_by_signal)
        self.set_keymap(self.keys.keymap())
        self.looks.put_on(self.looks.name)
        self.polling = self.set_interval(POLL_S, self.poll)
        self.call_after_refresh(self.input.begin)
        if self.pad is not None:
            self.pad.start()
        if self._first in self.MODES:
            self.screens.go_to(self._first)
        if not self._left.instructed:
            self.push_screen(FirstScreen(self.keys, self.link.status), self._instructed)

    def _instructed(self, understood: bool | None) -> None:
        self._left = replace(self._left, instructed=bool(understood))

    def poll(self) -> None:
        """Take the latest status and show what changed."""
        self.input.alive()
        self.link.take(self.arm.status)
        self.show()

    def show(self) -> None:
        """Show the latest status on the current screen."""
        self.screens.show(self.link.status)

    def say(self, message: str) -> None:
        """Say something on whatever screen is shown."""
        self.message = message
        self.show()

    def spoken(self, text: str) -> str:
        """Return a text in the words of the desk, with the joints as people write them."""
        return spoken(self.keys.presented(text), self._joint_names)

    def action_show_screen(self, screen: str) -> None:
        """Go to a screen by its id. The last message was about the one before."""
        self.message = ""
        self.screens.go_to(screen)

    def show_place(self, place: str) -> None:
        """Go to the screen on which a row of the table of keys counts."""
        if place and place != self.place.place:
            self.action_show_screen(place)

    def action_view(self, what: str) -> None:
        """Move the camera about the arm that is drawn."""
        if not move_cameras(self.screen, what):
            self.say("no arm is drawn here")

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Offer the actions of this screen, actions with other search words, and the looks."""
        del screen
        here = self.place.place
        known = (row for row in self.keys.rows if row.also and row.place not in ("", here))
        return commands(
            (*self.keys.at(here), *known),
            self.action_do_row,
            self.looks.put_on,
        )

    # -- calls that take a moment -------------------------------------------------------------

    def in_thread(self, work: Callable[[], object]) -> None:
        """Do work that takes a moment, without keeping the stop key waiting."""
        self.run_worker(work, thread=True, exit_on_error=False)

    def call(self, call: Callable[[], object], done: Done) -> None:
        """Make a call in a thread, and show how it went.

        `done` is the message after success, or makes one of the status; None shows no message.
        """

        def work() -> None:
            if (message := outcome(self.arm, call, done)) is not None:
                self.call_from_thread(self.say, message)

        self.in_thread(work)

    # -- stopping and ending ------------------------------------------------------------------

    def action_stop_arm(self) -> None:
        """Stop the arm before anything else, then disarm and show the screen."""
        self.arm.request_stop()
        self.screens.disarm("stopped")
        self.message = "STOP was asked for; the keys are disarmed"
        self.screens.close_dialogs()
        self.show()

    def action_leave(self) -> None:
        """Stop the arm and end the desk."""
        self.arm.request_stop()
        self.exit(0)

    def open_next(self, path: Path) -> None:
        """Leave this arm, for a desk on the arm of a file."""
        self.opens = path
        self.action_leave()

    def on_key_up(self, event: KeyUp) -> None:
        """End what a jog key holds as soon as the terminal reports its release."""
        key, hand = self.keys.jog_key(event.key), self.screens.hand
        if key is not None and hand is not None:
            hand.key_up(key)

    def on_app_blur(self) -> None:
        """Disarm when the terminal says that another window has the keyboard."""
        self.screens.disarm("the terminal lost the keyboard focus")

    def on_paste(self, event: events.Paste) -> None:
        """Disarm on pasted text: it may be backlog that a multiplexer took for a paste."""
        event.stop()
        self.screens.disarm("text was pasted, and dropped")

    def on_unmount(self) -> None:
        """Stop the arm, whatever it was that ended the desk, and remember where it was left."""
        self.arm.request_stop()
        if self.pad is not None:
            self.pad.close()
        if self._memory is None:
            return
        look = self._left.look if self.no_color else self.looks.name
        arm = left_at(self.settings, self.manner, self.current_mode)
        left = replace(self._left.with_arm(self.link.status, arm), look=look)
        with contextlib.suppress(OSError):  # losing these settings does no harm
            remember(self._memory, left)

    def _end_by_signal(self, number: int) -> None:
        """Leave the arm standing and closed before the framework tidies up."""
        self.arm.request_stop()
        try:
            self.arm.close()
        except ArmError:
            self.arm.request_stop()  # no one is left to read that the arm did not confirm
        self.exit(_SIGNAL_EXIT + number, return_code=_SIGNAL_EXIT + number)


_: type[ScreenHost] = Desk  # screens reach it as `app`: here the type checker compares the two
