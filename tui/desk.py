"""The desk itself: it owns the arm, polls its status, stops it, and gets a lost link back."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import ClassVar, cast

from textual import events
from textual.app import SystemCommand
from textual.binding import BindingType
from textual.screen import Screen

from armdrive.errors import ArmError
from armdrive.render.side_view import ArmScene
from armdrive.status import State, Status, Trust
from kinematics.errors import KinematicsError
from kinematics.spaces import Joints
from tui.arm_port import DeskArm
from tui.arm_view import move_cameras, scene_of
from tui.framework import FirstKeys, on_ending_signals
from tui.gamepad.hand import PadDesk
from tui.gamepad.reader import Pad
from tui.jog.jogging import DeskJogging
from tui.jog.screen import JogScreen
from tui.keys.keyboard import DEFAULT_KEYS, Keyboard, bindings
from tui.keys.rows import STOP, DeskKey
from tui.keys.table import SCREENS, jog_pairs, spoken
from tui.log.screen import LogScreen
from tui.look import (
    CSS,
    STANDS_SO,
    FirstScreen,
    HelpScreen,
    PostureScreen,
    StillPalette,
    commands,
    look_after,
    put_on,
)
from tui.move.screen import MoveScreen
from tui.panels import after_reset, at_work, link_back, look_for_it
from tui.points.screen import PointsScreen
from tui.screens import DeskScreen, Done, ScreenHost
from tui.settings import DeskMemory, JogSettings, left_at, manner_of, recall, remember, set_as

POLL_S = 0.05
"""The arm's latest status is looked at so often, however often it changes."""

_SIGNAL_EXIT = 128  # a shell's way to say which signal ended a program


def _setup_screen() -> DeskScreen:
    """Make the set-up screen; what it asks of ports takes as long to load as the desk itself."""
    from tui.setup.screen import SetupScreen

    return SetupScreen()


def _theory_screen() -> DeskScreen:
    """Make the theory screen; the textbook takes as long to load as the desk itself."""
    from tui.theory.screen import TheoryScreen

    return TheoryScreen()


