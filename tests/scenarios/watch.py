"""The laws of motion: a `Watch` sees every motion of the physical arm and judges whether it may be.

- Nothing moves without a command, or longer than announced after it.
- After a stop the tip stands in time and in place (`Bound`).
- Every motor stays between start and goal, every joint within its limits, and no part of the arm
  enters a guard. No joint is driven into its mechanical stop, and none is too fast.

The watch asks no register and no driver. It records each violation in `Watch.broken`. What no
driver can know or prevent is excused by one rule: `Watch.excuse` says which laws do not hold, and
`Watch.slack_s` how much longer anything may take, until the next command that begins without any
fault at work and with a position that is right (`Stage.forget_excuses`).
"""

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from enum import IntEnum

from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import Controller
from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody
from kinematics import Joints, Motors
from kinematics.guards import GuardedArm
from tests.conformance.observation import ON_THE_STEP, Point, rests_within

OVERSHOOT_STEPS = 4
"""How far from its path a stopped motor may stand: a Robko's goes on by so much."""
LIMIT_RAD = math.radians(0.5)
"""How far a joint may be beyond a limit because motors stand on whole steps."""
NOISE_S = 0.03
"""The longest time between an event and the next look at the arm."""
SPEED_WINDOW_S = 0.2
"""The shortest time over which a speed is averaged: motors make whole steps, seen at moments."""
SPEED_TOLERANCE = 1.2
"""By what factor a joint may exceed its limit: devices have tables of speeds, and motors that are
not coordinated catch up."""
CATCH_UP_HZ = 550.0
"""How much faster a drive may be that catches up: two turns a minute of an MKS drive."""


def depth_mm(guarded: GuardedArm, joints: Joints) -> float:
    """Return how deep a posture is inside a guard; 0 if it is in none."""
    return max((each.excess_mm for each in guarded.violations(joints)), default=0.0)


class Excuse(IntEnum):
    """Which laws do not hold, because no driver could keep them; each includes those before it."""

    NOTHING = 0
    PATH = 1
    """Motors may be off their paths: how far, how fast and where they go is not judged."""
    MOTION = 2
    """The device may move on orders that were not given: no motion is judged."""


