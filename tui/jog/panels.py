"""The panels of the jog screen, made from a status: axes, what is near, and details."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from textual.app import ComposeResult

from armdrive import Grasped
from armdrive.errors import ArmError
from armdrive.moves import BASE_FRAME, TOOL_FRAME
from armdrive.registry import DIALECTS
from armdrive.status import State, Status, Trust, pose_numbers
from kinematics.guards.path import least_clearances
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose
from kinematics.text import deg_text, mm_text, shown_name
from tui.axes import DEGREE, AxisRow, AxisTable
from tui.desk import Desk
from tui.jog.jogging import DeskJogging
from tui.keys.table import MM_AXES, Needs
from tui.safety import bound_text, without_link
from tui.settings import JogSettings
from tui.widgets import UNKNOWN, Span

# A guard is marked as near from here on.
NEAR_MM = 40.0

# Parts of the base's turn in which its farthest points are looked for: a bar shows no less.
TURNS = 72

Limits = tuple[float, float]


def limits_hold(status: Status) -> bool:
    """Return whether jogs end at limits and guards, and the keys can move the tip."""
    return status.trust is Trust.REFERENCED


def joint_rows(status: Status, model: ArmModel, settings: JogSettings) -> tuple[AxisRow, ...]:
    """Return a row for each joint, with its keys where they move joints."""
    angles = status.joints or (None,) * len(model.arm.limits)
    rows = zip(settings.rows[:-1], angles, model.arm.limits, strict=True)
    return tuple(
        AxisRow(
            pair.joint,
            None if angle is None else math.degrees(angle),
            DEGREE,
            (math.degrees(limit.low_rad), math.degrees(limit.high_rad)),
            None if settings.cartesian else pair,
        )
        for pair, angle, limit in rows
    )


def tip_rows(
    pose: Pose | None, limits: Sequence[Limits | None], settings: JogSettings, *, driven: bool
) -> tuple[AxisRow, ...]:
    """Return a row for each coordinate of the tip, with its keys if it is `driven` by any."""
    values = (None,) * len(limits) if pose is None else tuple(pose_numbers(pose).values())
    return tuple(
        AxisRow(
            pair.cartesian,
            value,
            "mm" if pair.cartesian in MM_AXES else DEGREE,
            limit,
            pair if driven else None,
        )
        for pair, value, limit in zip(settings.rows[:-1], values, limits, strict=False)
    )


def tip_limits(model: ArmModel) -> tuple[Limits, ...]:
    """Return how far each coordinate of the tip in the base's frame can go at most.

    The arm stretched out, as far as its base turns; the table below, where a guard keeps it clear.
    """
    arm = model.arm
    middle = tuple((limit.low_rad + limit.high_rad) / 2 for limit in arm.limits)
    points = arm.points(Joints(middle, arm.joint_names))
    height_mm = points[1][2]
    length_mm = sum(math.dist(a, b) for a, b in pairwise(points[1:]))
    reach_mm = min(length_mm, model.guards.outer_radius_mm or length_mm)
    base = arm.limits[0]
    turn_rad = (base.high_rad - base.low_rad) / TURNS
    turns = [base.low_rad + turn_rad * at for at in range(TURNS + 1)]
    xs, ys = ([reach_mm * each(angle) for angle in turns] for each in (math.cos, math.sin))
    low_mm = 0.0 if model.guards.table else height_mm - length_mm
    turn = (-180.0, 180.0)
    return (
        (min(*xs, 0.0), max(xs)),
        (min(ys), max(ys)),
        (low_mm, height_mm + length_mm),
        turn,
        turn,
        *([turn] if arm.has_yaw else []),
    )


def near_lines(
    status: Status, model: ArmModel, joints: Sequence[AxisRow], quick_stop: str
) -> Iterator[Span]:
    """Say what a person would want to know before the next key, warnings first.

    Nothing ends a jog at a limit or a guard before the position is trusted.
    """
    if not limits_hold(status):
        if status.state is not State.DISCONNECTED:
            yield "NO LIMITS before it is referenced: watch the arm", "$text-warning"
    else:
        found = [*_near_limit(joints)]
        if status.joints is not None:
            found += _near_guards(status.joints, model)
        yield from sorted(found, key=lambda line: not line[1])
    if quick_stop and status.state is not State.DISCONNECTED:  # then the message says so
        yield quick_stop, "dim"


def _near_limit(joints: Sequence[AxisRow]) -> Iterator[Span]:
    nearest = min(joints, key=_margin_share, default=None)
    if nearest is not None and nearest.margin is not None:
        style = {"": "", "!": "$text-warning", "!!": "$text-error"}[nearest.sign]
        yield f"{shown_name(nearest.name)} {deg_text(nearest.margin)} from its limit", style


def _near_guards(joints: Joints, model: ArmModel) -> Iterator[Span]:
    """Yield how far the table is, and each other guard that some part of the arm is near to."""
    for each in least_clearances(model.guards.over(model.arm), [joints]):
        near = each.clearance_mm < NEAR_MM
        if near or each.guard == "table":
            said = f"{each.guard}: {round(each.clearance_mm)} mm ({each.quantity})"
            yield said, "$text-warning" if near else ""


def _margin_share(row: AxisRow) -> float:
    return math.inf if row.margin_share is None else row.margin_share


def can_grasp(dialect: str) -> bool:
    """Return whether this arm can close its fingers until a grip switch closes."""
    row = DIALECTS.get(dialect)
    return row is not None and row.abilities.grip_switch


def grip_line(gripping: bool | None, force_n: float) -> str:
    """Say how the grip switch stands and how hard the fingers press."""
    force = f"pressing {force_n:.1f} N" if force_n > 0.0 else ""
    switch = "" if gripping is None else f"grip switch {'CLOSED' if gripping else 'open'}"
    return "  ".join(filter(None, (switch, force)))


def detail_lines(status: Status) -> str:
    """Return what a technician asks for: why the position is trusted, motors, inputs, the wire."""
    row = DIALECTS.get(status.dialect)
    lines = (
        f"position {status.trust.value} {status.trust_age}: {status.trust_reason}",
        without_link(status),
        f"motors {status.current.value}  steps {_steps(status.acknowledged)}",
        _bits("inputs", status.inputs, 0 if row is None else row.abilities.inputs)
        + _bits("outputs", status.outputs, 0 if row is None else row.abilities.outputs),
        _if_silent(status),
        f"sent {status.last_sent or '-'}",
        f"answer {status.last_answer or '-'}",
    )
    return "\n".join(line.strip() for line in lines if line)


def _bits(name: str, value: int | None, lines: int) -> str:
    """Show digital lines, the lowest first: by its number where one is on, else by a dot."""
    if value is None or not lines:
        return ""
    shown = (str(n + 1) if value >> n & 1 else "." for n in range(lines))
    return f"{name} {' '.join(shown)}  "


def _if_silent(status: Status) -> str:
    """Say how far the tip goes if this program dies, where that is farther than after a stop."""
    if status.silent_time_s <= status.stop_time_s:
        return ""
    return f"if the link is lost {bound_text(status.silent_distance_mm, status.silent_time_s)}"


def _steps(steps: Sequence[int] | None) -> str:
    return UNKNOWN if steps is None else " ".join(map(str, steps))


def grasped(found: Grasped) -> str:
    """Say what the fingers found."""
    if not found.holding:
        return "the fingers closed on nothing"
    return f"grasped: {mm_text(found.width_mm)} wide, pressed with {found.force_n:.1f} N"


class AxisPanels:
    """Shows every axis with its value, limits and key caps; pressing a key cap jogs."""

    def __init__(self, desk: Desk, hand: DeskJogging) -> None:
        self._desk = desk
        self._hand = hand
        self._limits = tip_limits(desk.arm.model)
        self._tip, self._joints, self._gripper = (
            AxisTable(hand, self._push, cap=desk.keys.jog, id=name)
            for name in ("tip", "joints", "gripper")
        )

    def compose(self) -> ComposeResult:
        """Lay the panels out."""
        yield from (self._tip, self._joints, self._gripper)

    def show(self, status: Status) -> tuple[AxisRow, ...]:
        """Show a status; return the rows of the joints."""
        settings, model = self._desk.settings.jog, self._desk.arm.model
        pose, limits = self._pose(status)
        joints = joint_rows(status, model, settings)
        driven = settings.cartesian and pose is not None and limits_hold(status)
        tip = tip_rows(pose, limits, settings, driven=driven)
        self._tip.show_axes(tip)
        self._joints.show_axes(joints)
        fingers = AxisRow(
            "opening",
            status.gripper_mm,
            "mm",
            model.gripper_range_mm,
            settings.rows[-1],
            warns=False,
        )
        force_n = self._desk.arm.gripper.force_n
        self._gripper.show_axes((fingers,), grip_line(status.gripping, force_n))
        self._name(settings)
        return joints

    def show_only_driven(self, *, only: bool) -> None:
        """Hide the panel of the axes that no key moves in this mode, or show it again."""
        cartesian = self._desk.settings.jog.cartesian
        self._tip.display = cartesian or not only
        self._joints.display = not (cartesian and only)

    def _name(self, settings: JogSettings) -> None:
        """Say in the panels' titles which of them the keys move, and in which frame."""
        keys = self._desk.keys
        mode = keys.label("mode")
        titles = {self._tip: _tip_title(settings.frame), self._joints: "Joints"}
        driven = self._tip if settings.cartesian else self._joints
        for panel, title in titles.items():
            name = panel.id or ""
            if panel is driven:
                panel.set_titles(title, _arrows(settings))
            else:
                panel.set_titles(name.capitalize(), f"{mode}: keys move the {name}")
            panel.set_class(panel is driven, "-driven")
        presets = [f"{keys.label(f'grip-{word}')} {word}" for word in ("open", "half", "closed")]
        if can_grasp(self._desk.link.status.dialect):
            presets.append(f"{keys.label('grasp')} grasp")
        self._gripper.set_titles("Gripper", "  ".join(presets))

    def _pose(self, status: Status) -> tuple[Pose | None, Sequence[Limits | None]]:
        """Return the pose in the frame that is jogged in, and its limits where that is the base.

        A jog in the tool's frame is shown in the base's, since the tool is always at its own zero.
        """
        settings, limits = self._desk.settings.jog, self._limits
        if (
            status.pose is None
            or not settings.cartesian
            or settings.frame in (BASE_FRAME, TOOL_FRAME)
        ):
            return status.pose, limits
        try:
            return self._desk.arm.pose_in(settings.frame), (None,) * len(limits)
        except ArmError:
            return None, limits  # it has become unknown since the status was taken

    def _push(self, key: str) -> None:
        """Hold the key cap of a jog key."""
        with self._desk.calls.acting():
            self._desk.link.require(Needs.MOTORS)
            self._hand.push(key)


def _tip_title(frame: str) -> str:
    """Name the frame in which the keys move the tip, and the one of the numbers if it differs."""
    if frame == TOOL_FRAME:
        return "Tip: tool frame, shown in base"
    return "Tip, Cartesian" if frame == BASE_FRAME else f"Tip: {frame} frame"


def _arrows(settings: JogSettings) -> str:
    """Say what the arrow keys move."""
    axes = {
        pair.plus: shown_name(pair.axis(cartesian=settings.cartesian))
        for pair in settings.pairs
        if pair.is_arrow
    }
    return f"arrows: {axes['left']}, {axes['up']}"