class Desk(FirstKeys):
    """One arm and its screens. Every way out of it, and every change of screen, stops a jog."""

    TITLE = "armdrive"
    ABSENT_S = 1.0
    STARVED_S = 0.3
    BINDINGS: ClassVar[list[BindingType]] = bindings("")
    CSS = CSS
    MODES: ClassVar = {
        "jog": JogScreen,
        "move": MoveScreen,
        "points": PointsScreen,
        "setup": _setup_screen,
        "theory": _theory_screen,
        "log": LogScreen,
    }
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
        super().__init__()
        self.arm = arm
        self.braille = braille
        self.clock = clock
        self.keys = keys
        self._handle_signals = handle_signals
        self._memory = memory
        self._left = DeskMemory(instructed=True) if memory is None else recall(memory)
        if first:
            self._left = replace(self._left, screen=first)
        geometry = arm.model.arm
        pairs = jog_pairs(geometry.joint_names, has_yaw=geometry.has_yaw)
        self._joint_names = geometry.joint_names
        self.settings = set_as(JogSettings(pairs=pairs, frames=arm.frames), self._left)
        self.manner = manner_of(self._left)
        """How the move screen's goals are given and gone to."""
        self.look_name = self._left.look
        self.message = ""
        """What was said last; each screen has a hint of its own for when nothing was."""
        self.status: Status = arm.status
        self.goal: Joints | None = None
        """A posture that one screen has left for the move screen."""
        self._was_lost = False
        self.paused_here = False
        """Whether the arm waits because of this desk, and not of somebody outside."""
        self.reopens = False
        """Whether whoever runs this desk would open the next one on another arm file."""
        self.opens: Path | None = None
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
        return commands(self.keys.at(self.place.place), self._run_row, self.look)

    async def _run_row(self, row: DeskKey) -> None:
        await self.run_action(row.action, self.place if row.place else self)

    def action_command_palette(self) -> None:
        """Open the palette; behind it no key moves the arm."""
        self.disarm("the commands are shown")
        if not isinstance(self.screen, StillPalette):
            self.push_screen(StillPalette())

    @property
    def place(self) -> DeskScreen:
        """The screen that the desk is at; dialogs may lie over it."""
        return cast("DeskScreen", self.screen_stack[0])

    @property
    def armed(self) -> bool:
        """Whether keys move the arm at once."""
        return self.place.armed

    @property
    def at_work(self) -> str:
        """The program or sequence that the arm is at work on, and how far it is, in few words."""
        program = self.arm.program
        return "" if program is None else at_work(program())

    def show(self) -> None:
        """Show the latest status on the current screen."""
        if self.is_running and self.screen_stack:  # else they are already being taken down
            self.place.show(self.status)

    def say(self, message: str) -> None:
        """Say something on whatever screen is shown."""
        self.message = message
        self.show()

    def spoken(self, text: str) -> str:
        """Return a text in the words of the desk, with the joints as people write them."""
        return spoken(self.keys.presented(text), self._joint_names)

    def scene(self) -> ArmScene | None:
        """Return what is to be drawn of the arm as it stands; None while that is not known."""
        joints = self.status.joints
        if joints is None:
            return None
        return scene_of(self.arm.model, joints, self.status.gripper_mm)

    def disarm(self, reason: str) -> None:
        """Let go of what the current screen holds, and let no key of it move the arm."""
        if self.screen_stack:  # else they are already being taken down
            self.place.disarm(reason)

    def close_dialogs(self) -> None:
        """Take away whatever lies over the current screen; no question in it is answered."""
        while len(self.screen_stack) > 1:
            self.pop_screen()

    # -- what is asked, and called ------------------------------------------------------------

    def call(self, call: Callable[[], object], done: Done) -> None:
        """Make a call that takes a moment, without keeping the stop key waiting.

        `done` is said when it has gone well, or what it says of the status then; without it the
        status speaks for itself.
        """
        self.run_worker(partial(self._called, call, done), thread=True, exit_on_error=False)

    def _called(self, call: Callable[[], object], done: Done) -> None:
        try:
            call()
            said = done(self.arm.status) if callable(done) else done
        except (ArmError, KinematicsError) as error:
            said = str(error)
        except Exception as flaw:  # said, not swallowed: the desk and its stop key live on
            said = f"a flaw of armdrive, please report it: {type(flaw).__name__}: {flaw}"
        if said is not None:
            self.call_from_thread(self.say, said)

    def ask(
        self,
        question: str,
        scene: ArmScene | None,
        agreed: Callable[[], object],
        done: Done = "confirmed: the position is referenced",
        *,
        asked: str = STANDS_SO,
    ) -> None:
        """Draw a posture with a question, and make the call if the answer to `asked` is yes."""
        self.disarm("a question is open")

        def answered(stands: bool | None) -> None:
            if stands:
                self.call(agreed, done)
            else:
                self.say("not confirmed: nothing was changed")

        self.push_screen(
            PostureScreen(
                self.spoken(question), scene, self.keys, braille=self.braille, asked=asked
            ),
            answered,
        )

    def action_help(self) -> None:
        """Show all keys."""
        self.disarm("the help is shown")
        self.push_screen(HelpScreen(self.keys, self.place.place, self.settings.pairs))

    def action_reference(self) -> None:
        """Ask whether the arm stands in its reference posture; a simulated one is brought there."""
        if self.nobody_there():
            return
        arm = self.arm
        if arm.homes_by_switches:
            text = "THE ARM WILL MOVE: its controller seeks its switches."
            done = "homed by its own switches"
            self.ask(text, self.scene(), arm.home, done, asked="Is its way clear?")
            return
        if self.status.simulated:
            self.disarm("the simulated operator is at work")
            self.call(arm.home, "the simulated operator referenced the arm")
            return
        try:
            request = arm.reference_request()
        except (ArmError, KinematicsError) as error:
            self.say(str(error))
            return
        scene = scene_of(arm.model, request.joints, request.opening_mm)
        self.ask(str(request), scene, arm.confirm_reference)

    def action_confirm(self) -> None:
        """Ask whether the arm stands where it is remembered to."""
        status = self.status
        if self.nobody_there():
            return
        if status.trust is not Trust.RESTORED or status.joints is None:
            self.say(f"nothing to confirm: the position is {status.trust.value}")
            return
        scene = scene_of(self.arm.model, status.joints, status.gripper_mm)
        text = f"Remembered ({status.trust_reason}): {status.joints}"
        self.ask(text, scene, self.arm.confirm_restored)

    def action_motors(self) -> None:
        """Switch the motor current on; off only after a question, since the arm sags then."""
        if self.nobody_there():
            return
        if self.status.state is State.DISABLED:
            self.call(self.arm.enable, "the motors are on: nothing was moved")
            return
        text = "The motors are switched off: THE ARM SAGS, and its position is lost."
        self.ask(
            text, self.scene(), self.arm.disable, "the motors are off", asked="Is it supported?"
        )

    # -- the link, the pause, the gamepad -----------------------------------------------------

    def take(self, status: Status) -> None:
        """Take the latest status."""
        if self.status.paused and not status.paused:
            self.paused_here = False  # the next pause may be somebody else's
        self.status = status
        if self.lost:
            self._note_loss()
        elif self._was_lost:
            self._note_return()

    def pause_or_go_on(self) -> None:
        """Hold the arm up behind its next burst, or let it go on."""
        self.paused_here = not self.status.paused
        (self.arm.pause if self.paused_here else self.arm.resume)()

    @property
    def lost(self) -> bool:
        """Whether there is no link to the arm."""
        return self.status.state is State.DISCONNECTED

    def nobody_there(self) -> bool:
        """Say so where there is no link to an arm of which something could be asked."""
        if self.lost:
            self.say(f"there is no link to the arm, and no key moves it: {look_for_it(self.keys)}")
        return self.lost

    def _note_loss(self) -> None:
        """Let no key jog, and take away what was asked of an arm that is gone."""
        self.disarm("the link is lost")
        if not self._was_lost:
            self._was_lost = True
            self.message = ""  # what was said of a link that there was is of no use now
            self.close_dialogs()

    def _note_return(self) -> None:
        """Say what a link that came back has ended in; before that it has not proved itself."""
        if self.status.state in (State.ERROR_STOP, State.DISABLED):
            self._was_lost = False
            self.message = link_back(self.status, self.keys)

    def action_reconnect(self) -> None:
        """Look for a lost link once, now. Moves nothing."""
        if self.lost:
            self.say("looking for the link ...")
        self.call(self.arm.reconnect, None)

    @property
    def jogging(self) -> DeskJogging | None:
        """The hand on the jog keys, where there is a link and they are shown."""
        return None if self.lost or not self.screen_stack else self.place.hand

    def press_row(self, name: str) -> None:
        """Do what a row of the table of keys does: the stop anywhere, others where keys jog."""
        if name == STOP:
            self.action_stop_arm()
        elif self.place.hand is not None and len(self.screen_stack) == 1:
            getattr(self.place, f"action_{self.keys.row(name).action}")()

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
            self.call(self.arm.reset, partial(after_reset, keys=self.keys))

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


_: type[ScreenHost] = Desk  # screens reach it as `app`: here the type checker compares the two
