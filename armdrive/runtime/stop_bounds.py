"""Stop bounds: how long and how far the fingertips move on after a stop, or after the host dies.

The controller bounds the time, and how much more of its motion the device performs in that time.
Each joint turns at its speed in the planned motion, or, without a plan, at its limit or that of its
motors, whichever is lower. On a device that does not coordinate its motors, each motor turns by
itself instead. Rounding adds one step per motor.

The distance of the tip is bounded in two ways, and the smaller bound is announced:

- By levers: each joint turns the tip about its axis, at the tip's distance from that axis. The
  distance grows by the travel of the joints farther out, but never beyond the arm's reach.
- By directions: in the present posture, each joint moves the tip in its own direction. If the
  directions stayed the same, the farthest corner of their sum would be the bound. They change as
  the arm turns, at most at the rate given by the levers; half of that change is added.

Without a known posture, the first bound is used with the arm stretched out.

While a device homes by itself, each motor that homes may turn as long as the controller says, but
no farther than to its switch, which stands within its joints' range.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, replace

from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import OVERTRAVEL, Controller, StopPart, Stopping
from armdrive.runtime.position import MotionSegment
from armdrive.tasks import HomeDevice
from kinematics.frames.vectors import Vector
from kinematics.geometry import ArmGeometry
from kinematics.spaces import Joints
from kinematics.transmission import Transmission

ROUNDING_STEPS = 1.0  # a motor starts and ends on whole steps, so it may turn one step more
PROBE_RAD = 1e-6  # turn each joint by this angle to find how it moves the tip
LEAST_S = 1e-9  # shortest duration of a part of a motion
LEAST_HZ = 1e-6  # lowest rate of a motor

# The angle that each joint turns when one joint or one motor moves, in rad.
Turn = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class StopBound:
    """The worst case at this moment, for a stop and for a host that dies (`silent`).

    A pause is bounded like the death of the host: the device finishes what it was sent.
    """

    time_s: float
    distance_mm: float
    silent_time_s: float
    silent_distance_mm: float


@dataclass(frozen=True, slots=True)
class StopStretch:
    """A part of a planned motion, with the highest speed of each joint and each motor."""

    part: StopPart
    joints_rad_s: tuple[float, ...]
    motors_hz: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Turns:
    """The turns that may happen after a stop, each in either direction.

    `each` are the turns of the motion itself, `extra` those that rounding and braking add.
    """

    each: tuple[Turn, ...]
    extra: tuple[Turn, ...]


@dataclass(frozen=True, slots=True)
class RunOn:
    """How long an arm moves on, and which turns happen meanwhile, in any posture."""

    time_s: float
    turns: Turns
    silent_time_s: float
    silent_turns: Turns

    def bound(self, config: ArmConfig, joints: Joints | None) -> StopBound:
        """Return the bound for the tip in a posture; for the worst posture if it is unknown."""
        arm = config.model.arm
        moves = None if joints is None else _tip_moves(arm, joints)
        ways_mm = (_way_mm(arm, joints, moves, turns) for turns in (self.turns, self.silent_turns))
        asked_mm, silent_mm = ways_mm
        return StopBound(self.time_s, asked_mm, self.silent_time_s, silent_mm)


def homing_run_on(
    config: ArmConfig, controller: Controller, burst_s: float, request: HomeDevice
) -> RunOn:
    """Return how an arm moves on while its device homes by itself: after a stop, as always."""
    stop, search = run_on(config, controller, burst_s), controller.search(request)
    homing = {motor for group in request.groups for motor in group}
    rows, each = _inverse(config), []
    for motor, range_steps in enumerate(config.motor_ranges):
        if motor in homing or not homing:
            steps = min(OVERTRAVEL * range_steps, search.most_steps)
            each.append(_times(tuple(row[motor] for row in rows), steps))
    return replace(
        stop, silent_time_s=search.time_s, silent_turns=Turns(tuple(each), stop.turns.extra)
    )


def homing_bound(config: ArmConfig, controller: Controller) -> StopBound | None:
    """Return the bound for the worst group of the controller's own homing, in any posture.

    None if the arm has no such homing.
    """
    if config.homing is None or not controller.abilities.own_homing:
        return None
    found = [
        homing_run_on(config, controller, config.motion.jog_burst_s, request).bound(config, None)
        for request in config.homing.requests()
    ]
    return StopBound(*(max(each) for each in zip(*map(astuple, found), strict=True)))


def stop_bound(config: ArmConfig, controller: Controller, burst_s: float) -> StopBound:
    """Return the bound for any command, in any posture."""
    return run_on(config, controller, burst_s).bound(config, None)


class StopForecast:
    """The stop bound of one arm, based on its planned motion if there is one."""

    def __init__(self, config: ArmConfig, transmission: Transmission) -> None:
        self._config = config
        self._transmission = transmission
        self.burst_s = config.motion.jog_burst_s
        """The longest motion that is sent ahead."""
        self.cut_off_s = 0.0
        """The longest motion that the device may still have held when the link was lost."""
        self._planned: RunOn | None = None
        self._homing: HomeDevice | None = None
        """The homing that the device carries out by itself."""
        self._bound: tuple[RunOn, Joints | None, StopBound] | None = None
        """The latest bound, cached because most polls find the arm at rest."""

    def plan(self, controller: Controller, legs: Iterable[MotionSegment], burst_s: float) -> None:
        """Base the bound on a planned motion until `end`."""
        self.burst_s = burst_s
        found = stretches(self._transmission, legs)
        self._planned = run_on(self._config, controller, burst_s, found) if found else None

    def home(self, request: HomeDevice) -> None:
        """Base the bound on the device's own homing until `end`, or until it is found again."""
        self._homing = request

    def end(self) -> None:
        """Base the bound on arbitrary commands."""
        self.burst_s = self._config.motion.jog_burst_s
        self._planned = self._homing = None

    def cut_off(self) -> None:
        """Handle the loss of the link during a motion: the device finishes what it was sent."""
        self.cut_off_s = max(self.cut_off_s, self.burst_s)

    def found(self) -> None:
        """Handle a device that was found again: what it was sent has ended, and so has homing."""
        self.cut_off_s, self._homing = 0.0, None

    def sent_s(self, controller: Controller) -> float:
        """Return how long a cut-off device drives what it was sent, if it does not home.

        To find a device again ends its homing on most boards, so that is not waited for.
        """
        return controller.stopping(max(self.burst_s, self.cut_off_s)).silent_s

    def bound(
        self, controller: Controller, joints: Joints | None, *, lost: bool, slowed: bool
    ) -> StopBound:
        """Return how long and how far the tip moves on; for the worst posture if it is unknown.

        The plan no longer applies to a motion that was `slowed` or whose link is `lost`. While the
        device homes, the arm leaves its known posture.
        """
        if self._homing is not None:
            joints = None
        burst_s = max(self.burst_s, self.cut_off_s) if lost else self.burst_s
        planned = None if lost or slowed else self._planned
        if planned is None:
            homing = self._homing
            inputs = self._config, controller, burst_s
            planned = run_on(*inputs) if homing is None else homing_run_on(*inputs, homing)
        if self._bound is None or self._bound[:2] != (planned, joints):
            self._bound = planned, joints, planned.bound(self._config, joints)
        return self._bound[2]


