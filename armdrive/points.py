"""Named points of an arm, and sequences over them: values, checked when they are made.

A point is a posture: joint angles, which stay what they are whatever tool or frame is meant, and
the opening of the fingers. Units: rad, mm, s.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from types import MappingProxyType

from armdrive.errors import BadRequest
from kinematics import Joints
from kinematics.errors import finite

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,39}")
"""What points and sequences may be called: one word, as in programs."""

WAYS = ("joint", "line")
"""How a step leads to its point."""

GRIPPER_WORDS = ("open", "close", "grasp", "point")
"""What a step may have the fingers do besides an opening in mm: `point` is the point's opening."""

LONGEST_WAIT_S = 3600.0


@dataclass(frozen=True, slots=True)
class Point:
    """One posture worth coming back to. `opening_mm` is None where nobody knew the fingers."""

    joints: Joints
    opening_mm: float | None = None
    note: str = ""
    taught: datetime | None = None

    def __post_init__(self) -> None:
        if self.opening_mm is not None:
            object.__setattr__(self, "opening_mm", finite("gripper_mm", self.opening_mm))


@dataclass(frozen=True, slots=True)
class Step:
    """One step of a sequence: to a point, or the fingers, or a wait; exactly one of them.

    `gripper` is one of `GRIPPER_WORDS` or an opening in mm, `how` one of `WAYS`, `speed` a fraction
    of the limits. Raises `BadRequest`.
    """

    point: str = ""
    how: str = "joint"
    speed: float = 1.0
    gripper: str | float | None = None
    wait_s: float | None = None

    def __post_init__(self) -> None:
        said = [bool(self.point), self.gripper is not None, self.wait_s is not None]
        if sum(said) != 1:
            raise BadRequest("a step is one of point, gripper and wait_s, and no two of them")
        if not self.point and self.how != WAYS[0]:
            raise BadRequest("how belongs to a step that leads to a point")
        if self.how not in WAYS:
            raise BadRequest(f"how is one of {', '.join(WAYS)}, not {self.how!r}")
        if not 0.0 < finite("speed", self.speed) <= 1.0:
            raise BadRequest(f"speed is above 0 and up to 1, not {self.speed:g}")
        if isinstance(self.gripper, str):
            if self.gripper not in GRIPPER_WORDS:
                raise BadRequest(
                    f"gripper is one of {', '.join(GRIPPER_WORDS)}, or mm, not {self.gripper!r}"
                )
        elif self.gripper is not None:
            finite("gripper", self.gripper)
        if self.wait_s is not None and not 0.0 <= finite("wait_s", self.wait_s) <= LONGEST_WAIT_S:
            raise BadRequest(f"wait_s is from 0 to {LONGEST_WAIT_S:g} s, not {self.wait_s:g}")

    def __str__(self) -> str:
        slowly = f" at {self.speed:.0%}" if self.speed < 1.0 else ""
        if self.point:
            return f"to {self.point}{' along a line' * (self.how == 'line')}{slowly}"
        if self.gripper is not None:
            what = self.gripper if isinstance(self.gripper, str) else f"{self.gripper:g} mm"
            return f"gripper {what}{slowly}"
        return f"wait {self.wait_s:g} s"


@dataclass(frozen=True, slots=True)
class StepList:
    """A named list of steps."""

    steps: tuple[Step, ...] = ()
    note: str = ""

    @property
    def points(self) -> tuple[str, ...]:
        """The points that it goes to, in its order."""
        return tuple(step.point for step in self.steps if step.point)


@dataclass(frozen=True, slots=True)
class Taught:
    """All that a file of points holds. Raises `BadRequest` for a step to a point there is not."""

    points: Mapping[str, Point] = field(default_factory=dict)
    sequences: Mapping[str, StepList] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in (*self.points, *self.sequences):
            check_name(name)
        for name, each in self.sequences.items():
            for number, step in enumerate(each.steps, 1):
                if step.point and step.point not in self.points:
                    known = ", ".join(self.points) or "none"
                    raise BadRequest(
                        f"step {number} of sequence {name!r} goes to the point {step.point!r}, "
                        f"which there is not; known are {known}"
                    )
        object.__setattr__(self, "points", MappingProxyType(dict(self.points)))
        object.__setattr__(self, "sequences", MappingProxyType(dict(self.sequences)))

    def users(self, point: str) -> tuple[str, ...]:
        """Return the sequences that go to a point."""
        return tuple(name for name, each in self.sequences.items() if point in each.points)


def check_name(name: str) -> str:
    """Return a name that a point or a sequence may have; raises `BadRequest`."""
    if not NAME.fullmatch(name):
        raise BadRequest(
            f"{name!r} is no name: one word of letters, digits, - and _ that begins with a letter, "
            "of at most 40 characters"
        )
    return name
