"""A goal as it is typed: fields, the mode, the frame, line or joint motion, the speed.

Units: degrees and mm, as people type them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from textual import events
from textual.content import Content
from textual.coordinate import Coordinate
from textual.widgets import DataTable

from armdrive.motion.frames import BASE, TOOL
from armdrive.moves import JointMove, LineMove, Motion, PoseMove
from armdrive.status import Status
from kinematics.spaces import Joints, Pose
from tui.keys.table import words
from tui.settings import SPEEDS, neighbour

STEPS = (0.1, 1.0, 5.0, 10.0, 50.0)
"""By how much the arrows change a field, in degrees or mm."""

DIGITS = frozenset("0123456789.-")
"""What a field is typed with; a space is never one of them."""

LONGEST = 9
"""Characters in a field: -1234.567 is more than any arm needs."""

TASK_UNITS: Mapping[str, str] = MappingProxyType(
    {"x": "mm", "y": "mm", "z": "mm", "pitch": "°", "roll": "°", "yaw": "°"}
)


@dataclass(frozen=True, slots=True)
class FormEntry:
    """What stands in a field: as typed, or a number from elsewhere with all its digits."""

    text: str = ""
    exact: float | None = None

    @property
    def value(self) -> float | None:
        """The number; None of an empty field. Raises `ValueError` for what is no number."""
        if self.exact is not None or not self.text:
            return self.exact
        return float(self.text)

    @property
    def shown(self) -> str:
        """The field as people see it."""
        return self.text if self.exact is None else f"{self.exact:.2f}"


EMPTY = FormEntry()


@dataclass(frozen=True, slots=True)
class GoalForm:
    """The fields of both modes, and which of them is typed into. Every change makes a new one."""

    joints: tuple[str, ...]
    has_yaw: bool
    frames: tuple[str, ...]
    cartesian: bool = True
    line: bool = False
    frame: str = BASE
    speed: float = 0.5
    step: float = 1.0
    at: int = 0
    entries: Mapping[str, FormEntry] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """The fields of the present mode."""
        if not self.cartesian:
            return self.joints
        return tuple(TASK_UNITS)[: None if self.has_yaw else -1]

    @property
    def name(self) -> str:
        """The field that is typed into."""
        return self.names[self.at]

    def entry(self, name: str) -> FormEntry:
        """Return what stands in a field of the present mode."""
        return self.entries.get(name, EMPTY)

    def unit(self, name: str) -> str:
        """Return the unit of a field."""
        return TASK_UNITS[name] if self.cartesian else "°"

    # -- changes ------------------------------------------------------------------------------

    def moved(self, by: int) -> GoalForm:
        """Go to another field."""
        return replace(self, at=(self.at + by) % len(self.names))

    def typed(self, character: str) -> GoalForm:
        """Type into the field; what was put there from elsewhere is typed over."""
        entry = self.entry(self.name)
        text = ("" if entry.exact is not None else entry.text) + character
        return self._with(self.name, FormEntry(text[:LONGEST]))

    def erased(self) -> GoalForm:
        """Take the last character away; a number from elsewhere as a whole."""
        entry = self.entry(self.name)
        return self._with(self.name, FormEntry("" if entry.exact is not None else entry.text[:-1]))

    def cleared(self) -> GoalForm:
        """Empty every field of the present mode: all stays as it is."""
        return replace(self, entries={})

    def stepped(self, sign: int, present: float | None) -> GoalForm:
        """Change the field by a step, from what stands in it or from where the arm is."""
        try:
            value = self.entry(self.name).value
        except ValueError:
            value = None
        start = present if value is None else value
        if start is None:
            return self
        return self._with(self.name, FormEntry(exact=round(start + sign * self.step, 4)))

    def other_mode(self) -> GoalForm:
        """Switch between joint angles and poses; the fields are empty then."""
        return replace(self, cartesian=not self.cartesian, at=0, entries={})

    def other_way(self) -> GoalForm:
        """Switch between a joint motion and a straight line, which only poses know."""
        return replace(self, line=not self.line)

    def next_frame(self) -> GoalForm:
        """Mean the pose in the next frame; what was typed was meant in the last one."""
        following = self.frames[(self.frames.index(self.frame) + 1) % len(self.frames)]
        return replace(self, frame=following, entries={})

    def with_speed(self, by: int) -> GoalForm:
        """Go faster or more slowly."""
        return replace(self, speed=neighbour(SPEEDS, self.speed, by))

    def with_step(self, by: int) -> GoalForm:
        """Make the arrows' step smaller or larger."""
        return replace(self, step=neighbour(STEPS, self.step, by))

    def at_joints(self, joints: Joints) -> GoalForm:
        """Ask for these joints, with all their digits."""
        entries = {name: FormEntry(exact=angle) for name, angle in joints.deg.items()}
        return replace(self, cartesian=False, at=0, entries=entries)

    def at_pose(self, pose: Pose) -> GoalForm:
        """Ask for this pose of the base, with all its digits."""
        entries = {name: FormEntry(exact=value) for name, value in of_pose(pose).items()}
        return replace(self, cartesian=True, frame=BASE, at=0, entries=entries)

    def _with(self, name: str, entry: FormEntry) -> GoalForm:
        return replace(self, entries={**self.entries, name: entry})

    # -- what it means ------------------------------------------------------------------------

    def wrong(self) -> str:
        """Say which field holds no number; nothing where all do."""
        for name in self.names:
            try:
                value = self.entry(name).value
            except ValueError:
                return f"{name}: {self.entry(name).text!r} is no number"
            if value is not None and not math.isfinite(value):
                return f"{name} must be finite"
        return ""

    def ask(self, present: Mapping[str, float]) -> Motion | None:
        """Return the move; None where nothing is asked for, or not all of it is known.

        `present` are the coordinates of the fields that stay empty: of the pose in the frame.
        """
        if self.wrong():
            return None
        values = {name: self.entry(name).value for name in self.names}
        given = {name: value for name, value in values.items() if value is not None}
        if not given:
            return None
        if not self.cartesian:
            return JointMove({f"{name}_deg": value for name, value in given.items()}, self.speed)
        whole = {**present, **given}
        if not set(self.names) <= set(whole):
            return None
        kind = LineMove if self.line else PoseMove
        return kind(pose_of(whole), self.speed, self.frame)