def stretches(transmission: Transmission, legs: Iterable[MotionSegment]) -> tuple[StopStretch, ...]:
    """Return the parts of a planned motion in which a motor turns."""
    found = []
    for leg in legs:
        duration_s = max(leg.duration_s, LEAST_S)
        motors_hz = tuple(abs(steps) / duration_s for steps in leg.steps(transmission))
        joints_rad_s = tuple(abs(turn) / duration_s for turn in leg.turns_rad)
        if max(motors_hz) > 0.0:
            found.append(StopStretch(StopPart(duration_s, max(motors_hz)), joints_rad_s, motors_hz))
    return tuple(found)


def run_on(
    config: ArmConfig, controller: Controller, burst_s: float, planned: Sequence[StopStretch] = ()
) -> RunOn:
    """Return how an arm moves on after a stop, in a planned motion or after any command."""
    whole = controller.stopping(burst_s, [stretch.part for stretch in planned])
    # Each stretch with its own run-on: the fastest joint may belong to another stretch than the
    # one that takes longest to stop.
    ways: list[tuple[StopStretch, Stopping]]
    if planned or not controller.abilities.coordinated:
        alone = planned or _single_motors(config, controller)
        ways = [(each, controller.stopping(burst_s, (each.part,))) for each in alone]
    else:
        ways = [(_at_limits(config, controller), whole)]
    free = not controller.abilities.coordinated
    asked = [
        _turned(config, one, found.asked_motion_s, found.asked_extra_steps, free=free)
        for one, found in ways
    ]
    silent = [
        _turned(config, one, found.silent_motion_s, found.silent_extra_steps, free=free)
        for one, found in ways
    ]
    return RunOn(whole.asked_s, _widest(asked), whole.silent_s, _widest(silent))


