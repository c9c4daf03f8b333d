"""The physical arm under watch: every motion of it is seen, and who or what has moved it.

Nothing here asks a register or the driver; what breaks a promise is noted in `Watch.broken`.

A stepper that slips gives no evidence, so no driver can know where its motor stands. What a driver
commanded is still known: `WatchedWorld.supposed` is where the motors would stand if every one had
made the steps that its controller gave it. The way of a motion is judged there. For motors that
have not slipped it is where they stand, and for a motor that has, the commands are judged.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Protocol

from armdrive.sim.world.arm import World
from armdrive.sim.world.body import ArmBody
from kinematics import Joints, Motors
from kinematics.guards.guards import GuardedArm
from tests.conformance.seen import ON_THE_STEP, Point

from .freed import Freed
from .lagging import Lagging
from .speeds import SpeedWatch

NOISE_S = 0.03
"""What lies between an event and the next look at it."""
ROUNDING_RAD = math.radians(0.5)
"""Motors stand on whole steps: a joint may be beyond a limit by so much."""


class WatchedWorld(World):
    """The physical arm, which tells a watch of every motion, and notes who is the cause."""

    def __init__(self, body: ArmBody) -> None:
        self.watch: Watch | None = None
        self.by_person = False
        self.sagging = False
        self.measured = False
        """Whether the drives measure their shafts, and make up for steps that were lost."""
        self._told: Motors | None = None
        """The steps that a controller gives its motors now."""
        self._all_follow = False
        """Whether what turns now are those steps, every one of them."""
        super().__init__(body)
        self._supposed = self._motors

    @property
    def supposed(self) -> Motors:
        """Where the motors would stand, had none slipped or sagged since the last reference."""
        return self._motors if self.measured else self._supposed

    @property
    def supposed_joints(self) -> Joints:
        """The joint angles that belong to `supposed`."""
        there = self.supposed
        if there == self._motors:
            return self._joints
        return self.body.transmission.to_joints(there)[0]

    def suppose(self, there: Motors) -> None:
        """Hear where the motors were seen to stand, or are to be supposed from now on."""
        self._supposed = there

    def cut_current(self, time_s: float = 0.0) -> None:
        """Let the arm sag."""
        self.sagging = True
        try:
            super().cut_current(time_s)
        finally:
            self.sagging = False

    def give_way(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Let a part of the arm sag."""
        self.sagging = True
        try:
            super().give_way(steps, time_s)
        finally:
            self.sagging = False

    def drive(self, steps: Motors, time_s: float = 0.0) -> None:  # type: ignore[override]
        """Turn the motors, and note which of them did not follow."""
        before = self._motors
        failing = {i for i, one in enumerate(steps) if one and self.fails(i)}
        if failing and self.watch is not None:
            in_motion = self.watch.may_move(time_s)
            self.watch.freed.blocked(failing, time_s, in_motion=in_motion)
            # before the way is judged that the others make without it
            self.watch.slipped(failing, time_s)
        meant = before + Motors(steps)
        self._told = Motors(steps)
        try:
            super().drive(steps, time_s)
        finally:
            self._told = None
        if self.watch is not None and meant != self._motors:
            pairs = enumerate(zip(meant, self._motors, strict=True))
            self.watch.slipped({i for i, (a, b) in pairs if a != b}, time_s)

    def force(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Turn motors; what was told to those that do not follow goes on in the same pieces."""
        told, self._told = self._told, None
        if told is None or tuple(told) == tuple(steps):
            if told is None and self.watch is not None:
                self.watch.speeds.forget()  # what runs on from a dead stop is shown at once
            self._all_follow = told is not None
            super().force(steps, time_s)
            self._all_follow = False
            return
        last = len(told) - self.body.transmission.has_gripper
        pieces = 1 + max(map(abs, told[:last]), default=0) // self._sample_steps
        made = promised = Motors((0,) * len(told))
        for piece in range(1, pieces + 1):
            share = Motors(count * piece // pieces for count in steps)
            meant = Motors(count * piece // pieces for count in told)
            self._supposed = self._supposed + (meant - promised)
            self._shift(share - made, time_s)
            made, promised = share, meant

    def fails(self, motor: int) -> bool:
        """Tell whether a motor does not follow now, by a fault."""
        return motor in self.stalled or bool(self._to_lose.get(motor))

    def _shift(self, steps: Motors, time_s: float) -> None:
        before, tip = self._motors, self.tip
        if self._all_follow:
            self._supposed = self._supposed + steps
        super()._shift(steps, time_s)
        if self.watch is not None and self._motors != before:
            pairs = zip(before, self._motors, strict=True)
            self.watch.moved(time_s, {i for i, (a, b) in enumerate(pairs) if a != b}, tip)


class Unled(Protocol):
    """A drive that obeys nobody for a while (`unled`)."""

    @property
    def joints(self) -> frozenset[str]:
        """Those that its motor turns."""

    def begin(self) -> None:
        """Hear that another command begins."""

    def excuses(self, time_s: float) -> bool:
        """Tell whether nobody can know yet that a motion goes astray."""

    def let_pass(self, allowed: dict[str, float], beyond: Mapping[str, float]) -> None:
        """Have joints be as far beyond their limits as they have come."""


class Turned(Protocol):
    """Shafts that a hand has turned (`turned`)."""

    @property
    def until_s(self) -> float:
        """Until when their drives may turn them back."""

    def excuses(self, motors: Collection[int], there: Motors, time_s: float) -> bool:
        """Tell whether no driver can know yet that a hand has turned these motors."""


class Aim(Protocol):
    """Where a call is to bring the arm (`arrival`)."""

    def missed(self, world: WatchedWorld, result: object, excused: Collection[int]) -> str:
        """Return what is wrong with where the arm stands, or nothing.

        `result` is what the call returned, `excused` the motors of which nobody can know.
        """


@dataclass(slots=True)
class Bound:
    """A promise how long and how far the tip goes on, from a moment on."""

    what: str
    since_s: float
    tip: Point
    time_s: float
    distance_mm: float


@dataclass(slots=True)
class Command:
    """A call that may move the arm, and what is promised of its way."""

    what: str
    known: bool = False
    """Whether the position was trusted when it was given: limits and guards hold then."""
    span: tuple[Motors, Motors] | None = None
    """Between which ends every motor stays: supposed positions."""
    aim: Aim | None = None
    """Where the arm stands when the call ends well; None where nothing is promised of its end."""
    speed: float = 1.0
    """No joint turns faster than this fraction of its limit."""
    joints_beyond: dict[str, float] = field(default_factory=dict)
    depth_mm: float = 0.0
    slack_mm: float = 0.0
    verified: bool = True
    """Whether its good end says that the registers were looked at a moment ago."""


class Watch:
    """What is seen of one arm, and which of its motions are allowed."""

    def __init__(
        self,
        world: WatchedWorld,
        guarded: GuardedArm,
        step_mm: float,
        speeds_rad_s: tuple[float, ...],
        on_the_step: int = ON_THE_STEP,
        slowest_hz: float = 0.0,
        setting_hz: float = 0.0,
    ) -> None:
        self.world = world
        self.on_the_step = on_the_step
        """So many steps may be between two counts of the same place."""
        self.overshoot_steps = 0
        """How many steps a stop may take a motor beyond where it was sent."""
        self.broken: list[str] = []
        self.stray = False
        """Something has happened that no driver can prevent: the way is nobody's promise now."""
        self.late_s = 0.0
        """How much later than it was sent the wire has delivered something."""
        self.slips: set[int] = set()
        """Motors that have slipped since the last reference; no stepper notices."""
        self.sags: set[int] = set()
        """Motors that gave way without current since the last reference."""
        self.adrift: set[int] = set()
        """Motors whose supposed place nobody can know either, since the last reference."""
        self.changed_s = self.evidence_by_s = -math.inf
        """When something last changed that no command made, and until when nobody can know."""
        self.told_by_s = -math.inf
        """Until when a restart is told that left the registers as they were, at zero."""
        self.unled: Unled | None = None
        """What is excused of a drive that obeys no more."""
        self.turned: Turned | None = None
        """What is excused of shafts that a hand has turned a moment ago."""
        self.freed = Freed()
        """What is excused of a shaft that was blocked while nobody heard its drive."""
        self.lagging = Lagging()
        """What is excused of a joint one of whose motors misses its targets."""
        self._guarded = guarded
        self._step_mm = step_mm
        self._command: Command | None = None
        self._until_s = -math.inf
        self._earlier_speed, self._earlier_until_s = 0.0, -math.inf
        """The speed of the command before, and until when what it has sent may run on."""
        self._bounds: list[Bound] = []
        self._stood = world.motors
        """Where the motors were when they last turned as they may."""
        self._last_what = "nothing"
        self._before: tuple[set[int], set[int], bool, float, tuple[float, float, float]] | None = (
            None
        )
        """What was excused before the latest reference, which may not have been taken."""
        self.disturbed: set[int] = set()
        """Motors that somebody has turned since the present command began."""
        self.sagged: set[int] = set()
        """Motors that gave way since the present command began."""
        self._turning = tuple(
            (name, frozenset(motor for motor, share in enumerate(row) if share))
            for name, row in zip(world.joints.names, world.body.transmission.inverse, strict=False)
        )
        """Each joint, and the motors that turn it."""
        inverse = world.body.transmission.inverse[: len(world.joints)]
        steps_rad = [math.fsum(map(abs, row)) for row in inverse]
        self.speeds = SpeedWatch(
            speeds_rad_s,
            tuple(step_rad * on_the_step for step_rad in steps_rad),
            tuple(step_rad * slowest_hz for step_rad in steps_rad),
            tuple(step_rad * setting_hz for step_rad in steps_rad),
        )
        world.watch = self

    # -- what is allowed ------------------------------------------------------------------------

    def begin(self, command: Command) -> None:
        """Hear that a call may move the arm from now on."""
        arm, joints = self._guarded.arm, self.world.supposed_joints
        command.joints_beyond = {each.joint: each.excess_rad for each in arm.violations(joints)}
        command.depth_mm = self.inside_mm(joints)
        if self._command is not None:
            self._earlier_speed, self._earlier_until_s = self._command.speed, self._until_s
        self._command, self._until_s = command, math.inf
        self.disturbed.clear()
        self.sagged.clear()
        self.speeds.forget()
        if self.unled is not None:
            self.unled.begin()
        self._last_what = command.what
        self._bounds.clear()

    def end(self, now_s: float, runs_on_s: float) -> None:
        """Hear that the call has ended; what it has sent may run on for so long."""
        self._until_s = now_s + runs_on_s + self.late_s + NOISE_S

    def promise(self, bound: Bound) -> None:
        """Hear how long and how far the tip may go on."""
        self._bounds.append(bound)

    @property
    def promised(self) -> bool:
        """Whether the tip is to come to rest."""
        return bool(self._bounds)

    def let_go_on(self) -> None:
        """Hear that what was promised to come to rest may go on."""
        self._bounds.clear()

    def referred(self, *, faultless: bool = True) -> None:
        """Hear that somebody looks at the arm and is about to say where it stands.

        While faults go on, what they excuse of the wire and of the future stays excused.
        """
        self._before = (
            self.slips | self.adrift,
            set(self.sags),
            self.stray,
            self.late_s,
            (self.changed_s, self.evidence_by_s, self.told_by_s),
        )
        self.slips.clear()
        self.adrift.clear()
        self.world.suppose(self.world.motors)
        if faultless:
            self.stray = False
            self.late_s = 0.0
            self.sags.clear()
            self.changed_s = self.evidence_by_s = self.told_by_s = -math.inf

    def not_referred(self) -> None:
        """Hear that nothing may have come of that: the old reference may hold, or the new one."""
        if self._before is None:
            return
        lost, sags, stray, late_s, (changed_s, evidence_by_s, told_by_s) = self._before
        self._before = None
        self.slips |= lost
        self.adrift |= lost
        self.sags |= sags
        self.stray = self.stray or stray
        self.late_s = max(self.late_s, late_s)
        self.changed_s = max(self.changed_s, changed_s)
        self.evidence_by_s = max(self.evidence_by_s, evidence_by_s)
        self.told_by_s = max(self.told_by_s, told_by_s)

    @contextmanager
    def referencing(self) -> Iterator[Callable[[], None]]:
        """Hold a call that references; what this gives is to be called when it has ended well."""
        self._before = None
        well = False

        def ended_well() -> None:
            nonlocal well
            well = True

        try:
            yield ended_well
        finally:
            if not well:
                self.not_referred()

    def change(self, now_s: float, known_by_s: float) -> None:
        """Hear of a change that no command made, and when it can be known at the latest."""
        self.changed_s, self.evidence_by_s = now_s, max(self.evidence_by_s, known_by_s)

    def asleep(self, now_s: float, for_s: float) -> None:
        """Hear that the program is suspended for so long: it cannot look meanwhile."""
        self.evidence_by_s += for_s if now_s < self.evidence_by_s else 0.0
        self.told_by_s += for_s if now_s < self.told_by_s else 0.0

    def untold(self, now_s: float | None = None, motors: Collection[int] | None = None) -> None:
        """Hear that nobody can know of a restart at zeros, or not if it has not been told by now.

        The position of these motors, or of all, is nobody's promise until the next reference.
        """
        if now_s is None or now_s < self.told_by_s:
            lost = set(range(len(self.world.motors)) if motors is None else motors)
            self.slips |= lost
            self.adrift |= lost

    # -- what is seen ---------------------------------------------------------------------------

    def slipped(self, motors: set[int], time_s: float) -> None:
        """Note motors that did not follow."""
        failing = {motor for motor in range(len(self.world.motors)) if self.world.fails(motor)}
        known = self.slips | self.sags | self.disturbed | failing
        self.slips |= motors
        last = len(self.world.motors) - 1
        fingers = self.world.body.transmission.has_gripper and motors <= {last}
        if fingers or not self._promised:
            return
        blocked = self._blocked() - self._turned_by(known)
        if self.unled is not None and self.unled.excuses(time_s):
            blocked -= self.unled.joints  # they may go beyond their limits, and so to their stops
        if blocked:
            self._break(
                f"{', '.join(sorted(blocked))}: driven into a mechanical stop: {self.world.joints}"
            )

    def moved(self, time_s: float, motors: Collection[int], tip: Point) -> None:
        """Weigh a motion of the physical arm, for which these motors have turned, from a tip."""
        if self.world.sagging or self.world.by_person:
            self.speeds.forget()
            self._stood = self.world.motors
        if self.world.sagging:
            self.sags |= set(motors)
            self.sagged |= set(motors)
            self._carry_bounds(tip)
            return
        if self.world.by_person:
            self.disturbed |= set(motors)  # the present command does not know of it
            self._carry_bounds(tip)
            return
        if self._is_excused(motors, time_s):
            self._stood = self.world.motors
            return
        if time_s > self._until_s and not self._trembles():
            late_s = time_s - self._until_s
            self._break(f"it moved without a command, {late_s:.2f} s after: {self._last_what}")
        self._keep_bounds(time_s)
        if self.may_move(time_s):
            self._stood = self.world.motors
        share = 1.0 if self._command is None else self._command.speed
        if time_s <= self._earlier_until_s < math.inf:
            share = max(share, self._earlier_speed)
        caught_up = self._turned_by(self.slips | self.sags | self.disturbed)
        if sentence := self.speeds.too_fast(time_s, self.world.joints, share, caught_up):
            self._break(sentence)
        if self._promised:
            self._keep_way(time_s)

    def may_move(self, time_s: float) -> bool:
        """Tell whether a command moves the arm, or it has not come to rest yet as promised."""
        return time_s <= min((self._until_s, *map(self._ends_s, self._bounds)))

    def _is_excused(self, motors: Collection[int], time_s: float) -> bool:
        """Tell whether no driver can know of a motion, or prevent it."""
        if self.stray or self.freed.excuses(motors, time_s):
            return True
        if self.turned is not None and self.turned.excuses(motors, self.world.motors, time_s):
            return True
        # what still holds does so against what does not
        return bool(self.sags) and not self.world.energised

    def _carry_bounds(self, before: Point) -> None:
        """Have the bounds count from where the tip is carried that no command moves."""
        by = tuple(b - a for a, b in zip(before, self.world.tip, strict=True))
        for bound in self._bounds:
            x, y, z = (at + way for at, way in zip(bound.tip, by, strict=True))
            bound.tip = (x, y, z)

    @property
    def _promised(self) -> bool:
        command = self._command
        return command is not None and command.known and not self.stray

    @property
    def excused(self) -> set[int]:
        """Motors whose place on the way of the present command nobody can know.

        Where drives measure their shafts, those that did not follow their drive, or gave way. A
        stepper's commands are judged in place of its shaft.
        """
        lost = self.slips | self.sags if self.world.measured else self.adrift
        return self.with_coupled(lost | self.disturbed)

    def with_coupled(self, motors: set[int]) -> set[int]:
        """Return motors with those that see a joint which they turn: its angle decides of all."""
        turned = self._turned_by(motors)
        matrix = self.world.body.transmission.matrix
        return motors | {
            motor
            for motor, row in enumerate(matrix)
            for name, share in zip(self.world.joints.names, row, strict=False)
            if share and name in turned
        }

    @property
    def unknowable(self) -> set[int]:
        """Motors of which nobody can know where they stand: no stepper notices that it slips."""
        return self.adrift if self.world.measured else self.slips

    def overlooked(self, steps: Motors) -> None:
        """Hear that somebody has turned motors of which no driver can know that they were."""
        turned = {motor for motor, count in enumerate(steps) if count}
        self.slips |= turned
        if self.world.measured:
            self.adrift |= turned
        else:
            self.world.suppose(self.world.supposed - steps)

    def _turned_by(self, motors: Collection[int]) -> set[str]:
        """Return the joints that any of these motors turns."""
        return {name for name, turning in self._turning if not turning.isdisjoint(motors)}

    def _blocked(self) -> set[str]:
        return {name for name in self.world._blocked if name not in ("gripper", "table")}

    def _trembles(self) -> bool:
        """Tell whether drives only hold: none is farther from where it stood than it may rest.

        Two that are coupled, and are sent to where their shafts stand against a stop, give way to
        each other by some counts: their orders are frames that come one after the other.
        """
        pairs = zip(self.world.motors, self._stood, strict=True)
        return self.world.measured and all(abs(a - b) <= self.on_the_step for a, b in pairs)

    def _ends_s(self, bound: Bound) -> float:
        """Return by when the arm is to stand."""
        return bound.since_s + bound.time_s + self.late_s + NOISE_S

    def _keep_bounds(self, time_s: float) -> None:
        for bound in self._bounds:
            if time_s > self._ends_s(bound) and not self._trembles():
                after_s = time_s - bound.since_s
                self._break(f"{bound.what}: it moved {after_s:.2f} s later, not {bound.time_s:.2f}")
            way_mm = math.dist(self.world.tip, bound.tip)
            if way_mm > bound.distance_mm + self._step_mm:
                self._break(f"{bound.what}: it went {way_mm:.1f} mm, not {bound.distance_mm:.1f}")

    def _keep_way(self, time_s: float) -> None:
        command = self._command
        assert command is not None
        excused = self.excused
        if command.span is not None:
            near = self.on_the_step + self.overshoot_steps
            for motor, (here, a, b) in enumerate(
                zip(self.world.supposed, *command.span, strict=True)
            ):
                if motor not in excused and not min(a, b) - near <= here <= max(a, b) + near:
                    self._break(f"motor {motor + 1} was at {here}, commanded from {a} to {b}")
        joints, free = self.world.supposed_joints, self._turned_by(excused)
        violations = [
            each for each in self._guarded.arm.violations(joints) if each.joint not in free
        ]
        # a joint whose angle nobody can know leaves the tip's place unknown as well
        depth_mm = 0.0 if free else self.inside_mm(joints)
        if self.unled is not None and self.unled.excuses(time_s):
            beyond_rad = {each.joint: each.excess_rad for each in violations}
            self.unled.let_pass(command.joints_beyond, beyond_rad)
            command.depth_mm = max(command.depth_mm, depth_mm)
        for each in violations:
            off_rad = ROUNDING_RAD + command.speed * self.lagging.allowed_rad(each.joint, time_s)
            if each.excess_rad > command.joints_beyond.get(each.joint, 0.0) + off_rad:
                beyond = math.degrees(each.excess_rad)
                self._break(f"the {each.joint} was {beyond:.2f} degrees beyond its limit")
        # within its tolerance a guard reports nothing, and just beyond it the whole depth
        began_mm = max(command.depth_mm, self._guarded.guards.tolerance_mm)
        if depth_mm > began_mm + command.slack_mm + self._step_mm:
            self._break(
                f"it was {depth_mm:.3f} mm inside a guard, and began {command.depth_mm:.1f}"
            )

    def inside_mm(self, joints: Joints) -> float:
        """Return how deep a posture is inside a guard."""
        broken = self._guarded.violations(joints)
        return max((each.excess_mm for each in broken), default=0.0)

    def _break(self, sentence: str) -> None:
        if sentence not in self.broken:
            self.broken.append(sentence)
