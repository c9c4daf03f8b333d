"""The parts of a route laid end to end, each from stop to stop: its curve and its chords.

Units: mm and rad.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from kinematics.arcs import Arc, arc_between, beginning
from kinematics.arm_geometry import ArmGeometry, Follower, Hand, Point
from kinematics.chords import Chord, cut
from kinematics.curves import JointCurve, Line, straight_between
from kinematics.errors import KinematicsError, NoArc, PathBroken, Unreachable
from kinematics.moves import ArcMove, JointMove, LineMove, Move, PoseMove
from kinematics.spaces import Joints


class Laid(NamedTuple):
    """A part of a route: its number, from 1, and the chords of the whole of its curve."""

    number: int
    move: Move
    chords: list[Chord]


class _Hold(NamedTuple):
    """How the tip and the hand stand, and what keeps the posture, between lines and arcs."""

    follower: Follower
    tip: Point
    hand: Hand


def lay(arm: ArmGeometry, start: Joints, moves: Sequence[Move], tolerance_mm: float) -> list[Laid]:
    """Return the parts of a route. Raises `PathBroken` and `NoArc` that name the part."""
    layer = _Layer(arm, tolerance_mm, start)
    found = []
    for number, move in enumerate(moves, 1):
        try:
            found.append(Laid(number, move, layer.chords(number, move)))
        except (PathBroken, NoArc) as broken:
            raise broken.of_part(number) from broken.__cause__
    return found


class _Layer:
    """Where the route has come to, and the posture in which its lines and arcs are followed."""

    def __init__(self, arm: ArmGeometry, tolerance_mm: float, start: Joints) -> None:
        self._arm = arm
        self._tolerance_mm = tolerance_mm
        self._here = start
        self._hold: _Hold | None = None
        self._posture: tuple[str, int] | None = None

    def chords(self, number: int, move: Move) -> list[Chord]:
        """Return the chords of the next part."""
        if isinstance(move, JointMove | PoseMove):
            found = self._turn(self._goal(move))
            self._hold = None
        else:
            hold = self._hold or self._begin(number, move)
            curve = _curve(hold, move)
            found = cut(self._arm, curve, self._here, self._tolerance_mm)
            self._hold = _Hold(hold.follower, curve.trace.end, curve.hands[-1])
        self._here = found[-1].end
        return found

    def _turn(self, goal: Joints) -> list[Chord]:
        if len(goal) != len(self._here):
            raise KinematicsError(
                f"this arm has {len(self._here)} joints, not the {len(goal)} of a joint motion"
            )
        curve = JointCurve(self._arm, (self._here, goal))
        return cut(self._arm, curve, self._here, self._tolerance_mm)

    def _goal(self, move: JointMove | PoseMove) -> Joints:
        if isinstance(move, JointMove):
            return move.goal
        try:
            return self._arm.ik(move.goal, self._here)
        except Unreachable as refusal:
            reason = f"{refusal.reason}; nearest pose that can be reached: {refusal.nearest}"
            raise PathBroken(1.0, move.goal, reason, shape="joint motion") from refusal

    def _begin(self, number: int, move: LineMove | ArcMove) -> _Hold:
        """Take up the posture of the arm; the first one is that of the whole route."""
        follower, tip = beginning(self._arm, self._here)
        posture, part = self._posture = self._posture or (follower.posture, number)
        if follower.posture != posture:
            reason = (
                f"the arm would stand in another posture ({follower.posture}) than in part "
                f"{part} ({posture})"
            )
            shape = "arc" if isinstance(move, ArcMove) else "straight line"
            raise PathBroken(0.0, self._arm.fk(self._here), reason, shape=shape)
        return _Hold(follower, tip, follower.first)


def _curve(hold: _Hold, move: LineMove | ArcMove) -> Line | Arc:
    follower, tip, hand = hold
    if isinstance(move, ArcMove):
        return arc_between(follower, tip, hand, move.via, move.goal, move.sweep_rad)
    return straight_between(follower, tip, hand, move.goal)
