"""Jogs in random grounds: the probes, the ground, the trials.

The trials measure the physical arm: how far beyond a limit or a guard it ever was, how far before
the bound it came to rest, and how long it took to move back.
"""

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass, replace

from armdrive import Jog
from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.motion.frames import axes_of
from armdrive.moves import CARTESIAN_AXES, GRIPPER_AXIS, Space
from armdrive.registry import simulate
from armdrive.runtime.position import ArmCoordinates
from armdrive.status import State
from kinematics import Joints, Pose
from kinematics.guards.shapes import Box

GRID_MM, GRID_RAD = 0.02, math.radians(0.02)
GRID_POINTS = 800


class Probe:
    """Measures postures of one arm."""

    def __init__(self, config: ArmConfig) -> None:
        self.config = config
        self.geometry = config.model.arm
        self.guarded = config.model.guards.over(self.geometry)
        assert config.model.transmission is not None
        self.transmission = config.model.transmission

    def over_steps(self, joints: Joints) -> float:
        """Return how many steps the physical arm is beyond the bound that it passes furthest."""
        found = [0.0]
        for bounds, row, angle in zip(
            self.geometry.limits, self.transmission.inverse, joints, strict=False
        ):
            found.append(abs(angle - bounds.clamp(angle)) / sum(map(abs, row)))
        beyond_mm = -self.guarded.room_mm(joints)
        found.append(beyond_mm / self._step_mm(joints))
        return max(found)

    def _step_mm(self, joints: Joints) -> float:
        """Return how far the tip travels at most by one step of every motor."""
        levers = self.geometry.levers_mm(joints)
        rows = zip(self.transmission.inverse, levers, strict=False)
        return sum(sum(map(abs, row)) * lever for row, lever in rows)

    def left_steps(self, jog: Jog, joints: Joints, opening_mm: float) -> float | None:
        """Return how many steps the arm could go on as it was going; None where it is very far."""
        here = ArmCoordinates(joints, opening_mm)
        furthest = here
        for there in self.onwards(jog, here):
            if there is None or self.config.model.guards.violations(self.geometry, there.joints):
                exact = self.transmission.to_exact(furthest.joints, furthest.opening_mm)
                before = self.transmission.to_exact(joints, opening_mm)
                return max(abs(b - a) for a, b in zip(before, exact, strict=True))
            furthest = there
        return None

    def onwards(
        self, jog: Jog, here: ArmCoordinates, grid_mm: float = GRID_MM
    ) -> Iterator[ArmCoordinates | None]:
        if jog.space is Space.JOINT:
            yield from self._joints_onwards(jog, here)
            return
        arm, pose = self.geometry, self.geometry.fk(here.joints)
        axes = axes_of(self.config, here.joints, jog.frame)
        amounts = [jog.amount(name) for name in CARTESIAN_AXES]
        x, y, z = (sum(a * v[i] for a, v in zip(amounts, axes, strict=False)) for i in range(3))
        turn = math.radians(45.0) / self.config.motion.tip_speed_mm_s
        before = here.joints
        for point in range(1, GRID_POINTS):
            s = point * grid_mm
            goal = Pose(
                pose.x_mm + x * s,
                pose.y_mm + y * s,
                pose.z_mm + z * s,
                pose.pitch_rad + amounts[3] * s * turn,
                pose.roll_rad + amounts[4] * s * turn,
            )
            joints = arm.solve(goal, before)
            if joints is None or math.dist(joints, before) > 0.5:
                yield None
                return
            before = joints
            yield ArmCoordinates(joints, here.opening_mm)

    def _joints_onwards(self, jog: Jog, here: ArmCoordinates) -> Iterator[ArmCoordinates | None]:
        """Yield points until the last of the axes is at its end: the others go on without it."""
        low_mm, high_mm = self.config.model.gripper_range_mm
        limits = self.geometry.limits
        going = {name: amount for name, amount in jog.axes if amount}
        for point in range(1, GRID_POINTS):
            angles, ended = list(here.joints), 0
            opening_mm = here.opening_mm
            for name, amount in going.items():
                if name == GRIPPER_AXIS:
                    wanted = here.opening_mm + amount * point * GRID_MM
                    opening_mm = min(max(wanted, low_mm), high_mm)
                    ended += opening_mm != wanted
                    continue
                index = here.joints.names.index(name)
                wanted = here.joints[index] + amount * point * GRID_RAD
                angles[index] = limits[index].clamp(wanted)
                ended += angles[index] != wanted
            yield ArmCoordinates(Joints(tuple(angles)), opening_mm)
            if ended == len(going):
                yield None
                return


