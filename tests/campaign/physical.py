"""The physical arm under watch: every motion of it is seen, and who or what has moved it.

Nothing here asks a register or the driver; what breaks a promise is noted in `Watch.broken`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from armdrive.sim.body import ArmBody
from armdrive.sim.world import World
from kinematics import Joints, Motors
from kinematics.guards import GuardedArm
from tests.conformance.seen import ON_THE_STEP, Point

from .freed import Freed

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
        super().__init__(body)

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
            self.watch.freed.blocked(failing, time_s)
            self.watch.slipped(failing)  # before the way is judged that the others make without it
        super().drive(steps, time_s)
        if self.watch is not None:
            meant = before + Motors(steps)
            if meant != self._motors:
                self.watch.slipped(
                    {i for i, (a, b) in enumerate(zip(meant, self._motors, strict=True)) if a != b}
                )

    def fails(self, motor: int) -> bool:
        """Tell whether a motor does not follow now, by a fault."""
        return motor in self.stalled or bool(self._to_lose.get(motor))

    def _shift(self, steps: Motors, time_s: float) -> None:
        before = self._motors
        super()._shift(steps, time_s)
        if self.watch is not None and self._motors != before:
            pairs = zip(before, self._motors, strict=True)
            self.watch.moved(time_s, {i for i, (a, b) in enumerate(pairs) if a != b})


class Unled(Protocol):
    """A drive that obeys nobody for a while (`unled`)."""

    def begin(self) -> None:
        """Hear that another command begins."""

    def excuses(self, time_s: float) -> bool:
        """Tell whether nobody can know yet that a motion goes astray."""

    def let_pass(self, allowed: dict[str, float], beyond: Mapping[str, float]) -> None:
        """Have joints be as far beyond their limits as they have come."""


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
        on_the_step: int = ON_THE_STEP,
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
        self.sagged = False
        self.slips: set[int] = set()
        """Motors that have slipped since the last reference; no stepper notices."""
        self.changed_s = self.evidence_by_s = -math.inf
        """When something last changed that no command made, and until when nobody can know."""
        self.told_by_s = -math.inf
        """Until when a restart is told that left the registers as they were, at zero."""
        self.unled: Unled | None = None
        """What is excused of a drive that obeys no more."""
        self.freed = Freed()
        """What is excused of a shaft that was blocked while nobody heard its drive."""
        self._guarded = guarded
        self._step_mm = step_mm
        self._command: Command | None = None
        self._until_s = -math.inf
        self._bounds: list[Bound] = []
        self._last_what = "nothing"
        self._disturbed = False
        world.watch = self

    # -- what is allowed ------------------------------------------------------------------------

    def begin(self, command: Command) -> None:
        """Hear that a call may move the arm from now on."""
        arm, joints = self._guarded.arm, self.world.joints
        command.joints_beyond = {each.joint: each.excess_rad for each in arm.violations(joints)}
        command.depth_mm = self.inside_mm(joints)
        self._command, self._until_s = command, math.inf
        self._disturbed = False
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

    def referred(self) -> None:
        """Hear that somebody has looked at the arm and said where it stands."""
        self.stray = self.sagged = False
        self.late_s = 0.0
        self.slips.clear()
        self.changed_s = self.evidence_by_s = self.told_by_s = -math.inf

    def change(self, now_s: float, known_by_s: float) -> None:
        """Hear of a change that no command made, and when it can be known at the latest."""
        self.changed_s, self.evidence_by_s = now_s, max(self.evidence_by_s, known_by_s)

    def asleep(self, now_s: float, for_s: float) -> None:
        """Hear that the program is suspended for so long: it cannot look meanwhile."""
        self.evidence_by_s += for_s if now_s < self.evidence_by_s else 0.0
        self.told_by_s += for_s if now_s < self.told_by_s else 0.0

    def untold(self, now_s: float | None = None) -> None:
        """Hear that nobody can know of a restart at zeros, or not if it has not been told by now.

        The position is nobody's promise then until the next reference.
        """
        if now_s is None or now_s < self.told_by_s:
            self.slips |= set(range(len(self.world.motors)))

    # -- what is seen ---------------------------------------------------------------------------

    def slipped(self, motors: set[int]) -> None:
        """Note motors that did not follow."""
        before = len(self.slips)
        self.slips |= motors
        by_fault = self.world.stalled or any(self.world._to_lose.values())
        last = len(self.world.motors) - 1
        fingers = self.world.body.transmission.has_gripper and motors <= {last}
        innocent = by_fault or fingers or before or not self._promised
        if not innocent and self._blocked():
            self._break(f"a joint was driven into its mechanical stop: {self.world.joints}")

    def moved(self, time_s: float, motors: Collection[int]) -> None:
        """Weigh a motion of the physical arm, for which these motors have turned."""
        if self.world.sagging:
            self.sagged = True
            return
        if self.world.by_person:
            self._disturbed = True  # the present command does not know of it
        if self.world.by_person or self.stray:
            return
        if self.freed.excuses(motors, time_s):
            return
        if self.sagged and not self.world.energised:
            return  # what still holds does so against what does not
        if time_s > self._until_s:
            late_s = time_s - self._until_s
            self._break(f"it moved without a command, {late_s:.2f} s after: {self._last_what}")
        if self.sagged:
            return
        self._keep_bounds(time_s)
        if self._promised and not self.slips:
            self._keep_way(time_s)

    @property
    def _promised(self) -> bool:
        command = self._command
        excused = self.stray or self.sagged or self._disturbed
        return command is not None and command.known and not excused

    def _blocked(self) -> bool:
        return any(name not in ("gripper", "table") for name in self.world._blocked)

    def _keep_bounds(self, time_s: float) -> None:
        for bound in self._bounds:
            after_s = time_s - bound.since_s
            if after_s > bound.time_s + self.late_s + NOISE_S:
                self._break(f"{bound.what}: it moved {after_s:.2f} s later, not {bound.time_s:.2f}")
            way_mm = math.dist(self.world.tip, bound.tip)
            if way_mm > bound.distance_mm + self._step_mm:
                self._break(f"{bound.what}: it went {way_mm:.1f} mm, not {bound.distance_mm:.1f}")

    def _keep_way(self, time_s: float) -> None:
        command = self._command
        assert command is not None
        if command.span is not None:
            for here, a, b in zip(self.world.motors, *command.span, strict=True):
                near = self.on_the_step + self.overshoot_steps
                if not min(a, b) - near <= here <= max(a, b) + near:
                    self._break(f"a motor was at {here}, commanded from {a} to {b}")
        violations = self._guarded.arm.violations(self.world.joints)
        depth_mm = self.inside_mm(self.world.joints)
        if self.unled is not None and self.unled.excuses(time_s):
            beyond_rad = {each.joint: each.excess_rad for each in violations}
            self.unled.let_pass(command.joints_beyond, beyond_rad)
            command.depth_mm = max(command.depth_mm, depth_mm)
        for each in violations:
            if each.excess_rad > command.joints_beyond.get(each.joint, 0.0) + ROUNDING_RAD:
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
