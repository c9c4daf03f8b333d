"""What all screens of the desk have in common: title, banner, remarks, footer, and the desk.

A screen of its own says what it is called in `place`, gives `BINDINGS = bindings(place)`, lays out
its middle in `compose_body` and shows each status in `show_body`. It keeps nothing that moves the
arm alive while it is not shown: `disarm` is called before another screen or a dialog comes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, cast

from textual.app import ComposeResult
from textual.containers import Container
from textual.screen import Screen

from armdrive.status import Status
from tui import panels
from tui.framework import PlainText, send_spans_alone
from tui.keys.table import summary_of, titled

if TYPE_CHECKING:
    from tui.desk import Desk
    from tui.jog.jogging import Jogging


class DeskScreen(Screen[None]):
    """One screen of the desk. Nothing on it is focused unless somebody chooses it."""

    AUTO_FOCUS = ""
    place: ClassVar[str] = ""
    """The id of the screen's row in `SCREENS`, and of its rows in the table of keys."""

    hand: Jogging | None = None
    """The hand on the jog keys, where the screen has those."""

    _laid_out = False

    def __init__(self) -> None:
        super().__init__()
        send_spans_alone(self)

    @property
    def desk(self) -> Desk:
        """The desk that the screen belongs to."""
        return cast("Desk", self.app)

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
        banner = panels.banner(status, desk.keys, looked_for=looked_for, paused_here=paused_here)
        remarks = panels.remarks(status, desk.message or self.hint, bannered=bool(banner))
        self.text("title").show(panels.title(status, titled(self.place), width, desk.at_work))
        self.text("banner").show(desk.spoken(banner))
        self.text("remarks").show(desk.spoken(remarks))
        self.text("footer").show(desk.keys.footer(self.place, width, self.idle))
        self.text("title").set_class(not status.simulated, "-real")
        self.text("banner").set_class(bool(banner), "-shown")
        self.show_body(status)

    def show_body(self, status: Status) -> None:
        """Show this status in the middle of the screen."""

    def text(self, name: str) -> PlainText:
        """Return one of the screen's texts."""
        return self.query_one(f"#{name}", PlainText)
