"""The mechanics of a simulated arm: geometry, stops, fingers, backlash, sag, first posture."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass

from armdrive.errors import BadRequest
from kinematics.five_axis import FiveAxisArm
from kinematics.geometry import ArmGeometry
from kinematics.limits import JointRange
from kinematics.presets import POUND_FORCE_N, ArmModel, Reference
from kinematics.spaces import Joints, Motors
from kinematics.transmission import MotorSpec, Transmission

# How far beyond its stated range a joint meets its mechanical stop.
STOP_MARGIN_RAD = math.radians(3.0)
# The widest opening of the fingers.
OPENING_STOP_MM = 78.0
# At which the grip switch trips: a guess, the makers do not say.
SWITCH_FORCE_N = POUND_FORCE_N / 2
# Beyond this grip force the gripper's motor loses steps.
MOST_FORCE_N = 35.0
# Motion is sampled every time a motor has made this many steps: some 30 mm at full reach.
SAMPLE_STEPS = 72
# Samples per rad, for motors whose steps are much finer than those of a Mini-mover.
_SAMPLES_PER_RAD = 17


@dataclass(frozen=True, slots=True)
class ArmBody:
    """The physical properties of a simulated arm.

    `stalls` lists, for each joint, the motors that lose steps when it is at its stop. `reference`
    is the posture from which the arm counts its steps, if known. `play` is the backlash of each
    motor's drive train in steps, empty for none.
    """

    key: str
    arm: ArmGeometry
    transmission: Transmission
    grip_steps_per_n: float
    stalls: tuple[tuple[int, ...], ...]
    reference: Reference | None
    play: tuple[int, ...] = ()

    @classmethod
    def of_preset(cls, preset: ArmModel) -> ArmBody:
        """Build the arm that a preset describes. Raises `BadRequest` if its steps are unknown."""
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
        """The mechanical stops of each joint."""
        return tuple(
            JointRange(limit.low_rad - STOP_MARGIN_RAD, limit.high_rad + STOP_MARGIN_RAD)
            for limit in self.arm.limits
        )

    @property
    def sample_steps(self) -> int:
        """Return after how many steps of a motor a motion is sampled."""
        finest = max(abs(motor.steps_per_unit) for motor in self._turning)
        return max(SAMPLE_STEPS, int(finest / _SAMPLES_PER_RAD))

    @property
    def _turning(self) -> tuple[MotorSpec, ...]:
        return self.transmission.motors[: len(self.transmission.joint_names)]

    @property
    def grip_steps_per_mm(self) -> float:
        """Half-steps of the gripper motor, if there is one, for each mm of opening."""
        return abs(self.transmission.motors[-1].steps_per_unit)

    def force_n(self, squeeze_mm: float) -> float:
        """Return the grip force when the motor has pulled the fingers this far beyond contact."""
        return max(squeeze_mm, 0.0) * self.grip_steps_per_mm / self.grip_steps_per_n

    def squeeze_mm(self, force_n: float) -> float:
        """Return how far beyond contact the motor must pull for a force."""
        return force_n * self.grip_steps_per_n / self.grip_steps_per_mm


def _stalls(transmission: Transmission) -> tuple[tuple[int, ...], ...]:
    """Return the motors that alone turn each joint.

    Such a motor is blocked by the joint, and the joint's angle is computed from it. An elbow's
    angle is computed from the shoulder's motor too, but that motor is not blocked by the elbow.
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


# --- Lost motion: a pin in a slot between each motor and what it drives --------------------------
# Backlash is modelled as a pin in a slot. The motor moves the slot, which is longer than the pin by
# the play. The pin follows only when an end of the slot pushes it. All lengths are in steps.

MOST_STEPS = 10_000  # more backlash than any drive train has


class Play:
    """The slots of all motors; `ahead` is how far each is ahead of its pin, from 0 to its width."""

    def __init__(self, widths: Sequence[int]) -> None:
        self.widths = tuple(widths)
        self.any = any(self.widths)
        self.ahead = [0] * len(self.widths)

    def stand(self, ahead: Sequence[int]) -> None:
        """Set how far each slot is ahead of its pin, limited to its width."""
        self.ahead = [min(one, width) for one, width in zip(ahead, self.widths, strict=False)]

    def drive(self, steps: Sequence[int]) -> Sequence[int]:
        """Move the slots; return how far the pins were pushed."""
        if not self.any:
            return steps
        pushed = []
        for motor, (step, width) in enumerate(zip(steps, self.widths, strict=True)):
            slot = (
                self.ahead[motor] + step
            )  # the pin is at 0 and must lie within slot - width ... slot
            pin = min(max(0, slot - width), slot)
            self.ahead[motor] = slot - pin
            pushed.append(pin)
        return Motors(pushed)

    def turns_for(self, steps: Motors) -> Motors:
        """Return how far motors must turn to push their pins this far."""
        if not self.any:
            return steps
        return Motors(
            step + (width - ahead if step > 0 else -ahead if step else 0)
            for step, width, ahead in zip(steps, self.widths, self.ahead, strict=True)
        )


