"""The laws of motion: a `Watch` sees every motion of the physical arm and judges whether it may be.

- Nothing moves without a command (`Watch.judge_motion`).
- After a stop the tip stands in time and in place (`Bound`).
- Every motor stays between start and goal, every joint within its limits, and no part of the arm
  enters a guard (`Command`, checked by `Watch._check_path`).
- No joint is too fast (`speeds`), and none is driven into a mechanical stop (`Watch.note_slip`).

The watch asks no register and no driver. It records each violation in `Watch.broken`. `excuses`
lists what no driver can know or prevent.

No driver can know that a stepper has slipped, so its path is judged by what was commanded:
`WatchedWorld.expected` is where each motor would stand if it had made every step that its
controller gave it. That is where a motor does stand as long as it has not slipped.
"""

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Protocol

from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody
from kinematics import Joints, Motors, Transmission
from kinematics.guards import GuardedArm
from tests.conformance.observation import ON_THE_STEP, Point

from .excuses import NOISE_S, LostTargets, MissedOrders, SpringBack, TurnedByHand, fastest_hz
from .speeds import NOTHING, WINDOW_S, SpeedWatch

ROUNDING_RAD = math.radians(0.5)
"""How far a joint may be beyond a limit because motors stand on whole steps."""


class WatchedWorld(World):
    """The physical arm, which reports every motion and its cause to a watch."""

    def __init__(self, body: ArmBody) -> None:
        self.watch: Watch | None = None
        self.moved_by_hand = False
        self.sagging = False
        self.closed_loop = False
        """Whether the drives measure their shafts and make up for lost steps."""
        self._ordered: Motors | None = None
        """The steps that the controller gives the motors in the present call of `drive`."""
        self._motors_follow = False
        """Whether every motor makes these steps."""
        super().__init__(body)
        self._expected = self._motors

    @property
    def expected(self) -> Motors:
        """Where the motors would stand if none had slipped or sagged since the last reference."""
        return self._motors if self.closed_loop else self._expected

    @property
    def expected_joints(self) -> Joints:
        """The joint angles that belong to `expected`."""
        there = self.expected
        if there == self._motors:
            return self._joints
        return self.body.transmission.to_joints(there)[0]

    def set_expected(self, there: Motors) -> None:
        """Set where the motors are expected to stand from now on."""
        self._expected = there

    def cut_current(self, time_s: float = 0.0) -> None:
        """Let the arm sag."""
        self.sagging = True
        try:
            super().cut_current(time_s)
        finally:
            self.sagging = False

    def give_way(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Let a part of the arm sag by some motor steps."""
        self.sagging = True
        try:
            super().give_way(steps, time_s)
        finally:
            self.sagging = False

    def drive(self, steps: Motors, time_s: float = 0.0) -> None:  # type: ignore[override]
        """Turn the motors, and report those that did not follow to the watch."""
        before = self._motors
        failing = {i for i, one in enumerate(steps) if one and self.fails(i)}
        if failing and self.watch is not None:
            in_motion = self.watch.may_move(time_s)
            self.watch.spring_back.note_blocked(failing, time_s, in_motion=in_motion)
            # report the slip before the watch judges the path that the other motors make
            self.watch.note_slip(failing, time_s)
        meant = before + Motors(steps)
        self._ordered = Motors(steps)
        try:
            super().drive(steps, time_s)
        finally:
            self._ordered = None
        if self.watch is not None and meant != self._motors:
            pairs = enumerate(zip(meant, self._motors, strict=True))
            self.watch.note_slip({i for i, (a, b) in pairs if a != b}, time_s)

    def force(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Turn motors by the steps that they really make, which may differ from those ordered.

        Expected and real motors advance together in small pieces, so that the watch sees both.
        """
        ordered, self._ordered = self._ordered, None
        if ordered is None or tuple(ordered) == tuple(steps):
            if ordered is None and self.watch is not None:
                self.watch.speeds.forget()  # a motor that runs on after a dead stop moves at once
            self._motors_follow = ordered is not None
            super().force(steps, time_s)
            self._motors_follow = False
            return
        last = len(ordered) - self.body.transmission.has_gripper
        pieces = 1 + max(map(abs, ordered[:last]), default=0) // self._sample_steps
        made = meant_so_far = Motors((0,) * len(ordered))
        for piece in range(1, pieces + 1):
            share = Motors(count * piece // pieces for count in steps)
            meant = Motors(count * piece // pieces for count in ordered)
            self._expected = self._expected + (meant - meant_so_far)
            self._shift(share - made, time_s)
            made, meant_so_far = share, meant

    def fails(self, motor: int) -> bool:
        """Return whether a fault keeps a motor from following now."""
        return motor in self.stalled or bool(self.to_lose.get(motor))

    def _shift(self, steps: Motors, time_s: float) -> None:
        before, tip = self._motors, self.tip
        if self._motors_follow:
            self._expected = self._expected + steps
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


@dataclass(slots=True)
class Command:
    """A call that may move the arm, and what it promises about the motion."""

    what: str
    position_known: bool = False
    """Whether the position was trusted when the call began: then limits and guards hold."""
    span: tuple[Motors, Motors] | None = None
    """The range in which every motor stays, by its expected position."""
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


@dataclass(frozen=True, slots=True)
class PriorExcuses:
    """What a watch excused before an attempt to reference; the names are those of the watch."""

    lost: set[int]
    """Motors whose physical or expected place was unknown."""
    sagged: set[int]
    misdirected: bool
    late_s: float
    changed_s: float
    evidence_by_s: float
    restart_shown_by_s: float


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
        self.misdirected = False
        """Whether a fault may have made the device do what the driver did not command.

        No driver can prevent that, so no path is judged until the next reference.
        """
        self.late_s = 0.0
        """The longest delay of a message on the wire."""
        self.slipped: set[int] = set()
        """Motors that have slipped since the last reference; a driver cannot know of steppers."""
        self.sagged: set[int] = set()
        """Motors that gave way without current since the last reference."""
        self.expected_unknown: set[int] = set()
        """Motors whose expected place is unknown as well, since the last reference."""
        self.changed_s = self.evidence_by_s = -math.inf
        """When the arm last changed without a command, and by when the driver can know of it."""
        self.restart_shown_by_s = -math.inf
        """By when a restart shows that left the registers at zero as they were."""
        self.missed_orders: MissedOrders | None = None
        self.turned_by_hand: TurnedByHand | None = None
        self.spring_back = SpringBack()
        self.lost_targets = LostTargets()
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
        self._before_reference: PriorExcuses | None = None
        """What was excused before the latest attempt to reference, which may fail."""
        self.referencing = False
        """Whether a call that references is under way."""
        self.turned_in_command: set[int] = set()
        """Motors that a person has turned, or that restarted, since the present command began."""
        self.sagged_in_command: set[int] = set()
        """Motors that gave way since the present command began."""
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
            _all_motors_rad_s(world.body.transmission, speeds_rad_s),
        )
        world.watch = self

    # -- what is allowed ------------------------------------------------------------------------

    def begin(self, command: Command) -> None:
        """Judge motions by this command from now on."""
        arm, joints = self._guarded.arm, self.world.expected_joints
        command.excess_rad_at_start = {each.joint: each.excess for each in arm.violations(joints)}
        command.depth_mm = self.guard_depth_mm(joints)
        if self._command is not None:
            self._earlier_speed, self._earlier_until_s = self._command.speed, self._until_s
        self._command, self._until_s = command, math.inf
        self.turned_in_command.clear()
        self.sagged_in_command.clear()
        self.speeds.forget()
        if self.missed_orders is not None:
            self.missed_orders.begin()
        self._last_call = command.what
        self._bounds.clear()

    def end(self, now_s: float, runs_on_s: float) -> None:
        """Note that the call has ended; what it has sent may run on for `runs_on_s`.

        What an earlier command has sent may still run on for longer, such as a homing without wire.
        """
        ends_s = now_s + runs_on_s + self.late_s + NOISE_S
        earlier_s = self._earlier_until_s
        self._until_s = max(ends_s, earlier_s) if math.isfinite(earlier_s) else ends_s

    def add_bound(self, bound: Bound) -> None:
        """Judge motions by this bound as well, until the next command begins."""
        self._bounds.append(bound)

    @property
    def commanded_speed(self) -> float:
        """The share of its greatest speed at which the arm may move."""
        return 1.0 if self._command is None else self._command.speed

    @property
    def must_stop(self) -> bool:
        """Whether the arm has to come to rest: a bound holds."""
        return bool(self._bounds)

    def loosen_bounds(self, loosened: Callable[[float, float], tuple[float, float]]) -> None:
        """Replace the time and distance of each bound by what a function makes of them."""
        for bound in self._bounds:
            bound.time_s, bound.distance_mm = loosened(bound.time_s, bound.distance_mm)

    def clear_bounds(self) -> None:
        """Drop all bounds: the motion may go on."""
        self._bounds.clear()

    def begin_reference(self, *, no_faults: bool = True) -> None:
        """Start afresh, because a person is about to declare where the arm stands.

        Unless there are `no_faults`, sags, misdirected and late messages stay excused, and so do
        changes whose evidence is still to come.
        """
        self._before_reference = PriorExcuses(
            self.slipped | self.expected_unknown,
            set(self.sagged),
            self.misdirected,
            self.late_s,
            self.changed_s,
            self.evidence_by_s,
            self.restart_shown_by_s,
        )
        self.slipped.clear()
        self.expected_unknown.clear()
        self.world.set_expected(self.world.motors)
        if no_faults:
            self.misdirected = False
            self.late_s = 0.0
            self.sagged.clear()
            self.changed_s = self.evidence_by_s = self.restart_shown_by_s = -math.inf

    def undo_reference(self) -> None:
        """Excuse what was excused before as well: the old reference may hold, or the new one."""
        before, self._before_reference = self._before_reference, None
        if before is None:
            return
        self.slipped |= before.lost
        self.expected_unknown |= before.lost
        self.sagged |= before.sagged
        self.misdirected = self.misdirected or before.misdirected
        self.late_s = max(self.late_s, before.late_s)
        self.changed_s = max(self.changed_s, before.changed_s)
        self.evidence_by_s = max(self.evidence_by_s, before.evidence_by_s)
        self.restart_shown_by_s = max(self.restart_shown_by_s, before.restart_shown_by_s)

    @contextmanager
    def reference_attempt(self) -> Iterator[Callable[[], None]]:
        """Surround a call that references; the caller calls what this yields if it succeeds."""
        self._before_reference, self.referencing = None, True
        well = False

        def ended_well() -> None:
            nonlocal well
            well = True

        try:
            yield ended_well
        finally:
            self.referencing = False
            if not well:
                self.undo_reference()

    def note_change(self, now_s: float, known_by_s: float) -> None:
        """Note that the arm changes without a command, and by when the driver can know."""
        self.changed_s, self.evidence_by_s = now_s, max(self.evidence_by_s, known_by_s)

    def note_suspension(self, now_s: float, for_s: float) -> None:
        """Note that the program is suspended for `for_s`, and cannot poll the arm meanwhile."""
        self.evidence_by_s += for_s if now_s < self.evidence_by_s else 0.0
        self.restart_shown_by_s += for_s if now_s < self.restart_shown_by_s else 0.0

    def excuse_restart(
        self, now_s: float | None = None, motors: Collection[int] | None = None
    ) -> None:
        """Excuse the position of these motors, or of all, until the next reference.

        No driver can know of a restart that left the registers at zero. With `now_s`, the restart
        is excused only if its evidence was still to come at that time, because it is lost then.
        """
        if now_s is None or now_s < self.restart_shown_by_s:
            lost = set(range(len(self.world.motors)) if motors is None else motors)
            self.slipped |= lost
            self.expected_unknown |= lost

    # -- what is seen ---------------------------------------------------------------------------

    def note_slip(self, motors: set[int], time_s: float) -> None:
        """Note motors that did not follow; judge whether they were driven into a stop."""
        failing = {motor for motor in range(len(self.world.motors)) if self.world.fails(motor)}
        known = self.slipped | self.sagged | self.turned_in_command | failing
        self.slipped |= motors
        last = len(self.world.motors) - 1
        fingers = self.world.body.transmission.has_gripper and motors <= {last}
        if fingers or not self._path_is_judged:
            return
        blocked = self._joints_at_stops() - self._joints_of(known)
        if self.missed_orders is not None and self.missed_orders.excuses(time_s):
            # these joints may pass their limits, and so reach their mechanical stops
            blocked -= self.missed_orders.joints
        if blocked:
            self._violation(
                f"{', '.join(sorted(blocked))}: driven into a mechanical stop: {self.world.joints}"
            )

    def judge_motion(self, time_s: float, motors: Collection[int], tip: Point) -> None:
        """Judge a motion of the physical arm. `tip` is where the tip was before it."""
        if self.world.sagging or self.world.moved_by_hand:
            self.speeds.forget()
            self._rest_position = self.world.motors
        if self.world.sagging:
            self.sagged |= set(motors)
            self.sagged_in_command |= set(motors)
            self._shift_bounds(tip)
            return
        if self.world.moved_by_hand:
            self.turned_in_command |= set(motors)
            self._shift_bounds(tip)
            return
        if self._is_excused(motors, time_s):
            self._rest_position = self.world.motors
            return
        if time_s > self._until_s and not self._only_holds():
            late_s = time_s - self._until_s
            self._violation(f"it moved without a command, {late_s:.2f} s after: {self._last_call}")
        self._check_bounds(time_s)
        if self.may_move(time_s):
            self._rest_position = self.world.motors
        share = self.commanded_speed
        if time_s <= self._earlier_until_s < math.inf:
            share = max(share, self._earlier_speed)
        free = self._joints_of(self.slipped | self.sagged | self.turned_in_command)
        faster_rad_s, ahead_s = NOTHING, self.lost_targets.ahead_s(time_s, WINDOW_S)
        if self.missed_orders is not None:
            faster_rad_s = self.missed_orders.faster_rad_s(time_s, WINDOW_S)
        joints = self.world.joints
        if sentence := self.speeds.violation(time_s, joints, share, free, faster_rad_s, ahead_s):
            self._violation(sentence)
        if self._path_is_judged:
            self._check_path(time_s)

    def may_move(self, time_s: float) -> bool:
        """Return whether a command may move the arm now, and no bound has ended."""
        return time_s <= min((self._until_s, *map(self._rests_by_s, self._bounds)))

    def _is_excused(self, motors: Collection[int], time_s: float) -> bool:
        """Return whether no driver can know of a motion, or prevent it."""
        if self.misdirected or self.spring_back.excuses(motors, time_s):
            return True
        if self.turned_by_hand is not None and self.turned_by_hand.excuses(
            motors, self.world.motors, time_s
        ):
            return True
        # motors that still hold may give way to those that do not
        return bool(self.sagged) and not self.world.energised

    def _shift_bounds(self, before: Point) -> None:
        """Move the starts of the bounds along with a tip that no command moves."""
        by = tuple(b - a for a, b in zip(before, self.world.tip, strict=True))
        for bound in self._bounds:
            x, y, z = (at + way for at, way in zip(bound.tip, by, strict=True))
            bound.tip = (x, y, z)

    @property
    def _path_is_judged(self) -> bool:
        command = self._command
        return command is not None and command.position_known and not self.misdirected

    @property
    def excused_motors(self) -> set[int]:
        """Motors whose place on the path of the present command no driver can know.

        With closed-loop drives, those that slipped or gave way. For steppers the path is judged by
        the expected place, so only those whose expected place is unknown.
        """
        lost = self.slipped | self.sagged if self.world.closed_loop else self.expected_unknown
        return self.with_coupled(lost | self.turned_in_command)

    def with_coupled(self, motors: set[int]) -> set[int]:
        """Return motors, with all others that turn, or depend on, a joint that they turn."""
        turned = self._joints_of(motors)
        matrix = self.world.body.transmission.matrix
        return motors | {
            motor
            for motor, row in enumerate(matrix)
            for name, share in zip(self.world.joints.names, row, strict=False)
            if share and name in turned
        }

    @property
    def unknown_motors(self) -> set[int]:
        """Motors whose physical place no driver can know; a slipped stepper gives no evidence."""
        return self.expected_unknown if self.world.closed_loop else self.slipped

    def excuse_hand_turn(self, steps: Motors) -> None:
        """Excuse motors that a person has turned, if no driver can know of it."""
        turned = {motor for motor, count in enumerate(steps) if count}
        self.slipped |= turned
        if self.world.closed_loop:
            self.expected_unknown |= turned
        else:
            self.world.set_expected(self.world.expected - steps)

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
        return bound.since_s + bound.time_s + self.late_s + NOISE_S

    def _check_bounds(self, time_s: float) -> None:
        for bound in self._bounds:
            if time_s > self._rests_by_s(bound) and not self._only_holds():
                after_s = time_s - bound.since_s
                self._violation(
                    f"{bound.what}: it moved {after_s:.2f} s later, not {bound.time_s:.2f}"
                )
            if self.slipped and not self.world.closed_loop:
                continue  # what coupled motors do without the one that slips is not announced
            way_mm = math.dist(self.world.tip, bound.tip)
            if way_mm > bound.distance_mm + self._step_mm:
                self._violation(
                    f"{bound.what}: it went {way_mm:.1f} mm, not {bound.distance_mm:.1f}"
                )

    def _check_path(self, time_s: float) -> None:
        command = self._command
        assert command is not None
        excused = self.excused_motors
        if command.span is not None:
            near = self.on_the_step + self.overshoot_steps
            for motor, (here, a, b) in enumerate(
                zip(self.world.expected, *command.span, strict=True)
            ):
                if motor not in excused and not min(a, b) - near <= here <= max(a, b) + near:
                    self._violation(f"motor {motor + 1} was at {here}, commanded from {a} to {b}")
        joints, free = self.world.expected_joints, self._joints_of(excused)
        violations = [
            each for each in self._guarded.arm.violations(joints) if each.joint not in free
        ]
        # if a joint's angle is unknown, so is the tip's place
        depth_mm = 0.0 if free else self.guard_depth_mm(joints)
        if self.missed_orders is not None and self.missed_orders.excuses(time_s):
            beyond_rad = {each.joint: each.excess for each in violations}
            self.missed_orders.allow_excess(command.excess_rad_at_start, beyond_rad, command.speed)
            command.depth_mm = max(command.depth_mm, depth_mm)
        for each in violations:
            off_rad = ROUNDING_RAD + command.speed * self.lost_targets.allowed_rad(
                each.joint, time_s
            )
            if each.excess > command.excess_rad_at_start.get(each.joint, 0.0) + off_rad:
                beyond = math.degrees(each.excess)
                self._violation(f"the {each.joint} was {beyond:.2f} degrees beyond its limit")
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


def _all_motors_rad_s(
    transmission: Transmission, speeds_rad_s: Sequence[float]
) -> tuple[float, ...]:
    """Return how fast each joint turns if all its motors turn it one way at their fastest."""
    motors_hz = fastest_hz(transmission, speeds_rad_s)
    return tuple(
        math.fsum(abs(share) * hz for share, hz in zip(row, motors_hz, strict=True))
        for row in transmission.inverse[: len(speeds_rad_s)]
    )