def of_pose(pose: Pose) -> dict[str, float]:
    """Return the coordinates of a pose by field."""
    found = {
        "x": pose.x_mm,
        "y": pose.y_mm,
        "z": pose.z_mm,
        "pitch": pose.pitch_deg,
        "roll": pose.roll_deg,
    }
    return found if pose.yaw_deg is None else {**found, "yaw": pose.yaw_deg}


def pose_of(values: Mapping[str, float]) -> Pose:
    """Return the pose of all fields."""
    return Pose.of(
        x_mm=values["x"],
        y_mm=values["y"],
        z_mm=values["z"],
        pitch_deg=values["pitch"],
        roll_deg=values["roll"],
        yaw_deg=values.get("yaw"),
    )


def present_of(form: GoalForm, status: Status, pose: Pose | None) -> dict[str, float]:
    """Return where the arm is, field by field; empty while that is unknown.

    `pose` is the present one in the form's frame; in the tool's a goal is a change, from zero.
    """
    if not form.cartesian:
        return {} if status.joints is None else dict(status.joints.deg)
    if form.frame == TOOL:
        return dict.fromkeys(form.names, 0.0)
    return {} if pose is None else of_pose(pose)


COLUMNS = (("", 12), ("goal", 12), ("", 3), ("now", 9))
"""The titles of the columns, and their widths in characters."""

Cells = tuple[str, str, str, str]


class GoalFields(DataTable[Content], can_focus=False):
    """The fields; the one that is typed into is lit. It is never focused; a click chooses a field.

    The keys of the table of keys type and move, so that a stop is never taken as text.
    """

    def __init__(self, chosen: Callable[[int], object], *, id: str) -> None:  # noqa: A002
        """`chosen` is called with the number of the field that was clicked."""
        super().__init__(id=id, cursor_type="row", cell_padding=0, show_cursor=True)
        self._clicked = chosen
        self._rows: tuple[Cells, ...] = ()

    @property
    def shown(self) -> str:
        """The rows as they stand."""
        return "\n".join(" ".join(row) for row in self._rows)

    def on_mount(self) -> None:
        """Make the columns."""
        for title, width in COLUMNS:
            self.add_column(f"{title:>{width}}", width=width)

    def show_form(self, form: GoalForm, present: Mapping[str, float]) -> None:
        """Show the fields of a form, with where the arm is; repaint only what has changed."""
        rows = tuple(_cells(form, name, present) for name in form.names)
        if len(rows) != len(self._rows):
            self.clear()
            self.add_rows(map(Content, row) for row in rows)
        else:
            for at, (row, before) in enumerate(zip(rows, self._rows, strict=True)):
                for column, text in enumerate(row):
                    if text != before[column]:
                        self.update_cell_at(Coordinate(at, column), Content(text))
        self._rows = rows
        if self.cursor_row != form.at:
            self.move_cursor(row=form.at)

    def on_click(self, event: events.Click) -> None:
        """Choose the field that was clicked."""
        row = event.style.meta.get("row", -1)
        if 0 <= row < len(self._rows):
            self._clicked(row)


def _cells(form: GoalForm, name: str, present: Mapping[str, float]) -> Cells:
    chosen = name == form.name
    now = f"{present[name]:.1f}" if name in present else "?"
    text = form.entry(name).shown + "_" * chosen
    return (f"{'>' if chosen else ' '} {words(name)}", f"{text:>12}", f" {form.unit(name)}",
            f"{now:>9}")  # fmt: skip
