"""The singularities of the five-axis build: which there are, how near, and what each one costs.

In its own task space (x, y, z, pitch, roll) the build's Jacobian has the determinant
r * a2 * a3 * sin(elbow), up to its sign, where r is the tip's distance from the base axis: it is
singular with the elbow straight or folded, and with the tip over the base, and nowhere else.
Source: McKerrow, chapter 4, sections 12 and 16. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from kinematics.chains.generated import Jacobian
from kinematics.five_axis.arm import FiveAxisArm
from kinematics.five_axis.closed_form import AXIS_MM, plane_tip
from kinematics.limits import wrap
from kinematics.spaces import Joints, RollFrame

_ROUNDS = 50
_CLOSE_MM = 1e-10


def task_jacobian(
    arm: FiveAxisArm, joints: Joints, roll_frame: RollFrame = RollFrame.HAND
) -> Jacobian:
    """Return the five rows x, y, z (mm/rad), pitch and roll (rad/rad) of the five-axis build.

    The derivative of `FiveAxisArm.fk`. A tip behind the base axis pitches against its joints
    (see `arm`); on the axis itself pitch counts as in front, and the tip can leave in the
    arm's own plane only.
    """
    arm.fk(joints)  # checks that these are the build's joints
    base, shoulder, elbow, wrist, _ = joints.angles_rad
    r, _, _ = plane_tip(shoulder, elbow, wrist, arm.lengths)
    joints_above = _above(arm, shoulder, elbow, wrist)
    cos_base, sin_base = math.cos(base), math.sin(base)
    outwards = [-rise for _, rise in joints_above]
    upwards = [reach for reach, _ in joints_above]
    sense = -1.0 if r < -AXIS_MM else 1.0
    turns_roll = -1.0 if roll_frame is RollFrame.TABLE else 0.0
    return (
        (-r * sin_base, *(cos_base * rate for rate in outwards), 0.0),
        (r * cos_base, *(sin_base * rate for rate in outwards), 0.0),
        (0.0, *upwards, 0.0),
        (0.0, sense, sense, sense, 0.0),
        (turns_roll, 0.0, 0.0, 0.0, 1.0),
    )


def _above(
    arm: FiveAxisArm, shoulder: float, elbow: float, wrist: float
) -> list[tuple[float, float]]:
    """Return how far the tip lies outwards of and above shoulder, elbow and wrist, in the plane."""
    _, upper, fore, hand = arm.lengths
    found = []
    reach = rise = 0.0
    for length, elevation in (
        (hand, shoulder + elbow + wrist),
        (fore, shoulder + elbow),
        (upper, shoulder),
    ):
        reach += length * math.cos(elevation)
        rise += length * math.sin(elevation)
        found.append((reach, rise))
    return found[::-1]


class FiveAxisSingularity(Enum):
    """A way in which the five-axis build is singular; the value says what it costs."""

    ELBOW_STRAIGHT = (
        "the elbow is straight: the wrist cannot move further from the shoulder, and elbow up and "
        "elbow down are the same posture"
    )
    ELBOW_FOLDED = (
        "the elbow is folded: the wrist cannot move nearer to the shoulder, and elbow up and "
        "elbow down are the same posture"
    )
    TIP_OVER_BASE = (
        "the tip is on the base axis: turning the base only turns the hand, and the tip cannot "
        "move across the plane that the arm stands in"
    )


@dataclass(frozen=True, slots=True)
class Nearness:
    """How far a posture is from one singularity.

    `distance_rad` is the smallest joint move that leads there (root of the sum of squares; over
    the base, the smallest one found, which is never more than the shoulder's alone);
    `distance_mm` how far the wrist is from full stretch or full fold, or the tip from the base
    axis.
    """

    singularity: FiveAxisSingularity
    distance_rad: float
    distance_mm: float

    @property
    def sentence(self) -> str:
        """What the singularity costs, and how far away it is."""
        return (
            f"{math.degrees(self.distance_rad):.1f}° and {self.distance_mm:.1f} mm away: "
            f"{self.singularity.value}"
        )


def five_axis_singularities(arm: FiveAxisArm, joints: Joints) -> tuple[Nearness, ...]:
    """Return the three singularities, the nearest (by joint moves) first; limits not looked at."""
    points = arm.points(joints)
    _, shoulder, elbow, wrist, _ = joints.angles_rad
    bend = abs(wrap(elbow))
    span = math.dist(points[1], points[3])
    upper, fore = arm.upper_arm_mm, arm.forearm_mm
    over = _over_base(arm, (shoulder, elbow, wrist))
    return tuple(
        sorted(
            (
                Nearness(FiveAxisSingularity.ELBOW_STRAIGHT, bend, max(upper + fore - span, 0.0)),
                Nearness(
                    FiveAxisSingularity.ELBOW_FOLDED,
                    math.pi - bend,
                    max(span - abs(upper - fore), 0.0),
                ),
                Nearness(FiveAxisSingularity.TIP_OVER_BASE, over, math.hypot(*points[4][:2])),
            ),
            key=lambda one: one.distance_rad,
        )
    )


def _over_base(arm: FiveAxisArm, start: tuple[float, float, float]) -> float:
    """Return a small move of shoulder, elbow and wrist that puts the tip on the base axis.

    The shoulder alone can always do it, since its axis meets the base axis: that bounds the
    move from above. Newton's method on r = 0, always by the shortest way from the start,
    looks for a combination that is smaller.
    """
    r, z, _ = plane_tip(*start, arm.lengths)
    height = z - arm.base_height_mm
    alone = math.atan2(abs(r), abs(height)) if r or height else 0.0
    angles = start
    for _ in range(_ROUNDS):
        if not math.dist(start, angles) <= alone:
            break  # on the flat at full stretch a step is thrown anywhere
        r, _, _ = plane_tip(*angles, arm.lengths)
        if abs(r) <= _CLOSE_MM:
            return math.dist(start, angles)
        slopes = _slopes(arm, angles)
        steep = sum(slope * slope for slope in slopes)
        if steep == 0.0:
            break
        back = sum(s * (a - b) for s, a, b in zip(slopes, start, angles, strict=True))
        step = (r + back) / steep
        one, two, three = (a - slope * step for a, slope in zip(start, slopes, strict=True))
        angles = one, two, three
    return alone


def _slopes(arm: FiveAxisArm, angles: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return how the tip's distance from the base axis changes with each angle, mm/rad."""
    shoulder, elbow, wrist = angles
    _, upper, fore, hand = arm.lengths
    of_hand = -hand * math.sin(shoulder + elbow + wrist)
    of_fore = of_hand - fore * math.sin(shoulder + elbow)
    return of_fore - upper * math.sin(shoulder), of_fore, of_hand
