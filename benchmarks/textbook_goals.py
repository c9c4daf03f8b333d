"""Goals for solvers of the Mini-mover: in reach, out of it, off the manifold, on every singularity.

Frames in mm, in the axes of `kinematics.five_axis.closed_form`. The same goals in every run.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass

from kinematics import FiveAxisArm, Joints
from kinematics.frames.rotations import multiply, rot_y, rot_z
from kinematics.frames.transforms import Transform, position_of, rotation_of, transform

SEED = 1982
MARGIN_RAD = math.radians(2.0)


Angles = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class GoalSet:
    """Goals of one kind, and whether a posture of the arm holds each of them."""

    name: str
    frames: tuple[Transform, ...]
    held: bool


def postures(arm: FiveAxisArm, count: int, seed: int = SEED) -> list[Angles]:
    """Return postures within the limits."""
    chance = random.Random(seed)
    return [
        tuple(
            chance.uniform(one.low_rad + MARGIN_RAD, one.high_rad - MARGIN_RAD)
            for one in arm.limits
        )
        for _ in range(count)
    ]


def goal_sets(arm: FiveAxisArm, count: int = 60) -> tuple[GoalSet, ...]:
    """Return every kind of goal, `count` of each."""
    inside = [arm.transform(Joints(q)) for q in postures(arm, count)]
    return (
        GoalSet("in reach", tuple(inside), held=True),
        GoalSet("out of reach", tuple(map(_pulled_away, inside)), held=False),
        GoalSet("off the five-axis manifold", _turned(inside), held=False),
        GoalSet("on the base axis", _frames(arm, count, _over_the_axis), held=True),
        GoalSet("arm stretched", _frames(arm, count, _stretched), held=True),
        GoalSet("hand vertical", _frames(arm, count, _hand_down), held=True),
        GoalSet("wrist above the shoulder", _frames(arm, count, _wrist_above), held=True),
        GoalSet("straight up", _frames(arm, count, _straight_up), held=True),
        GoalSet("at the joint limits", _frames(arm, count, _at_limits), held=True),
    )


Change = Callable[[FiveAxisArm, Angles], Angles | None]


def _frames(arm: FiveAxisArm, count: int, change: Change) -> tuple[Transform, ...]:
    """Return the frames of postures of one kind that the limits allow."""
    chance = random.Random(SEED)
    found: list[Transform] = []
    while len(found) < count:
        base = tuple(chance.uniform(one.low_rad, one.high_rad) for one in arm.limits)
        posture = change(arm, base)
        if posture is not None and not arm.violations(Joints(posture)):
            found.append(arm.transform(Joints(posture)))
    return tuple(found)


def _over_the_axis(arm: FiveAxisArm, q: Angles) -> Angles | None:
    """Bend the wrist so that the tip is exactly above (or in) the base."""
    _, upper, fore, hand = arm.lengths
    r = upper * math.cos(q[1]) + fore * math.cos(q[1] + q[2])
    if abs(r) > hand:
        return None
    pitch = math.copysign(math.acos(-r / hand), q[4])
    return (*q[:3], pitch - q[1] - q[2], q[4])


def _stretched(_arm: FiveAxisArm, q: Angles) -> Angles:
    return q[0], q[1], 0.0, q[3], q[4]


def _hand_down(_arm: FiveAxisArm, q: Angles) -> Angles:
    return (*q[:3], -math.pi / 2.0 - q[1] - q[2], q[4])


def _wrist_above(arm: FiveAxisArm, q: Angles) -> Angles | None:
    """Put the wrist on the base axis, where the shoulder's turn moves it level."""
    _, upper, fore, _ = arm.lengths
    cosine = -upper * math.cos(q[1]) / fore
    if abs(cosine) > 1.0:
        return None
    return q[0], q[1], math.acos(cosine) - q[1], q[3], q[4]


def _straight_up(_arm: FiveAxisArm, q: Angles) -> Angles:
    return q[0], math.pi / 2.0, 0.0, 0.0, q[4]


def _at_limits(arm: FiveAxisArm, q: Angles) -> Angles:
    mixed = int(abs(q[0]) * 1e9)  # as good as a throw of dice
    first, second = mixed % len(q), mixed // 7 % len(q)
    ends = [(one.low_rad, one.high_rad) for one in arm.limits]
    return tuple(
        ends[index][mixed // 64 % 2] if index in {first, second} else angle
        for index, angle in enumerate(q)
    )


def _pulled_away(frame: Transform) -> Transform:
    """Return the same hand 700 mm farther from the shoulder: beyond any reach."""
    x, y, z = position_of(frame)
    away = math.hypot(x, y, z - 200.0) or 1.0
    far = 700.0 / away + 1.0
    return transform(rotation_of(frame), (far * x, far * y, 200.0 + far * (z - 200.0)))


def _turned(frames: list[Transform]) -> tuple[Transform, ...]:
    """Return hands turned sideways out of the arm's plane by 5 to 60 degrees."""
    found = []
    for index, frame in enumerate(frames):
        turn = math.radians(5.0 + 55.0 * index / len(frames)) * (-1.0) ** index
        x, y, z = position_of(frame)
        bearing = math.atan2(y, x)
        level = multiply(rot_z(bearing), rot_z(turn), rot_y(math.pi / 2.0))
        found.append(transform(level, (x, y, z)))
    return tuple(found)
