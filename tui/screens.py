"""What all screens of the desk have in common, and which of them is shown.

A screen of its own says what it is called in `place`, gives `BINDINGS = bindings(place)`, lays out
its middle in `compose_body` and shows each status in `show_body`. It keeps nothing that moves the
arm alive while it is not shown: `disarm` is called before another screen or a dialog comes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Protocol, cast

from textual import events, on
from textual.app import App, ComposeResult
from textual.containers import Container, Vertical
from textual.screen import Screen

from armdrive.status import State, Status, Trust
from kinematics.spaces import Joints
from tui.arm_port import DeskArm, Done
from tui.arm_view import SpaceView
from tui.conduct import at_work, conduct_of, remarks
from tui.control import ArmControl, ArmLink
from tui.frame import KeyLine, SafetyPanel, ScreenTabs
from tui.jog.jogging import DeskJogging
from tui.keys.keyboard import Keyboard
from tui.keys.table import summary_of
from tui.painting import PlainText, send_spans_alone
from tui.settings import JogSettings, Manner


class ScreenHost(Protocol):
    """The parts of the desk that its screens use."""

    arm: DeskArm
    braille: bool
    clock: Callable[[], float]
    keys: Keyboard
    link: ArmLink
    """The latest status, and whether there is a link at all."""
    control: ArmControl
    screens: Screens
    message: str
    """The last message."""
    settings: JogSettings
    manner: Manner
    goal: Joints | None
    """A posture that one screen has left for the move screen."""
    programs: Path
    """The folder whose program files are listed."""
    program: Path | None
    """The program file that was named when the desk was opened."""
    reopens: bool
    """Whether another desk can be opened on an arm file."""

    def poll(self) -> None:
        """Take the latest status and show what changed."""

    def show(self) -> None:
        """Show the latest status on the current screen."""

    def say(self, message: str) -> None:
        """Say something on whatever screen is shown."""

    def spoken(self, text: str) -> str:
        """Return a text in the words of the desk."""

    def call(self, call: Callable[[], object], done: Done) -> None:
        """Make a call that takes a moment in a thread, then say `done`."""

    def in_thread(self, work: Callable[[], object]) -> None:
        """Do work that takes a moment in a thread."""

    def call_from_thread(self, callback: Callable[..., Any], *args: Any) -> Any:
        """Call in the desk's own thread, and wait until that is done."""

    def open_next(self, path: Path) -> None:
        """Leave this arm for a desk on an arm file."""


