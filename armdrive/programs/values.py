"""What a program computes with: numbers, truth, texts and places; and how they are written down."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from kinematics import Pose

ForwardKinematics: TypeAlias = Callable[[Mapping[str, float]], Pose]
"""Joint angles of all joints (deg, by name) to the pose that the arm has there."""


class Trouble(Exception):
    """What a line cannot be carried out for; the machine adds where it stands."""


@dataclass(frozen=True, slots=True)
class Place:
    """A place: joint angles (deg, by name), a pose, or both of the same place.

    Where both are known, the arm goes to the joint angles: they say which elbow was meant.
    """

    pose: Pose | None = None
    joints_deg: Mapping[str, float] | None = None
    opening_mm: float | None = None

    @property
    def goal(self) -> Pose | Mapping[str, float]:
        """What an act goes to."""
        found = self.pose if self.joints_deg is None else self.joints_deg
        if found is None:
            raise Trouble("this place is nowhere")
        return found

    def __str__(self) -> str:
        if self.pose is not None:
            return str(self.pose)
        return ", ".join(
            f"{name} {said(angle)}°" for name, angle in (self.joints_deg or {}).items()
        )


Value: TypeAlias = float | bool | str | Place


def pose_of(place: Place, fk: ForwardKinematics | None) -> Pose:
    """Return the pose of a place. Raises `Trouble` where nobody can say it."""
    if place.pose is not None:
        return place.pose
    if fk is None or place.joints_deg is None:
        raise Trouble("a place in joint angles has no x, y and z without an arm")
    return fk(place.joints_deg)


def said(value: Value) -> str:
    """Return a value as people are told it: numbers to three decimals at most."""
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, float):
        return f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".")
    return str(value)


def number(value: object) -> float:
    """Return a number; `Trouble` for what is none, or too large for one."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise Trouble(f"a number is needed, not {value}")
    if not math.isfinite(value):
        raise Trouble("this comes to no number: it is too large")
    return float(value)


def truth(value: object) -> bool:
    """Return on or off; `Trouble` for anything else."""
    if not isinstance(value, bool):
        raise Trouble(f"on or off is needed, not {value}")
    return value


def place(value: object) -> Place:
    """Return a place; `Trouble` for anything else."""
    if not isinstance(value, Place):
        raise Trouble(f"a place is needed, not {value}")
    return value


def to_json(value: Value) -> object:
    """Return a value as plain JSON data."""
    if not isinstance(value, Place):
        return value
    pose = value.pose
    return {
        "pose": None
        if pose is None
        else [pose.x_mm, pose.y_mm, pose.z_mm, pose.pitch_rad, pose.roll_rad, pose.yaw_rad],
        "joints_deg": None if value.joints_deg is None else dict(value.joints_deg),
        "opening_mm": value.opening_mm,
    }


def from_json(data: object) -> Value:
    """Return a value from plain JSON data; raises `ValueError`, `TypeError` or `KeyError`."""
    if isinstance(data, bool | str):
        return data
    if isinstance(data, int | float):
        return float(data)
    if not isinstance(data, dict):
        raise TypeError(f"{data!r} is no value of a program")
    pose, joints, opening = data["pose"], data["joints_deg"], data["opening_mm"]
    return Place(
        None if pose is None else Pose(*pose),
        None if joints is None else {str(name): float(angle) for name, angle in joints.items()},
        None if opening is None else float(opening),
    )
