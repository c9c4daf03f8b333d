"""The laws of motion: a `Watch` sees every motion of the physical arm and judges whether it may be.

- Nothing moves without a command (`Watch.judge_motion`).
- After a stop the tip stands in time and in place (`Bound`).
- Every motor stays between start and goal, every joint within its limits, and no part of the arm
  enters a guard (`Command`, checked by `Watch._check_path`).
- No joint is too fast (`speeds`), and none is driven into a mechanical stop (`Watch.note_slip`).

The watch asks no register and no driver. It records each violation in `Watch.broken`.

What no driver can know or prevent is excused by four rules:

- The path and the place of a motor that has left its orders, until the next reference (`Doubts`).
- Every motion, once the device may have got another order than was sent, until the next reference.
- The path, the speed and the stopping distance of drives that do not all get their orders, or get
  them late, until the end of the command that this disturbs (`Watch.disturb`). They must still come
  to rest in time.
- A shaft in a closed loop that was blocked or turned by hand, as it turns back to its set-point
  (`Watch.note_displaced`).
"""

import math
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Protocol

from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody
from kinematics import Joints, Motors
from kinematics.guards import GuardedArm
from tests.conformance.observation import ON_THE_STEP, Point

from .speeds import SpeedWatch

ROUNDING_RAD = math.radians(0.5)
"""How far a joint may be beyond a limit because motors stand on whole steps."""
NOISE_S = 0.03
"""The longest time between an event and the next look at the arm."""
NOTICED_S = 0.6
"""The driver notices within this time that a drive does not follow, and stops the others."""
TURNS_BACK_S = 0.1
"""A shaft that comes free is at its set-point within this time."""


