"""The jog screen: the arm in drawings and numbers, and the keys that move it by hand."""

from __future__ import annotations

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll

from armdrive.draw.armview import side_view, top_view
from armdrive.status import Status
from tui import tables
from tui.framework import Alarm, PlainText
from tui.jogging import Jogging
from tui.layout import bindings
from tui.screens.base import DeskScreen
from tui.settings import Settings
from tui.views import ArmView


class JogScreen(DeskScreen):
    """Jog keys live here alone, and only while they are armed."""

    place = "jog"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)
    CSS = """
    #views { width: 1fr; }
    #panel { width: 1fr; min-width: 42; padding: 0 0 0 1; scrollbar-size: 0 0; }
    #conduct, #joints, #tip, #bottom { height: auto; }
    #conduct.-armed { color: $warning; text-style: bold; }
    .-wide #joints, .-wide #tip, .-wide #bottom { margin: 1 0 0 0; }
    """

    def __init__(self) -> None:
        super().__init__()
        desk = self.desk
        self.hand = Jogging(
            desk.arm, clock=desk.clock, say=desk.say, settings=lambda: self.desk.settings
        )
        self.hand.alarm = Alarm(desk, self.hand.tick)

    @property
    def armed(self) -> bool:
        """Whether jog keys have any effect."""
        return self.hand.armed

    def disarm(self, reason: str) -> None:
        """End what is held, and let no jog key have effect."""
        self.hand.disarm(reason)

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: drawings on the left, words and numbers on the right."""
        with Horizontal():
            with Vertical(id="views"):
                yield ArmView("side", side_view, braille=self.desk.braille, id="side")
                yield ArmView("above", top_view, braille=self.desk.braille, id="top")
            with VerticalScroll(id="panel", can_focus=False):
                for name in ("conduct", "joints", "tip", "bottom"):
                    yield PlainText(id=name)

    def show_body(self, status: Status) -> None:
        """Show this status; keys that nobody uses are disarmed."""
        self.hand.disarm_idle()
        settings, model = self.desk.settings, self.desk.arm.model
        width = max(self.query_one("#panel").content_size.width, 1)
        keys = self.desk.keys
        self.text("conduct").show(tables.conduct(status, settings, keys, armed=self.armed))
        self.text("joints").show(tables.joint_table(status, model, settings, keys, width))
        self.text("tip").show(tables.tip_lines(status, settings, keys))
        self.text("bottom").show(tables.bottom_lines(status))
        self.text("conduct").set_class(self.armed, "-armed")
        scene = self.desk.scene()
        for view in self.query(ArmView):
            view.show(scene)

    # -- keys ---------------------------------------------------------------------------------

    def action_jog(self, key: str) -> None:
        """Hand a jog key to the dead-man."""
        if not self.desk.nobody_there():
            self.hand.press(key)

    def action_arm_keys(self) -> None:
        """Let the jog keys have effect."""
        if self.desk.nobody_there():
            return
        if self.hand.arm_keys():
            self.desk.say("armed: tap a key for one increment, hold it to keep moving")
        else:
            arm = self.desk.keys.label("arm")
            self.desk.say(f"keys are still arriving: let go of all keys, then press {arm} again")

    def _set(self, settings: Settings) -> None:
        """Change settings. Whatever is held was meant with the old ones, so it ends."""
        self.hand.release()
        self.desk.settings = settings
        self.desk.show()

    def action_mode(self) -> None:
        """Switch between joint and Cartesian mode."""
        self._set(self.desk.settings.other_mode())

    def action_frame(self) -> None:
        """Go on to the next frame in which the tip is jogged."""
        if not self.desk.settings.cartesian:
            mode = self.desk.keys.label("mode")
            self.desk.say(f"frames are for Cartesian mode: press {mode} first")
            return
        self._set(self.desk.settings.with_next_frame())

    def action_finer(self) -> None:
        """Make the increment smaller."""
        self._set(self.desk.settings.with_increment(-1))

    def action_coarser(self) -> None:
        """Make the increment larger."""
        self._set(self.desk.settings.with_increment(1))

    def action_slower(self) -> None:
        """Jog more slowly."""
        self._set(self.desk.settings.with_speed(-1))

    def action_faster(self) -> None:
        """Jog faster."""
        self._set(self.desk.settings.with_speed(1))
