"""The move screen: type a goal, see the motion before it begins, and confirm it."""

from __future__ import annotations

from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll

from armdrive.errors import ArmError
from armdrive.motion.frames import BASE, TOOL
from armdrive.motion.preview import Preview
from armdrive.moves import Motion
from armdrive.status import Status
from kinematics.spaces import Pose
from tui.arm_view import SpaceView
from tui.framework import PlainText
from tui.keys.keyboard import bindings
from tui.move import words as move_words
from tui.move.errand import ErrandScreen
from tui.move.form import DIGITS, GoalForm, present_of
from tui.settings import Manner


class MoveScreen(ErrandScreen):
    """A form, and beside it the arm with the ghost of where it would go.

    Every change of the form takes a first press of a confirmation back.
    """

    place = "move"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)
    CSS = """
    #move-panel { width: 1fr; min-width: 42; padding: 0 0 0 1; scrollbar-size: 0 0; }
    #goal, #foreseen, #going { height: auto; }
    #going { text-style: bold; }
    MoveScreen.-wide #foreseen, MoveScreen.-wide #going { margin: 1 0 0 0; }
    """

    def __init__(self) -> None:
        super().__init__()
        arm = self.desk.arm
        geometry = arm.model.arm
        manner = self.desk.manner
        self.form = GoalForm(
            geometry.joint_names,
            geometry.has_yaw,
            arm.frames,
            cartesian=manner.cartesian,
            speed=manner.speed,
        )

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: the arm with its ghost on the left, the goal on the right."""
        desk = self.desk
        with Horizontal():
            yield SpaceView(desk.arm.model, braille=desk.braille, id="space", clock=desk.clock)
            with VerticalScroll(id="move-panel", can_focus=False):
                for name in ("goal", "foreseen", "going"):
                    yield PlainText(id=name)

    def goal(self, status: Status) -> Motion | None:
        """Return what the form asks for."""
        return self.form.ask(self.present(status))

    def show_body(self, status: Status) -> None:
        """Show the goal, and what its motion would be as soon as that is worked out."""
        fresh = self.look_ahead(status)
        present = self.present(status)
        self.text("goal").show(move_words.form_text(self.form, present, self.desk.keys))
        self.text("foreseen").show(self.desk.spoken(self._foreseen_text(fresh)))
        self.text("going").show(self.going_text(status, fresh))

    def _foreseen_text(self, fresh: Preview | None) -> str:
        if self._progress is not None:
            return ""
        if wrong := self.form.wrong():
            return wrong
        if fresh is not None:
            return move_words.preview_text(fresh, self.desk.keys)
        return "working it out ..." if self._working else move_words.NOTHING_ASKED

    def present(self, status: Status) -> dict[str, float]:
        """Return where the arm is, in the form's mode and frame."""
        pose: Pose | None = status.pose
        if self.form.cartesian and self.form.frame not in (BASE, TOOL) and pose is not None:
            try:
                pose = self.desk.arm.pose_in(self.form.frame)
            except ArmError:
                pose = None
        return present_of(self.form, status, pose)

    # -- the keys that fill in the goal -------------------------------------------------------

    def on_key(self, event: events.Key) -> None:
        """Type into the field; other keys go on to the table of keys."""
        if event.character is not None and event.character in DIGITS:
            event.stop()
            event.prevent_default()
            self._change(self.form.typed(event.character))

    def _change(self, form: GoalForm) -> None:
        """Take another form; a first press was meant for the one before."""
        self.confirming.forget()
        self.form = form
        self.desk.manner = Manner(form.cartesian, form.speed)
        self.desk.show()

    def action_field(self, by: int) -> None:
        """Go to another field."""
        self._change(self.form.moved(by))

    def action_step(self, sign: int) -> None:
        """Change the field by a step."""
        present = self.present(self.desk.status)
        self._change(self.form.stepped(sign, present.get(self.form.name)))

    def action_erase(self) -> None:
        """Take the last character of the field away."""
        self._change(self.form.erased())

    def action_clear(self) -> None:
        """Empty all fields."""
        self._change(self.form.cleared())

    def action_mode(self) -> None:
        """Switch between joint angles and poses."""
        self._change(self.form.other_mode())

    def action_line(self) -> None:
        """Switch between a straight line and a joint motion."""
        if self.form.cartesian:
            self._change(self.form.other_way())
        else:
            self.desk.say("a straight line is of a pose: switch the mode first")

    def action_frame(self) -> None:
        """Mean the pose in the next frame."""
        if self.form.cartesian:
            self._change(self.form.next_frame())
        else:
            self.desk.say("frames are of poses: switch the mode first")

    def action_speed(self, by: int) -> None:
        """Move faster or more slowly."""
        self._change(self.form.with_speed(by))

    def action_step_size(self, by: int) -> None:
        """Make the arrows' step smaller or larger."""
        self._change(self.form.with_step(by))

    def action_nearest(self) -> None:
        """Ask for what is possible instead of a goal that was refused."""
        nearest = self.preview.nearest if self.preview is not None else None
        if nearest is None:
            self.desk.say("nothing was refused for which there is something nearer")
        elif self.form.cartesian:
            self._change(self.form.at_pose(nearest.pose))
        else:
            self._change(self.form.at_joints(nearest.joints))

    def action_posture(self) -> None:
        """Ask for the next posture at this goal that is allowed, by its joints."""
        ways = [way for way in (self.preview.ways if self.preview else ()) if way.allowed]
        others = [way for way in ways if not way.taken]
        if not others:
            self.desk.say("no other posture that is allowed holds the hand there")
        else:
            self._change(self.form.at_joints(others[0].joints))

    def on_screen_resume(self) -> None:
        """Take up a goal that another screen has left for this one."""
        left, self.desk.goal = self.desk.goal, None
        if left is not None:
            self.form = self.form.at_joints(left)
        super().on_screen_resume()
