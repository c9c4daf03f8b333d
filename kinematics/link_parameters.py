"""From a frame in another frame back to the four link parameters, where there are such.

Source: McKerrow, chapter 4, section 6, solved for its parameters; Craig, chapter 3. Four numbers
cannot say where any frame is: frames that were not assigned by the rules are refused.
"""

from __future__ import annotations

import math

from kinematics.errors import KinematicsError
from kinematics.frames import Transform, position_of
from kinematics.links import Convention, a_matrix
from kinematics.vectors import distance

CLEAN_MM = 1e-9
"""A length this near to zero is zero: rounding of the axes' geometry."""

CLEAN_RAD = 1e-9
"""An angle this near to a whole number of quarter turns is one."""

MISFIT = 1e-6
"""How far (mm, and of the entries of the rotation) the parameters may miss the frame."""

_QUARTER = math.pi / 2


def link_parameters(
    frame: Transform, convention: Convention = Convention.STANDARD
) -> tuple[float, float, float, float] | None:
    """Return theta, d, a and alpha of a frame in the one before it; None if it has none."""
    (xx, xy, _, px), (yx, _, yz, py), (_, zy, zz, pz), _ = frame
    if convention is Convention.STANDARD:
        theta, alpha = math.atan2(yx, xx), math.atan2(zy, zz)
        length, along = px * math.cos(theta) + py * math.sin(theta), pz
    else:
        theta, alpha = math.atan2(-xy, xx), math.atan2(-yz, zz)
        length, along = px, pz * math.cos(alpha) - py * math.sin(alpha)
    found = _angle(theta), _length(along), _length(length), _angle(alpha)
    again = a_matrix(*found, convention)
    off = max(abs(again[i][j] - frame[i][j]) for i in range(3) for j in range(3))
    if off > MISFIT or distance(position_of(again), position_of(frame)) > MISFIT:
        return None
    return found


def assigned_parameters(
    number: int, frame: Transform, convention: Convention
) -> tuple[float, float, float, float]:
    """Return the parameters of link `number`, or raise `KinematicsError`, which names it."""
    found = link_parameters(frame, convention)
    if found is None:
        raise KinematicsError(
            f"link {number}: no four parameters of the {convention.value} convention lead to its "
            "frame; its axes are too nearly parallel to tell how they lie"
        )
    return found


def _length(value: float) -> float:
    return 0.0 if abs(value) < CLEAN_MM else value


def _angle(value: float) -> float:
    quarters = round(value / _QUARTER)
    if abs(value - quarters * _QUARTER) >= CLEAN_RAD:
        return value
    return math.pi if quarters == -2 else quarters * _QUARTER
