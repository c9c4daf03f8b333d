"""What all screens of the desk have in common: title, banner, remarks, footer, and the desk.

A screen of its own says what it is called in `place`, gives `BINDINGS = bindings(place)`, lays out
its middle in `compose_body` and shows each status in `show_body`. It keeps nothing that moves the
arm alive while it is not shown: `disarm` is called before another screen or a dialog comes.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import ClassVar, Protocol, cast

from textual.app import ComposeResult
from textual.containers import Container
from textual.screen import Screen

from armdrive.status import Status
from kinematics.spaces import Joints
from tui.arm_port import DeskArm
from tui.framework import PlainText, send_spans_alone
from tui.jog.jogging import DeskJogging
from tui.keys.keyboard import Keyboard
from tui.keys.table import summary_of, titled
from tui.panels import banner, remarks, title
from tui.settings import JogSettings, Manner

Done = str | Callable[[Status], str] | None
"""What is said when a call has gone well: a sentence, or one made from the status then."""


class ScreenHost(Protocol):
    """What screens use of the desk that shows them; they know no more of it than this."""

    arm: DeskArm
    braille: bool
    clock: Callable[[], float]
    keys: Keyboard
    status: Status
    """The latest one."""
    message: str
    """What was said last."""
    settings: JogSettings
    manner: Manner
    goal: Joints | None
    """A posture that one screen has left for the move screen."""
    paused_here: bool
    """Whether the arm waits because of this desk."""
    reopens: bool
    """Whether another desk can be opened on an arm file."""

    @property
    def at_work(self) -> str:
        """The program or sequence that the arm is at work on, in few words."""

    def poll(self) -> None:
        """Take the latest status and show what changed."""

    def show(self) -> None:
        """Show the latest status on the current screen."""

    def say(self, message: str) -> None:
        """Say something on whatever screen is shown."""

    def spoken(self, text: str) -> str:
        """Return a text in the words of the desk."""

    def nobody_there(self) -> bool:
        """Return whether the link is lost, and say so."""

    def call(self, call: Callable[[], object], done: Done) -> None:
        """Make a call that takes a moment in a thread, then say `done`."""

    def pause_or_go_on(self) -> None:
        """Pause the arm, or let it go on."""

    def show_screen(self, screen: str) -> None:
        """Go to another screen by its id."""

    def open_next(self, path: Path) -> None:
        """Leave this arm for a desk on an arm file."""

    def action_reference(self) -> None:
        """Ask whether the arm stands in its reference posture."""


class DeskScreen(Screen[None]):
    """One screen of the desk. Nothing on it is focused unless somebody chooses it."""

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
    def idle(self) -> tuple[str, ...]:
        """Rows of the table of keys that would change nothing now, by id."""
        return ()

    @property
    def hint(self) -> str:
        """What is said while nothing else has been."""
        return summary_of(self.place)

    def disarm(self, reason: str) -> None:
        """Let go of what this screen holds, and let no key of it move the arm."""

    def compose(self) -> ComposeResult:
        """Lay out what every screen has; the middle is the screen's own."""
        yield PlainText(id="title")
        yield PlainText(id="banner")
        with Container(id="body"):
            yield from self.compose_body()
        yield PlainText(id="remarks")
        yield PlainText(id="footer")

    def compose_body(self) -> ComposeResult:
        """Lay out the middle of the screen."""
        yield from ()

    def on_mount(self) -> None:
        """Show the arm as soon as there is room to show it in."""
        self._laid_out = True
        self.call_after_refresh(self.desk.poll)

    def on_resize(self) -> None:
        """Fit the texts to the new width."""
        self.call_after_refresh(self.desk.poll)

    def on_screen_resume(self) -> None:
        """Show what has happened meanwhile."""
        self.call_after_refresh(self.desk.poll)

    def on_screen_suspend(self) -> None:
        """Let no key move the arm behind a dialog or another screen."""
        self.disarm("another screen is shown")

    def show(self, status: Status) -> None:
        """Show this status: called at each poll of the desk while it is at this screen."""
        if not (self._laid_out and self.is_attached):
            return  # not laid out yet, or already being taken down
        desk = self.desk
        width = self.size.width
        looked_for, paused_here = desk.arm.reconnects, desk.paused_here
        forbids = banner(status, desk.keys, looked_for=looked_for, paused_here=paused_here)
        said = remarks(status, desk.message or self.hint, bannered=bool(forbids))
        self.text("title").show(title(status, titled(self.place), width, desk.at_work))
        self.text("banner").show(desk.spoken(forbids))
        self.text("remarks").show(desk.spoken(said))
        self.text("footer").show(desk.keys.footer(self.place, width, self.idle))
        self.text("title").set_class(not status.simulated, "-real")
        self.text("banner").set_class(bool(forbids), "-shown")
        self.show_body(status)

    def show_body(self, status: Status) -> None:
        """Show this status in the middle of the screen."""

    def text(self, name: str) -> PlainText:
        """Return one of the screen's texts."""
        return self.query_one(f"#{name}", PlainText)
