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
from kinematics.frames.rotations import Matrix3, multiply, rotate
from kinematics.frames.transforms import Transform, homogeneous, position_of, rotation_of
from kinematics.frames.vectors import Vector, add, cross, scale, subtract
from kinematics.spaces import Jacobian

# A rotation and a position: a frame without its last row.
Placed = tuple[Matrix3, Vector]


@dataclass(frozen=True, slots=True)
class Evaluator:
    """The constant frames of a chain, and which of its joints slide."""

    constants: tuple[Placed, ...]
    slides: tuple[bool, ...]

    def fk(self, values: Sequence[float]) -> Transform:
        """Return the tool's frame in the world."""
        return homogeneous(*self._frames(values)[-1])

    def jacobian(self, values: Sequence[float]) -> Jacobian:
        """Return the geometric Jacobian (Whitney, 1972; Craig, chapter 5)."""
        return self.fk_and_jacobian(values)[1]

    def fk_and_jacobian(self, values: Sequence[float]) -> tuple[Transform, Jacobian]:
        """Return the tool's frame and the geometric Jacobian, both from one walk."""
        *before, (rotation, tip) = self._frames(values)
        columns = []
        for (axes, origin), slides in zip(before, self.slides, strict=True):
            axis = axes[0][2], axes[1][2], axes[2][2]
            if slides:
                columns.append((*axis, 0.0, 0.0, 0.0))
            else:
                columns.append((*cross(axis, subtract(tip, origin)), *axis))
        return homogeneous(rotation, tip), tuple(zip(*columns, strict=True))

    def _frames(self, values: Sequence[float]) -> list[Placed]:
        """Return the frame of each joint, whose z is the joint's axis, then the tool's."""
        rotation, origin = self.constants[0]
        found = [(rotation, origin)]
        for value, slides, (turn, way) in zip(values, self.slides, self.constants[1:], strict=True):
            (a, b, c), (d, e, f), (g, h, i) = rotation
            if slides:
                origin = add(origin, scale(value, (c, f, i)))
            else:
                p, q = math.cos(value), math.sin(value)
                rotation = (  # a turn about z leaves the third column as it is
                    (a * p + b * q, b * p - a * q, c),
                    (d * p + e * q, e * p - d * q, f),
                    (g * p + h * q, h * p - g * q, i),
                )
            origin = add(origin, rotate(rotation, way))
            rotation = multiply(rotation, turn)
            found.append((rotation, origin))
        return found


@lru_cache(maxsize=64)
def evaluator(chain: Chain) -> Evaluator:
    """Return the evaluator of a chain; keep it, since looking it up takes as long as using it.

    Raises `KinematicsError` for a chain with parameters that are not plain numbers.
    """
    if not chain.is_plain:
        raise KinematicsError("only a chain of plain numbers can be evaluated, not one of symbols")
    constants = tuple((rotation_of(one), position_of(one)) for one in chain.constants)
    return Evaluator(constants, tuple(kind is JointKind.PRISMATIC for kind in chain.kinds))
