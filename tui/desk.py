"""The desk: the app of one arm, what all its screens share, and the keys of all screens.

Twenty times a second `Desk.poll` takes the arm's status. `ArmLink.take` stores it and disarms the
keys if a stop, a lost link or a state forbids motion; then `DeskScreen.show` shows it on the
current screen; then what two presses have confirmed is done. A screen, its line of keys and the
refusals of its keys go by this stored status, so they agree.

A screen defines its name in `place`, gives `BINDINGS = bindings(place)`, lays out its middle in
`compose_body` and shows each status in `show_body`. `works` and `needs` say which of its keys would
do anything now. Nothing that moves the arm stays active on a hidden screen: `disarm` is called
before another screen or a dialog opens.
"""

from __future__ import annotations

import contextlib
import pkgutil
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import ClassVar, cast

from textual import events, on
from textual.actions import ActionParseResult
from textual.app import ComposeResult, SystemCommand
from textual.binding import BindingType
from textual.containers import Vertical, VerticalScroll
from textual.screen import Screen

from armdrive import Arm
from armdrive.errors import ArmError, BadRequest
from armdrive.moves import ParkMove
from armdrive.render.canvas import draws_braille
from armdrive.render.scene import Moment
from armdrive.status import IMMOBILE, IN_MOTION, State, Status, Trust
from tui.app import POLL_S, KeyApp, Outcome
from tui.arm_view import SpaceView
from tui.dialogs import PostureScreen, commands, first_dialog
from tui.jog.jogging import STOPPED, DeskJogging
from tui.keys.keyboard import DEFAULT_KEYS, Keyboard, bindings, short_label
from tui.keys.table import (
    PAUSE,
    SCREENS,
    STOP,
    DeskKey,
    Needs,
    jog_pairs,
    spoken,
    summary_of,
)
from tui.safety import (
    FACT_GAP,
    LEADS_OUT,
    SafetyPanel,
    after_reset,
    badge_of,
    banner,
    can_reference,
    hindrance,
    position_text,
    progress_of,
    stopping_text,
    titled_arm,
    way_out,
    without_link,
)
from tui.settings import DeskSettings, memory_file
from tui.terminal import KeyUp, forget_a_closed_terminal, on_ending_signals
from tui.widgets import PlainText, ScreenTabs, fill_frame, framed, show_panel, text_of

_SIGNAL_EXIT = 128  # as a shell reports the signal that ended a program


