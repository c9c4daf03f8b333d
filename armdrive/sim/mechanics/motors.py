"""Steppers that turn together, the arm that follows them, and limit switches.

Units: half-steps, seconds, half-steps per second. A rack computes the commanded counts at any time,
without ticking; the world decides whether the arm can follow.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Generic, NamedTuple, Protocol, TypeVar

from armdrive.config.arm import ArmConfig
from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody
from kinematics.spaces import Motors
from kinematics.transmission import Transmission

# Tolerance for floating-point rounding, as a share of a step.
_ROUNDING = 1e-6


@dataclass(frozen=True, slots=True)
class Motion:
    """Steps for every motor: the one with the most steps makes one each `interval_s`.

    Motors turn `in_proportion`, or each at the full rate until its own steps are made.
    """

    deltas: tuple[int, ...]
    interval_s: float
    start_s: float
    """One interval before the first step."""
    in_proportion: bool = True
    busiest: int = field(init=False)
    """The steps of the motor with the most steps."""
    done_s: float = field(init=False)
    """When the last step has been made."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "busiest", max(abs(delta) for delta in self.deltas))
        object.__setattr__(self, "done_s", self.step_s(self.busiest))

    def step_s(self, number: int) -> float:
        """Return when the busiest motor makes a step; its first one is number 1."""
        return self.start_s + number * self.interval_s

    def count(self, now_s: float) -> int:
        """Return how many steps the busiest motor has made by now."""
        count = math.floor((now_s - self.start_s) / self.interval_s + _ROUNDING)
        return min(max(count, 0), self.busiest)

    def made(self, now_s: float) -> tuple[int, ...]:
        """Return the whole steps that each motor has made by now."""
        if now_s >= self.done_s:
            return self.deltas
        count = self.count(now_s)
        if not self.in_proportion:
            return tuple(max(-count, min(delta, count)) for delta in self.deltas)
        return tuple(
            (abs(delta) * count // self.busiest) * (1 if delta > 0 else -1) for delta in self.deltas
        )

    def bends(self) -> list[float]:
        """Return when motors fall out of step, one by one; those in proportion never do."""
        if self.in_proportion:
            return []
        return sorted({self.step_s(abs(delta)) for delta in self.deltas if delta})


class MotorRack:
    """The position counts of all motors, and the motion under way."""

    def __init__(self, counts: Sequence[int]) -> None:
        self._counts = tuple(counts)
        self._motion: Motion | None = None
        self._last_step_s = -math.inf

    @property
    def moving(self) -> bool:
        """Whether a motion is under way, or has ended and not been taken in by `settle`."""
        return self._motion is not None

    @property
    def done_s(self) -> float:
        """When the motion under way ends; infinity while there is none."""
        return math.inf if self._motion is None else self._motion.done_s

    def start(
        self, deltas: Sequence[int], interval_s: float, now_s: float, *, in_proportion: bool = True
    ) -> None:
        """Begin to turn all motors by `deltas`; a motion under way is cut short.

        Motors in proportion make their first step after an interval. The others make it at once, or
        an interval after the last step of the previous motion.
        """
        self.stop(now_s)
        start_s = now_s
        if not in_proportion and any(deltas):
            start_s = max(now_s, self._last_step_s + interval_s) - interval_s
        self._motion = Motion(tuple(deltas), interval_s, start_s, in_proportion)

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return the counts at a moment."""
        if self._motion is None:
            return self._counts
        made = self._motion.made(now_s)
        return tuple(count + step for count, step in zip(self._counts, made, strict=True))

    def bends(self, start_s: float, end_s: float) -> list[float]:
        """Return when motors fall out of step, between two times."""
        bends = self._motion.bends() if self._motion else ()
        return [bend for bend in bends if start_s < bend < end_s]

    def settle(self, now_s: float) -> None:
        """Fold a finished motion into the counts."""
        if self.done_s <= now_s:
            self.stop(now_s)

    def stop(self, now_s: float) -> None:
        """End the motion where it is now."""
        self._counts = self.positions(now_s)
        if self._motion is not None and (made := self._motion.count(now_s)):
            self._last_step_s = self._motion.step_s(made)
        self._motion = None

    def count(self, deltas: Sequence[int]) -> None:
        """Add steps that were made outside any motion."""
        self._counts = tuple(a + b for a, b in zip(self._counts, deltas, strict=True))

    def zero(self) -> None:
        """Set the counts to zero. Nothing turns."""
        self._counts = (0,) * len(self._counts)
        self._motion = None


# --- The controller's counting and the arm, kept in step on one clock ----------------------------
# A rack computes where its motors stand at any time: `MotorRack` turns them at one rate,
# `UncoordinatedRack` each by itself, `PathRack` along queued lines.


class Rack(Protocol):
    """The counts of all motors at any time, without ticking."""

    @property
    def moving(self) -> bool:
        """Whether a motion is under way, or has ended since the last call of `settle`."""

    @property
    def done_s(self) -> float:
        """When the motion under way ends; infinity while there is none."""

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return the counts at a time, which must not precede that of an earlier change."""

    def bends(self, start_s: float, end_s: float) -> Iterable[float]:
        """Return the times in between at which the motors leave a straight path, in order."""

    def settle(self, now_s: float) -> None:
        """Fold finished motion into the counts."""

    def stop(self, now_s: float) -> None:
        """End all motion dead where it is now."""

    def count(self, deltas: Sequence[int]) -> None:
        """Add steps made outside any motion, while standing."""

    def zero(self) -> None:
        """Set the counts to zero. Nothing turns."""


R = TypeVar("R", bound=Rack)


class MotorDrive(Generic[R]):
    """Turns motors: the rack counts what was commanded, and the world applies it to the arm.

    A dialect's device starts motions on `rack` itself, after `energise`.
    """

    def __init__(self, world: World, rack: R) -> None:
        self.world = world
        self.rack = rack
        self._driven = Motors(rack.positions(0.0))
        self._looked_s = 0.0

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
        return self.rack.moving

    @property
    def done_s(self) -> float:
        """When the motion under way ends; infinity while there is none."""
        return self.rack.done_s

    @property
    def counts(self) -> Motors:
        """The commanded counts as of the last `follow`."""
        return self._driven

    def energise(self) -> None:
        """Switch the motors' current on."""
        self.world.energised = True

    def follow(self, now_s: float) -> None:
        """Move the physical arm to where the motors have turned it by now.

        A device calls this whenever its clock advances, moving or not, so that a motion is followed
        from its very start.
        """
        if self.rack.moving:
            for bend_s in self.rack.bends(self._looked_s, now_s):
                self._follow(bend_s)
            self._follow(now_s)
        self._looked_s = now_s

    def settle(self, now_s: float) -> None:
        """Fold finished motion into the counts."""
        self.follow(now_s)
        self.rack.settle(now_s)

    def stop(self, now_s: float) -> None:
        """End the motion dead where it is now."""
        self.follow(now_s)
        self.rack.stop(now_s)

    def turn(self, steps: Sequence[int], now_s: float) -> None:
        """Turn motors from the pendant: counted, with the current on, and at once."""
        self.stop(now_s)
        self.energise()
        self.rack.count(steps)
        self._follow(now_s)

    def set_counts(self, counts: Sequence[int], now_s: float) -> None:
        """Set the counts. Nothing turns."""
        self.stop(now_s)
        self.rack.zero()
        self.rack.count(counts)
        self._driven = Motors(counts)

    def lose_power(self, now_s: float) -> None:
        """Stop dead, let the motors go, and set the counts to zero."""
        self.set_counts((0,) * len(self.world.motors), now_s)
        self.world.cut_current(now_s)

    def _follow(self, now_s: float) -> None:
        positions = self.rack.positions(now_s)
        if positions != self._driven:
            counts = Motors(positions)
            steps = counts - self._driven
            self._driven = counts
            self._turn(steps, now_s)

    def _turn(self, steps: Motors, now_s: float) -> None:
        """Make the arm follow steps that the rack has counted."""
        self.world.drive(steps, now_s)


class CoordinatedDrive(MotorDrive[MotorRack]):
    """All motors in proportion, at a constant rate."""

    def __init__(self, world: World) -> None:
        super().__init__(world, MotorRack((0,) * len(world.motors)))

    def start(self, steps: Sequence[int], rate_hz: float, now_s: float) -> None:
        """Begin to turn all motors in proportion, with the current on."""
        self.energise()
        self.rack.start(steps, 1.0 / rate_hz, now_s)


# --- Limit switches: one for each motor, at one end of its travel ---------------------------------


class SwitchState(Enum):
    """How a limit switch behaves."""

    FREE = "free"
    """Follows the arm; works normally."""
    OPEN = "open"
    """Stuck open: never reads as pressed."""
    CLOSED = "closed"
    """Stuck closed: always reads as pressed."""


class LimitSwitch:
    """A switch that a motor presses, at a position and beyond in a direction.

    It depends on where the motor stands (`position`, in steps), and on no register.
    """

    def __init__(self, position: Callable[[], int], at: int, way: int = 1) -> None:
        self.at, self.way = at, way
        """The first position that presses it, and the direction of those beyond: 1 or -1."""
        self.state = SwitchState.FREE
        self._position = position

    @property
    def opens_at(self) -> int:
        """The position nearest to the switch that does not press it."""
        return self.at - self.way

    @property
    def pressed(self) -> bool:
        """Whether the controller sees it pressed."""
        if self.state is not SwitchState.FREE:
            return self.state is SwitchState.CLOSED
        return (self._position() - self.at) * self.way >= 0

    def steps_to(self, way: int) -> int | None:
        """Return how many steps in a direction press it; None if none ever do."""
        if self.pressed:
            return 0
        missing = (self.at - self._position()) * way
        return missing if missing > 0 and self.state is SwitchState.FREE else None


class SwitchPlace(NamedTuple):
    """The first position at which a motor presses its switch, and its way there: 1 or -1."""

    at: int
    way: int


def switch_places(
    config: ArmConfig, turning: Transmission, beyond: Sequence[int]
) -> list[SwitchPlace]:
    """Return where each motor meets its switch: `beyond` steps after the end of homing.

    A motor turns that way from where a new arm is found. So that posture presses no switch, and
    homing can end where the arm file says. If that does not say where homing ends, the switches are
    at the upper end of each motor's travel.
    """
    if config.homing is not None:
        homed = turning.to_motors(config.homing.joints, config.homing.opening_mm)
        found = World(ArmBody.of_preset(config.model)).motors
        ways = [1 if there >= here else -1 for here, there in zip(found, homed, strict=True)]
        return [
            SwitchPlace(there + way * steps, way)
            for there, way, steps in zip(homed, ways, beyond, strict=True)
        ]
    bounds = [(one.low_rad, one.high_rad) for one in config.model.arm.limits]
    bounds.append(config.model.gripper_range_mm)
    highest = (
        sum(max(share * low, share * high) for share, (low, high) in zip(row, bounds, strict=False))
        for row in turning.matrix
    )
    return [
        SwitchPlace(math.ceil(most + motor.offset_steps), 1)
        for most, motor in zip(highest, turning.motors, strict=True)
    ]