def play_of(play: int | Sequence[int], count: int) -> tuple[int, ...]:
    """Return the play of each motor, given one number for all of them or one for each."""
    widths = tuple(play) if isinstance(play, Sequence) else (play,) * count
    if len(widths) != count or any(
        type(width) is not int or not 0 <= width <= MOST_STEPS for width in widths
    ):
        raise BadRequest(
            f"play is a whole number of steps from 0 to {MOST_STEPS}, or {count} of them, "
            f"not {play!r}"
        )
    return widths


# --- How an arm without motor current comes down: each link a little, to the table ---------------

# How far the joint that lowers the tip most gives way, and the others in proportion.
#
# The sag of a real arm depends on its friction and load. This is easy to see in a picture and far
# beyond any tolerance.
SAG_RAD = math.radians(4.0)
_HALVINGS = 20  # a millionth of the sag
_LOOK_RAD = 1e-4  # turn a joint by this much to see whether that lowers the tip


def sagged(arm: ArmGeometry, joints: Joints) -> Joints:
    """Return the posture in which an arm without current comes to rest.

    Each joint gives way as far as that lowers the tip, within its range, until the tip is on the
    table.
    """
    here_mm = arm.fk(joints).z_mm
    if here_mm <= 0.0:
        return joints
    slopes = [
        (arm.fk(joints.replace(**{name: angle + _LOOK_RAD})).z_mm - here_mm) / _LOOK_RAD
        for name, angle in zip(joints.names, joints, strict=True)
    ]
    steepest = max(map(abs, slopes)) or 1.0

    def lowered(share: float) -> Joints:
        angles = (
            min(max(at - share * SAG_RAD * slope / steepest, min(one.low_rad, at)),
                max(one.high_rad, at))
            for at, slope, one in zip(joints, slopes, arm.limits, strict=True)
        )  # fmt: skip
        return Joints(tuple(angles), joints.names)

    free, blocked = 0.0, 1.0
    if arm.fk(lowered(1.0)).z_mm >= 0.0:
        return lowered(1.0)
    for _ in range(_HALVINGS):
        half = (free + blocked) / 2
        if arm.fk(lowered(half)).z_mm >= 0.0:
            free = half
        else:
            blocked = half
    return lowered(free)


# --- The posture of a new simulated arm: raised and clear of the table ---------------------------

# The posture in which an arm of the Mini-mover's build is found.
FOUND_POSTURE = Joints.of(0.0, 70.0, -95.0, -35.0, 0.0)

CLEAR_MM = 30.0  # above the table, with every point of the arm
_TRIES = 500
_SHARE = 0.5  # of each joint's range, around its middle


def found_posture(arm: ArmGeometry) -> Joints:
    """Return the posture in which the arm is found; always the same for the same arm.

    For arms other than the Mini-mover's build it is the middle of the ranges if every point is
    above the table there, otherwise the first random posture from the middle half of the ranges
    that is clear of the table, otherwise the highest of those tried.
    """
    if isinstance(arm, FiveAxisArm):
        return FOUND_POSTURE
    draw = random.Random(1)  # noqa: S311 - any posture will do
    best, height_mm = _between(arm, [0.5] * len(arm.limits)), float("-inf")
    for attempt in range(_TRIES):
        shares = [0.5 + (draw.random() - 0.5) * _SHARE * (attempt > 0) for _ in arm.limits]
        joints = _between(arm, shares)
        lowest_mm = min(point[2] for point in arm.points(joints)[-len(arm.moving_points) :])
        if lowest_mm > height_mm:
            best, height_mm = joints, lowest_mm
        if height_mm >= CLEAR_MM:
            break
    return best


def _between(arm: ArmGeometry, shares: list[float]) -> Joints:
    return Joints(
        tuple(
            one.low_rad + share * (one.high_rad - one.low_rad)
            for one, share in zip(arm.limits, shares, strict=True)
        ),
        arm.joint_names,
    )
