"""A chain's forward kinematics and Jacobian on plain floats, for searches and plans.

T = C0 M1 C1 M2 ... Mn Cn: constant frames, and between them each joint's turn about z or move
along it. A frame takes some microseconds; `Chain.fk`, which checks its arguments and multiplies
out all A matrices, takes several times as long. Values are floats in rad and mm, not checked.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from kinematics.chains.chain import Chain
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError
from kinematics.frames.transforms import LAST_ROW, Transform, compose, position_of, z_axis_of
from kinematics.frames.vectors import cross, subtract
from kinematics.spaces import Jacobian


@dataclass(frozen=True, slots=True)
class Evaluator:
    """The constant frames of a chain, and which of its joints slide."""

    constants: tuple[Transform, ...]
    slides: tuple[bool, ...]

    def frames(self, values: Sequence[float]) -> list[Transform]:
        """Return the frame of each joint, whose z is the joint's axis, then the tool's."""
        frame = self.constants[0]
        found = [frame]
        for value, slides, constant in zip(values, self.slides, self.constants[1:], strict=True):
            (a, b, c, x), (d, e, f, y), (g, h, i, z), _ = frame
            if slides:
                x, y, z = x + value * c, y + value * f, z + value * i
            else:
                p, q = math.cos(value), math.sin(value)
                # a turn about z leaves the third column as it is
                a, b = a * p + b * q, b * p - a * q
                d, e = d * p + e * q, e * p - d * q
                g, h = g * p + h * q, h * p - g * q
            frame = compose(((a, b, c, x), (d, e, f, y), (g, h, i, z), LAST_ROW), constant)
            found.append(frame)
        return found

    def fk(self, values: Sequence[float]) -> Transform:
        """Return the tool's frame in the world."""
        return self.frames(values)[-1]

    def jacobian(self, values: Sequence[float]) -> Jacobian:
        """Return the geometric Jacobian (Whitney, 1972; Craig, chapter 5)."""
        return self.fk_and_jacobian(values)[1]

    def fk_and_jacobian(self, values: Sequence[float]) -> tuple[Transform, Jacobian]:
        """Return the tool's frame and the geometric Jacobian, both from one walk."""
        *before, tool = self.frames(values)
        tip = position_of(tool)
        columns = []
        for frame, slides in zip(before, self.slides, strict=True):
            axis = z_axis_of(frame)
            if slides:
                columns.append((*axis, 0.0, 0.0, 0.0))
            else:
                columns.append((*cross(axis, subtract(tip, position_of(frame))), *axis))
        return tool, tuple(zip(*columns, strict=True))


@lru_cache(maxsize=64)
def evaluator(chain: Chain) -> Evaluator:
    """Return the evaluator of a chain; keep it, since looking it up takes as long as using it.

    Raises `KinematicsError` for a chain with parameters that are not plain numbers.
    """
    if not chain.is_plain:
        raise KinematicsError("only a chain of plain numbers can be evaluated, not one of symbols")
    return Evaluator(chain.constants, tuple(kind is JointKind.PRISMATIC for kind in chain.kinds))