WALL = Box("wall", (-500.0, 250.0, -10.0), (500.0, 254.0, 700.0))
RADII_MM = (35.0, 30.0, 25.0)
NEAR_S = 0.8
"""A joint starts so near to its limit, at the speed that the device makes of full speed."""

COARSE_MM = 1.0
CLEAR_MM = 3.0


class Stand:
    """One simulated arm that is put into postures drawn at random, and jogs that lead to bounds.

    `share` is what the device makes of full speed.
    """

    share = 1.0

    def __init__(self, dialect: str, seed: int, *, over_base: bool = False) -> None:
        config = simulated_config(dialect)
        guards = replace(config.model.guards, radii_mm=RADII_MM, boxes=(WALL,))
        if over_base:
            guards = replace(guards, inner_radius_mm=None, hand_wrist_radius_mm=None)
        self.config = replace(config, model=replace(config.model, guards=guards))
        self.draw = random.Random(f"{seed} {dialect} {over_base}")
        self.twin = simulate(self.config)
        self.arm: Arm = Arm(connect_simulated(self.config, twin=self.twin))
        if self.arm.status.state is State.DISABLED:
            self.arm.enable()
        self.probe = Probe(self.config)

    def stand(self, joints: Joints, opening_mm: float) -> None:
        """Have the arm stand there, referenced."""
        self.arm.stop()
        world = self.twin.world
        world.drive_to(self.arm.parts.core.transmission.to_motors(joints, opening_mm))
        self.arm.reference.declare(world.joints, opening_mm=world.opening_mm)

    def anywhere(self) -> tuple[Joints, float]:
        """Return a random posture clear of all guards."""
        while True:
            angles = (self.draw.uniform(b.low_rad, b.high_rad) for b in self.probe.geometry.limits)
            joints = Joints(tuple(angles))
            if self.probe.guarded.room_mm(joints) > CLEAR_MM:
                return joints, self.draw.uniform(*self.config.model.gripper_range_mm)

    def into_limit(self) -> tuple[str, Jog, Joints, float]:
        """Return a jog of one or two joints, the first of which is near its limit."""
        names = (*self.probe.geometry.joint_names, GRIPPER_AXIS)
        name, way = self.draw.choice(names), self.draw.choice((-1.0, 1.0))
        what = f"{name} {'high' if way > 0 else 'low'}"
        other = self.draw.choice([each for each in names if each != name])
        amounts = {name: way, other: self.draw.choice((0.0, 0.0, 1.0, -1.0))}
        jog = Jog.joint(**{each: amount for each, amount in amounts.items() if amount})
        while True:
            joints, opening_mm = self.anywhere()
            if name == GRIPPER_AXIS:
                return what, jog, joints, opening_mm
            index = self.probe.geometry.joint_names.index(name)
            bounds = self.probe.geometry.limits[index]
            speed = self.config.model.joint_speeds_rad_s[index] * self.share
            near = speed * NEAR_S * self.draw.uniform(0.1, 1.0)
            angle = bounds.high_rad - near if way > 0 else bounds.low_rad + near
            joints = joints.replace(**{name: angle})
            if self.probe.guarded.room_mm(joints) > CLEAR_MM:
                return what, jog, joints, opening_mm

    def into_guard(self) -> tuple[str, Jog, Joints, float]:
        """Return a line of the tip that leads to a guard, a limit or the edge of the reach."""
        joints, opening_mm = self.anywhere()
        tip = self.probe.geometry.fk(joints)
        r = max(math.hypot(tip.x_mm, tip.y_mm), 1.0)
        outwards = {"x": tip.x_mm / r, "y": tip.y_mm / r}
        inwards = {axis: -amount for axis, amount in outwards.items()}
        what, amounts, frame = self.draw.choice(
            (
                ("table", {"z": -1.0}, "base"),
                ("outwards", outwards, "base"),
                ("inwards", inwards, "base"),
                ("wall", {"y": 1.0}, "base"),
                ("pitch", {"pitch": self.draw.choice((-1.0, 1.0))}, "base"),
                ("along the tool", {"z": 1.0}, "tool"),
                ("any", {axis: self.draw.uniform(-1, 1) for axis in CARTESIAN_AXES}, "base"),
            )
        )
        jog = Jog.cartesian(frame=frame, **amounts)
        return what, jog, self._nearer(jog, joints), opening_mm

    def _nearer(self, jog: Jog, joints: Joints) -> Joints:
        """Return a posture further on along a line, not far before it meets a bound."""
        before_mm = self.draw.uniform(2.0, 60.0) * min(self.share, 1.0)
        passed = [joints]
        for there in self.probe.onwards(jog, ArmCoordinates(joints, 0.0), COARSE_MM):
            if there is None or self.probe.guarded.room_mm(there.joints) <= 0.0:
                break
            passed.append(there.joints)
        return passed[max(len(passed) - 1 - math.ceil(before_mm / COARSE_MM), 0)]

    def over_base(self) -> tuple[str, Jog, Joints, float]:
        """Return a line that passes the base axis at a few mm, where the base has to turn fast."""
        while True:
            joints, opening_mm = self.anywhere()
            tip = self.probe.geometry.fk(joints)
            r = math.hypot(tip.x_mm, tip.y_mm)
            if not 40.0 < r < 100.0:
                continue
            beside = self.draw.uniform(1.0, 15.0) / r
            x = -(tip.x_mm - beside * tip.y_mm) / r
            y = -(tip.y_mm + beside * tip.x_mm) / r
            most = max(abs(x), abs(y))
            return "over the base", Jog.cartesian(x=x / most, y=y / most), joints, opening_mm


