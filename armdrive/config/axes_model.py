"""A model file that gives joint axes instead of links: `[[axes]]` and `[tip]`.

Each axis is a point and a direction in the world while every joint is at zero; the tip is the
tool's point there. `assign_frames` finds the link table.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from armdrive.errors import ArmFileError
from armdrive.text.toml import TomlTable, setting
from kinematics.chains.assignment import JointAxis, ZeroPosition, tip_frame
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError
from kinematics.frames.transforms import Transform
from kinematics.frames.vectors import unit


@dataclass(frozen=True, slots=True)
class AxisRow:
    """One of [[axes]]: the axis of a joint, from the base on."""

    point_mm: tuple[float, float, float] = setting(means="any point of the axis, in the world")
    direction: tuple[float, float, float] = setting(
        means="along the axis, of any length; a joint turns right-handed"
    )
    joint: str = setting("", "the joint's name; by default joint_1, joint_2, ...")
    kind: str = setting("revolute", words=tuple(kind.value for kind in JointKind))
    low_deg: float | None = setting(None, "limit of the joint's value; without it, none")
    high_deg: float | None = None
    low_mm: float | None = setting(None, "the same of a prismatic joint")
    high_mm: float | None = None

    def axis(self, where: str, number: int) -> JointAxis:
        """Return the joint's axis. Raises `ArmFileError`, which names the row."""
        kind = JointKind(self.kind)
        turns = kind is JointKind.REVOLUTE
        own, other = ("deg", "mm") if turns else ("mm", "deg")
        for key in ("low", "high"):
            if getattr(self, f"{key}_{other}") is not None:
                raise ArmFileError(
                    f"{where}: a {self.kind} joint has {key}_{own}, not {key}_{other}"
                )
        low, high = (getattr(self, f"{key}_{own}") for key in ("low", "high"))
        low, high = -math.inf if low is None else low, math.inf if high is None else high
        if turns:
            low, high = math.radians(low), math.radians(high)
        name = self.joint or f"joint_{number}"
        with _at(f"{where}.direction"):
            direction = unit(self.direction)
        return JointAxis(self.point_mm, direction, kind, name, low, high)


@dataclass(frozen=True, slots=True)
class Tip:
    """The tool in the world: its point, and how its frame is turned."""

    point_mm: tuple[float, float, float] = setting(means="the tip of the tool, in the world")
    approach: tuple[float, float, float] | None = setting(
        None, "z of the tool; by default along the last axis"
    )
    normal: tuple[float, float, float] | None = setting(
        None, "x of the tool, at 90 degrees to the approach"
    )

    def frame(self, last: JointAxis) -> Transform:
        """Return the tool's frame in the world. Raises `ArmFileError`."""
        with _at("tip"):
            return tip_frame(last, self.point_mm, self.approach, self.normal)


def read_axes(table: TomlTable, most: int) -> ZeroPosition | None:
    """Return the arm that a model file describes by its axes, None if they cannot be read."""
    before = table.problems.count
    rows = table.rows("axes")
    if not rows and table.problems.count == before:
        table.problems.note("a model needs at least one axis, each written under [[axes]]")
    if len(rows) > most:
        table.problems.note(f"a model has at most {most} axes, not {len(rows)}")
        return None
    axes = [_axis(row, number) for number, row in enumerate(rows, 1)]
    if "tip" not in table.entries:
        table.problems.note("[tip] is missing: the point of the tool, point_mm = [x, y, z]")
    tip = table.table("tip").section(Tip)
    if table.problems.count > before or tip is None:
        return None
    found = tuple(axis for axis in axes if axis is not None)
    frame = table.problems.attempt(lambda: tip.frame(found[-1]), None)
    return None if frame is None else ZeroPosition(found, frame)


def _axis(row: TomlTable, number: int) -> JointAxis | None:
    read = row.section(AxisRow)
    if read is None:
        return None
    return row.problems.attempt(lambda: read.axis(row.where, number), None)


@contextmanager
def _at(where: str) -> Iterator[None]:
    """Say where in the file something is wrong that kinematics refuses."""
    try:
        yield
    except KinematicsError as error:
        raise ArmFileError(f"{where}: {error}") from None
