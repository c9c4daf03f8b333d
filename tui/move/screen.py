"""The move screen: type a goal, see the motion before it begins, and confirm it."""

from __future__ import annotations

from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll

from armdrive.errors import ArmError, BadRequest
from armdrive.motion.frames import BASE, TOOL
from armdrive.motion.preview import Preview
from armdrive.moves import Motion
from armdrive.status import Status
from kinematics.spaces import Joints, Pose
from tui.arm_view import SpaceView
from tui.desk import Desk, DeskScreen
from tui.keys.keyboard import bindings
from tui.move.form import DIGITS, GoalFields, GoalForm, present_of
from tui.move.planned import NOTHING_ASKED, PlannedMove, preview_text, way_text
from tui.settings import MoveSettings
from tui.widgets import PlainText, panels


class GoalEntry:
    """The form as it is filled in. Every change takes the first press of a confirmation back."""

    def __init__(self, desk: Desk) -> None:
        geometry, settings = desk.arm.model.arm, desk.move_settings
        self.form = GoalForm(
            geometry.joint_names,
            geometry.has_yaw,
            desk.arm.frames,
            cartesian=settings.cartesian,
            speed=settings.speed,
        )
        self.planned = PlannedMove(desk, self.goal)
        """The motion to this goal."""
        self._desk = desk

    def goal(self, status: Status) -> Motion | None:
        """Return what the form asks for."""
        return self.form.ask(self.present(status))

    def present(self, status: Status) -> dict[str, float]:
        """Return where the arm is, in the form's mode and frame."""
        pose: Pose | None = status.pose
        if self.form.cartesian and self.form.frame not in (BASE, TOOL) and pose is not None:
            try:
                pose = self._desk.arm.pose_in(self.form.frame)
            except ArmError:
                pose = None
        return present_of(self.form, status, pose)

    def start_at(self, joints: Joints) -> None:
        """Take up a goal that another screen has left for this one."""
        self.form = self.form.at_joints(joints)

    def _change(self, form: GoalForm) -> None:
        """Take another form; a first press was meant for the one before."""
        self.planned.forget_press()
        self.form = form
        self._desk.move_settings = MoveSettings(form.cartesian, form.speed)

    # -- keys ---------------------------------------------------------------------------------

    def type(self, character: str) -> None:
        """Type into the field."""
        self._change(self.form.typed(character))

    def erase(self) -> None:
        """Take the last character of the field away."""
        self._change(self.form.erased())

    def clear(self) -> None:
        """Empty all fields."""
        self._change(self.form.cleared())

    def move_to_field(self, by: int) -> None:
        """Go to another field."""
        self._change(self.form.moved(by))

    def choose_field(self, at: int) -> None:
        """Go to the field that was clicked."""
        with self._desk.calls.acting():
            self._change(self.form.moved(at - self.form.at))

    def step(self, sign: int) -> None:
        """Change the field by a step."""
        present = self.present(self._desk.link.status)
        self._change(self.form.stepped(sign, present.get(self.form.name)))

    def change_step(self, by: int) -> None:
        """Make the arrows' step smaller or larger."""
        self._change(self.form.with_step(by))

    def change_speed(self, by: int) -> None:
        """Move faster or more slowly."""
        self._change(self.form.with_speed(by))

    def switch_mode(self) -> None:
        """Switch between joint angles and poses."""
        self._change(self.form.other_mode())

    def switch_line(self) -> None:
        """Switch between a straight line and a joint motion."""
        if not self.form.cartesian:
            raise BadRequest("a straight line is of a pose: switch the mode first")
        self._change(self.form.other_way())

    def next_frame(self) -> None:
        """Mean the pose in the next frame."""
        if not self.form.cartesian:
            raise BadRequest("frames are of poses: switch the mode first")
        self._change(self.form.next_frame())

    def take_nearest(self) -> None:
        """Ask for what is possible instead of a goal that was refused."""
        preview = self.planned.preview
        nearest = preview.nearest if preview is not None else None
        if nearest is None:
            raise BadRequest("nothing was refused for which there is something nearer")
        form = self.form
        cartesian = form.cartesian
        self._change(form.at_pose(nearest.pose) if cartesian else form.at_joints(nearest.joints))

    def take_next_posture(self) -> None:
        """Ask for the next posture at this goal that is allowed, by its joints."""
        preview = self.planned.preview
        others = [way for way in (preview.ways if preview else ()) if way.allowed and not way.taken]
        if not others:
            raise BadRequest("no other posture that is allowed holds the hand there")
        self._change(self.form.at_joints(others[0].joints))


class MoveScreen(DeskScreen):
    """A form, and the arm with the ghost of where it would go.

    Nothing here moves the arm but what was seen, and confirmed by two presses.
    """

    place = "move"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        self.entry = GoalEntry(self.desk)
        self.planned = self.entry.planned

    def disarm(self, reason: str) -> None:  # noqa: ARG002 - as every screen
        """Take a first press back."""
        self.planned.forget_press()

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: the arm with its ghost on the left, the goal on the right."""
        with Horizontal():
            yield from self.arm_panel()
            with VerticalScroll(id="panels", can_focus=False):
                with Vertical(id="goal-panel", classes="panel") as goal:
                    goal.border_title = "Goal"
                    yield PlainText(id="goal")
                    yield GoalFields(self.entry.choose_field, id="fields")
                yield from panels(going="Go", foreseen="What the motion would be")

    def show_body(self, status: Status) -> None:
        """Show the goal, and what its motion would be as soon as that is worked out."""
        fresh = self.planned.follow(status)
        self.query_one(SpaceView).show(self.planned.moment(status, fresh))
        form, present = self.entry.form, self.entry.present(status)
        self.text("goal").show(way_text(form, self.desk.keys))
        self.query_one(GoalFields).show_form(form, present)
        self.show_panel("foreseen", self.desk.spoken(self._foreseen_text(fresh)))
        self.show_panel("going", self.planned.text(status, fresh))

    def _foreseen_text(self, fresh: Preview | None) -> str:
        if self.planned.under_way:
            return ""
        if wrong := self.entry.form.wrong():
            return wrong
        if fresh is not None:
            return preview_text(fresh, self.desk.keys)
        return "working it out ..." if self.planned.working else NOTHING_ASKED

    def take_typed(self, event: events.Key) -> bool:
        """Type into the field; other keys go on to the table of keys."""
        if event.character is None or event.character not in DIGITS:
            return False
        with self.desk.calls.acting():
            self.entry.type(event.character)
        return True

    def on_screen_resume(self) -> None:
        """Take up a goal that another screen has left for this one."""
        left, self.desk.goal = self.desk.goal, None
        if left is not None:
            self.entry.start_at(left)