class ArmLink:
    """Holds the latest status.

    The jog keys disarm after a stop, and in a state in which nothing can move the arm.
    """

    def __init__(self, desk: Desk) -> None:
        self.status: Status = desk.arm.status
        """The latest status."""
        self._desk = desk
        self._unchecked = False
        """Whether the link was lost, and the arm has not been checked since."""
        # counted, not flagged: a stop that comes and goes between two polls must not be missed
        self._stops = desk.arm.stops

    @property
    def lost(self) -> bool:
        """Whether there is no link to the arm."""
        return self.status.state is State.DISCONNECTED

    @property
    def moves(self) -> bool:
        """Whether the arm moves, or is paused in a motion."""
        return self.status.state in IN_MOTION

    def hindrance(self, needs: Needs) -> str:
        """Say why a key that needs this of the arm would do nothing now; empty if it would."""
        return hindrance(needs, self.status, self._desk.keys)

    def require(self, needs: Needs) -> None:
        """Raise `BadRequest` unless the arm is so that a key with these needs does something."""
        if why := self.hindrance(needs):
            raise BadRequest(why)

    def require_standing(self) -> None:
        """Raise `BadRequest` while the arm moves, or is paused in a motion."""
        if self.moves:
            raise BadRequest(f"the arm is {self.status.state.value}: wait until it stands")

    def take(self, status: Status) -> None:
        """Store the latest status, and disarm the keys if the arm cannot move any more."""
        before, self.status = self.status, status
        self.follow_stops()
        if self.lost and not self._unchecked:
            self._unchecked = True
            self._desk.disarm("the link is lost")
            self._desk.say("")  # the last message was about a link that worked
            self._desk.close_dialogs(PostureScreen)
        elif self._unchecked and status.state in (State.ERROR_STOP, State.DISABLED):
            self._unchecked = False  # in other states the check still runs
            self._desk.say("the link is back: nothing was moved")
        hand = self._desk.hand
        if hand is not None and hand.armed and (why := self.hindrance(Needs.MOTORS)):
            hand.disarm(why)  # the first key after a reset must not move the arm
        # a notice that has ended clears the message only if the message is that notice
        new = status.notices != before.notices
        if new and (status.notice or self._desk.message == before.notice):
            self._desk.message = status.notice

    def follow_stops(self, reason: str = STOPPED) -> None:
        """After a stop, by this desk or another program, end everything that was begun before it.

        Keys have to be armed again, a first press no longer counts, and an open question is closed.
        """
        stops, self._stops = self._stops, self._desk.arm.stops
        if stops != self._stops:
            self._desk.message = "" if self.lost else reason
            self._desk.disarm(reason)
            self._desk.close_dialogs(PostureScreen)

    @property
    def pausable(self) -> bool:
        """Whether there is anything to pause or to resume: a motion, or a program that waits."""
        return self.moves or self.status.paused or self._desk.arm.program is not None

    def switch_pause(self) -> None:
        """Pause the arm after its next burst, or resume it.

        A pause is made at once. The key may still be held then, so only a later press resumes.
        """
        if not self.pausable:
            raise BadRequest("nothing moves: there is nothing to pause")
        if self._desk.arm.status.paused:
            self._desk.confirmation.press("resumes", self._desk.arm.resume, needed=1)
            return
        self._desk.arm.pause()
        self._desk.confirmation.refuse()


class ArmControl:
    """The keys of every screen that command the arm: reference, motors, emergency stop.

    What moves the arm, or lets it sag, is done only after a question.
    """

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._arm = desk.arm

    def estop(self) -> None:
        """Stop and latch the error state."""
        try:
            self._arm.estop()
        finally:
            self._desk.link.follow_stops("emergency stop")

    def reset(self) -> None:
        """Leave the error state."""

        def reset() -> str:
            self._arm.reset()
            return after_reset(self._arm.status, self._desk.keys)

        self._desk.calls.make(reset)

    def reconnect(self) -> None:
        """Try once to reconnect a lost link. Moves nothing."""
        if self._desk.link.lost:
            self._desk.say("reconnecting ...")
        self._desk.calls.make(self._arm.reconnect)

    def reference(self) -> None:
        """Ask whether the arm stands in its reference posture; a simulated one is brought there."""
        self._desk.link.require(Needs.MOTORS)  # the set-up screen asks for it, too
        home = partial(self._arm.home, stops=self._arm.stops)
        if self._arm.reference.homes_by_switches:
            text, done = self._arm.reference.homing_words, "homed by its own switches"
            self._ask(text, self._present, home, done, asked="Is the way clear?")
        elif self._desk.link.status.simulated:
            self._desk.disarm("the simulated operator is at work")
            self._desk.say("the simulated operator brings the arm to its reference posture ...")
            self._desk.calls.make(home, "the simulated operator referenced the arm")
        else:
            request = self._arm.reference.request()
            posture = Moment(request.joints, request.opening_mm)
            enter, again = map(self._desk.keys.label, ("arm", "reference"))
            otherwise = f"not referenced: jog the arm there ({enter} arms the keys), then {again}"
            self._ask(str(request), posture, self._arm.reference.confirm, otherwise=otherwise)

    def confirm(self) -> None:
        """Ask whether the arm stands where the last program left it."""
        status = self._desk.link.status
        if status.trust is not Trust.RESTORED or status.joints is None:
            raise BadRequest(f"nothing to confirm: the position is {status.trust.value}")
        text = f"Remembered ({status.trust_reason}): {status.joints}"
        self._ask(text, self._present, self._arm.reference.confirm_restored)

    def park(self, speed: float) -> None:
        """Draw the park posture, and go there if the answer is yes."""
        move = ParkMove(speed)
        preview = self._arm.preview(move)
        if preview.refusal is not None or preview.end is None:
            raise BadRequest(str(preview.refusal))
        posture = Moment(preview.end, self._desk.link.status.gripper_mm)
        text = f"THE ARM WILL MOVE to its park posture, drawn here, at {speed:.0%} of its speed."
        # counted now: a stop before the answer must keep the arm from moving
        start = partial(self._arm.start, move, stops=self._arm.stops)
        self._ask(text, posture, lambda: start().wait(), "parked", asked="Is the way clear?")

    def switch_motors(self) -> None:
        """Switch the motor current on; off only after a question, since the arm sags then."""
        if self._desk.link.status.state is State.DISABLED:
            self._desk.calls.make(self._arm.enable, "the motors are on: nothing was moved")
            return
        text = "This switches the motors off: THE ARM SAGS, and its position is lost."
        done = "the motors are off"
        self._ask(text, self._present, self._arm.disable, done, asked="Is it supported?")

    @property
    def _present(self) -> Moment:
        """The present posture."""
        status = self._desk.link.status
        return Moment(status.joints, status.gripper_mm)

    def _ask(
        self,
        question: str,
        posture: Moment,
        agreed: Outcome,
        done: str = "confirmed: the position is referenced",
        *,
        asked: str = "Does the arm stand exactly like this?",
        otherwise: str = "not confirmed: nothing was changed",
    ) -> None:
        """Show a posture with the question `asked`, and make the call if the answer is yes.

        `done` and `otherwise` are the messages after a yes and a no.
        """
        desk, stops = self._desk, self._arm.stops

        def answered(yes: bool | None) -> None:
            if self._arm.stops != stops:
                return  # void, although the desk may not have noticed the stop yet
            if yes:
                desk.calls.make(agreed, done)
            else:
                desk.say(otherwise)

        dialog = PostureScreen(
            desk.spoken(question),
            desk.arm.model,
            posture,
            desk.keys,
            asked,
            desk.confirmation,
            braille=desk.braille,
        )
        desk.open_dialog(dialog, answered)


