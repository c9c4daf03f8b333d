"""The effect of a step, of rounding or of a wrong parameter on the tip of a five-axis arm.

Source: McKerrow, chapter 4, section 14 (accuracy of the kinematic model). Every error here is the
difference of two forward solutions, exact and not linearised. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from operator import mul

from kinematics.five_axis import FiveAxisArm
from kinematics.spaces import JOINT_NAMES, Joints
from kinematics.transmission import Transmission, times

LENGTH_NAMES = ("base_height_mm", "upper_arm_mm", "forearm_mm", "hand_mm")


@dataclass(frozen=True, slots=True)
class TipError:
    """The effect of one cause on the tip: the cause, its size, and the change of the tip.

    `change` is in `unit`: steps of a motor, mm of a length, rad of a joint's zero, or the share
    of a motor's steps per unit (0.01 is one per cent).
    """

    cause: str
    change: float
    unit: str
    offset_mm: tuple[float, float, float]
    pitch_rad: float
    roll_rad: float

    @property
    def distance_mm(self) -> float:
        """How far the tip moves."""
        return math.hypot(*self.offset_mm)


def step_errors(
    arm: FiveAxisArm, transmission: Transmission, joints: Joints
) -> tuple[TipError, ...]:
    """Return the effect of one step of each motor on the tip, while the others stand still.

    On an arm with the Mini-mover's cables the motors hold absolute link angles, so that one step
    of the shoulder's motor moves the upper arm alone and carries the rest along unturned.
    """
    found = []
    for index, motor in enumerate(transmission.motors):
        if _moves_joints(transmission, index):
            stepped = _moved(joints, [row[index] for row in transmission.inverse])
            found.append(_tip_error((arm, joints), (arm, stepped), motor.name, 1.0, "steps"))
    return tuple(found)


def rounding_rms_mm(arm: FiveAxisArm, transmission: Transmission, joints: Joints) -> float:
    """Return the tip's root mean square error when every motor is rounded to its whole step.

    A rounding is as likely anywhere within half a step, so a motor's share of the variance is a
    twelfth of the square of what its whole step does.
    """
    steps = step_errors(arm, transmission, joints)
    return math.sqrt(sum(one.distance_mm**2 for one in steps) / 12.0)


def rounding_bound_mm(arm: FiveAxisArm, transmission: Transmission, joints: Joints) -> float:
    """Return the tip's largest error when every motor is rounded: half a step each, any signs."""
    offsets = [one.offset_mm for one in step_errors(arm, transmission, joints)]
    far = []
    for signs in product((0.5, -0.5), repeat=len(offsets)):
        axes = zip(*offsets, strict=True)
        far.append(math.hypot(*(sum(map(mul, signs, axis)) for axis in axes)))
    return max(far)


def length_errors(arm: FiveAxisArm, joints: Joints, change_mm: float = 1.0) -> tuple[TipError, ...]:
    """Return the effect of an error in each length: the true arm's tip minus the modelled one."""
    found = []
    for name in LENGTH_NAMES:
        true = replace(arm, **{name: getattr(arm, name) + change_mm})
        found.append(_tip_error((arm, joints), (true, joints), name, change_mm, "mm"))
    return tuple(found)


def zero_errors(
    arm: FiveAxisArm, joints: Joints, change_rad: float = math.radians(0.1)
) -> tuple[TipError, ...]:
    """Return the effect of an error in each joint's zero on the tip."""
    found = []
    for name in JOINT_NAMES:
        true = joints.replace(**{name: joints[name] + change_rad})
        found.append(_tip_error((arm, joints), (arm, true), name, change_rad, "rad"))
    return tuple(found)


def gearing_errors(
    arm: FiveAxisArm,
    transmission: Transmission,
    joints: Joints,
    share: float = 0.01,
    reference: Joints | None = None,
) -> tuple[TipError, ...]:
    """Return the effect of a wrong number of steps per unit of each motor on the tip.

    Steps are counted from the reference posture (the zero of all joints by default), where the
    error is none; it grows with the way from there. The true motor makes `share` more steps.
    """
    start = reference or Joints((0.0,) * len(JOINT_NAMES))
    made = _difference(transmission.to_exact(joints), transmission.to_exact(start))
    found = []
    for index, motor in enumerate(transmission.motors):
        if not _moves_joints(transmission, index):
            continue
        true = replace(motor, steps_per_unit=motor.steps_per_unit * (1.0 + share))
        motors = (*transmission.motors[:index], true, *transmission.motors[index + 1 :])
        way = times(replace(transmission, motors=motors).inverse, made)
        reached = _moved(start, way)
        found.append(_tip_error((arm, joints), (arm, reached), motor.name, share, "share"))
    return tuple(found)


# An arm and its posture.
Posed = tuple[FiveAxisArm, Joints]


def _tip_error(model: Posed, true: Posed, cause: str, change: float, unit: str) -> TipError:
    """Return the true tip less the modelled one; pitch and roll by the short way round."""
    a, b = (arm.points(joints)[-1] for arm, joints in (model, true))
    offset = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    turn = _difference(true[1].angles_rad, model[1].angles_rad)
    return TipError(cause, change, unit, offset, turn[1] + turn[2] + turn[3], turn[4])


def _moved(joints: Joints, way: list[float] | tuple[float, ...]) -> Joints:
    pairs = zip(joints.angles_rad, way, strict=False)  # the gripper's opening turns no joint
    return Joints(tuple(angle + more for angle, more in pairs))


def _moves_joints(transmission: Transmission, motor: int) -> bool:
    return any(row[motor] != 0.0 for row in transmission.inverse[: len(JOINT_NAMES)])


def _difference(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(p - q for p, q in zip(a, b, strict=True))
