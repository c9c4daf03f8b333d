"""What the five two-link manipulators of the notes share: three solutions and a workspace.

Source: McKerrow, chapter 4, sections 5 to 9. `by_trigonometry` writes the tip's coordinates down
(section 5), `by_matrices` multiplies the A matrices as the notes print them (sections 6 and 7),
`by_vectors` adds the two link vectors after turning the second into the base frame (section 9).
All three run on numbers of any kind. Lengths in mm, angles in rad.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

from kinematics.frames import LAST_ROW, Transform, compose
from kinematics.numbers import cos, sin
from kinematics.systems.named_system import REACH_MM, System
from kinematics.vectors import Vector

Span = tuple[float, float]
"""Lowest and highest value of a prismatic joint, in mm."""


@dataclass(frozen=True, slots=True)
class Workspace:
    """Where a tip can be put: the shape, a sentence with its measures, and a test of goals."""

    shape: str
    sentence: str
    holds: Callable[[tuple[float, ...]], bool]


class TwoLink(System):
    """A manipulator of two links, its tip described in three ways."""

    __slots__ = ()

    @abstractmethod
    def by_trigonometry(self, first: float, second: float) -> Vector:
        """Return the tip (x, y, z) in mm from its coordinates written down."""

    @abstractmethod
    def a_matrices(self, first: float, second: float) -> tuple[Transform, Transform]:
        """Return the two A matrices as the notes print them."""

    @abstractmethod
    def by_vectors(self, first: float, second: float) -> Vector:
        """Return the tip as p01 + Rot1 p12, both vectors in the base frame."""

    @abstractmethod
    def orientation(self, first: float, second: float) -> Vector:
        """Return phi, theta, psi of RPY = Rot(z, phi) Rot(y, theta) Rot(x, psi) (section 8)."""

    @abstractmethod
    def workspace(self) -> Workspace:
        """Return where the tip can be put (the figures c), joint ranges included."""

    def by_matrices(self, first: float, second: float) -> Transform:
        """Return the hand's frame as the product of the A matrices."""
        return compose(*self.a_matrices(first, second))


def turned_link(theta: float, length: float) -> Transform:
    """Return the A matrix of a revolute joint whose link has a length and no twist."""
    c, s = cos(theta), sin(theta)
    return (c, -s, 0.0, length * c), (s, c, 0.0, length * s), (0.0, 0.0, 1.0, 0.0), LAST_ROW


def turned_column(theta: float, height: float) -> Transform:
    """Return the A matrix of a revolute joint with a distance and a twist of 90 degrees."""
    c, s = cos(theta), sin(theta)
    return (c, 0.0, s, 0.0), (s, 0.0, -c, 0.0), (0.0, 1.0, 0.0, height), LAST_ROW


def raised_column(height: float) -> Transform:
    """Return the A matrix of a prismatic joint with a twist of 90 degrees."""
    return (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, height), LAST_ROW


def within(value: float, span: Span) -> bool:
    """Return whether a length lies in a span, rounding allowed."""
    return span[0] - REACH_MM <= value <= span[1] + REACH_MM