class WatchedWorld(World):
    """The physical arm; it reports its motions to a watch and measures how far its tip goes."""

    def __init__(self, body: ArmBody) -> None:
        self.watch: Watch | None = None
        self.excused = False
        """Whether a hand turns the motors, or they give way without current."""
        self._driven = False
        self.moved_s = -math.inf
        """When the arm last moved."""
        self.mark: Point | None = None
        self.furthest_mm = 0.0
        """How far the tip got from the mark, without sagging."""
        super().__init__(body)

    @contextmanager
    def by_itself(self) -> Iterator[None]:
        """Surround motions that no controller makes: by hand, or without current."""
        before, self.excused = self.excused, True
        try:
            yield
        finally:
            self.excused = before

    def cut_current(self, time_s: float = 0.0) -> None:
        """Let the arm sag; no bound holds for a sag, which depends on the arm's weight."""
        self.mark = None
        with self.by_itself():
            super().cut_current(time_s)

    def give_way(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Let a part of the arm sag by some motor steps."""
        with self.by_itself():
            super().give_way(steps, time_s)

    def drive(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Turn the motors, and report a joint that is driven into its mechanical stop."""
        before = set(self._blocked)
        self._driven = True
        super().drive(steps, time_s)
        self._driven = False
        new = self._blocked - before - {"gripper", "table"}
        if new and self.watch is not None:
            self.watch.judge_stops(new)

    def force(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Turn motors that nothing drives: what they overrun after a dead stop comes at once."""
        if not self._driven and self.watch is not None:
            self.watch.forget_speeds()
        super().force(steps, time_s)

    def _shift(self, steps: Motors, time_s: float) -> None:
        before = self._motors
        super()._shift(steps, time_s)
        if self._motors == before:
            return
        self.moved_s = time_s
        if self.mark is not None:
            self.furthest_mm = max(self.furthest_mm, math.dist(self.mark, self.tip))
        if self.watch is not None:
            self.watch.judge(time_s)


@dataclass(frozen=True, slots=True)
class Bound:
    """An announced bound: how long and how far the tip may go on after `since_s`."""

    what: str
    since_s: float
    tip: Point
    time_s: float
    distance_mm: float


Reaches = Callable[[World, object], str]
"""Tells what is wrong with where a successful call has brought the arm; empty if it is right."""


@dataclass(slots=True)
class Command:
    """A call that may move the arm, and what it promises about the motion."""

    what: str
    position_known: bool = False
    """Whether the position was trusted when the call began: then limits and guards hold."""
    span: tuple[Motors, Motors] | None = None
    """The range in which every motor stays."""
    reaches: Reaches | None = None
    speed: float = 1.0
    """No joint turns faster than this fraction of its limit."""
    verified: bool = True
    """Whether the driver has read the registers a moment before a successful call returns."""
    homes: bool = False
    """Whether the device homes by itself, and may go on with that without the driver."""
    excess_rad: dict[str, float] = field(default_factory=dict)
    """How far each joint was beyond its limit when the call began: it may not go further."""
    depth_mm: float = 0.0
    """How deep the arm was inside a guard when the call began: it may not go deeper."""


class Watch:
    """Sees every motion of one arm, and records those that break a law."""

    def __init__(self, world: WatchedWorld, config: ArmConfig, controller: Controller) -> None:
        self.world = world
        self.broken: list[str] = []
        """A sentence for each violation."""
        self.excuse = Excuse.NOTHING
        self.slack_s = 0.0
        """How much longer than announced anything may take."""
        self.hidden = False
        """Whether motors may have left their place without any evidence."""
        self.stuck_until_s = -math.inf
        """Until when a limit switch is wrong."""
        self.changed_s = self.evident_s = -math.inf
        """When the arm last changed without a command, and by when the driver can know of it."""
        self.on_the_step = max(ON_THE_STEP, rests_within(config.device))
        """How many steps two counts of the same place may differ by."""
        self.closed_loop = bool(rests_within(config.device))
        self._guarded = config.model.guards.over(config.model.arm)
        inverse = world.body.transmission.inverse[: len(world.joints)]
        steps_rad = [math.fsum(map(abs, row)) for row in inverse]
        levers = zip(steps_rad, config.model.arm.levers_mm(None), strict=True)
        # how far the tip is off at most if every motor is one step off
        self._step_mm = self.on_the_step * math.fsum(turn * lever for turn, lever in levers)
        coordinated = controller.abilities.coordinated
        self._slack_mm = self._step_mm + (0.0 if coordinated else config.motion.deviation_mm)
        self._limits_rad_s = config.model.joint_speeds_rad_s
        self._slowest_rad_s = [each * controller.usable_rate_hz(0.0) for each in steps_rad]
        extra_hz = CATCH_UP_HZ if self.closed_loop else 0.0
        self._speed_slack_rad_s = [each * extra_hz for each in steps_rad]
        self._angle_slack_rad = [each * self.on_the_step for each in steps_rad]
        self._angles: deque[tuple[float, Joints]] = deque()
        """The joint angles of the last `SPEED_WINDOW_S`."""
        self._command: Command | None = None
        self._until_s = self._earlier_until_s = -math.inf
        """Until when the present command, and those before it, may move the arm."""
        self._bounds: list[Bound] = []
        self._rested_at = world.motors
        """Where the motors stood after the last allowed motion."""
        world.watch = self

    # -- what is allowed ------------------------------------------------------------------------

    def begin(self, command: Command) -> None:
        """Judge motions by this command from now on."""
        joints = self.world.joints
        command.excess_rad = {
            each.joint: each.excess for each in self._guarded.arm.violations(joints)
        }
        command.depth_mm = self.guard_depth_mm(joints)
        self._earlier_until_s = max(
            self._earlier_until_s, self._until_s if self._until_s < math.inf else -math.inf
        )
        self._command, self._until_s = command, math.inf
        self._angles.clear()
        self._bounds.clear()

    def end(self, now_s: float, runs_on_s: float) -> None:
        """Note that the call has ended; what it has sent may run on for `runs_on_s`."""
        self._until_s = max(now_s + runs_on_s, self._earlier_until_s)

    def add_bound(self, bound: Bound) -> None:
        """Judge motions by this bound as well, until the next command begins."""
        self._bounds.append(bound)

    def clear_bounds(self) -> None:
        """Drop all bounds: the motion may go on."""
        self._bounds.clear()

    def pardon(self, excuse: Excuse, slack_s: float = 0.0) -> None:
        """Excuse what no driver can know or prevent."""
        self.excuse = max(self.excuse, excuse)
        self.slack_s = max(self.slack_s, slack_s)

    def note_change(self, now_s: float, known_by_s: float) -> None:
        """Note that the arm changes without a command, and by when the driver can know."""
        self.pardon(Excuse.PATH)
        self.changed_s, self.evident_s = now_s, max(self.evident_s, known_by_s)

    def forget_excuses(self) -> None:
        """Judge by every law again."""
        self.excuse, self.slack_s = Excuse.NOTHING, 0.0

    def forget_speeds(self) -> None:
        """Forget the angles: no command made the last motion."""
        self._angles.clear()

    # -- what is seen ---------------------------------------------------------------------------

    def judge(self, time_s: float) -> None:
        """Judge a motion of the physical arm."""
        world = self.world
        if world.excused:  # the driver learns of it later
            self.pardon(Excuse.PATH)
        # motors that still hold may give way to those that do not
        gives_way = self.excuse is Excuse.PATH and not world.energised
        if world.excused or gives_way or self.excuse is Excuse.MOTION:
            self.forget_speeds()
            self._rested_at = world.motors
            return
        self._judge_time(time_s)
        if self.excuse is Excuse.PATH:
            self.forget_speeds()
            return
        for bound in self._bounds:
            way_mm = math.dist(world.tip, bound.tip)
            if way_mm > bound.distance_mm + self._step_mm:
                self._violation(
                    f"{bound.what}: it went {way_mm:.1f} mm, not {bound.distance_mm:.1f}"
                )
        self._judge_speed(time_s)
        if self._command is not None and self._command.position_known:
            self._judge_path(self._command)

    def _judge_time(self, time_s: float) -> None:
        """Judge whether the arm may move now; drives may hold their shafts at any time."""
        rests_s = self.slack_s + NOISE_S
        late = [each for each in self._bounds if time_s > each.since_s + each.time_s + rests_s]
        unasked = time_s > self._until_s + rests_s
        if not (unasked or late):
            self._rested_at = self.world.motors
        elif not self._only_holds():
            for each in late:
                after_s = time_s - each.since_s
                self._violation(
                    f"{each.what}: it moved {after_s:.2f} s later, not {each.time_s:.2f}"
                )
            if unasked:
                what = self._command.what if self._command is not None else "nothing"
                late_s = time_s - self._until_s
                self._violation(f"it moved without a command, {late_s:.2f} s after: {what}")

    def judge_stops(self, joints: set[str]) -> None:
        """Judge joints that a controller has driven into their mechanical stops."""
        known = self._command is not None and self._command.position_known
        if known and self.excuse is Excuse.NOTHING and not self.world.excused:
            names = ", ".join(sorted(joints))
            self._violation(f"{names}: driven into a mechanical stop: {self.world.joints}")

    def _only_holds(self) -> bool:
        """Return whether closed-loop drives only hold: each shaft is within its rest window."""
        pairs = zip(self.world.motors, self._rested_at, strict=True)
        return self.closed_loop and all(abs(a - b) <= self.on_the_step for a, b in pairs)

    def _judge_speed(self, time_s: float) -> None:
        """Judge the mean speed of each joint over `SPEED_WINDOW_S`."""
        seen, joints = self._angles, self.world.joints
        if seen and seen[-1][0] == time_s:
            seen.pop()  # a long motion is reported in pieces with the same time
        seen.append((time_s, joints))
        while len(seen) > 1 and seen[1][0] <= time_s - SPEED_WINDOW_S:
            seen.popleft()
        began_s, before = seen[0]
        since_s = time_s - began_s
        if since_s < SPEED_WINDOW_S:
            return
        share = 1.0 if self._command is None else self._command.speed
        for index, (a, b) in enumerate(zip(before, joints, strict=True)):
            limit = self._limits_rad_s[index]
            allowed = max(share * limit, min(self._slowest_rad_s[index], limit))
            allowed = SPEED_TOLERANCE * allowed + self._speed_slack_rad_s[index]
            if abs(b - a) > allowed * since_s + self._angle_slack_rad[index]:
                self._violation(
                    f"the {joints.names[index]} turned at {math.degrees(abs(b - a)) / since_s:.1f} "
                    f"degrees a second for {since_s:.2f} s, and its limit is "
                    f"{math.degrees(limit):.1f}, of which {share:.0%} were asked for"
                )

    def _judge_path(self, command: Command) -> None:
        if command.span is not None:
            # the driver counts from where it has read the motors, and they rest beside their goal
            near = max(2 * self.on_the_step, OVERSHOOT_STEPS)
            for motor, (here, a, b) in enumerate(
                zip(self.world.motors, *command.span, strict=True)
            ):
                if not min(a, b) - near <= here <= max(a, b) + near:
                    self._violation(f"motor {motor + 1} was at {here}, commanded from {a} to {b}")
        for each in self._guarded.arm.violations(self.world.joints):
            if each.excess > command.excess_rad.get(each.joint, 0.0) + LIMIT_RAD:
                beyond = math.degrees(each.excess)
                self._violation(f"the {each.joint} was {beyond:.2f} degrees beyond its limit")
        depth_mm = self.guard_depth_mm(self.world.joints)
        # a guard reports nothing within its tolerance, and the whole depth just beyond it
        began_mm = max(command.depth_mm, self._guarded.guards.tolerance_mm)
        if depth_mm > began_mm + self._slack_mm:
            self._violation(
                f"it was {depth_mm:.3f} mm inside a guard, and began {command.depth_mm:.1f}"
            )

    def guard_depth_mm(self, joints: Joints) -> float:
        """Return how deep a posture is inside a guard; 0 if it is in none."""
        return depth_mm(self._guarded, joints)

    def _violation(self, sentence: str) -> None:
        if sentence not in self.broken:
            self.broken.append(sentence)
