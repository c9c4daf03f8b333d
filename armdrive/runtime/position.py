"""Where one arm is: commanded, acknowledged and read back, in motor steps and in joint angles.

`DeviceReadings` and `FingerState` are what is known besides: current, inputs and outputs, fingers.

Positions are motor steps of the model: registers plus the reference offset, less what is taken up
of each motor's backlash (backlash.py). A reference is that offset: nothing here ever asks the
controller to zero its registers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import Controller
from armdrive.errors import Refused
from armdrive.runtime.backlash import Slack
from armdrive.status import Current
from armdrive.storage.record import Record
from armdrive.tasks import Registers
from kinematics.spaces import Joints, Motors
from kinematics.transmission import Transmission


def joints_between(start: Joints, end: Joints, fraction: float) -> Joints:
    """Return the joints at a fraction of the straight way between two; beyond its end above 1."""
    angles = (a + (b - a) * fraction for a, b in zip(start, end, strict=True))
    return Joints(tuple(angles), start.names)


def alike(a: Joints, b: Joints, within_rad: float) -> bool:
    """Tell whether two postures are the same, each joint within an angle."""
    return all(abs(x - y) <= within_rad for x, y in zip(a, b, strict=True))


@dataclass(frozen=True, slots=True)
class ArmCoordinates:
    """Where the arm is meant to be, before rounding to steps: joints and gripper opening."""

    joints: Joints
    opening_mm: float

    @property
    def values(self) -> tuple[float, ...]:
        """The joint angles in rad, and then the opening."""
        return (*self.joints, self.opening_mm)

    def motors(self, transmission: Transmission) -> Motors:
        """Return the whole steps that stand for this point: the one place where it is rounded."""
        return transmission.to_motors(self.joints, self.opening_mm)

    def towards(self, other: ArmCoordinates, fraction: float) -> ArmCoordinates:
        """Return the point at a fraction of the straight way in joint space."""
        if fraction >= 1.0:
            return other
        opening_mm = self.opening_mm + (other.opening_mm - self.opening_mm) * fraction
        return ArmCoordinates(joints_between(self.joints, other.joints, fraction), opening_mm)


@dataclass(frozen=True, slots=True)
class MotionSegment:
    """A motion that is straight in joint space, and how long it takes at the speed asked for."""

    start: ArmCoordinates
    end: ArmCoordinates
    duration_s: float

    @property
    def turns_rad(self) -> tuple[float, ...]:
        """By how much each joint turns."""
        return tuple(b - a for a, b in zip(self.start.joints, self.end.joints, strict=True))

    def steps(self, transmission: Transmission) -> tuple[float, ...]:
        """Return how far each motor turns, before any rounding."""
        before, after = (
            transmission.to_exact(each.joints, each.opening_mm) for each in (self.start, self.end)
        )
        return tuple(b - a for a, b in zip(before, after, strict=True))


class DeviceReadings:
    """What the device says of itself apart from its registers: current, inputs, outputs, grip."""

    def __init__(self, *, grip_switch: bool) -> None:
        self._grip_switch = grip_switch
        self.current = Current.UNKNOWN
        self.inputs: int | None = None
        self.sensed = 0
        """How often the inputs have been read."""
        self.awaiting = 0
        """How many calls wait for inputs: a standing arm is looked at more often then."""
        self.outputs: int | None = None
        self.gripping: bool | None = None

    def sense(self, registers: Registers) -> None:
        """Take the inputs and the current; without a grip switch nothing tells whether it grips."""
        if registers.held is not None:
            self.current = Current.HELD if registers.held else Current.OFF
        self.inputs = registers.inputs
        self.sensed += 1
        if self._grip_switch:
            self.gripping = registers.gripping


class FingerState:
    """Where the fingers touched something, or the share that a servo was told to open."""

    def __init__(self, config: ArmConfig, transmission: Transmission) -> None:
        self._config = config
        self._transmission = transmission
        self.touch_mm: float | None = None
        self.share: float | None = None

    def arrive(self, opening_mm: float) -> None:
        """Note how far the gripper is open by its motor: fingers opened past the touch let go."""
        if self.touch_mm is not None and opening_mm >= self.touch_mm:
            self.touch_mm = None

    def force_n(self, opening_mm: float) -> float:
        """Return the force with which they press, from the cable pulled in behind the touch."""
        steps_per_n = self._config.model.grip_steps_per_n
        if self.touch_mm is None or steps_per_n is None:
            return 0.0
        steps_per_mm = abs(self._transmission.motors[-1].steps_per_unit)
        return (self.touch_mm - opening_mm) * steps_per_mm / steps_per_n

    def seen_mm(self, pulled_mm: float) -> float | None:
        """Return how far apart the fingers are, from where their motor or servo has them."""
        if self._transmission.has_gripper:
            return max(pulled_mm, self.touch_mm or 0.0)
        if self.share is None:
            return None
        low, high = self._config.model.gripper_range_mm
        return low + self.share * (high - low)


def motors_of(config: ArmConfig, controller: Controller) -> Transmission:
    """Return an arm's motors. Raises `Refused` where they do not fit its controller."""
    transmission = config.model.transmission
    if transmission is None:
        raise Refused(
            f"no motor steps are known of the {config.model.title}: give steps_per_turn in "
            "an arm file of a model that has motors"
        )
    motors = len(transmission.motors)
    if motors != controller.abilities.motors:
        raise Refused(
            f"the {config.title} has {motors} motors, but its controller drives "
            f"{controller.abilities.motors}: list every motor of the controller in the arm "
            "file, or correct gripper.kind"
        )
    return transmission


