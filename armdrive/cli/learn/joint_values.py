"""Joint values and what they lead to: how many are typed, solutions in a table, a frame as data."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from armdrive.cli.presenter import Ink, Inked, Line
from armdrive.errors import BadRequest
from kinematics.frames.orientations import solve_rpy
from kinematics.frames.transforms import Transform, position_of, rotation_of
from kinematics.text import counted, shown_name


def require_values(joint_names: Sequence[str], typed: Sequence[object]) -> None:
    """Raise `BadRequest` unless there is a value for each joint."""
    if len(typed) != len(joint_names):
        raise BadRequest(
            f"{counted(len(joint_names), 'joint value is', 'joint values are')} required "
            f"({', '.join(map(shown_name, joint_names))}), not {len(typed)}"
        )


@dataclass(frozen=True, slots=True)
class BranchRow:
    """A solution: its name, the joint values with their units, and the limits that it violates."""

    name: str
    values: tuple[str, ...]
    violations: tuple[str, ...]


def branch_table(joint_names: Sequence[str], rows: Sequence[BranchRow]) -> Iterator[Line]:
    """Yield the heading and the rows; a solution that violates a limit is faint and says which."""
    if not rows:
        return
    names = [shown_name(name) for name in joint_names]
    columns = zip(*(row.values for row in rows), strict=True)
    widths = [
        max(len(name), len("-180.0°"), *map(len, values)) + 2
        for name, values in zip(names, columns, strict=True)
    ]
    first = max(len(row.name) for row in rows) + 2
    yield f"  {'':<{first}}{''.join(f'{n:>{w}}' for n, w in zip(names, widths, strict=True))}"
    for row in rows:
        values = "".join(f"{v:>{w}}" for v, w in zip(row.values, widths, strict=True))
        text = f"  {row.name:<{first}}{values}"
        against = "; ".join(row.violations)
        yield (Inked(f"{text}   {against}", Ink.FAINT),) if against else text


def frame_view(frame: Transform) -> dict[str, Any]:
    """Return the hand's frame as plain data: the matrix, and what it says in mm and degrees."""
    angles = solve_rpy(rotation_of(frame)).first
    turned = (angles.phi_rad, angles.theta_rad, angles.psi_rad)
    return {
        "frame": [list(row) for row in frame],
        "position_mm": list(position_of(frame)),
        "rpy_deg": [math.degrees(angle) for angle in turned],
    }