class DeskScreen(Screen[None]):
    """One screen of the desk. At first no widget has the focus."""

    AUTO_FOCUS = ""
    place: ClassVar[str] = ""
    """The id of the screen's row in `SCREENS`, and of its rows in the table of keys."""

    go: ClassVar[str] = "go"
    """The row of what the screen is for, which is offered first."""

    hand: DeskJogging | None = None
    """The jogging of this screen; None if it has no jog keys."""

    @property
    def desk(self) -> Desk:
        """The desk that the screen belongs to."""
        return cast("Desk", self.app)

    @property
    def armed(self) -> bool:
        """Whether keys of this screen move the arm without a second press."""
        return self.hand is not None and self.hand.armed

    @property
    def says(self) -> str:
        """The text after the badge of the arm's state, while motion is possible."""
        keys, link = self.desk.keys, self.desk.link
        stops = f"{keys.label(STOP)} stops the arm" if link.moves else ""
        return way_out(link.status.state, keys) or stops

    @property
    def settings_text(self) -> str:
        """How the keys of this screen move the arm, in a few words."""
        return ""

    @property
    def works(self) -> Mapping[str, bool]:
        """Whether rows of the table of keys do anything now, by id; all others do."""
        return {}

    @property
    def hint(self) -> str:
        """The message while there is no other."""
        return summary_of(self.place)

    def disarm(self, reason: str) -> None:
        """End a held jog of this screen, and disarm its keys."""
        if self.hand is not None:
            self.hand.disarm(reason)

    def compose(self) -> ComposeResult:
        """Lay out what every screen has around its own middle."""
        keys = self.desk.keys
        head = (ScreenTabs(self.place, keys), SafetyPanel(keys))
        yield from framed(head, self.compose_body())

    def compose_body(self) -> ComposeResult:
        """Lay out the middle of the screen."""
        raise NotImplementedError

    def arm_panel(self) -> ComposeResult:
        """Lay out the panel in which the arm is drawn."""
        desk = self.desk
        with Vertical(id="arm") as panel:
            panel.border_title = "Arm"
            panel.border_subtitle = f"{desk.keys.label('view-next')} view, drag to turn"
            yield SpaceView(
                desk.arm.model,
                braille=desk.braille,
                unknown="position unknown",  # the safety panel says what to do about it
                clock=desk.clock,
                id="space",
            )

    @on(events.Mount)
    @on(events.Resize)
    @on(events.ScreenResume)
    def _show_soon(self) -> None:
        """Refresh the screen, fitted to the size."""
        self.call_after_refresh(self.desk.poll)

    def show(self) -> None:
        """Show the latest status."""
        desk, lost, keys = self.desk, self.desk.link.lost, self.desk.keys
        status = desk.link.status
        program = progress_of(tells() if (tells := desk.arm.program) else {})
        forbids = desk.spoken(
            banner(status, keys, reconnects=desk.arm.reconnects, place=self.place)
        )
        settings = "" if lost or not self.settings_text else f"{FACT_GAP}{self.settings_text}"
        self.query_one(SafetyPanel).show(
            titled_arm(status, program),
            badge_of(status, armed=self.armed),
            forbids or self.says,
            status.trust,
            desk.spoken(position_text(status, keys)),
            f"{stopping_text(status)}{settings}",
            real=not status.simulated,
        )
        message = desk.spoken(desk.message)
        if message.rstrip(".") in forbids:
            message = ""
        if lost:
            message = f"{without_link(status)}\n{message}".strip()
        rows = desk.keys.next_keys(self.place, self._idle, self.first_keys(status))
        fill_frame(self, message or self.hint + self._more, rows)
        self.show_body(status)

    @property
    def _pauses(self) -> tuple[str, ...]:
        """The row that pauses the arm, where this screen has one."""
        return (PAUSE,) if self.desk.keys.row(PAUSE).counts_at(self.place) else ()

    @property
    def _idle(self) -> set[str]:
        """The rows that would do nothing now."""
        link = self.desk.link
        unmet = {needs for needs in Needs if link.hindrance(needs)}
        idle = {row.id for row in self.desk.keys.at(self.place) if self.needs(row) in unmet}
        idle |= {row for row, works in self.works.items() if not works}
        idle |= {STOP} if link.lost else set()
        if not link.pausable:
            return idle.union(self._pauses)
        return idle | ({self.go} if self.desk.keys.row(self.go).needs else set())

    def needs(self, row: DeskKey) -> Needs:
        """Return what a row of the table of keys needs of the arm on this screen now."""
        return row.needs

    @property
    def _more(self) -> str:
        """How to scroll to what the panels cut off; empty if nothing is cut off."""
        below = any(each.max_scroll_y > each.scroll_y for each in self.query(VerticalScroll))
        return f" ({short_label(self.desk.keys.row('more')).split()[-1]}: more)" if below else ""

    def first_keys(self, status: Status) -> tuple[str, ...]:
        """Return the ids of rows that pause a moving arm, or make a blocked one drivable again."""
        if status.state in IMMOBILE:
            return (LEADS_OUT[status.state], self.go)
        if self.desk.link.pausable and self._pauses:
            return (*self._pauses, self.go)
        if status.trust is Trust.RESTORED:
            return ("confirm", self.go)
        reference = status.trust is not Trust.REFERENCED and can_reference(status.state)
        return ("reference", self.go) if reference else (self.go,)

    def action_pause(self) -> None:
        """Pause the arm after its next burst, or resume it."""
        self.desk.link.switch_pause()

    def show_body(self, status: Status) -> None:
        """Show this status in the middle of the screen."""

    def show_panel(self, name: str, text: str) -> None:
        """Show a text in its panel; hide the panel while there is none."""
        show_panel(self, name, text)

    def text(self, name: str) -> PlainText:
        """Return one of the screen's texts."""
        return text_of(self, name)