# -- which joints turn, and how far -------------------------------------------------------------


def _at_limits(config: ArmConfig, controller: Controller) -> StopStretch:
    """Return a motion of all joints, each as fast as its limit and its motors allow."""
    limits = config.model.joint_speeds_rad_s
    fastest_hz = controller.usable_rate_hz(math.inf)
    rows = _inverse(config)
    turns = (fastest_hz * math.fsum(map(abs, row)) for row in rows)
    speeds = tuple(min(limit, turn) for limit, turn in zip(limits, turns, strict=False))
    return StopStretch(StopPart(math.inf, fastest_hz), speeds, (fastest_hz,) * len(rows[0]))


def _single_motors(config: ArmConfig, controller: Controller) -> list[StopStretch]:
    """Return a motion of each motor alone, as fast as the motor and its joints may turn."""
    transmission = config.transmission
    speeds = (*config.model.joint_speeds_rad_s, config.model.gripper_speed_mm_s)
    motors, found = range(len(transmission.motors)), []
    for motor, wanted_hz in enumerate(transmission.most_steps(speeds)):
        rate_hz = max(min(wanted_hz, controller.usable_rate_hz(math.inf)), LEAST_HZ)
        rates_hz = tuple(rate_hz if index == motor else 0.0 for index in motors)
        found.append(
            StopStretch(StopPart(math.inf, rate_hz), config.model.joint_speeds_rad_s, rates_hz)
        )
    return found


def _turned(
    config: ArmConfig, stretch: StopStretch, motion_s: float, extra_steps: float, *, free: bool
) -> Turns:
    """Return the turns in `motion_s` of a motion; if motors are `free`, each motor separately."""
    rates = list(zip(zip(*_inverse(config), strict=True), stretch.motors_hz, strict=True))
    if free:
        each = tuple(_times(column, rate_hz * motion_s) for column, rate_hz in rates)
    else:
        count = len(stretch.joints_rad_s)
        each = tuple(
            tuple(speed * motion_s if index == joint else 0.0 for index in range(count))
            for joint, speed in enumerate(stretch.joints_rad_s)
        )
    extra = tuple(
        _times(column, ROUNDING_STEPS + extra_steps if rate_hz else ROUNDING_STEPS)
        for column, rate_hz in rates
    )
    return Turns(each, extra)


def _inverse(config: ArmConfig) -> tuple[tuple[float, ...], ...]:
    """Return the joint angles per motor step, one row per joint."""
    transmission = config.transmission
    return tuple(map(tuple, transmission.inverse[: len(transmission.joint_names)]))


def _times(turn: Turn, factor: float) -> Turn:
    return tuple(one * factor for one in turn)


def _widest(found: Sequence[Turns]) -> Turns:
    """Return the largest of several turns for each joint or motor."""
    return Turns(
        tuple(max(same, key=_size) for same in zip(*(turns.each for turns in found), strict=True)),
        tuple(max(same, key=_size) for same in zip(*(turns.extra for turns in found), strict=True)),
    )