class DeskScreen(Screen[None]):
    """One screen of the desk. Nothing on it has the focus at first."""

    AUTO_FOCUS = ""
    place: ClassVar[str] = ""
    """The id of the screen's row in `SCREENS`, and of its rows in the table of keys."""

    hand: DeskJogging | None = None
    """The hand on the jog keys, where the screen has those."""

    _laid_out = False

    def __init__(self) -> None:
        super().__init__()
        send_spans_alone(self)

    @property
    def desk(self) -> ScreenHost:
        """The desk that the screen belongs to."""
        return cast("ScreenHost", self.app)

    @property
    def armed(self) -> bool:
        """Whether keys of this screen move the arm at once."""
        return False

    @property
    def says(self) -> str:
        """The words after the badge of the arm's state, while nothing forbids motion."""
        return ""

    @property
    def settings_text(self) -> str:
        """How the keys of this screen move the arm, in a few words."""
        return ""

    @property
    def idle(self) -> tuple[str, ...]:
        """Rows of the table of keys that would change nothing now, by id."""
        return ()

    @property
    def hint(self) -> str:
        """The message while there is no other."""
        return summary_of(self.place)

    def disarm(self, reason: str) -> None:
        """Let go of what this screen holds, and let no key of it move the arm."""

    def compose(self) -> ComposeResult:
        """Lay out what every screen has; the middle is the screen's own."""
        keys = self.desk.keys
        yield ScreenTabs(self.place, keys)
        yield SafetyPanel(keys)
        with Container(id="body"):
            yield from self.compose_body()
        yield PlainText(id="remarks")
        yield KeyLine(id="footer")

    def compose_body(self) -> ComposeResult:
        """Lay out the middle of the screen."""
        yield from ()

    def arm_panel(self) -> ComposeResult:
        """Lay out the panel in which the arm is drawn."""
        desk, keys = self.desk, self.desk.keys
        with Vertical(id="arm") as panel:
            panel.border_title = "Arm"
            panel.border_subtitle = f"{keys.label('view-next')} view, drag to turn"
            yield SpaceView(
                desk.arm.model,
                braille=desk.braille,
                unknown=f"position unknown: press {keys.label('reference')}",
                clock=desk.clock,
                id="space",
            )

    def on_mount(self) -> None:
        """Note that there is room to show the arm in."""
        self._laid_out = True

    @on(events.Mount)
    @on(events.Resize)
    @on(events.ScreenResume)
    def _show_soon(self) -> None:
        """Show what has happened meanwhile, fitted to the width."""
        self.call_after_refresh(self.desk.poll)

    def on_screen_suspend(self) -> None:
        """Let no key move the arm behind a dialog or another screen."""
        self.disarm("another screen is shown")

    def show(self, status: Status) -> None:
        """Show this status: called at each poll of the desk while it is at this screen."""
        if not (self._laid_out and self.is_attached):
            return  # not laid out yet, or already being taken down
        desk = self.desk
        conduct = conduct_of(
            status,
            desk.keys,
            armed=self.armed,
            says=self.says,
            looked_for=desk.arm.reconnects,
            paused_at=desk.link.paused_at,
            program=at_work(tells() if (tells := desk.arm.program) else {}),
        )
        conduct = replace(
            conduct,
            forbids=desk.spoken(conduct.forbids),
            position=desk.spoken(conduct.position),
        )
        messages = remarks(status, desk.message or self.hint, bannered=bool(conduct.forbids))
        rows = desk.keys.next_keys(self.place, self.idle, self.first_keys(status))
        self.query_one(SafetyPanel).show(conduct, self.settings_text)
        self.text("remarks").show(desk.spoken(messages))
        self.query_one(KeyLine).show_keys(rows, self.query_one(KeyLine).content_size.width)
        self.show_body(status)

    def first_keys(self, status: Status) -> tuple[str, ...]:
        """Return the rows, by id, that make a blocked arm drivable again."""
        by_state = {
            State.DISCONNECTED: ("reconnect",),
            State.ERROR_STOP: ("reset",),
            State.DISABLED: ("motors",),
        }
        by_trust = {
            Trust.UNKNOWN: ("reference",),
            Trust.SUSPECT: ("reference",),
            Trust.RESTORED: ("confirm",),
        }
        return by_state.get(status.state, ()) or by_trust.get(status.trust, ())

    def show_body(self, status: Status) -> None:
        """Show this status in the middle of the screen."""

    def show_panel(self, name: str, text: str) -> None:
        """Show a text in its panel; hide the panel while there is none."""
        panel = self.text(name)
        panel.show(text)
        panel.display = bool(text)

    def text(self, name: str) -> PlainText:
        """Return one of the screen's texts."""
        return self.query_one(f"#{name}", PlainText)


def panels(**titles: str) -> Iterator[PlainText]:
    """Yield a titled panel of text for each id."""
    for name, title in titles.items():
        panel = PlainText(id=name, classes="panel")
        panel.border_title = title
        yield panel


class Screens:
    """The screen that the desk is at; dialogs may lie over it."""

    def __init__(self, app: App[int]) -> None:
        self._app = app

    @property
    def current(self) -> DeskScreen:
        """The screen that the desk is at."""
        return cast("DeskScreen", self._app.screen_stack[0])

    @property
    def uncovered(self) -> bool:
        """Whether no dialog lies over the screen."""
        return len(self._app.screen_stack) == 1

    @property
    def hand(self) -> DeskJogging | None:
        """The hand on the jog keys, where the screen has those."""
        return self.current.hand if self._app.screen_stack else None

    def show(self, status: Status) -> None:
        """Show a status on the current screen."""
        if self._app.is_running and self._app.screen_stack:  # else they are being taken down
            self.current.show(status)

    def disarm(self, reason: str) -> None:
        """Let go of what the current screen holds, and let no key of it move the arm."""
        if self._app.screen_stack:  # else they are already being taken down
            self.current.disarm(reason)

    def resumed(self, time_s: float) -> None:
        """Disarm after a suspension of this length: keys typed meanwhile move nothing."""
        self.disarm(f"this program was suspended for {time_s:.1f} s")

    def starved(self, time_s: float) -> None:
        """Note that keys may have waited for the desk for this long; those move nothing."""
        if self.hand is not None:
            self.hand.doubt(time_s)

    def close_dialogs(self) -> None:
        """Close whatever lies over the current screen; no question in it is answered."""
        while len(self._app.screen_stack) > 1:
            self._app.pop_screen()

    def go_to(self, screen: str) -> None:
        """Go to a screen by its id. What the one before held ends first."""
        self.disarm("another screen is shown")
        self.close_dialogs()
        self._app.switch_mode(screen)
