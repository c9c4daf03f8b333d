"""Joint angles and gripper opening to whole motor steps and back, as data.

Units: rad, mm (the gripper's opening) and motor steps. A motor sees a sum of joint angles (the
cables of a Mini-mover pass over the joints before theirs, so its motors see absolute link
angles), multiplies it by its steps per unit, and adds an offset. It may also follow other motors
step for step: the gripper's cable runs over the elbow, so each elbow step is added to the
gripper's motor as it is, and the fingers stand exactly still while the elbow moves.

Exact values are rounded once, to the nearest whole step, halves upwards (towards the positive
end): the same rule on both sides of zero, so that shifting a zero by whole steps shifts every
target by the same steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from operator import mul
from typing import TypeVar

from kinematics.errors import KinematicsError, SingularTransmission, finite
from kinematics.spaces import JOINT_NAMES, Joints, Motors
from kinematics.text import counted

N = TypeVar("N", int, float)

Matrix = tuple[tuple[float, ...], ...]

# A pivot smaller than this, against its row's largest entry, is a row that adds nothing.
PIVOT = 1e-12


@dataclass(frozen=True, slots=True)
class MotorSpec:
    """One motor: which joints turn it, by how much, and which other motors it follows.

    `steps_per_unit` is per rad, or per mm for the gripper's motor. `sees` holds one coefficient for
    each joint and, if the gripper has a motor, a last one for the opening. `follows` lists (index
    of an earlier motor, whole ratio): that many of its own steps for each of theirs.
    """

    name: str
    steps_per_unit: float
    sees: tuple[float, ...]
    offset_steps: float = 0.0
    follows: tuple[tuple[int, int], ...] = ()

    def __post_init__(self) -> None:
        per_unit = finite(f"{self.name} steps_per_unit", self.steps_per_unit)
        object.__setattr__(self, "steps_per_unit", per_unit)
        sees = tuple(finite(f"what {self.name} sees", share) for share in self.sees)
        object.__setattr__(self, "sees", sees)
        offset = finite(f"{self.name} offset_steps", self.offset_steps)
        object.__setattr__(self, "offset_steps", offset)
        if not all(type(ratio) is int for _, ratio in self.follows):
            raise KinematicsError(f"motor {self.name!r} can follow only in whole ratios of steps")

    def followed(self, steps: Sequence[N]) -> N | int:
        """Return the steps that the motor makes because those before it have made these."""
        if not self.follows:
            return 0
        return sum(ratio * steps[earlier] for earlier, ratio in self.follows)


@dataclass(frozen=True, slots=True)
class Transmission:
    """All motors of an arm: one for each joint, plus one if the gripper has a motor.

    `matrix` gives steps per unit of each joint (and the opening), couplings included; `inverse` is
    its inverse. Raises `SingularTransmission` if the motors do not determine the joints.
    """

    motors: tuple[MotorSpec, ...]
    joint_names: tuple[str, ...] = JOINT_NAMES
    matrix: Matrix = field(init=False, repr=False, compare=False)
    inverse: Matrix = field(init=False, repr=False, compare=False)
    _own: Matrix = field(init=False, repr=False, compare=False)
    _own_inverse: Matrix = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        _check_shape(self.motors, len(self.joint_names))
        own = tuple(
            tuple(motor.steps_per_unit * share for share in motor.sees) for motor in self.motors
        )
        full: list[tuple[float, ...]] = []
        for motor, row in zip(self.motors, own, strict=True):
            for earlier, ratio in motor.follows:
                row = tuple(a + ratio * b for a, b in zip(row, full[earlier], strict=True))
            full.append(row)
        names = [motor.name for motor in self.motors]
        object.__setattr__(self, "matrix", tuple(full))
        object.__setattr__(self, "inverse", _inverse(tuple(full), names))
        object.__setattr__(self, "_own", own)
        object.__setattr__(self, "_own_inverse", _inverse(own, names))

    @property
    def has_gripper(self) -> bool:
        """Whether the last motor drives the gripper."""
        return len(self.motors) > len(self.joint_names)

    def to_motors(self, joints: Joints, opening_mm: float = 0.0) -> Motors:
        """Return absolute motor steps, rounded once. The opening needs a gripper motor."""
        steps: list[int] = []
        for motor, own in zip(self.motors, self._own_steps(joints, opening_mm), strict=True):
            steps.append(math.floor(own + 0.5) + motor.followed(steps))
        return Motors(steps)

    def to_exact(self, joints: Joints, opening_mm: float = 0.0) -> tuple[float, ...]:
        """Return absolute motor steps, unrounded."""
        steps: list[float] = []
        for motor, own in zip(self.motors, self._own_steps(joints, opening_mm), strict=True):
            steps.append(own + motor.followed(steps))
        return tuple(steps)

    def to_joints(self, motors: Sequence[int]) -> tuple[Joints, float]:
        """Return joint angles and the gripper opening in mm, which is 0 without a gripper motor."""
        if len(motors) != len(self.motors):
            raise KinematicsError(
                f"{counted(len(self.motors), 'motor was', 'motors were')} expected, not "
                f"{len(motors)}"
            )
        own = tuple(
            steps - motor.followed(motors) - motor.offset_steps
            for motor, steps in zip(self.motors, motors, strict=True)
        )
        values = times(self._own_inverse, own)
        count = len(self.joint_names)
        return Joints(values[:count], self.joint_names), values[count] if self.has_gripper else 0.0

    def most_steps(self, amounts: Sequence[float]) -> tuple[float, ...]:
        """Return how far each motor turns at most while every joint turns by up to its amount.

        The opening's amount follows those of the joints. Amounts beyond what the motors drive are
        ignored. Rates in rad/s (and mm/s) give rates in steps/s.
        """
        return tuple(
            math.fsum(abs(share * amount) for share, amount in zip(row, amounts, strict=False))
            for row in self.matrix
        )

    def with_signs(
        self, motors: Sequence[int] = (), coordinates: Sequence[int] = ()
    ) -> Transmission:
        """Return this transmission with some directions reversed, as calibration finds them.

        `motors` holds 1 or -1 for each motor: -1 if it counts the other way. `coordinates` holds 1
        or -1 for each joint (and the opening): -1 if the joint's positive direction is the other
        one. Arguments that are left out change nothing.
        """
        turns = _signs(motors, len(self.motors), "motor")
        axes = _signs(coordinates, len(self.motors), "joint")
        return replace(
            self,
            motors=tuple(
                replace(
                    motor,
                    steps_per_unit=turn * motor.steps_per_unit,
                    sees=tuple(axis * share for axis, share in zip(axes, motor.sees, strict=True)),
                    offset_steps=turn * motor.offset_steps,
                    follows=tuple(
                        (earlier, turn * turns[earlier] * ratio) for earlier, ratio in motor.follows
                    ),
                )
                for motor, turn in zip(self.motors, turns, strict=True)
            ),
        )

    def without_gripper(self) -> Transmission:
        """Return only the joints' motors, for an arm whose fingers are moved by something else."""
        if not self.has_gripper:
            return self
        kept = self.motors[:-1]
        return Transmission(
            tuple(replace(motor, sees=motor.sees[:-1]) for motor in kept), self.joint_names
        )

    def _own_steps(self, joints: Joints, opening_mm: float) -> tuple[float, ...]:
        """Return each motor's own steps, offset included, without what it follows."""
        seen = times(self._own, self._coordinates(joints.angles_rad, opening_mm))
        return tuple(a + motor.offset_steps for a, motor in zip(seen, self.motors, strict=True))

    def _coordinates(self, joints: Sequence[float], opening: float) -> tuple[float, ...]:
        if len(joints) != len(self.joint_names):
            raise KinematicsError(
                f"{counted(len(self.joint_names), 'joint was', 'joints were')} expected, "
                f"not {len(joints)}"
            )
        if not self.has_gripper:
            return tuple(joints)
        return (*joints, finite("gripper opening", opening))