def _size(turn: Turn) -> float:
    return max(map(abs, turn), default=0.0)


# -- how far the tip moves ----------------------------------------------------------------------


def _tip_moves(arm: ArmGeometry, joints: Joints) -> tuple[Vector, ...]:
    """Return the tip's displacement in mm per rad of each joint."""
    here = _tip(arm, joints)
    moves = []
    for index, name in enumerate(joints.names):
        there = _tip(arm, joints.replace(**{name: joints[index] + PROBE_RAD}))
        x, y, z = ((b - a) / PROBE_RAD for a, b in zip(here, there, strict=True))
        moves.append((x, y, z))
    return tuple(moves)


def _tip(arm: ArmGeometry, joints: Joints) -> Vector:
    pose = arm.fk(joints)
    return pose.x_mm, pose.y_mm, pose.z_mm


def _way_mm(
    arm: ArmGeometry, joints: Joints | None, moves: tuple[Vector, ...] | None, turns: Turns
) -> float:
    """Return the smaller of the two bounds of the tip's distance."""
    each_rad = [
        math.fsum(abs(turn[joint]) for turn in (*turns.each, *turns.extra))
        for joint in range(len(arm.joint_names))
    ]
    longest_mm = arm.levers_mm(None)
    by_levers_mm = _by_levers_mm(each_rad, arm.levers_mm(joints), longest_mm)
    if moves is None:
        return by_levers_mm
    straight_mm = _furthest_mm([_moved(moves, turn) for turn in turns.each])
    straight_mm += math.fsum(math.hypot(*_moved(moves, turn)) for turn in turns.extra)
    return min(by_levers_mm, straight_mm + _bent_mm(each_rad, longest_mm))


def _by_levers_mm(
    each_rad: Sequence[float], levers_mm: Sequence[float], longest_mm: Sequence[float]
) -> float:
    way_mm = 0.0
    for turn_rad, lever_mm, most_mm in reversed(
        list(zip(each_rad, levers_mm, longest_mm, strict=True))
    ):
        if lever_mm > 0.0:
            # the chord: a tip that is turned far comes back on the other side
            half = math.sin(min(turn_rad, math.pi) / 2.0)
            way_mm += 2.0 * half * min(lever_mm + way_mm, most_mm)
    return way_mm


def _moved(moves: Sequence[Vector], turn: Turn) -> Vector:
    """Return the tip's displacement by a turn, with the present directions."""
    x, y, z = (
        math.fsum(move[axis] * angle for move, angle in zip(moves, turn, strict=True))
        for axis in range(3)
    )
    return x, y, z


def _furthest_mm(ways: Sequence[Vector]) -> float:
    """Return the longest sum of displacements, each taken in one direction or the other."""
    corners = [(0.0, 0.0, 0.0)]
    for x, y, z in ways:
        if x or y or z:
            corners += [(a - 2.0 * x, b - 2.0 * y, c - 2.0 * z) for a, b, c in corners]
            corners = [(a + x, b + y, c + z) for a, b, c in corners]
    return max(math.hypot(*corner) for corner in corners)


def _bent_mm(each_rad: Sequence[float], longest_mm: Sequence[float]) -> float:
    """Bound the effect of changing directions: half of the sum of their second derivatives.

    The second derivative for two joints is at most the lever of the outer joint.
    """
    total_mm, inner_rad = 0.0, 0.0
    for turn_rad, lever_mm in zip(each_rad, longest_mm, strict=True):
        total_mm += turn_rad * lever_mm * (turn_rad / 2.0 + inner_rad)
        inner_rad += turn_rad
    return total_mm


def deviation_mm(config: ArmConfig, joints: Joints, steps: Sequence[float]) -> float:
    """Bound the tip's deviation from its path if each motor deviates by this many steps."""
    turns_rad = (
        math.fsum(abs(share) * one for share, one in zip(row, steps, strict=True))
        for row in config.transmission.inverse
    )
    levers_mm = config.model.arm.levers_mm(joints)
    return math.fsum(turn * lever for turn, lever in zip(turns_rad, levers_mm, strict=False))