class WatchedWorld(World):
    """The physical arm, which reports every motion and its cause to a watch."""

    def __init__(self, body: ArmBody) -> None:
        self.watch: Watch | None = None
        self.moved_by_hand = False
        self.sagging = False
        self.closed_loop = False
        """Whether the drives measure their shafts and make up for lost steps."""
        self._driven = False
        super().__init__(body)

    def cut_current(self, time_s: float = 0.0) -> None:
        """Let the arm sag."""
        with self._sags():
            super().cut_current(time_s)

    def give_way(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Let a part of the arm sag by some motor steps."""
        with self._sags():
            super().give_way(steps, time_s)

    @contextmanager
    def _sags(self) -> Iterator[None]:
        self.sagging = True
        try:
            yield
        finally:
            self.sagging = False

    def drive(self, steps: Motors, time_s: float = 0.0) -> None:  # type: ignore[override]
        """Turn the motors, and report those that did not follow to the watch."""
        meant = self._motors + Motors(steps)
        failing = {i for i, one in enumerate(steps) if one and self.fails(i)}
        if failing and self.watch is not None:
            # report the slip before the watch judges the path that the other motors make
            self.watch.note_slip(failing, time_s)
        self._driven = True
        super().drive(steps, time_s)
        self._driven = False
        if self.watch is not None and meant != self._motors:
            pairs = enumerate(zip(meant, self._motors, strict=True))
            self.watch.note_slip({i for i, (a, b) in pairs if a != b}, time_s)

    def force(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Turn motors that nothing drives: what they overrun after a dead stop comes at once."""
        if not self._driven and self.watch is not None:
            self.watch.speeds.forget()
        super().force(steps, time_s)

    def fails(self, motor: int) -> bool:
        """Return whether a fault keeps a motor from following now."""
        return motor in self.stalled or bool(self.to_lose.get(motor))

    def _shift(self, steps: Motors, time_s: float) -> None:
        before, tip = self._motors, self.tip
        super()._shift(steps, time_s)
        if self.watch is not None and self._motors != before:
            pairs = zip(before, self._motors, strict=True)
            self.watch.judge_motion(time_s, {i for i, (a, b) in enumerate(pairs) if a != b}, tip)


class Aim(Protocol):
    """Where a successful call has to bring the arm (the classes are in `arrival`)."""

    def missed(self, world: WatchedWorld, result: object, excused: Collection[int]) -> str:
        """Return what is wrong with where the arm stands; empty if it is right.

        `result` is what the call returned. `excused` are motors whose place no driver can know.
        """


@dataclass(slots=True)
class Bound:
    """An announced bound: how long and how far the tip may go on after `since_s`."""

    what: str
    since_s: float
    tip: Point
    """Where the tip was at `since_s`."""
    time_s: float
    distance_mm: float
    is_pause: bool = False


@dataclass(slots=True)
class Command:
    """A call that may move the arm, and what it promises about the motion."""

    what: str
    position_known: bool = False
    """Whether the position was trusted when the call began: then limits and guards hold."""
    span: tuple[Motors, Motors] | None = None
    """The range in which every motor stays."""
    aim: Aim | None = None
    """Where the arm stands after a successful call; None if the call promises nothing about it."""
    speed: float = 1.0
    """No joint turns faster than this fraction of its limit."""
    excess_rad_at_start: dict[str, float] = field(default_factory=dict)
    """How far each joint was beyond its limit when the call began: it may not go further."""
    depth_mm: float = 0.0
    """How deep the arm was inside a guard when the call began: it may not go deeper."""
    slack_mm: float = 0.0
    """How much deeper it may go because the motors are not coordinated."""
    verified: bool = True
    """Whether the driver has read the registers a moment before a successful call returns."""
    homes: bool = False
    """Whether the device homes by itself, and may go on with that without the driver."""
    disturbed: bool = False
    """Whether drives may have missed orders of this call, or got them late."""


@dataclass(slots=True)
class Doubts:
    """What a driver need not know, or not yet, of the arm since the last reference."""

    off_path: set[int] = field(default_factory=set)
    """Motors that may not be where their orders should have brought them."""
    unknown: set[int] = field(default_factory=set)
    """Motors that left their place without any evidence: a stepper that slips gives none."""
    misdirected: bool = False
    """Whether a fault may have made the device do what the driver did not command."""
    late_s: float = 0.0
    """The longest delay of a message on the wire."""
    changed_s: float = -math.inf
    """When the arm last changed without a command."""
    evident_s: float = -math.inf
    """By when the driver can know of that change."""

    def joined(self, other: "Doubts") -> "Doubts":
        """Return the doubts of both."""
        return Doubts(
            self.off_path | other.off_path,
            self.unknown | other.unknown,
            self.misdirected or other.misdirected,
            max(self.late_s, other.late_s),
            max(self.changed_s, other.changed_s),
            max(self.evident_s, other.evident_s),
        )


class Watch:
    """Sees every motion of one arm, and records those that break a law."""

    def __init__(
        self,
        world: WatchedWorld,
        guarded: GuardedArm,
        step_mm: float,
        speeds_rad_s: tuple[float, ...],
        on_the_step: int = ON_THE_STEP,
        slowest_hz: float = 0.0,
        rounding_up_hz: float = 0.0,
    ) -> None:
        self.world = world
        self.on_the_step = on_the_step
        """How many steps two counts of the same place may differ by."""
        self.overshoot_steps = 0
        """How many steps a stop may take a motor beyond its goal."""
        self.broken: list[str] = []
        """A sentence for each violation."""
        self.doubts = Doubts()
        self.disturbed_until_s = -math.inf
        """By when drives that missed orders have been stopped, or follow them again."""
        self.referencing = False
        """Whether a call that references is under way."""
        self.moved_in_command: set[int] = set()
        """Motors that a person turned, or that gave way, since the present command began."""
        self._displaced_until_s: dict[int, float] = {}
        """Until when a motor may turn back to its drive's set-point."""
        self._guarded = guarded
        self._step_mm = step_mm
        self._command: Command | None = None
        self._until_s = -math.inf
        self._earlier_speed, self._earlier_until_s = 0.0, -math.inf
        """The speed of the previous command, and until when its motion may still run on."""
        self._bounds: list[Bound] = []
        self._rest_position = world.motors
        """Where the motors stood after the last allowed motion."""
        self._last_call = "nothing"
        self._motors_of_joint = tuple(
            (name, frozenset(motor for motor, share in enumerate(row) if share))
            for name, row in zip(world.joints.names, world.body.transmission.inverse, strict=False)
        )
        """The name of each joint, with the motors that turn it."""
        inverse = world.body.transmission.inverse[: len(world.joints)]
        steps_rad = [math.fsum(map(abs, row)) for row in inverse]
        self.speeds = SpeedWatch(
            speeds_rad_s,
            tuple(step_rad * on_the_step for step_rad in steps_rad),
            tuple(step_rad * slowest_hz for step_rad in steps_rad),
            tuple(step_rad * rounding_up_hz for step_rad in steps_rad),
        )
        world.watch = self

    # -- what is allowed ------------------------------------------------------------------------

    def begin(self, command: Command) -> None:
        """Judge motions by this command from now on."""
        arm, joints = self._guarded.arm, self.world.joints
        command.excess_rad_at_start = {each.joint: each.excess for each in arm.violations(joints)}
        command.depth_mm = self.guard_depth_mm(joints)
        if self._command is not None:
            self._earlier_speed, self._earlier_until_s = self._command.speed, self._until_s
        self._command, self._until_s = command, math.inf
        self.moved_in_command.clear()
        self.speeds.forget()
        self._last_call = command.what
        self._bounds.clear()

    def end(self, now_s: float, runs_on_s: float) -> None:
        """Note that the call has ended; what it has sent may run on for `runs_on_s`.

        What an earlier command has sent may still run on for longer, such as a homing without wire.
        """
        ends_s = now_s + runs_on_s + self.doubts.late_s + NOISE_S
        earlier_s = self._earlier_until_s
        self._until_s = max(ends_s, earlier_s) if math.isfinite(earlier_s) else ends_s

    def add_bound(self, bound: Bound) -> None:
        """Judge motions by this bound as well, until the next command begins."""
        self._bounds.append(bound)

    @property
    def bounds(self) -> Sequence[Bound]:
        """The bounds that hold now."""
        return self._bounds

    def clear_bounds(self) -> None:
        """Drop all bounds: the motion may go on."""
        self._bounds.clear()

    def begin_reference(self, *, no_faults: bool = True) -> None:
        """Start afresh, because a person is about to declare where the arm stands.

        Unless there are `no_faults`, what these have disturbed stays excused.
        """
        self._before_reference = self.doubts
        self.doubts = Doubts() if no_faults else replace(self.doubts, unknown=set())

    @contextmanager
    def reference_attempt(self) -> Iterator[list[bool]]:
        """Surround a call that references; the caller appends to what this yields if it succeeds.

        After a failure the old reference may hold, or the new one: all that was in doubt stays so.
        """
        self._before_reference, self.referencing = Doubts(), True
        succeeded: list[bool] = []
        try:
            yield succeeded
        finally:
            self.referencing = False
            if not succeeded:
                self.doubts = self.doubts.joined(self._before_reference)

    def note_change(self, now_s: float, known_by_s: float) -> None:
        """Note that the arm changes without a command, and by when the driver can know."""
        self.doubts.changed_s = now_s
        self.doubts.evident_s = max(self.doubts.evident_s, known_by_s)

    def note_suspension(self, now_s: float, for_s: float) -> None:
        """Note that the program is suspended for `for_s`, and cannot poll the arm meanwhile."""
        if now_s < self.doubts.evident_s:
            self.doubts.evident_s += for_s

    def lose_track(self, motors: Collection[int]) -> None:
        """Excuse the place of these motors until the next reference: no driver can know it."""
        self.doubts.off_path |= set(motors)
        self.doubts.unknown |= set(motors)

    def disturb(self, until_s: float) -> None:
        """Excuse the path of a command of which drives may miss orders until a time."""
        self.disturbed_until_s = max(self.disturbed_until_s, until_s)

    def note_displaced(self, motors: Collection[int], time_s: float) -> None:
        """Note shafts in a closed loop that are off their set-points, and turn back when free."""
        for motor in motors if self.world.closed_loop else ():
            self._displaced_until_s[motor] = time_s + TURNS_BACK_S

    def turning_back(self, motors: Collection[int], time_s: float) -> bool:
        """Return whether all these motors turn back to their set-points."""
        return all(time_s <= self._displaced_until_s.get(each, -math.inf) for each in motors)

    @property
    def may_turn_back_until_s(self) -> float:
        """Until when any motor may turn back."""
        return max(self._displaced_until_s.values(), default=-math.inf)

    # -- what is seen ---------------------------------------------------------------------------

    def note_slip(self, motors: set[int], time_s: float) -> None:
        """Note motors that did not follow; judge whether they were driven into a stop."""
        failing = {motor for motor in range(len(self.world.motors)) if self.world.fails(motor)}
        known = self.doubts.off_path | self.moved_in_command | failing
        self.note_displaced(failing & motors, time_s)
        if self.world.closed_loop:  # the drive measures where its shaft is
            self.doubts.off_path |= motors
        else:
            self.lose_track(motors)
        last = len(self.world.motors) - 1
        fingers = self.world.body.transmission.has_gripper and motors <= {last}
        if fingers or not self._path_is_judged(time_s):
            return
        if blocked := self._joints_at_stops() - self._joints_of(known):
            self._violation(
                f"{', '.join(sorted(blocked))}: driven into a mechanical stop: {self.world.joints}"
            )

    def judge_motion(self, time_s: float, motors: Collection[int], tip: Point) -> None:
        """Judge a motion of the physical arm. `tip` is where the tip was before it."""
        if self.world.sagging or self.world.moved_by_hand:
            self.speeds.forget()
            self._rest_position = self.world.motors
            self.moved_in_command |= set(motors)
            if self.world.sagging:
                self.doubts.off_path |= set(motors)
            self._shift_bounds(tip)
            return
        if self._is_excused(motors, time_s):
            self._rest_position = self.world.motors
            return
        if time_s > self._until_s and not self._only_holds():
            late_s = time_s - self._until_s
            self._violation(f"it moved without a command, {late_s:.2f} s after: {self._last_call}")
        self._check_bounds(time_s)
        if time_s <= min((self._until_s, *map(self._rests_by_s, self._bounds))):
            self._rest_position = self.world.motors
        if self._disturbed(time_s):
            self.speeds.forget()
            return
        share = 1.0 if self._command is None else self._command.speed
        if time_s <= self._earlier_until_s < math.inf:
            share = max(share, self._earlier_speed)
        free = self._joints_of(self.doubts.off_path | self.moved_in_command)
        if sentence := self.speeds.violation(time_s, self.world.joints, share, free):
            self._violation(sentence)
        if self._path_is_judged(time_s):
            self._check_path()

    def _is_excused(self, motors: Collection[int], time_s: float) -> bool:
        """Return whether no driver can know of a motion, or prevent it."""
        if self.doubts.misdirected or self.turning_back(motors, time_s):
            return True
        # motors that still hold may give way to those that do not
        return bool(self.doubts.off_path) and not self.world.energised

    def _disturbed(self, time_s: float) -> bool:
        """Return whether drives may have missed orders of the present command."""
        if time_s <= self.disturbed_until_s and self._command is not None:
            self._command.disturbed = True
        return self._command is not None and self._command.disturbed

    def _shift_bounds(self, before: Point) -> None:
        """Move the starts of the bounds along with a tip that no command moves."""
        by = tuple(b - a for a, b in zip(before, self.world.tip, strict=True))
        for bound in self._bounds:
            x, y, z = (at + way for at, way in zip(bound.tip, by, strict=True))
            bound.tip = (x, y, z)

    def _path_is_judged(self, time_s: float) -> bool:
        known = self._command is not None and self._command.position_known
        return known and not (self.doubts.misdirected or self._disturbed(time_s))

    def with_coupled(self, motors: Collection[int]) -> set[int]:
        """Return motors, with all others that turn, or depend on, a joint that they turn."""
        turned = self._joints_of(motors)
        matrix = self.world.body.transmission.matrix
        return set(motors) | {
            motor
            for motor, row in enumerate(matrix)
            for name, share in zip(self.world.joints.names, row, strict=False)
            if share and name in turned
        }

    def _joints_of(self, motors: Collection[int]) -> set[str]:
        """Return the joints that any of these motors turns."""
        return {name for name, turning in self._motors_of_joint if not turning.isdisjoint(motors)}

    def _joints_at_stops(self) -> set[str]:
        return {name for name in self.world._blocked if name not in ("gripper", "table")}

    def _only_holds(self) -> bool:
        """Return whether closed-loop drives only hold: each shaft is within its rest window.

        Two coupled drives that are ordered to hold at a mechanical stop give way to each other by
        some counts, because their orders are two frames, one after the other.
        """
        pairs = zip(self.world.motors, self._rest_position, strict=True)
        return self.world.closed_loop and all(abs(a - b) <= self.on_the_step for a, b in pairs)

    def _rests_by_s(self, bound: Bound) -> float:
        """Return by when the arm has to stand."""
        return bound.since_s + bound.time_s + self.doubts.late_s + NOISE_S

    def _check_bounds(self, time_s: float) -> None:
        for bound in self._bounds:
            if time_s > self._rests_by_s(bound) and not self._only_holds():
                after_s = time_s - bound.since_s
                self._violation(
                    f"{bound.what}: it moved {after_s:.2f} s later, not {bound.time_s:.2f}"
                )
            if self.doubts.unknown or self._disturbed(time_s):
                continue  # what coupled motors do without the one that slips is not announced
            way_mm = math.dist(self.world.tip, bound.tip)
            if way_mm > bound.distance_mm + self._step_mm:
                self._violation(
                    f"{bound.what}: it went {way_mm:.1f} mm, not {bound.distance_mm:.1f}"
                )

    def _check_path(self) -> None:
        command = self._command
        assert command is not None
        excused = self.with_coupled(self.doubts.off_path | self.moved_in_command)
        if command.span is not None:
            near = self.on_the_step + self.overshoot_steps
            for motor, (here, a, b) in enumerate(
                zip(self.world.motors, *command.span, strict=True)
            ):
                if motor not in excused and not min(a, b) - near <= here <= max(a, b) + near:
                    self._violation(f"motor {motor + 1} was at {here}, commanded from {a} to {b}")
        joints, free = self.world.joints, self._joints_of(excused)
        for each in self._guarded.arm.violations(joints):
            allowed_rad = command.excess_rad_at_start.get(each.joint, 0.0) + ROUNDING_RAD
            if each.joint not in free and each.excess > allowed_rad:
                beyond = math.degrees(each.excess)
                self._violation(f"the {each.joint} was {beyond:.2f} degrees beyond its limit")
        # if a joint's angle is unknown, so is the tip's place
        depth_mm = 0.0 if free else self.guard_depth_mm(joints)
        # a guard reports nothing within its tolerance, and the whole depth just beyond it
        began_mm = max(command.depth_mm, self._guarded.guards.tolerance_mm)
        if depth_mm > began_mm + command.slack_mm + self._step_mm:
            self._violation(
                f"it was {depth_mm:.3f} mm inside a guard, and began {command.depth_mm:.1f}"
            )

    def guard_depth_mm(self, joints: Joints) -> float:
        """Return how deep a posture is inside a guard; 0 if it is in none."""
        broken = self._guarded.violations(joints)
        return max((each.excess_mm for each in broken), default=0.0)

    def _violation(self, sentence: str) -> None:
        if sentence not in self.broken:
            self.broken.append(sentence)
