"""A goal as it is typed: fields, the mode, the frame, line or joint motion, the speed.

Units: degrees and mm, as people type them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from armdrive.errors import BadRequest
from armdrive.moves import BASE_FRAME, JointMove, LineMove, Motion, PoseMove
from armdrive.status import pose_numbers
from kinematics.spaces import POSE_FIELDS, Joints, Pose
from kinematics.text import shown_name, tenths
from tui.settings import MoveSettings, neighbour
from tui.widgets import UNKNOWN, TypedText

# By how much the arrows change a field, in degrees or mm.
STEPS = (0.1, 1.0, 5.0, 10.0, 50.0)

# The characters of a field, never a space.
DIGITS = frozenset("0123456789.-")

# Characters in a field: -1234.567 is more than any arm needs.
LONGEST = 9

# Returns where the arm is, field by field of the present mode and frame.
Present = Callable[[], Mapping[str, float]]


class GoalForm:
    """The fields of both modes, and which of them is typed into.

    The first key that is typed into a field replaces what stood in it when it was chosen, or what
    was filled in from elsewhere, which has all its digits.
    """

    def __init__(
        self,
        joints: tuple[str, ...],
        frames: tuple[str, ...],
        settings: MoveSettings,
        present: Present,
        *,
        has_yaw: bool = False,
    ) -> None:
        """`settings` are changed along with the form."""
        self.settings = settings
        self.frame = BASE_FRAME
        self.step = 1.0
        self.at = 0
        self._joints = joints
        self._axes = tuple(POSE_FIELDS)[: None if has_yaw else -1]
        self._frames = frames
        self._present = present
        self._fields: dict[str, TypedText] = {}

    @property
    def cartesian(self) -> bool:
        """Whether the goal is a pose; else it is joint angles."""
        return self.settings.cartesian

    @property
    def names(self) -> tuple[str, ...]:
        """The fields of the present mode."""
        return self._axes if self.cartesian else self._joints

    @property
    def name(self) -> str:
        """The field that is typed into."""
        return self.names[self.at]

    def field(self, name: str) -> TypedText:
        """Return what stands in a field of the present mode."""
        if name not in self._fields:
            self._fields[name] = TypedText(takes=DIGITS.__contains__, longest=LONGEST)
        return self._fields[name]

    def shown(self, name: str) -> str:
        """Return a field as people see it: what was filled in has too many digits for them."""
        text = self.field(name).text
        return text if len(text) <= LONGEST else f"{float(text):.2f}"

    def unit(self, name: str) -> str:
        """Return the unit of a field."""
        return "mm" if self.cartesian and POSE_FIELDS[name].endswith("_mm") else "°"

    # -- keys ---------------------------------------------------------------------------------

    def move_to_field(self, by: int) -> None:
        """Go to another field; what stands in it is replaced by what is typed next."""
        self.at = (self.at + by) % len(self.names)
        field = self.field(self.name)
        field.offered = bool(field.text)

    def clear(self) -> None:
        """Empty every field: the arm would stay where it is."""
        self._fields.clear()

    def change_value(self, sign: int) -> None:
        """Change the field by a step, from what stands in it or from where the arm is."""
        try:
            value = self._value(self.name)
        except ValueError:
            value = None
        start = self._present().get(self.name) if value is None else value
        if start is not None:
            self._fill({self.name: round(start + sign * self.step, 4)})

    def change_step(self, by: int) -> None:
        """Make the arrows' step smaller or larger."""
        self.step = neighbour(STEPS, self.step, by)

    def switch_mode(self) -> None:
        """Switch between joint angles and poses; the fields are empty then."""
        self._begin(cartesian=not self.cartesian)

    def switch_line(self) -> None:
        """Switch between a straight line and a joint motion."""
        if not self.cartesian:
            raise BadRequest("a straight line leads to a pose: switch the mode first")
        self.settings.switch_line()

    def next_frame(self) -> None:
        """Mean the pose in the next frame; what was typed was meant in the last one."""
        if not self.cartesian:
            raise BadRequest("joint angles have no frame: switch the mode first")
        self.frame = self._frames[(self._frames.index(self.frame) + 1) % len(self._frames)]
        self.clear()

    # -- goals from elsewhere -----------------------------------------------------------------

    def take_joints(self, joints: Joints) -> None:
        """Ask for these joints, with all their digits."""
        self._begin(cartesian=False)
        self._fill(joints.deg)

    def take_pose(self, pose: Pose) -> None:
        """Ask for this pose of the base, with all its digits."""
        self._begin(cartesian=True)
        self.frame = BASE_FRAME
        self._fill(of_pose(pose))

    def _begin(self, *, cartesian: bool) -> None:
        self.settings.cartesian = cartesian
        self.at = 0
        self.clear()

    def _fill(self, values: Mapping[str, float]) -> None:
        for name, value in values.items():
            field = self.field(name)
            field.text, field.offered = repr(value), True

    # -- what it means ------------------------------------------------------------------------

    def _value(self, name: str) -> float | None:
        """Return a field's number; None of an empty field. Raises `ValueError` without one."""
        text = self.field(name).text
        return float(text) if text else None

    def wrong(self) -> str:
        """Say which field holds no number; nothing where all do."""
        for name in self.names:
            try:
                value = self._value(name)
            except ValueError:
                return f"{name}: {self.field(name).text!r} is no number"
            if value is not None and not math.isfinite(value):
                return f"{name} must be finite"
        return ""

    def goal(self) -> Motion | None:
        """Return the move; None where nothing is asked for, or not all of it is known.

        Fields that stay empty keep the arm's present coordinates.
        """
        if self.wrong():
            return None
        values = {name: self._value(name) for name in self.names}
        given = {name: value for name, value in values.items() if value is not None}
        if not given:
            return None
        speed = self.settings.speed
        if not self.cartesian:
            return JointMove({f"{name}_deg": value for name, value in given.items()}, speed)
        whole = {**self._present(), **given}
        if not set(self.names) <= set(whole):
            return None
        kind = LineMove if self.settings.line else PoseMove
        return kind(pose_of(whole), speed, self.frame)


def of_pose(pose: Pose) -> dict[str, float]:
    """Return the coordinates of a pose by field."""
    return {key.partition("_")[0]: value for key, value in pose_numbers(pose).items()}


def pose_of(values: Mapping[str, float]) -> Pose:
    """Return the pose of all fields."""
    return Pose.of(**{POSE_FIELDS[name]: value for name, value in values.items()})


def field_rows(form: GoalForm, present: Mapping[str, float]) -> list[str]:
    """Return a row for each field: its name, what is typed, its unit, and where the arm is."""
    rows = []
    for name in form.names:
        now = tenths(present[name]) if name in present else UNKNOWN
        text = form.shown(name) + "_" * (name == form.name)
        rows.append(f"{shown_name(name):<12}{text:>11} {form.unit(name):<3}{now:>9}")
    return rows


FIELDS_HEAD = f"{'goal':>25}{'now':>13}"
