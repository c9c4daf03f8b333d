"""The law of arrival: where a successful call has to bring the arm. Each class is one kind of aim.

An aim follows from the request and the posture before the call; the driver is not asked. Kinematics
and transmission give the motors' steps, and how far off rounding to whole steps may leave them.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from armdrive.motion.jog import Jogged
from kinematics import Joints, Motors, Pose, Transmission

from .physical import WatchedWorld

ROUNDED_STEPS = 0.5
"""How far a motor on a whole step may be from an exact angle."""
ALMOST = 1e-6
"""The error of floating point sums."""
TRIP_STEPS = 4
"""A grasp closes two steps at a time until the switch trips, which it does on a whole step."""


@dataclass(frozen=True, slots=True)
class JointsAim:
    """Some joints at new angles, or the fingers at a new opening; everything else stays.

    `start` is where the motors stood before the call. `near` is how many counts a
    resting drive may be off its target. With `clipped`, a jog whose result has a note may end
    anywhere on the way.
    """

    start: Motors
    angles_rad: Mapping[str, float]
    opening_mm: float | None = None
    near: int = 0
    clipped: bool = False

    def goal(self, transmission: Transmission) -> Motors:
        """Return where the motors have to stand."""
        joints, opening_mm = transmission.to_joints(self.start)
        if self.opening_mm is not None:
            opening_mm = self.opening_mm
        return transmission.to_motors(joints.replace(**self.angles_rad), opening_mm)

    def tolerance(self, transmission: Transmission) -> tuple[float, ...]:
        """Return how far each motor may be from the goal, in steps.

        The goal and the place are both rounded to steps. A joint that stays keeps its exact angle,
        from which `start` may differ by rounding.
        """
        count = len(transmission.joint_names)
        stays = [name not in self.angles_rad for name in transmission.joint_names]
        stays += [self.opening_mm is None] * (len(transmission.motors) - count)
        before = max(ROUNDED_STEPS, self.near)
        found = []
        for row in transmission.matrix:
            carried = math.fsum(
                abs(
                    math.fsum(
                        share * transmission.inverse[axis][motor]
                        for axis, share in enumerate(row)
                        if stays[axis]
                    )
                )
                for motor in range(len(row))
            )
            found.append(2.0 * ROUNDED_STEPS + before * carried + self.near + ALMOST)
        return tuple(found)

    def missed(self, world: WatchedWorld, result: object, excused: Collection[int]) -> str:
        """Compare every motor with the goal, or with the way there if the jog was clipped."""
        transmission = world.body.transmission
        goal, there = self.goal(transmission), world.motors
        on_the_way = self.clipped and isinstance(result, Jogged) and bool(result.note)
        start = self.start if on_the_way else goal
        off = {
            motor + 1: here
            for motor, (here, a, b, most) in enumerate(
                zip(there, start, goal, self.tolerance(transmission), strict=True)
            )
            if motor not in excused and not min(a, b) - most <= here <= max(a, b) + most
        }
        if not off:
            return ""
        return f"motors {sorted(off)} stand at {tuple(there)}, and the goal is at {tuple(goal)}"


@dataclass(frozen=True, slots=True)
class PoseAim:
    """A pose of the tip, in any posture.

    With `clipped`, a jog whose result has a note may end anywhere between the first pose and the
    goal.
    """

    start: Motors
    goal: Pose
    near: int = 0
    clipped: bool = False
    deviation_mm: float = 0.0
    """How far from the straight line a clipped jog may end."""

    def missed(self, world: WatchedWorld, result: object, excused: Collection[int]) -> str:
        """Compare the tip with the requested pose."""
        if excused:
            return ""  # every motor moves the tip
        body = world.body
        joints, _ = body.transmission.to_joints(world.motors)
        here = body.arm.fk(joints)
        rounded = ROUNDED_STEPS + self.near
        turns_rad = [
            math.fsum(map(abs, row)) * rounded + ALMOST
            for row, _ in zip(body.transmission.inverse, joints, strict=False)
        ]
        levers_mm = body.arm.levers_mm(joints)
        most_mm = math.fsum(a * b for a, b in zip(turns_rad, levers_mm, strict=True)) + ALMOST
        goal = self.goal
        if self.clipped and isinstance(result, Jogged) and result.note:
            first = body.arm.fk(body.transmission.to_joints(self.start)[0])
            goal = nearest_between(first, goal, here)
            most_mm += self.deviation_mm
        off_mm = math.dist((here.x_mm, here.y_mm, here.z_mm), (goal.x_mm, goal.y_mm, goal.z_mm))
        if off_mm > most_mm:
            return f"the tip is at {here}, {off_mm:.1f} mm from {goal}"
        most_rad = math.fsum(turns_rad)
        angles = ("pitch_rad", "roll_rad")
        off_rad = max(
            abs(math.remainder(getattr(here, name) - getattr(goal, name), math.tau))
            for name in angles
        )
        if off_rad > most_rad:
            return f"the hand points {math.degrees(off_rad):.1f} degrees away from {goal}: {here}"
        return ""


def nearest_between(start: Pose, goal: Pose, here: Pose) -> Pose:
    """Return the pose between `start` and `goal` whose point is nearest to `here`."""
    way = [getattr(goal, name) - getattr(start, name) for name in ("x_mm", "y_mm", "z_mm")]
    made = [getattr(here, name) - getattr(start, name) for name in ("x_mm", "y_mm", "z_mm")]
    long2 = math.fsum(each * each for each in way)
    share = math.fsum(a * b for a, b in zip(way, made, strict=True)) / long2 if long2 else 0.0
    share = min(max(share, 0.0), 1.0)
    return Pose(
        start.x_mm + share * way[0],
        start.y_mm + share * way[1],
        start.z_mm + share * way[2],
        start.pitch_rad + share * math.remainder(goal.pitch_rad - start.pitch_rad, math.tau),
        start.roll_rad + share * math.remainder(goal.roll_rad - start.roll_rad, math.tau),
    )


@dataclass(frozen=True, slots=True)
class PostureAim:
    """The reference posture, by the physical motors: a person has brought the arm there."""

    joints: Joints
    opening_mm: float
    near: int

    def missed(self, world: WatchedWorld, result: object, excused: Collection[int]) -> str:
        """Compare the motors with the posture."""
        goal = world.body.transmission.to_motors(self.joints, self.opening_mm)
        off = [
            motor + 1
            for motor, (here, there) in enumerate(zip(world.motors, goal, strict=True))
            if abs(here - there) > self.near and motor not in excused
        ]
        return f"motors {off} stand at {tuple(world.motors)}, not at {tuple(goal)}" if off else ""


@dataclass(frozen=True, slots=True)
class GraspAim:
    """A grasp: the result is the width of what is between the fingers, and they press it."""

    def missed(self, world: WatchedWorld, result: object, excused: Collection[int]) -> str:
        """Compare the measured width with that of the block; 0 if there is none."""
        if excused or not isinstance(result, float):
            return ""
        if not world.grip_switch:
            return f"the fingers press with {world.grip_force_n:.1f} N, and hold nothing"
        wide_mm = world.scene.contact_mm
        if abs(result - wide_mm) > TRIP_STEPS / world.body.grip_steps_per_mm:
            return f"{result:.2f} mm were measured, and {wide_mm:.2f} mm are between the fingers"
        return ""