class PositionLedger:
    """Where the motors of one arm are, as commanded, as acknowledged and as read back.

    `unwrap` undoes the wrap of registers near a position, as `Controller.unwrap` does.
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
        """Whether registers fell to zero in the present motion, which does not lead there."""
        self.coordinates = self.coordinates_of(still)

    @property
    def shift(self) -> Motors:
        """What the registers of the acknowledged position have to be added to."""
        return self.offset - self.slack.taken

    @property
    def expected(self) -> Motors:
        """The registers at the acknowledged position."""
        return self.acknowledged - self.shift

    def stands(self) -> None:
        """Note that nothing is under way: what is sent next begins at the acknowledged position."""
        self.slack.stand()
        self.commanded = self.acknowledged
        self.fell = False

    def sends(self, steps: Motors) -> None:
        """Note what motors are about to be sent, backlash included."""
        self.commanded = self.commanded + self.slack.sends(steps)
        self._readings.current = Current.HELD

    def takes_back(self, commanded: Motors) -> None:
        """Note that what was to be sent last was not: so far it is commanded, as it was before."""
        self.commanded = commanded
        self.slack.takes_back()

    def arrived(self, coordinates: ArmCoordinates | None) -> None:
        """Note that the motion was acknowledged, and which unrounded point it stands for."""
        self.acknowledged = self.commanded
        self.slack.arrive()
        self.coordinates = coordinates or self.coordinates_of(self.acknowledged)
        self._fingers.arrive(self.coordinates.opening_mm)

    def found(self, registers: Registers) -> None:
        """Take the registers for the position of an arm of which nothing else is known."""
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
        """Note where the motors are while they move."""
        there = self.commanded - self.offset + self.slack.ahead
        self._see(self._unwrap(registers.positions, there))

    def _see(self, counts: Motors) -> None:
        before = self.read_back if self.counts.largest and not counts.largest else None
        self.counts = counts
        self.read_back = self.acknowledged + self.slack.see(counts - self.expected)
        if before is not None:  # a motion only goes on
            ways = zip(before, self.read_back, self.commanded, strict=True)
            self.fell |= any(not min(a, c) <= b <= max(a, c) for a, b, c in ways)

    def believe_registers(self) -> None:
        """Take the read-back for the position: the motors are there, whatever was commanded."""
        if self.read_back is not None and self.read_back != self.acknowledged:
            self.acknowledged = self.read_back
            self.coordinates = self.coordinates_of(self.acknowledged)
        self.commanded = self.acknowledged  # also where nothing had moved yet
        self.slack.believe()

    def count_anew(self, registers: Motors) -> None:
        """Keep the position, and let it be what these registers mean from now on."""
        self.slack.doubt()
        self.offset = self.acknowledged - registers + self.slack.taken
        self.counts = registers
        self.commanded = self.read_back = self.acknowledged

    def refer(self, registers: Motors, there: ArmCoordinates) -> None:
        """Make the present registers mean a known posture."""
        position = there.motors(self._transmission)
        self.slack.refer()
        self.offset = position - registers + self.slack.taken
        self.counts = registers
        self.commanded = self.acknowledged = self.read_back = position
        self.coordinates = there

    def restore(self, record: Record, registers: Motors) -> bool:
        """Take up a recorded reference; False where the registers no longer agree with it."""
        self.offset = Motors(record.offset)
        recorded = Motors(record.registers)
        fits = self.slack.restore(record.taken, record.unsure)
        counts = self.counts = self._unwrap(registers, recorded)
        self.commanded = self.acknowledged = self.read_back = recorded + self.shift
        self.coordinates = self._recorded_point(record) or self.coordinates_of(self.acknowledged)
        if counts != recorded and not registers.largest:  # the counters lost the power, not the arm
            self.count_anew(registers)
        elif counts != recorded:
            self._see(counts)
            self.believe_registers()
        return counts == recorded and fits

    def _recorded_point(self, record: Record) -> ArmCoordinates | None:
        """Return the unrounded point of a record, if it stands for the same whole steps."""
        names = self.coordinates.joints.names
        if len(record.coordinates) != len(names) + 1:
            return None
        *angles, opening_mm = record.coordinates
        there = ArmCoordinates(Joints(tuple(angles), names), opening_mm)
        return there if there.motors(self._transmission) == self.acknowledged else None

    def coordinates_of(self, position: Motors) -> ArmCoordinates:
        """Return the point that whole motor steps stand for."""
        joints, opening_mm = self._transmission.to_joints(position)
        return ArmCoordinates(joints, opening_mm)
