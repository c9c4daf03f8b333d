"""The desk itself: it owns the arm, polls its status, stops it, and gets a lost link back."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import ClassVar

from textual import events
from textual.app import SystemCommand
from textual.binding import BindingType
from textual.screen import Screen

from armdrive.errors import ArmError
from tui import panels
from tui.arm_port import DeskArm
from tui.asking import ask_confirm, ask_motors, ask_reference
from tui.dialogs import FirstScreen, HelpScreen
from tui.framework import on_ending_signals
from tui.keyboard import DEFAULT_KEYS, Keyboard
from tui.layout import CSS, bindings
from tui.linked import LinkedOwner
from tui.memory import Remembered, left_at, manner_of, recall, remember, set_as
from tui.pad_desk import PadDesk
from tui.pad_reader import Pad
from tui.palette import StillPalette, commands
from tui.screens import SCREENS
from tui.themes import look_after, put_on
from tui.widgets.arm_view import move_cameras

POLL_S = 0.05
"""The arm's latest status is looked at so often, however often it changes."""

_SIGNAL_EXIT = 128  # a shell's way to say which signal ended a program


class Desk(LinkedOwner):
    """One arm and its screens. Every way out of it, and every change of screen, stops a jog."""

    TITLE = "armdrive"
    ABSENT_S = 1.0
    STARVED_S = 0.3
    BINDINGS: ClassVar[list[BindingType]] = bindings("")
    CSS = CSS
    MODES: ClassVar = {entry.id: entry.make for entry in SCREENS}
    DEFAULT_MODE = SCREENS[0].id
    HORIZONTAL_BREAKPOINTS = [(0, "-narrow"), (100, "-wide")]  # noqa: RUF012 - as App declares it

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
    ) -> None:
        """`find_pad` opens a gamepad, or returns None; without it none is looked for."""
        super().__init__(arm, braille=braille, clock=clock, keys=keys)
        self._handle_signals = handle_signals
        self._memory = memory
        self.reopens = False
        """Whether whoever runs this desk would open the next one on another arm file."""
        self.opens: Path | None = None
        self._left = Remembered(instructed=True) if memory is None else recall(memory)
        if first:
            self._left = replace(self._left, screen=first)
        self.settings = set_as(self.settings, self._left)
        self.manner = manner_of(self._left)
        self.look_name = self._left.look
        self.pad = None if find_pad is None else PadDesk(self, find_pad)

    # -- what is shown ------------------------------------------------------------------------

    def on_mount(self) -> None:
        """Begin to watch the arm."""
        if self._handle_signals:
            on_ending_signals(self._end_by_signal)
        self.set_keymap(self.keys.keymap())
        self.look(self.look_name)
        self.set_interval(POLL_S, self.poll)
        if self.pad is not None:
            self.pad.start()
        if self._left.screen in self.MODES:
            self.show_screen(self._left.screen)
        if not self._left.instructed:
            self.push_screen(FirstScreen(self.keys, self.status), self._instructed)

    def _instructed(self, understood: bool | None) -> None:
        self._left = replace(self._left, instructed=bool(understood))

    def poll(self) -> None:
        """Take the latest status and show what changed."""
        self.alive()
        self.take(self.arm.status)
        self.show()

    def woken(self, time_s: float) -> None:
        """Let no key move the arm that was typed while the desk was suspended."""
        self.disarm(f"this screen had stood still for {time_s:.1f} s")

    def starved(self, time_s: float) -> None:
        """Let no key move the arm that may have waited for the desk."""
        if self.screen_stack and self.place.hand is not None:
            self.place.hand.doubt(time_s)

    def show_screen(self, screen: str) -> None:
        """Go to a screen by its id. What the one before held ends first."""
        self.disarm("another screen is shown")
        self.close_dialogs()
        self.switch_mode(screen)

    def action_show_screen(self, screen: str) -> None:
        """Go to a screen by its id. What was said on the one before is of no use there."""
        self.message = ""
        self.show_screen(screen)

    def look(self, name: str) -> None:
        """Put on other colours."""
        self.look_name = put_on(self, name)

    def action_next_look(self) -> None:
        """Put on the next colours."""
        self.look(look_after(self.look_name).name)
        none = " NO_COLOR is set: no others are shown." if self.no_color else ""
        self.say(f"look: {self.look_name}.{none}")

    def action_view(self, what: str) -> None:
        """Move the watcher about the arm that is drawn."""
        if not move_cameras(self.screen, what):
            self.say("no arm is drawn here")

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Offer what the tables have, and nothing of the framework's own."""
        del screen
        return commands(self)

    def action_command_palette(self) -> None:
        """Open the palette; behind it no key moves the arm."""
        self.disarm("the commands are shown")
        if not isinstance(self.screen, StillPalette):
            self.push_screen(StillPalette())

    # -- what is asked ------------------------------------------------------------------------

    def action_help(self) -> None:
        """Show all keys."""
        self.disarm("the help is shown")
        self.push_screen(HelpScreen(self.keys, self.place.place, self.settings.pairs))

    def action_reference(self) -> None:
        """Ask whether the arm stands in its reference posture."""
        ask_reference(self)

    def action_confirm(self) -> None:
        """Ask whether the arm stands where it is remembered to."""
        ask_confirm(self)

    def action_motors(self) -> None:
        """Switch the motors on, or off after a question."""
        ask_motors(self)

    # -- stopping and ending ------------------------------------------------------------------

    def first_keys(self) -> Mapping[str, Callable[[], None]]:
        """Return what no widget may keep for itself: the stop."""
        return dict.fromkeys(self.keys.of("stop"), self.action_stop_arm)

    def urgent_keys(self) -> Mapping[str, Callable[[], object]]:
        """Return what waits for no picture: the stop."""
        return dict.fromkeys(self.keys.of("stop"), self.arm.request_stop)

    def action_stop_arm(self) -> None:
        """Stop the arm before anything else, then disarm and show the screen."""
        self.arm.request_stop()
        self.disarm("stopped")
        self.message = "STOP was asked for; the keys are disarmed"
        self.close_dialogs()
        self.show()

    def action_estop(self) -> None:
        """Stop and latch the error state."""
        self.arm.estop()
        self.disarm("emergency stop")

    def action_reset(self) -> None:
        """Leave the error state."""
        if not self.nobody_there():
            self.call(self.arm.reset, partial(panels.after_reset, keys=self.keys))

    def action_leave(self) -> None:
        """Stop the arm and end the desk."""
        self.arm.request_stop()
        self.exit(0)

    def open_next(self, path: Path) -> None:
        """Leave this arm, so that a desk is opened on the one of an arm file."""
        self.opens = path
        self.action_leave()

    def on_app_blur(self) -> None:
        """Disarm when the terminal says that another window has the keyboard."""
        self.disarm("the terminal lost the keyboard focus")

    def on_paste(self, event: events.Paste) -> None:
        """Disarm on pasted text: it may be backlog that a multiplexer took for a paste."""
        event.stop()
        self.disarm("text was pasted, and dropped")

    def on_unmount(self) -> None:
        """Stop the arm, whatever it was that ended the desk, and remember where it was left."""
        self.arm.request_stop()
        if self.pad is not None:
            self.pad.close()
        if self._memory is None:
            return
        left = left_at(
            self.settings,
            self.manner,
            self.current_mode,
            self._left.look if self.no_color else self.look_name,
            instructed=self._left.instructed,
        )
        with contextlib.suppress(OSError):  # a desk that is forgotten harms nobody
            remember(self._memory, left)

    def _end_by_signal(self, number: int) -> None:
        """Leave the arm standing and closed before the framework tidies up."""
        self.arm.request_stop()
        try:
            self.arm.close()
        except ArmError:
            self.arm.request_stop()  # it would not confirm that it stands; nobody is there to tell
        self.exit(_SIGNAL_EXIT + number, return_code=_SIGNAL_EXIT + number)
