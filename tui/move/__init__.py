"""The move screen: type a goal, see the motion before it begins, and confirm it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll

from armdrive.errors import ArmError, BadRequest
from armdrive.motion.preview import Preview
from armdrive.moves import BASE_FRAME, TOOL_FRAME
from armdrive.status import Status
from tui.arm_view import SpaceView
from tui.desk import DeskScreen
from tui.keys.keyboard import bindings
from tui.keys.table import Needs
from tui.move.form import FIELDS_HEAD, GoalForm, field_rows, of_pose
from tui.move.planned import (
    NOTHING_ASKED,
    PlannedMove,
    choices_text,
    other_ways,
    preview_text,
    way_text,
)
from tui.widgets import ChoiceList, PlainText, TypedText, panels


class MoveScreen(DeskScreen):
    """A form, and the arm with the ghost of where it would go.

    Nothing here moves the arm but what was seen, and confirmed by two presses.
    """

    place = "move"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        desk, geometry = self.desk, self.desk.arm.model.arm
        self.motion = desk.settings.move
        self.form = GoalForm(
            geometry.joint_names,
            desk.arm.frames,
            self.motion,
            self._present,
            has_yaw=geometry.has_yaw,
        )
        self.planned = PlannedMove(desk, self.form.goal)
        # what the keys of several screens do on this one
        self.action_press_go = self.planned.press
        self.action_choose = self.form.move_to_field
        self.action_change_value = self.form.change_value
        self.action_change_step = self.form.change_step
        self.action_change_speed = self.motion.change_speed
        self.action_switch_mode = self.form.switch_mode
        self.action_switch_line = self.form.switch_line
        self.action_next_frame = self.form.next_frame
        self.action_clear = self.form.clear

    @property
    def typing(self) -> TypedText:
        """The field that is typed into."""
        return self.form.field(self.form.name)

    @property
    def works(self) -> Mapping[str, bool]:
        """Without a goal no key goes, or takes another one."""
        preview = self.planned.preview
        return {
            "go": preview is not None and preview.refusal is None,
            "move-nearest": preview is not None and preview.nearest is not None,
            "move-posture": bool(other_ways(preview)),
        }

    def first_keys(self, status: Status) -> tuple[str, ...]:
        """Return the rows of every screen, and the key of a possible goal after a refusal."""
        return (*super().first_keys(status), "move-nearest")

    def _present(self) -> dict[str, float]:
        """Return where the arm is, field by field of the form; empty while that is unknown.

        In the tool's frame a goal is a change, from zero.
        """
        form, status = self.form, self.desk.link.status
        if not form.cartesian:
            return {} if status.joints is None else dict(status.joints.deg)
        if form.frame == TOOL_FRAME:
            return dict.fromkeys(form.names, 0.0)
        if status.pose is None or form.frame == BASE_FRAME:
            return {} if status.pose is None else of_pose(status.pose)
        try:
            return of_pose(self.desk.arm.pose_in(form.frame))
        except ArmError:
            return {}  # it has become unknown since the status was taken

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: the arm with its ghost on the left, the goal on the right."""
        with Horizontal():
            yield from self.arm_panel()
            with VerticalScroll(id="panels", can_focus=False):
                with Vertical(id="goal-panel", classes="panel") as goal:
                    goal.border_title = "Goal"
                    yield PlainText(id="goal")
                    yield ChoiceList("choose", id="fields", classes="")
                yield from panels(going="Go", foreseen="What the motion would be")

    def show_body(self, status: Status) -> None:
        """Show the goal, and what its motion would be as soon as that is worked out."""
        fresh = self.planned.follow(status)
        self.query_one(SpaceView).show(self.planned.moment(status, fresh))
        self.text("goal").show(f"{way_text(self.form, self.desk.keys)}\n{FIELDS_HEAD}")
        self.query_one(ChoiceList).show_rows(field_rows(self.form, self._present()), self.form.at)
        self.show_panel("foreseen", self.desk.spoken(self._foreseen_text(fresh)))
        self.show_panel("going", self.planned.text(status, fresh))

    def _foreseen_text(self, fresh: Preview | None) -> str:
        if self.planned.going.busy:
            return ""
        if wrong := self.form.wrong():
            return wrong
        if fresh is not None:
            told = bool(self.desk.link.hindrance(Needs.POSITION))
            choices = choices_text(fresh, self.desk.keys)
            return f"{preview_text(fresh, told=told)}\n{choices}".strip()
        return "working it out ..." if self.planned.previewing.busy else NOTHING_ASKED

    # -- keys ---------------------------------------------------------------------------------

    def action_take_nearest(self) -> None:
        """Ask for what is possible instead of a goal that was refused."""
        preview = self.planned.preview
        nearest = preview.nearest if preview is not None else None
        if nearest is None:
            raise BadRequest("there is no nearest possible goal: the motion is not refused")
        if self.form.cartesian:
            self.form.take_pose(nearest.pose)
        else:
            self.form.take_joints(nearest.joints)

    def action_take_next_posture(self) -> None:
        """Ask for the next posture at this goal that is allowed, by its joints."""
        others = other_ways(self.planned.preview)
        if not others:
            raise BadRequest("no other allowed posture reaches this goal")
        self.form.take_joints(others[0].joints)
