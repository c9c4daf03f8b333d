"""The desk itself: it polls the arm's status, and turns keys into jogs through the dead-man."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import ClassVar

from textual import events
from textual.app import App, ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll

from armdrive.draw.armview import ArmScene, side_view, top_view
from armdrive.errors import ArmError
from armdrive.jog import Action, DeadMan, Disarm, Hold, Increment
from armdrive.status import State, Status, Trust
from kinematics import KinematicsError
from tui import panels
from tui.arm_port import DeskArm
from tui.dialogs import HelpScreen, PostureScreen
from tui.framework import Alarm, PlainText, on_ending_signals
from tui.keys import footer, jog_pairs
from tui.layout import CSS, bindings
from tui.settings import Settings
from tui.views import ArmView, scene_of

POLL_S = 0.05
IDLE_DISARMS_S = 60.0
LEAVE_KEY = "q"
"""Leaves the desk once the link is lost; before that it is a jog key like the others."""

_SIGNAL_EXIT = 128  # a shell's way to say which signal ended a program


class Desk(App[int]):
    """One arm on one screen. Starts disarmed; every way out of it stops the arm."""

    ENABLE_COMMAND_PALETTE = False
    TITLE = "armdrive"
    BINDINGS: ClassVar[list[BindingType]] = bindings()
    CSS = CSS
    HORIZONTAL_BREAKPOINTS = [(0, "-narrow"), (100, "-wide")]  # noqa: RUF012 - as App declares it

    def __init__(
        self,
        arm: DeskArm,
        *,
        braille: bool,
        clock: Callable[[], float] = time.monotonic,
        handle_signals: bool = False,
    ) -> None:
        super().__init__()
        self._arm = arm
        self._braille = braille
        self._clock = clock
        self._handle_signals = handle_signals
        self._deadman = DeadMan()
        self._alarm = Alarm(self, self.tick)
        geometry = arm.model.arm
        self._settings = Settings(pairs=jog_pairs(geometry.joint_names, has_yaw=geometry.has_yaw))
        self._message = "enter arms the jog keys; space stops at any time"
        self._active_s = clock()
        self._status: Status = arm.status

    # -- what stands on the screen ------------------------------------------------------------

    def compose(self) -> ComposeResult:
        """Lay the screen out: drawings on the left, words and numbers on the right."""
        yield PlainText(id="title")
        yield PlainText(id="banner")
        with Horizontal():
            with Vertical(id="views"):
                yield ArmView("side", side_view, braille=self._braille, id="side")
                yield ArmView("above", top_view, braille=self._braille, id="top")
            with VerticalScroll(id="panel", can_focus=False):
                for name in ("conduct", "joints", "tip", "bottom"):
                    yield PlainText(id=name)
        yield PlainText(id="remarks")
        yield PlainText(id="footer")

    def on_mount(self) -> None:
        """Begin to watch the arm."""
        if self._handle_signals:
            on_ending_signals(self._end_by_signal)
        self.set_interval(POLL_S, self.poll)
        self.call_after_refresh(self.poll)

    def on_resize(self) -> None:
        """Fit the texts to the new width."""
        self.call_after_refresh(self.poll)

    @property
    def armed(self) -> bool:
        """Whether jog keys have any effect."""
        return self._deadman.armed

    @property
    def settings(self) -> Settings:
        """Mode, increment and speed as they are set."""
        return self._settings

    def poll(self) -> None:
        """Take the latest status and show what changed."""
        self._status = self._arm.status
        if self._status.state is State.DISCONNECTED:
            self._apply(self._deadman.disarm("the link is lost"))
        elif self.armed and self._clock() - self._active_s >= IDLE_DISARMS_S:
            self._apply(self._deadman.disarm(f"no key for {IDLE_DISARMS_S:.0f} s"))
        self._show()

    def _show(self) -> None:
        if not self.is_running:
            return  # the widgets are already being taken down
        status, settings, model = self._status, self._settings, self._arm.model
        screen = self.screen_stack[0]
        width = max(screen.query_one("#panel").content_size.width, 1)
        texts = {
            "title": panels.title(status, self.size.width),
            "banner": panels.banner(status),
            "conduct": panels.conduct(status, settings, armed=self.armed),
            "joints": panels.joint_table(status, model, settings, width),
            "tip": panels.tip_lines(status, settings),
            "bottom": panels.bottom_lines(status),
            "remarks": panels.remarks(status, self._message),
            "footer": footer(self.size.width),
        }
        for name, text in texts.items():
            screen.query_one(f"#{name}", PlainText).show(text)
        screen.query_one("#title").set_class(not status.simulated, "-real")
        screen.query_one("#banner").set_class(bool(texts["banner"]), "-shown")
        screen.query_one("#conduct").set_class(self.armed, "-armed")
        scene = self._scene()
        for name in ("side", "top"):
            screen.query_one(f"#{name}", ArmView).show(scene)

    def _say(self, message: str) -> None:
        self._message = message
        self._show()

    # -- jogging ------------------------------------------------------------------------------

    def action_jog(self, key: str) -> None:
        """Hand a jog key to the dead-man."""
        if self._status.state is State.DISCONNECTED and key == LEAVE_KEY:
            self.action_leave()
            return
        if self._settings.pair_of(key) is None:
            self._say(f"no axis of this arm is moved by the key {key}")
            return
        now_s = self._clock()
        if self.armed:
            self._active_s = now_s
        self._apply(self._deadman.press(key, now_s))

    def tick(self) -> None:
        """Let the dead-man's time pass."""
        self._apply(self._deadman.tick(self._clock()))

    def _apply(self, actions: tuple[Action, ...]) -> None:
        for action in actions:
            try:
                self._carry_out(action)
            except ArmError as error:
                self._say(str(error))
        self._alarm.after(self._deadman.next_s() - self._clock())

    def _carry_out(self, action: Action) -> None:
        speed = self._settings.speed
        if isinstance(action, Increment):
            self._arm.nudge(self._settings.increment_of(action.key), speed=speed)
        elif isinstance(action, Hold):
            for_s = action.until_s - self._clock()
            if for_s > 0:
                self._arm.hold(self._settings.direction_of(action.key), speed=speed, for_s=for_s)
        else:
            self._arm.release()
            if isinstance(action, Disarm):
                self._say(f"keys disarmed: {action.reason}")

    def action_arm_keys(self) -> None:
        """Let the jog keys have effect."""
        self._active_s = self._clock()
        if self._status.state is State.DISCONNECTED:
            self._say("the link is lost: there is nothing to arm")
        elif self._deadman.arm(self._active_s):
            self._say("armed: tap a key for one increment, hold it to keep moving")
        else:
            self._say("keys are still arriving: let go of all keys, then press enter again")

    def on_app_blur(self) -> None:
        """Disarm when the terminal says that another window has the keyboard."""
        self._apply(self._deadman.disarm("the terminal lost the keyboard focus"))

    def on_paste(self, event: events.Paste) -> None:
        """Disarm on pasted text: it may be backlog that a multiplexer took for a paste."""
        event.stop()
        self._apply(self._deadman.disarm("text was pasted, and dropped"))

    # -- settings -----------------------------------------------------------------------------

    def _set(self, settings: Settings) -> None:
        """Change settings. Whatever is held was meant with the old ones, so it ends."""
        self._apply(self._deadman.release_all(self._clock()))
        self._settings = settings
        self._show()

    def action_mode(self) -> None:
        """Switch between joint and Cartesian mode."""
        self._set(self._settings.other_mode())

    def action_finer(self) -> None:
        """Make the increment smaller."""
        self._set(self._settings.with_increment(-1))

    def action_coarser(self) -> None:
        """Make the increment larger."""
        self._set(self._settings.with_increment(1))

    def action_slower(self) -> None:
        """Jog more slowly."""
        self._set(self._settings.with_speed(-1))

    def action_faster(self) -> None:
        """Jog faster."""
        self._set(self._settings.with_speed(1))

    # -- stopping and ending ------------------------------------------------------------------

    def action_stop_arm(self) -> None:
        """Stop the arm before anything else, then disarm and show the desk."""
        self._arm.request_stop()
        self._apply(self._deadman.disarm("stopped"))
        self._message = "STOP was asked for; the keys are disarmed"
        self._close_dialogs()
        self._show()

    def action_estop(self) -> None:
        """Stop and latch the error state."""
        self._arm.estop()
        self._apply(self._deadman.disarm("emergency stop"))

    def action_reset(self) -> None:
        """Leave the error state."""
        self._in_thread(self._arm.reset, "reset: nothing was moved")

    def action_leave(self) -> None:
        """Stop the arm and end the desk."""
        self._arm.request_stop()
        self.exit(0)

    def on_unmount(self) -> None:
        """Stop the arm, whatever it was that ended the desk."""
        self._arm.request_stop()

    def _end_by_signal(self, number: int) -> None:
        """Leave the arm standing and closed before the framework tidies up."""
        self._arm.request_stop()
        try:
            self._arm.close()
        except ArmError:
            self._arm.request_stop()  # it would not confirm that it stands; nobody is there to tell
        self.exit(_SIGNAL_EXIT + number, return_code=_SIGNAL_EXIT + number)

    # -- dialogs ------------------------------------------------------------------------------

    def action_help(self) -> None:
        """Show all keys."""
        self._apply(self._deadman.release_all(self._clock()))
        self.push_screen(HelpScreen(self._settings.pairs))

    def action_reference(self) -> None:
        """Ask whether the arm stands in its reference posture; a simulated one is brought there."""
        if self._arm.homes_by_switches:
            text = "THE ARM WILL MOVE: its controller seeks its switches. Is its way clear?"
            self._ask(text, self._scene(), self._arm.home, "homed by its own switches")
            return
        if self._status.simulated:
            self._apply(self._deadman.disarm("the simulated operator is at work"))
            self._in_thread(self._arm.home, "the simulated operator referenced the arm")
            return
        try:
            request = self._arm.reference_request()
        except (ArmError, KinematicsError) as error:
            self._say(str(error))
            return
        scene = scene_of(self._arm.model, request.joints, request.opening_mm)
        self._ask(str(request), scene, self._arm.confirm_reference)

    def action_confirm(self) -> None:
        """Ask whether the arm stands where the last program left it."""
        status = self._status
        if status.trust is not Trust.RESTORED or status.joints is None:
            self._say(f"nothing to confirm: the position is {status.trust.value}")
            return
        scene = scene_of(self._arm.model, status.joints, status.gripper_mm)
        text = f"An earlier program left the arm here: {status.joints}"
        self._ask(text, scene, self._arm.confirm_restored)

    def action_motors(self) -> None:
        """Switch the motor current on; off only after a question, since the arm sags then."""
        if self._status.state is State.DISABLED:
            self._in_thread(self._arm.enable, "the motors are on: nothing was moved")
            return
        text = "Switch the motors off? THE ARM SAGS, and its position is lost. Is it supported?"
        self._ask(text, self._scene(), self._arm.disable, "the motors are off")

    def _scene(self) -> ArmScene | None:
        """Return what is to be drawn of the arm as it stands."""
        joints = self._status.joints
        if joints is None:
            return None
        return scene_of(self._arm.model, joints, self._status.gripper_mm)

    def _ask(
        self,
        description: str,
        scene: ArmScene | None,
        agreed: Callable[[], object],
        done: str = "confirmed: the position is referenced",
    ) -> None:
        """Draw a posture with a question, and make the call if the answer is yes."""
        self._apply(self._deadman.disarm("a question is open"))

        def answered(stands: bool | None) -> None:
            if stands:
                self._in_thread(agreed, done)
            else:
                self._say("not confirmed: nothing was changed")

        self.push_screen(PostureScreen(description, scene, braille=self._braille), answered)

    def _close_dialogs(self) -> None:
        while len(self.screen_stack) > 1:
            self.pop_screen()

    def _in_thread(self, call: Callable[[], object], done: str) -> None:
        """Make a call that takes a moment, without keeping the stop key waiting."""
        self.run_worker(partial(self._called, call, done), thread=True, exit_on_error=False)

    def _called(self, call: Callable[[], object], done: str) -> None:
        try:
            call()
        except (ArmError, KinematicsError) as error:
            done = str(error)
        self.call_from_thread(self._say, done)
