"""The mechanics of a simulated arm as data: geometry, transmission, stops and fingers."""

from __future__ import annotations

import math
from dataclasses import dataclass

from armdrive.errors import BadRequest
from kinematics.geometry import ArmGeometry
from kinematics.limits import JointRange
from kinematics.presets import POUND_FORCE_N, ArmModel, Reference
from kinematics.transmission import MotorSpec, Transmission

_BEYOND_RANGE_RAD = math.radians(3.0)
SAMPLE_STEPS = 72
"""A motion is looked at whenever a motor has made this many steps: some 30 mm at full reach."""
_SAMPLES_PER_RAD = 17
"""Looks for each rad of a motor whose steps are finer than those of such an arm."""


@dataclass(frozen=True, slots=True)
class ArmBody:
    """What a simulated arm is made of.

    `stop_margin_rad` is how far beyond its stated range a joint meets its mechanical stop, and
    `opening_stop_mm` how wide the fingers can be pulled. The grip switch trips at
    `switch_force_n` (the arm's papers do not state it: a setting), and beyond `most_force_n` the
    gripper's motor loses steps. `stalls` names, for each joint, the motors that lose steps when
    it is at its stop. `reference` is where the arm counts its steps from, if that is known. `play`
    is the lost motion of each motor's train in steps, none where it is empty.
    """

    key: str
    arm: ArmGeometry
    transmission: Transmission
    grip_steps_per_n: float = 32.0 / POUND_FORCE_N
    switch_force_n: float = POUND_FORCE_N / 2
    most_force_n: float = 35.0
    opening_stop_mm: float = 78.0
    stop_margin_rad: float = _BEYOND_RANGE_RAD
    stalls: tuple[tuple[int, ...], ...] = ((0,), (1,), (2,), (3, 4), (3, 4))
    reference: Reference | None = None
    play: tuple[int, ...] = ()

    @classmethod
    def of_preset(cls, preset: ArmModel) -> ArmBody:
        """Build the arm that a preset describes; `BadRequest` where its steps are unknown."""
        if preset.transmission is None:
            raise BadRequest(
                f"no steps per turn are known of the {preset.title}, so it cannot be simulated; "
                "choose another preset, or give its transmission in an arm file"
            )
        per_n = preset.grip_steps_per_n or 32.0 / POUND_FORCE_N
        return cls(
            preset.key,
            preset.arm,
            preset.transmission,
            grip_steps_per_n=per_n,
            stalls=_stalls(preset.transmission),
            reference=preset.reference,
        )

    @property
    def stops(self) -> tuple[JointRange, ...]:
        """Where each joint meets its mechanical stop."""
        margin = self.stop_margin_rad
        return tuple(
            JointRange(limit.low_rad - margin, limit.high_rad + margin) for limit in self.arm.limits
        )

    @property
    def sample_steps(self) -> int:
        """Return after how many steps of a motor a motion is looked at."""
        finest = max(abs(motor.steps_per_unit) for motor in self._turning)
        return max(SAMPLE_STEPS, int(finest / _SAMPLES_PER_RAD))

    @property
    def _turning(self) -> tuple[MotorSpec, ...]:
        return self.transmission.motors[: len(self.transmission.joint_names)]

    @property
    def grip_steps_per_mm(self) -> float:
        """Half-steps of the gripper's motor, where there is one, for each mm of opening."""
        return abs(self.transmission.motors[-1].steps_per_unit)

    def force_n(self, squeeze_mm: float) -> float:
        """Return the grip force when the motor has pulled the fingers this far beyond contact."""
        return max(squeeze_mm, 0.0) * self.grip_steps_per_mm / self.grip_steps_per_n

    def squeeze_mm(self, force_n: float) -> float:
        """Return how far beyond contact the motor must pull for a force."""
        return force_n * self.grip_steps_per_n / self.grip_steps_per_mm


def _stalls(transmission: Transmission) -> tuple[tuple[int, ...], ...]:
    """Return the motors that turn each joint by themselves.

    Those that see it and that it is computed from: an elbow's angle is computed from the
    shoulder's motor too, but that motor does not see the elbow.
    """
    motors = range(len(transmission.motors))
    return tuple(
        tuple(
            motor
            for motor in motors
            if transmission.matrix[motor][joint] != 0.0
            and abs(transmission.inverse[joint][motor] * transmission.matrix[motor][joint]) > 1e-9
        )
        for joint in range(len(transmission.joint_names))
    )
