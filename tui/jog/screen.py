"""The jog screen: the arm in drawings and numbers, and the keys that move it by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, cast

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.strip import Strip
from textual.widget import Widget

from armdrive.errors import ArmError
from armdrive.motion.frames import BASE, TOOL
from armdrive.render.scene import Moment
from armdrive.status import Status
from kinematics.spaces import Pose
from tui.app import HoldAlarm, KeyApp
from tui.arm_view import SpaceView
from tui.gamepad.jogging import PAD
from tui.jog import text as jog_text
from tui.jog.jogging import DeskJogging
from tui.jog.text import Load
from tui.keys.keyboard import bindings
from tui.painting import PlainText
from tui.screens import DeskScreen, ScreenHost
from tui.settings import JogSettings

# Buttons for the mouse that move an arm while they are held: a column of minus and plus.

CELLS = ("[-]", "[+]")
BUTTONS_WIDTH = sum(map(len, CELLS)) + 1
HELD = "<->", "<+>"
"""How a button looks that is held: not by its colour alone."""


class HoldButtons(Widget):
    """One row for each pair of jog keys. Pressing holds; letting go, or leaving, lets go.

    `push(row, plus)` is called when a button is pressed, `moved()` when the mouse is heard of while
    it holds, `lift()` when it is let go of. The column is never focused: no key can press it.
    """

    DEFAULT_CSS = f"""
    HoldButtons {{ width: {BUTTONS_WIDTH}; }}
    """
    can_focus = False

    def __init__(
        self,
        push: Callable[[int, bool], None],
        moved: Callable[[], None],
        lift: Callable[[], None],
        *,
        id: str,  # noqa: A002
    ) -> None:
        super().__init__(id=id)
        self._push, self._moved, self._lift = push, moved, lift
        self._rows = 0
        self._held: tuple[int, bool] | None = None

    @property
    def held(self) -> tuple[int, bool] | None:
        """The row and side that is held down."""
        return self._held

    def show(self, rows: int, *, held: bool) -> None:
        """Show so many rows; `held` says whether whatever is pressed still moves something."""
        if not held and self._held is not None:
            self._held = None
            self.refresh()
        if rows != self._rows:
            self._rows = rows
            self.styles.height = rows
            self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return one row of buttons."""
        style = self.rich_style
        segments = [Segment(" ", style)]
        for side in (False, True):
            down = self._held == (y, side)
            look = style + Style(reverse=True) if down else style
            segments.append(Segment((HELD if down else CELLS)[side], look))
        return (
            Strip(segments, BUTTONS_WIDTH) if y < self._rows else Strip.blank(BUTTONS_WIDTH, style)
        )

    def at(self, x: int, y: int) -> tuple[int, bool] | None:
        """Return the row and side of a place, None beside the buttons."""
        if not (0 <= y < self._rows and 1 <= x < BUTTONS_WIDTH):
            return None
        return y, x > len(CELLS[0])

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """Press a button, with the first button of the mouse alone."""
        event.stop()
        self._let_go()
        found = self.at(event.x, event.y)
        if event.button != 1 or found is None:
            return
        self._held = found
        self.capture_mouse()
        self.refresh()
        self._push(*found)

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """Go on while the mouse stays on its button; leaving it lets go."""
        if self._held is None:
            return
        if self.at(event.x, event.y) == self._held:
            self._moved()
        else:
            self._let_go()

    def on_mouse_up(self, event: events.MouseUp) -> None:
        """Let go."""
        event.stop()
        self._let_go()

    def on_leave(self) -> None:
        """Let go when the mouse is somewhere else."""
        self._let_go()

    def on_hide(self) -> None:
        """Let go of a button that is not shown any more."""
        self._let_go()

    def _let_go(self) -> None:
        self.release_mouse()
        if self._held is not None:
            self._held = None
            self.refresh()
            self._lift()


class Adjustments:
    """The keys that change how jog keys move the arm."""

    def __init__(self, desk: ScreenHost, hand: DeskJogging) -> None:
        self._desk = desk
        self._hand = hand

    def _set(self, settings: JogSettings) -> None:
        """Change settings. Whatever is held was meant with the old ones, so it ends."""
        self._hand.release()
        self._desk.settings = settings
        self._desk.show()

    def switch_mode(self) -> None:
        """Switch between joint and Cartesian mode."""
        self._set(self._desk.settings.other_mode())

    def next_frame(self) -> None:
        """Go on to the next frame in which the tip is jogged."""
        if not self._desk.settings.cartesian:
            mode = self._desk.keys.label("mode")
            self._desk.say(f"frames are for Cartesian mode: press {mode} first")
            return
        self._set(self._desk.settings.with_next_frame())

    def finer(self) -> None:
        """Make the increment smaller."""
        self._set(self._desk.settings.with_increment(-1))

    def coarser(self) -> None:
        """Make the increment larger."""
        self._set(self._desk.settings.with_increment(1))

    def slower(self) -> None:
        """Jog more slowly."""
        self._set(self._desk.settings.with_speed(-1))

    def faster(self) -> None:
        """Jog faster."""
        self._set(self._desk.settings.with_speed(1))


TABLES = ("joints", "tip")
"""What is jogged has buttons beside it: the joints, or the tip."""


