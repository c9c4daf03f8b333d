"""What solving a rotation for angles, axis or quaternion gives: both answers, and degeneracy."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar

from kinematics.rotation_check import ROTATION_TOLERANCE

DEGENERATE_RAD = ROTATION_TOLERANCE
"""Within this angle of a degenerate orientation the entries of a matrix tell only its noise."""


class Degeneracy(Enum):
    """Orientations at which a representation is not unique, and what remains determined."""

    X_AXIS_DOWN = "theta is 90°, the turned x axis points at -z: only phi - psi is determined"
    X_AXIS_UP = "theta is -90°, the turned x axis points at +z: only phi + psi is determined"
    NO_TILT = "theta is 0°, the z axes agree: only phi + psi is determined"
    FULL_TILT = "theta is 180°, the z axes oppose: only phi - psi is determined"
    NO_TURN = "the angle is 0°: every axis does"
    HALF_TURN = "the angle is 180°: an axis and its opposite are the same turn"


Representation = TypeVar("Representation")


@dataclass(frozen=True, slots=True)
class OrientationSolution(Generic[Representation]):
    """The answers to one rotation.

    `first` is in the usual range that its maker states, `second` the other one that makes the
    same matrix, None where there are endlessly many. `degeneracy` is None where the answers are
    all there are; else `first` holds what was asked to be held, and the answer stands for a
    family.
    """

    first: Representation
    second: Representation | None
    degeneracy: Degeneracy | None