def _check_shape(motors: tuple[MotorSpec, ...], joint_count: int) -> None:
    """Raise unless there are as many motors as coordinates and each follows earlier ones only."""
    if len(motors) not in {joint_count, joint_count + 1}:
        raise KinematicsError(
            f"{counted(joint_count, 'joint needs', 'joints need')} "
            f"{counted(joint_count, 'motor')}, "
            "or one more for the gripper, "
            f"not {len(motors)}"
        )
    for index, motor in enumerate(motors):
        if len(motor.sees) != len(motors):
            raise KinematicsError(
                f"motor {motor.name!r} must see {counted(len(motors), 'value')}, not "
                f"{len(motor.sees)}"
            )
        if not all(0 <= earlier < index for earlier, _ in motor.follows):
            raise KinematicsError(f"motor {motor.name!r} can follow only motors listed before it")


def _signs(signs: Sequence[int], count: int, what: str) -> tuple[int, ...]:
    if not signs:
        return (1,) * count
    if len(signs) != count or not all(sign in {1, -1} for sign in signs):
        raise KinematicsError(f"{count} {what} signs are needed, each 1 or -1, not {signs!r}")
    return tuple(signs)


def times(matrix: Matrix, vector: Sequence[float]) -> tuple[float, ...]:
    """Return the product of a matrix and a vector."""
    return tuple([sum(map(mul, row, vector)) for row in matrix])


def _inverse(matrix: Matrix, names: Sequence[str]) -> Matrix:
    """Return the inverse of a square matrix, or raise `SingularTransmission`.

    Gauss-Jordan with the largest entry of each row as its pivot: rows keep their order, so that
    the motor which adds nothing can be named. numpy would be loaded for this alone.
    """
    size = len(matrix)
    rows = [
        [*row, *(1.0 if column == index else 0.0 for column in range(size))]
        for index, row in enumerate(matrix)
    ]
    pivots: list[int] = []
    for index, row in enumerate(rows):
        pivot = max(range(size), key=lambda column: abs(row[column]))
        if abs(row[pivot]) <= PIVOT * max(map(abs, matrix[index])):
            raise SingularTransmission(names[index])
        pivots.append(pivot)
        rows[index] = row = [entry / row[pivot] for entry in row]
        for other, line in enumerate(rows):
            if other != index and line[pivot] != 0.0:
                factor = line[pivot]
                rows[other] = [a - factor * b for a, b in zip(line, row, strict=True)]
    order = sorted(range(size), key=pivots.__getitem__)
    return tuple(tuple(rows[index][size:]) for index in order)