def _made(place: str) -> DeskScreen:
    """Make the screen at a place, `package.module:Name`."""
    screen: DeskScreen = pkgutil.resolve_name(place)()
    return screen


class Desk(KeyApp):
    """One arm and its screens. Leaving the desk and changing the screen end a jog."""

    TITLE = "armdrive"
    BINDINGS: ClassVar[list[BindingType]] = bindings("")
    DEFAULT_MODE = SCREENS[0].id

    def __init__(
        self,
        arm: Arm,
        *,
        braille: bool,
        clock: Callable[[], float] = time.monotonic,
        handle_signals: bool = False,
        keys: Keyboard = DEFAULT_KEYS,
        memory: Path | None = None,
        first: str = "",
        program: Path | None = None,
    ) -> None:
        """`first` is the screen to begin at; `program` is the file of the program screen."""
        if first:  # otherwise a jog screen would be opened before it
            self.DEFAULT_MODE = first  # type: ignore[misc]
        geometry = arm.model.arm
        self.pairs = jog_pairs(geometry.joint_names, has_yaw=geometry.has_yaw)
        self._joint_names = geometry.joint_names
        self.settings = DeskSettings(memory, arm.status, self.pairs, arm.frames)
        super().__init__(keys, braille=braille, look=self.settings.look, clock=clock)
        for entry in SCREENS:
            self.add_mode(entry.id, partial(_made, entry.screen))
        self.arm = arm
        self._handle_signals = handle_signals
        self.program = program
        """The program file that was named when the desk was opened."""
        self.programs = Path.cwd()
        """The folder whose program files are listed."""
        # from the thread that reads the keys, so that a stop waits for no picture
        self.input.urgent = dict.fromkeys(self.stop_keys, arm.request_stop)
        self.input.hand = lambda: self.hand
        self.link = ArmLink(self)
        """The latest status, and whether there is a link at all."""
        self.message = arm.status.notice
        self.control = ArmControl(self)

    @property
    def current(self) -> DeskScreen:
        """The current screen; dialogs may lie above it."""
        return cast("DeskScreen", self.screen_stack[0])

    @property
    def hand(self) -> DeskJogging | None:
        """The hand on the jog keys, where the current screen has those."""
        return self.current.hand if self.screen_stack else None

    def disarm(self, reason: str) -> None:
        """End a held jog of the current screen, and disarm its keys."""
        super().disarm(reason)
        if self.screen_stack:  # otherwise the screens are already being removed
            self.current.disarm(reason)

    def action_show_screen(self, place: str) -> None:
        """Go to a screen by its id. A held jog of the previous screen ends first."""
        self.disarm("another screen is shown")
        self.close_dialogs()
        self.message = ""  # the message was about the previous screen
        self.switch_mode(place)

    # -- what is shown ------------------------------------------------------------------------

    def on_mount(self) -> None:
        """Begin to watch the arm."""
        if self._handle_signals:
            on_ending_signals(self._end_by_signal)
        self.polling = self.set_interval(POLL_S, self.poll)
        self.call_after_refresh(self.input.fresh.begin)
        if not self.settings.instructed:
            first = first_dialog(self.keys, self.link.status)
            self.open_dialog(first, lambda _: setattr(self.settings, "instructed", True))

    def poll(self) -> None:
        """Store the latest status, show changes, then perform what two presses have confirmed."""
        self.input.alive()  # first: what was confirmed before a suspension must not be done after
        self.link.take(self.arm.status)
        self.show()
        self.act_on_confirmed()

    def say(self, message: str) -> None:
        """Show a message. The effects of a stop come before its result."""
        self.link.follow_stops()
        super().say(message)

    def spoken(self, text: str) -> str:
        """Return a text in the words of the desk, with the joints as people write them."""
        return spoken(self.keys.presented(text), self._joint_names)

    def require(self, action: str | ActionParseResult) -> None:
        """Raise `BadRequest` if the arm as it is lets the key of an action do nothing."""
        rows = self.keys.at(self.place)
        row = next((r for r in rows for *_, does in r.bound if does == action), None)
        if row is not None:
            self.link.require(self.current.needs(row))

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Offer the actions of this screen, and actions found by other words."""
        del screen
        known = (row for row in self.keys.rows if row.also and not row.counts_at(self.place))
        known = (row for row in known if row.places)
        return commands((*self.keys.at(self.place), *known), self.action_do_row)

    # -- stopping and ending ------------------------------------------------------------------

    def action_stop_arm(self) -> None:
        """Stop the arm before anything else, then disarm and show the screen."""
        # a key has stopped the arm in its reading thread; a click on STOP arrives only here
        self.arm.request_stop()
        self.link.follow_stops("stopped")
        self.message = "" if self.link.lost else "STOP requested; the keys are disarmed"
        self.close_dialogs()
        self.show()

    def action_leave(self) -> None:
        """Stop the arm and end the desk."""
        self.arm.request_stop()
        self.exit(0)

    def on_key(self, event: events.Key) -> None:
        """Report that a key has no meaning here, such as a letter of another keyboard layout."""
        bound = any(event.key in row.all_keys for row in self.keys.at(self.place))
        if event.is_printable and not bound and len(self.screen_stack) == 1:
            help_key = self.keys.label("help")
            self.say(f"{event.character} is no key of this screen: {help_key} shows the keys")

    def on_key_up(self, event: KeyUp) -> None:
        """End a held jog as soon as the terminal reports the release of its key."""
        key = self.keys.jog_key(event.key)
        if key is not None and self.hand is not None:
            self.hand.key_up(key)

    def on_app_blur(self) -> None:
        """Disarm when the terminal reports that another window has the keyboard."""
        self.disarm("the terminal lost the keyboard focus")

    def on_paste(self, event: events.Paste) -> None:
        """Disarm on pasted text: it may be old keys that a multiplexer took for a paste."""
        event.stop()
        self.disarm("text was pasted, and dropped")

    def on_unmount(self) -> None:
        """Stop the arm, whatever has ended the desk, and save the settings."""
        self.arm.request_stop()
        look = self.settings.look if self.no_color else self.look
        self.settings.keep(self.link.status, look)

    def _end_by_signal(self, number: int) -> None:
        """Stop and close the arm before the framework cleans up."""
        self.arm.request_stop()
        with contextlib.suppress(ArmError):  # nobody could read that the arm did not confirm
            self.arm.close()
        self.exit(_SIGNAL_EXIT + number, return_code=_SIGNAL_EXIT + number)


# The interpreter lets a thread that computes go on for 5 ms before another one that has been woken
# may run. A stop passes through three threads, while the one that paints is hardly ever at rest.
# `benchmarks/desk.py keys` shows what a stop gains by it, `painting` that it costs nothing.
TURN_S = 0.0005


def run_desk(
    arm: Arm,
    *,
    ascii_only: bool = False,
    keys: Keyboard = DEFAULT_KEYS,
    first: str = "",
    hint: str = "",
    program: Path | None = None,
) -> int:
    """Show the desk until the user leaves it, and return the exit code.

    `keys` is the keyboard. `first` is the id of the screen to begin at, instead of the first one;
    `hint` is the first message, `program` the file that the program screen begins with.
    However it ends, a stop has been requested; closing the arm remains the caller's duty,
    except after SIGTERM and SIGHUP, when it is closed at once.
    """
    desk = Desk(
        arm,
        braille=draws_braille(ascii_only=ascii_only),
        handle_signals=True,
        keys=keys,
        memory=memory_file(),
        first=first,
        program=program,
    )
    desk.message = desk.message or hint
    before_s = sys.getswitchinterval()
    sys.setswitchinterval(TURN_S)
    try:
        desk.run_or_raise()
    finally:
        sys.setswitchinterval(before_s)
        arm.request_stop()
        forget_a_closed_terminal()
    return desk.return_code or 0
