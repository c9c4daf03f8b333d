"""The position of one arm: commanded, acknowledged and read back, in motor steps and joint angles.

Positions are motor steps of the model: the controller's registers plus the reference offset, minus
the backlash that each motor has taken up (backlash.py). A reference sets that offset; the
controller is never asked to zero its registers. `DeviceReadings` and `FingerState` hold the rest of
what the device reports: current, inputs, outputs, fingers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from armdrive.abilities import Abilities
from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import Controller
from armdrive.errors import Refused
from armdrive.runtime.backlash import Slack
from armdrive.status import Current
from armdrive.storage.record import Record
from armdrive.tasks import Registers
from kinematics.spaces import Joints, Motors
from kinematics.text import counted
from kinematics.transmission import Transmission


def joints_between(start: Joints, end: Joints, fraction: float) -> Joints:
    """Interpolate between two postures in joint space; a fraction above 1 extrapolates."""
    angles = (a + (b - a) * fraction for a, b in zip(start, end, strict=True))
    return Joints(tuple(angles), start.names)


def alike(a: Joints, b: Joints, within_rad: float) -> bool:
    """Return whether two postures agree, each joint within an angle."""
    return all(abs(x - y) <= within_rad for x, y in zip(a, b, strict=True))


@dataclass(frozen=True, slots=True)
class ArmCoordinates:
    """A point in joint space before rounding to steps: joint angles and gripper opening."""

    joints: Joints
    opening_mm: float

    @property
    def values(self) -> tuple[float, ...]:
        """The joint angles in rad, followed by the opening in mm."""
        return (*self.joints, self.opening_mm)

    def motors(self, transmission: Transmission) -> Motors:
        """Return the point in whole steps: the only place where it is rounded."""
        return transmission.to_motors(self.joints, self.opening_mm)

    def towards(self, other: ArmCoordinates, fraction: float) -> ArmCoordinates:
        """Interpolate in joint space; a fraction of 1 or more returns `other`."""
        if fraction >= 1.0:
            return other
        opening_mm = self.opening_mm + (other.opening_mm - self.opening_mm) * fraction
        return ArmCoordinates(joints_between(self.joints, other.joints, fraction), opening_mm)


@dataclass(frozen=True, slots=True)
class MotionSegment:
    """A motion that is straight in joint space, with its duration at the requested speed."""

    start: ArmCoordinates
    end: ArmCoordinates
    duration_s: float

    @property
    def turns_rad(self) -> tuple[float, ...]:
        """The angle that each joint turns."""
        return tuple(b - a for a, b in zip(self.start.joints, self.end.joints, strict=True))

    def steps(self, transmission: Transmission) -> tuple[float, ...]:
        """Return the steps that each motor turns, before rounding."""
        before, after = (
            transmission.to_exact(each.joints, each.opening_mm) for each in (self.start, self.end)
        )
        return tuple(b - a for a, b in zip(before, after, strict=True))


class DeviceReadings:
    """What the device reports apart from its registers: current, inputs, outputs, grip."""

    def __init__(self, abilities: Abilities) -> None:
        self._abilities = abilities
        self.current = Current.UNKNOWN
        self.inputs: int | None = None
        self.sensed = 0
        """Number of times the inputs have been read."""
        self.awaiting = 0
        """Number of calls that wait for inputs: an arm at rest is polled faster meanwhile."""
        self.outputs: int | None = None
        self.gripping: bool | None = None

    def sense(self, registers: Registers) -> None:
        """Take the current, and the inputs and the grip switch if the device has any."""
        if registers.held is not None:
            self.current = Current.HELD if registers.held else Current.OFF
        if self._abilities.inputs:
            self.inputs = registers.inputs
        self.sensed += 1
        if self._abilities.grip_switch:
            self.gripping = registers.gripping


class FingerState:
    """The opening at which the fingers touched something, or a servo gripper's commanded share."""

    def __init__(self, config: ArmConfig, transmission: Transmission) -> None:
        self._config = config
        self._transmission = transmission
        self.touch_mm: float | None = None
        self.share: float | None = None

    @property
    def steps_per_mm(self) -> float:
        """The gripper motor's steps per mm of opening, without a sign."""
        return abs(self._transmission.motors[-1].steps_per_unit)

    def arrive(self, opening_mm: float) -> None:
        """Take a new opening: opening the fingers beyond the touch releases the object."""
        if self.touch_mm is not None and opening_mm >= self.touch_mm:
            self.touch_mm = None

    def force_n(self, opening_mm: float) -> float:
        """Return the gripping force, computed from the cable pulled in since the touch."""
        steps_per_n = self._config.model.grip_steps_per_n
        if self.touch_mm is None or steps_per_n is None:
            return 0.0
        return (self.touch_mm - opening_mm) * self.steps_per_mm / steps_per_n

    def seen_mm(self, pulled_mm: float) -> float | None:
        """Return the opening of the fingers, given the opening that their motor stands for."""
        if self._transmission.has_gripper:
            return max(pulled_mm, self.touch_mm or 0.0)
        if self.share is None:
            return None
        low, high = self._config.model.gripper_range_mm
        return low + self.share * (high - low)


def motors_of(config: ArmConfig, controller: Controller) -> Transmission:
    """Return an arm's transmission. Raises `Refused` if it does not fit the controller."""
    transmission = config.transmission
    motors = len(transmission.motors)
    if motors != controller.abilities.motors:
        raise Refused(
            f"the {config.title} has {counted(motors, 'motor')}, but its controller drives "
            f"{controller.abilities.motors}: list every motor of the controller in the arm "
            "file, or correct gripper.kind"
        )
    return transmission


