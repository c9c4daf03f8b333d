"""The jog screen: the arm in drawings and numbers, and the keys that move it by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll

from armdrive import Grasped
from armdrive.errors import BadRequest
from armdrive.moves import GraspMove, GripperMove
from armdrive.render.scene import Moment
from armdrive.status import State, Status, Trust
from kinematics.text import mm_text
from tui.app import HoldAlarm
from tui.arm_view import SpaceView
from tui.axes import DEGREE
from tui.desk import Desk, DeskScreen
from tui.jog.jogging import DeskJogging
from tui.jog.panels import (
    AxisPanels,
    can_grasp,
    detail_lines,
    grasped,
    limits_hold,
    near_lines,
)
from tui.keys.keyboard import bindings
from tui.safety import FACT_GAP, can_reference, without_link
from tui.widgets import panels

TAP_OR_HOLD = "tap a key for one step, hold it to keep moving"


class Fingers:
    """The keys that open or close the fingers by themselves, once the keys are armed."""

    def __init__(self, desk: Desk, hand: DeskJogging) -> None:
        self._desk = desk
        self._hand = hand

    def preset(self, share: float) -> None:
        """Bring the fingers to a share of their range: 1 is open, 0 is closed."""
        low_mm, high_mm = self._desk.arm.model.gripper_range_mm
        opening_mm = low_mm + share * (high_mm - low_mm)
        move = GripperMove(opening_mm, self._desk.settings.jog.speed)
        self._press(f"opens to {share:.0%}", move)

    def grasp(self) -> None:
        """Close the fingers on what is between them."""
        self._press("grasps", GraspMove())

    def _press(self, effect: str, move: GripperMove | GraspMove) -> None:
        """Take one press of such a key: the fingers move once no other key has followed."""
        arm, stops = self._desk.arm, self._desk.arm.stops

        def carry_out() -> str:
            found = arm.start(move, stops=stops).wait()
            return grasped(found) if isinstance(found, Grasped) else opened(arm.status.gripper_mm)

        def begin() -> None:
            self._require_armed()  # the keys may have been disarmed since
            self._hand.disarm("the fingers move by themselves")
            self._desk.calls.make(carry_out)

        self._require_armed()
        self._desk.confirmation.press(effect, begin, needed=1)

    def _require_armed(self) -> None:
        if not self._hand.armed:
            arm = self._desk.keys.label("arm")
            raise BadRequest(f"this moves the fingers: {arm} arms the keys first")


class JogScreen(DeskScreen):
    """Jog keys live here alone, and only while they are armed."""

    place = "jog"
    go = "arm"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        desk = self.desk
        self.hand: DeskJogging = DeskJogging(
            desk.arm,
            clock=desk.clock,
            say=desk.say,
            settings=desk.settings.jog,
            age_s=desk.input.key_age_s,
        )
        self.hand.alarm = HoldAlarm(desk, self.hand.tick)
        self.fingers = Fingers(desk, self.hand)
        settings = desk.settings.jog
        self.action_switch_mode = self._release_and(settings.switch_mode)
        self.action_change_step = self._release_and(settings.change_step)
        self.action_change_speed = self._release_and(settings.change_speed)
        self.axes = AxisPanels(desk, self.hand)

    @property
    def says(self) -> str:
        """The state of the jog keys, in words."""
        keys = self.desk.keys
        if state_says := super().says:
            return state_says
        if not self.armed:
            return f"keys DISARMED: {keys.label('arm')} arms them"
        if limits_hold(self.desk.link.status):
            return TAP_OR_HOLD
        if self.desk.settings.jog.cartesian:
            return f"the tip needs a reference first; {keys.label('mode')} moves the joints"
        return f"NO LIMITS: {TAP_OR_HOLD}"

    @property
    def settings_text(self) -> str:
        """The speed and the steps of the jog keys."""
        settings = self.desk.settings.jog
        steps = [f"{settings.step_deg:g}{DEGREE}", f"{settings.step_mm:g} mm"]
        driven = int(settings.cartesian)
        steps[driven] = f"[{steps[driven]}]"  # the one that the keys use and change now
        return f"speed {settings.speed * 100:.0f}%{FACT_GAP}step {' '.join(steps)}"

    @property
    def works(self) -> Mapping[str, bool]:
        """Keys that are armed need no arming; keys that are not grasp nothing."""
        link = self.desk.link
        return {
            "arm": not (self.armed or link.moves),
            "grasp": self.armed and can_grasp(link.status.dialect),
            "park": link.status.state is not State.HOMING,
            "frame": self.desk.settings.jog.cartesian,
        }

    @property
    def hint(self) -> str:
        """Instructions to begin and to end a jog."""
        keys, status = self.desk.keys, self.desk.link.status
        if status.trust is Trust.UNKNOWN and can_reference(status.state):
            reference = keys.label("reference")
            return f"{reference} references the arm: only then does the desk know where it is"
        return f"{keys.label('stop')} stops at any time; {keys.label('help')} explains the keys"

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: the arm on the left, panels of numbers on the right."""
        near, details = panels(near="Near", details="Details")
        near.border_subtitle = f"{self.desk.keys.label('details')} details"
        with Vertical():
            with Horizontal():
                yield from self.arm_panel()
                with VerticalScroll(id="panels", can_focus=False):
                    yield from self.axes.compose()
                    yield near
            yield details

    def show_body(self, status: Status) -> None:
        """Show this status; keys that have not been used for a while are disarmed."""
        self.hand.disarm_idle()
        joints = self.axes.show(status)
        near = near_lines(
            status, self.desk.arm.model, joints, without_link(status).partition(";")[0]
        )
        self.text("near").show_lines(near)
        if self.text("details").display:
            self.text("details").show(detail_lines(status))
        self._make_room()
        self.query_one(SpaceView).show(Moment(status.joints, status.gripper_mm))

    def _make_room(self) -> None:
        """Hide rows that no key moves, and the near panel, if not everything fits.

        Nothing is known to be near an arm whose link was lost in a motion.
        """
        frame = 1 if self.has_class("-short") else 2
        details = self.text("details")
        below = details.shown.count("\n") + 1 + frame if details.display else 0
        room = self.query_one("#body").size.height - below
        table, gripper = len(self.desk.settings.jog.rows) - 1 + frame, 2 + frame
        both = room >= 2 * table + gripper
        self.axes.show_only_driven(only=not both)
        near = self.text("near")
        near.display = bool(near.shown) and room > (1 + both) * table + gripper

    # -- keys ---------------------------------------------------------------------------------

    def action_jog(self, key: str) -> None:
        """Hand a jog key to the dead-man."""
        self.hand.press(key)

    def _release_and(self, change: Callable[..., None]) -> Callable[..., None]:
        """Return a change of settings before which whatever is held ends: it had the old ones."""

        def changed(*words: int) -> None:
            self.hand.release()
            change(*words)

        return changed

    def action_next_frame(self) -> None:
        """Go on to the next frame in which the tip is jogged."""
        settings = self.desk.settings.jog
        if not settings.cartesian:
            mode = self.desk.keys.label("mode")
            raise BadRequest(f"frames are for Cartesian mode: press {mode} first")
        self._release_and(settings.next_frame)()

    def action_arm_keys(self) -> None:
        """Let the jog keys have effect."""
        if not self.armed:
            self.desk.link.require_standing()  # a key held till the arm stands would begin a jog
        if not self.hand.arm_keys():
            arm = self.desk.keys.label("arm")
            raise BadRequest(f"keys are still arriving: let go of all keys, then press {arm} again")
        self.desk.say("armed: let go of a key and the arm stops")

    def action_park(self) -> None:
        """Ask whether the arm may go to its park posture."""
        self.desk.control.park(self.desk.settings.jog.speed)

    def action_details(self) -> None:
        """Show or hide what a technician asks for."""
        details = self.text("details")
        details.display = not details.display
        self._make_room()


def opened(opening_mm: float | None) -> str:
    """Say how far the fingers are open now."""
    return (
        "the fingers have arrived" if opening_mm is None else f"fingers {mm_text(opening_mm)} open"
    )
