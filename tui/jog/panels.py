"""The panels of the jog screen that show axes: the tip, the joints, the gripper."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from textual.app import ComposeResult

from armdrive.errors import ArmError
from armdrive.motion.frames import BASE, TOOL
from armdrive.status import Status
from kinematics.spaces import Pose
from tui.axes import AxisRow, AxisTable
from tui.gamepad.jogging import PAD
from tui.jog.jogging import DeskJogging
from tui.jog.rows import Limits, Lit, grip_line, gripper_row, joint_rows, tip_limits, tip_rows
from tui.keys.table import JogPair, words
from tui.screens import ScreenHost
from tui.settings import JogSettings

PoseLimits: TypeAlias = Sequence[Limits | None]


class AxisPanels:
    """Shows every axis with its value, limits and key caps; pressing a key cap jogs."""

    def __init__(self, desk: ScreenHost, hand: DeskJogging) -> None:
        self._desk = desk
        self._hand = hand
        self._lit = Lit(desk.clock)
        self._limits = tip_limits(desk.arm.model)
        self._tip, self._joints, self._gripper = (
            AxisTable(self._push, hand.moved, hand.lift, cap=desk.keys.jog, id=name)
            for name in ("tip", "joints", "gripper")
        )

    def compose(self) -> ComposeResult:
        """Lay the panels out."""
        yield from (self._tip, self._joints, self._gripper)

    def show(self, status: Status) -> tuple[AxisRow, ...]:
        """Show a status; return the rows of the joints."""
        settings, model = self._desk.settings, self._desk.arm.model
        held = self._hand.held_button not in ("", PAD)
        pose, limits = self._pose(status)
        joints = joint_rows(status, model, settings, self._lit)
        self._tip.show_axes(tip_rows(pose, limits, settings, self._lit), held=held)
        self._joints.show_axes(joints, held=held)
        force_n = self._desk.arm.gripper.force_n
        self._gripper.show_axes(
            (gripper_row(status, model, settings, self._lit),),
            grip_line(status.gripping, force_n),
            held=held,
        )
        self._name(settings)
        return joints

    def _name(self, settings: JogSettings) -> None:
        """Say in the panels' titles which of them the keys move, and in which frame."""
        keys = self._desk.keys
        mode = keys.label("mode")
        frame = "" if settings.frame == BASE else f" of {settings.frame}"
        titles = {self._tip: f"Tip, Cartesian{frame}", self._joints: "Joints"}
        driven = self._tip if settings.cartesian else self._joints
        for panel, title in titles.items():
            name = panel.id or ""
            if panel is driven:
                panel.set_titles(title, _arrows(settings))
            else:
                panel.set_titles(name.capitalize(), f"{mode}: keys move the {name}")
            panel.set_class(panel is driven, "-driven")
        presets = (f"{keys.label(f'grip-{word}')} {word}" for word in ("open", "half", "closed"))
        self._gripper.set_titles("Gripper", "  ".join((*presets, f"{keys.label('grasp')} grasp")))

    def _pose(self, status: Status) -> tuple[Pose | None, PoseLimits]:
        """Return the pose in the frame that is jogged in, and its limits where that is the base.

        A jog in the tool's frame is shown in the base's, since the tool is always at its own zero.
        """
        settings, limits = self._desk.settings, self._limits
        if status.pose is None or not settings.cartesian or settings.frame in (BASE, TOOL):
            return status.pose, limits
        try:
            return self._desk.arm.pose_in(settings.frame), (None,) * len(limits)
        except ArmError:
            return None, limits  # it has become unknown since the status was taken

    def _push(self, pair: JogPair, plus: bool) -> None:
        """Hold the key cap of an axis."""
        if not self._desk.link.says_lost():
            self._hand.push(pair.plus if plus else pair.minus)


def _arrows(settings: JogSettings) -> str:
    """Say what the arrow keys move."""
    axes = {
        pair.plus: words(pair.axis(cartesian=settings.cartesian))
        for pair in settings.pairs
        if len(pair.plus) > 1
    }
    return f"arrows: {axes['left']}, {axes['up']}"