class PositionLedger:
    """The commanded, acknowledged and read-back position of one arm's motors.

    `unwrap` undoes the wrap of registers near a position, like `Controller.unwrap`.
    """

    def __init__(
        self,
        transmission: Transmission,
        backlash_steps: Sequence[int],
        unwrap: Callable[[Motors, Motors], Motors],
        readings: DeviceReadings,
        fingers: FingerState,
    ) -> None:
        self._transmission = transmission
        self._unwrap = unwrap
        self._readings = readings
        self._fingers = fingers
        still = Motors([0] * len(transmission.motors))
        self.slack = Slack(backlash_steps or still)
        self.offset = still
        self.counts = still
        self.commanded = still
        self.acknowledged = still
        self.read_back: Motors | None = None
        self.fell = False
        """Whether registers dropped to zero during a motion that does not lead there."""
        self.coordinates = self.coordinates_of(still)

    @property
    def shift(self) -> Motors:
        """The difference between the acknowledged position and its registers."""
        return self.offset - self.slack.taken

    @property
    def expected(self) -> Motors:
        """The registers at the acknowledged position."""
        return self.acknowledged - self.shift

    def stands(self) -> None:
        """Start from rest: the next motion begins at the acknowledged position."""
        self.slack.stand()
        self.commanded = self.acknowledged
        self.fell = False

    def sends(self, steps: Motors) -> None:
        """Add steps that are about to be sent, backlash compensation included."""
        self.commanded = self.commanded + self.slack.sends(steps)
        self._readings.current = Current.HELD  # a device switches its motors on to move them

    def takes_back(self, commanded: Motors) -> None:
        """Withdraw the latest steps, which were not sent after all."""
        self.commanded = commanded
        self.slack.takes_back()

    def arrived(self, coordinates: ArmCoordinates | None) -> None:
        """Acknowledge the motion, given the unrounded point that it leads to."""
        self.acknowledged = self.commanded
        self.slack.arrive()
        self.coordinates = coordinates or self.coordinates_of(self.acknowledged)
        self._fingers.arrive(self.coordinates.opening_mm)

    def found(self, registers: Registers) -> None:
        """Take the registers as the position of an arm about which nothing else is known."""
        self._readings.sense(registers)
        self.counts = registers.positions
        self.commanded = self.acknowledged = self.read_back = registers.positions
        self.slack.doubt()
        self.offset = self.slack.taken
        self.coordinates = self.coordinates_of(registers.positions)

    def compare(self, registers: Registers) -> Motors:
        """Take a read-back; return its difference from the acknowledged registers, in steps."""
        self._readings.sense(registers)
        expected = self.expected
        self._see(self._unwrap(registers.positions, expected))
        return self.counts - expected

    def progress(self, registers: Registers) -> None:
        """Take registers that were read during a motion."""
        goal = self.commanded - self.offset + self.slack.ahead
        self._see(self._unwrap(registers.positions, goal))

    def _see(self, counts: Motors) -> None:
        before = self.read_back if self.counts.largest and not counts.largest else None
        self.counts = counts
        self.read_back = self.acknowledged + self.slack.see(counts - self.expected)
        # Zeros may be a goal, or the registers of a board that has just restarted. On its way to a
        # goal no motor turns back, so a step backwards to zero is a restart.
        if before is not None:
            ways = zip(before, self.read_back, self.commanded, strict=True)
            self.fell |= any(not min(a, c) <= b <= max(a, c) for a, b, c in ways)

    def believe_registers(self) -> None:
        """Take the read-back position as the acknowledged one, whatever was commanded."""
        if self.read_back is not None and self.read_back != self.acknowledged:
            self.acknowledged = self.read_back
            self.coordinates = self.coordinates_of(self.acknowledged)
        self.commanded = self.acknowledged  # even if nothing has moved yet
        self.slack.believe()

    def rebase(self, registers: Motors) -> None:
        """Keep the position although the registers have changed: adjust the offset."""
        self.slack.doubt()
        self.offset = self.acknowledged - registers + self.slack.taken
        self.counts = registers
        self.commanded = self.read_back = self.acknowledged

    def refer(self, registers: Motors, there: ArmCoordinates) -> None:
        """Set the reference offset: the present registers stand for a known posture."""
        position = there.motors(self._transmission)
        self.slack.refer()
        self.offset = position - registers + self.slack.taken
        self.counts = registers
        self.commanded = self.acknowledged = self.read_back = position
        self.coordinates = there

    def restore(self, record: Record, registers: Motors) -> bool:
        """Take up a recorded reference; return whether the registers still agree with it."""
        self.offset = Motors(record.offset)
        recorded = Motors(record.registers)
        fits = self.slack.restore(record.taken, record.unsure)
        counts = self.counts = self._unwrap(registers, recorded)
        # First as if nothing had changed since; below, what the registers say to that.
        self.commanded = self.acknowledged = self.read_back = recorded + self.shift
        self.coordinates = self._recorded_point(record) or self.coordinates_of(self.acknowledged)
        if counts != recorded and not registers.largest:  # a power cut zeroed the registers
            self.rebase(registers)
        elif counts != recorded:
            self._see(counts)
            self.believe_registers()
        return counts == recorded and fits

    def _recorded_point(self, record: Record) -> ArmCoordinates | None:
        """Return the unrounded point of a record, if it rounds to the acknowledged position."""
        names = self.coordinates.joints.names
        if len(record.coordinates) != len(names) + 1:
            return None
        *angles, opening_mm = record.coordinates
        there = ArmCoordinates(Joints(tuple(angles), names), opening_mm)
        return there if there.motors(self._transmission) == self.acknowledged else None

    def coordinates_of(self, position: Motors) -> ArmCoordinates:
        """Return the joint angles and the opening at a position."""
        joints, opening_mm = self._transmission.to_joints(position)
        return ArmCoordinates(joints, opening_mm)