LOOK_S = 0.02
STANDS_S = 0.5
"""Motors that have not moved for so long stand; between two bursts they do for less."""

LONGEST_S = 20.0
BACK_S = 0.8
HELD_S = 0.25
AT_LIMIT_RAD = 0.005

AT_REST_STEPS = 1.0
MOVING_STEPS = 1.5
"""Rounding is half a step, and motors that move are not all at the same one."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """One trial. A step is one of every motor that turns a joint, or that moves the tip.

    `left_steps` is how far before the bound the arm stood, None where it did not come to one.
    `over_steps` is the furthest it ever was beyond, `rest_steps` where it stood; `back_s` is how
    long the way back took to begin, and `stall_s` the longest stand-still soon after that.
    """

    what: str
    ended: str
    state: State
    left_steps: float | None
    over_steps: float
    rest_steps: float
    back_s: float
    stall_s: float

    @property
    def kept(self) -> bool:
        """Whether no limit was passed by more than a step, and nothing went into error-stop."""
        passed = self.rest_steps > AT_REST_STEPS or self.over_steps > MOVING_STEPS
        return not passed and self.state is not State.ERROR_STOP


class Ground(Stand):
    """One simulated arm, jogged from one posture after the other."""

    def __init__(self, dialect: str, seed: int, *, over_base: bool = False) -> None:
        super().__init__(dialect, seed, over_base=over_base)
        self.stand(Joints.of(0.0, 60.0, -80.0, -30.0, 0.0), 30.0)
        before = self.twin.world.joints[0]
        self.begins_s, self.stands_s = self.held_s(Jog.joint(base=1.0))
        turned = self.twin.world.joints[0] - before
        full = self.config.model.joint_speeds_rad_s[0] * (BACK_S - self.begins_s)
        self.share = turned / full

    def outcome(self, what: str, jog: Jog, joints: Joints, opening_mm: float) -> Outcome:
        """Hold a jog until the arm stands, then hold its reverse."""
        self.stand(joints, opening_mm)
        over, stands = self._held_to_its_end(jog)
        status, world = self.arm.status, self.twin.world
        rest = self.probe.over_steps(world.joints)
        left = self.probe.left_steps(jog, world.joints, world.opening_mm) if stands else None
        back_s, stall_s = self.held_s(self._back(jog))
        over = max(over, self.probe.over_steps(world.joints))
        state = self.arm.status.state
        self.arm.jogging.release()
        self.arm.sleep(STANDS_S)
        if state is State.ERROR_STOP:
            self.arm.reset()
        return Outcome(what, status.notice, state, left, over, rest, back_s, stall_s)

    def _held_to_its_end(self, jog: Jog) -> tuple[float, bool]:
        """Return how far the arm was beyond a bound at most, and whether it came to rest."""
        arm, world, over = self.arm, self.twin.world, 0.0
        began_s = moved_s = arm.status.time_s
        last = world.motors
        while (now_s := arm.status.time_s) < moved_s + STANDS_S and now_s < began_s + LONGEST_S:
            arm.jogging.hold(jog, speed=1.0, for_s=HELD_S)
            arm.sleep(LOOK_S)
            if world.motors != last:
                last, moved_s = world.motors, now_s
                over = max(over, self.probe.over_steps(world.joints))
        return over, now_s >= moved_s + STANDS_S

    def held_s(self, jog: Jog) -> tuple[float, float]:
        """Hold a jog for a while; return when motors first moved, and how long they then stood."""
        arm, world = self.arm, self.twin.world
        began_s = moved_s = arm.status.time_s
        last, first_s, stall_s = world.motors, math.inf, 0.0
        while arm.status.time_s < began_s + BACK_S:
            arm.jogging.hold(jog, speed=1.0, for_s=HELD_S)
            arm.sleep(LOOK_S / 2.0)
            now_s = arm.status.time_s
            if world.motors != last:
                last, first_s = world.motors, min(first_s, now_s - began_s)
                stall_s = max(stall_s, now_s - moved_s) if moved_s > began_s else 0.0
                moved_s = now_s
        arm.jogging.release()
        return first_s, stall_s

    def _back(self, jog: Jog) -> Jog:
        """Return the jog that leads back the way it came: without joints that had ended before."""
        axes = [(name, -amount) for name, amount in jog.axes]
        if jog.space is Space.JOINT:
            here = self.twin.world.joints
            ended = [
                name
                for name, bounds in zip(here.names, self.probe.geometry.limits, strict=True)
                if min(here[name] - bounds.low_rad, bounds.high_rad - here[name]) < AT_LIMIT_RAD
            ]
            axes = [axis for axis in axes if axis[0] not in ended] or axes
        return replace(jog, axes=tuple(axes))


def trials(dialect: str, seed: int, count: int) -> Iterator[Outcome]:
    """Jog an arm into limits, guards and past the singularity over its base, in turn."""
    ground, over_base = Ground(dialect, seed), None
    for number in range(count):
        if number % 10 == 9:
            over_base = over_base or Ground(dialect, seed, over_base=True)
            yield over_base.outcome(*over_base.over_base())
        elif number % 2:
            yield ground.outcome(*ground.into_limit())
        else:
            yield ground.outcome(*ground.into_guard())