class JogScreen(DeskScreen):
    """Jog keys live here alone, and only while they are armed."""

    place = "jog"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)
    CSS = f"""
    #panel {{ width: 1fr; min-width: 49; padding: 0 0 0 1; scrollbar-size: 0 0; }}
    #conduct, #joints, #tip, #bottom, .table {{ height: auto; }}
    #joints, #tip {{ width: 1fr; max-width: {jog_text.WIDEST_ROW}; }}
    #conduct.-armed {{ color: $warning; text-style: bold; }}
    JogScreen.-wide .table, JogScreen.-wide #bottom {{ margin: 1 0 0 0; }}
    """

    def __init__(self) -> None:
        super().__init__()
        desk, app = self.desk, cast("KeyApp", self.app)
        self.hand: DeskJogging = DeskJogging(
            desk.arm,
            clock=desk.clock,
            say=desk.say,
            settings=lambda: self.desk.settings,
            age_s=app.input.key_age_s,
        )
        self.hand.alarm = HoldAlarm(app, self.hand.tick)
        self.adjustments = Adjustments(desk, self.hand)
        self._load = Load()
        self._felt = ""

    @property
    def armed(self) -> bool:
        """Whether jog keys have any effect."""
        return self.hand.armed

    @property
    def idle(self) -> tuple[str, ...]:
        """Keys that are armed need no arming; keys that are not grasp nothing."""
        return ("arm",) if self.armed else ("grasp",)

    @property
    def hint(self) -> str:
        """How jogging begins, and how it ends."""
        keys = self.desk.keys
        arm, stop = keys.label("arm"), keys.label("stop")
        return f"{arm} arms the jog keys; {stop} stops at any time"

    def disarm(self, reason: str) -> None:
        """End what is held, and let no jog key have effect."""
        self.hand.disarm(reason)

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: drawings on the left, words and numbers on the right."""
        with Horizontal():
            reference = self.desk.keys.label("reference")
            yield SpaceView(
                self.desk.arm.model,
                braille=self.desk.braille,
                unknown=f"posture not known: {reference}",
                clock=self.desk.clock,
                id="space",
            )
            with VerticalScroll(id="panel", can_focus=False):
                yield PlainText(id="conduct")
                for name in TABLES:
                    with Horizontal(classes="table"):
                        yield PlainText(id=name)
                        yield HoldButtons(
                            self._push, self.hand.moved, self.hand.lift, id=f"hold-{name}"
                        )
                yield PlainText(id="bottom")

    def show_body(self, status: Status) -> None:
        """Show this status; keys that nobody uses are disarmed."""
        self.hand.disarm_idle()
        settings, model = self.desk.settings, self.desk.arm.model
        width = max(self.query_one("#panel").content_size.width - BUTTONS_WIDTH, 1)
        keys, pose = self.desk.keys, self._pose(status)
        self._show_buttons(settings, pose_known=pose is not None)
        self.text("conduct").show(jog_text.conduct(status, settings, keys, armed=self.armed))
        self.text("joints").show(jog_text.joint_table(status, model, settings, keys, width))
        self.text("tip").show(jog_text.tip_lines(status, model, settings, keys, width, pose))
        load = self._load.of(status.link_stats, self.desk.clock())
        force_n = self.desk.arm.gripper.force_n
        self.text("bottom").show(jog_text.bottom_lines(status, width, force_n, load))
        self.text("conduct").set_class(self.armed, "-armed")
        self.query_one(SpaceView).show(Moment(status.joints, status.gripper_mm))

    def _pose(self, status: Status) -> Pose | None:
        """Return the pose as the frame sees it that is jogged in; for the tool's, as the base."""
        settings = self.desk.settings
        if status.pose is None or not settings.cartesian or settings.frame in (BASE, TOOL):
            return status.pose
        try:
            return self.desk.arm.pose_in(settings.frame)
        except ArmError:
            return None  # it has become unknown since the status was taken

    # -- buttons ------------------------------------------------------------------------------

    def _show_buttons(self, settings: JogSettings, *, pose_known: bool) -> None:
        """Show buttons beside whatever is jogged, and how they are held."""
        held = self.hand.held_button not in ("", PAD)
        for name in TABLES:
            buttons = self.query_one(f"#hold-{name}", HoldButtons)
            shown = (name == "tip") == settings.cartesian and (pose_known or name != "tip")
            buttons.visible = shown
            buttons.show(len(settings.rows) if shown else 0, held=held)

    def _push(self, row: int, plus: bool) -> None:
        """Hold the button of a row."""
        if not self.desk.link.says_lost():
            pair = self.desk.settings.rows[row]
            self.hand.push(pair.plus if plus else pair.minus)

    # -- keys ---------------------------------------------------------------------------------

    def action_jog(self, key: str) -> None:
        """Hand a jog key to the dead-man."""
        if not self.desk.link.says_lost():
            self.hand.press(key)

    def action_arm_keys(self) -> None:
        """Let the jog keys have effect."""
        if self.desk.link.says_lost():
            return
        if self.hand.arm_keys():
            self.desk.say("armed: tap a key for one increment, hold it to keep moving")
        else:
            arm = self.desk.keys.label("arm")
            self.desk.say(f"keys are still arriving: let go of all keys, then press {arm} again")

    def action_grasp(self) -> None:
        """Close the fingers on what is between them; they do that by themselves, so it is armed."""
        desk, arm = self.desk, self.desk.arm
        if desk.link.says_lost():
            return
        if not self.armed:
            desk.say(f"grasping moves the fingers: {desk.keys.label('arm')} arms it first")
            return
        self.disarm("the fingers close by themselves")

        def grasp() -> None:
            found = arm.gripper.feel()
            self._felt = jog_text.grasped(found)

        desk.call(grasp, lambda _: self._felt)
