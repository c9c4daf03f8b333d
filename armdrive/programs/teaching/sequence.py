"""A sequence on an arm: recorded from its motions, and stepped through. Units: deg, mm, s."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from armdrive.arm import Arm
from armdrive.errors import BadRequest, NotReferenced, Refused, Stopped
from armdrive.errors.arguments import known_attributes, made_of
from armdrive.moves import REST_S, JointMove, LineMove
from armdrive.programs.teaching.steps import finger_move, last_point
from armdrive.programs.waits import Waits
from armdrive.status import BELIEVED_WORDS
from armdrive.storage.points import SAME_OPENING_MM, Point, Step, StepList
from kinematics.spaces import Joints

# Recording: a step wherever the arm or its fingers come to rest. A recorder is given the arm's
# statuses and their times; it has no clock and no arm. Places where the arm rests only for a
# moment, such as between two jogs, do not count.

SAME_DEG = 0.05
"""The largest difference between equal postures: less than a step of any of these arms."""

RESTING = "standby"


@dataclass(frozen=True, slots=True)
class SeenPosture:
    """The posture in a status; `joints` is None if the arm does not rest."""

    joints: Joints | None
    opening_mm: float | None = None
    gripping: bool = False


@dataclass(frozen=True, slots=True)
class Choices:
    """The options of a recording.

    `how` and `speed` are those of every step to a point; with `waits` the rests become delays.
    """

    how: str = "joint"
    speed: float = 1.0
    waits: bool = False
    rest_s: float = REST_S


def seen_in(view: Mapping[str, Any], names: tuple[str, ...]) -> SeenPosture:
    """Read a status as `armdrive watch` prints it. Raises `NotReferenced` without a position."""
    joints = view.get("joints")
    trust = str(view.get("trust"))
    if trust not in BELIEVED_WORDS or joints is None:
        raise NotReferenced(
            f"the arm has no trusted position: it is {trust} "
            f"({view.get('trust_reason', '')}). Home it, then record"
        )
    if view.get("state") != RESTING or view.get("paused"):
        return SeenPosture(None)
    angles = (float(joints[f"{name}_deg"]) for name in names)
    opening = view.get("gripper_mm")
    return SeenPosture(
        Joints.of(*angles, names=names),
        None if opening is None else float(opening),
        bool(view.get("gripping")),
    )


class StepRecorder:
    """Makes a sequence of statuses; its points are named `NAME-1` and so on."""

    def __init__(self, name: str, choices: Choices) -> None:
        self.name = name
        self.points: dict[str, Point] = {}
        self.steps: list[Step] = []
        self._choices = choices
        self._standing: SeenPosture | None = None
        self._since_s = 0.0
        self._kept: SeenPosture | None = None

    def see(self, seen: SeenPosture, now_s: float) -> tuple[Step, ...]:
        """Take the present status; return the steps that it completes."""
        before = self._standing
        if before is not None and seen.joints is not None and _same(before, seen):
            return ()
        made = () if before is None else self._rested(before, now_s)
        self._standing = None if seen.joints is None else seen
        self._since_s = now_s
        return made

    def end(self, now_s: float) -> tuple[Step, ...]:
        """End with the place where the arm stands, however briefly it has rested there."""
        before, self._standing = self._standing, None
        return () if before is None else self._rested(before, now_s, enough=True)

    @property
    def sequence(self) -> StepList:
        """The recorded points and steps."""
        return StepList(tuple(self.steps), "recorded")

    def _rested(self, at: SeenPosture, now_s: float, *, enough: bool = False) -> tuple[Step, ...]:
        rested_s = now_s - self._since_s
        if rested_s < self._choices.rest_s and not enough:
            return ()
        made = [*self._way(at), *self._fingers(at)]
        if made and self._choices.waits and not enough:
            made.append(Step(wait_s=round(rested_s, 1)))
        if made:
            self._kept = at
        self.steps += made
        return tuple(made)

    def _way(self, at: SeenPosture) -> tuple[Step, ...]:
        """Return the step to a place, if the arm has moved; a known place keeps its name."""
        if at.joints is None or (self._kept is not None and _there(self._kept, at)):
            return ()
        name = next((n for n, each in self.points.items() if _near(each.joints, at.joints)), "")
        if not name:
            name = f"{self.name}-{len(self.points) + 1}"
            self.points[name] = Point(at.joints, at.opening_mm)
        return (Step(name, self._choices.how, self._choices.speed),)

    def _fingers(self, at: SeenPosture) -> tuple[Step, ...]:
        kept = self._kept
        if at.opening_mm is None or (kept is not None and _held_alike(kept, at)):
            return ()
        if at.gripping:
            return (Step(gripper="grasp"),)
        return (Step(gripper=round(at.opening_mm, 1)),)


def _same(a: SeenPosture, b: SeenPosture) -> bool:
    return _there(a, b) and _held_alike(a, b)


def _there(a: SeenPosture, b: SeenPosture) -> bool:
    return a.joints is not None and b.joints is not None and _near(a.joints, b.joints)


def _near(a: Joints, b: Joints) -> bool:
    pairs = zip(a.deg.values(), b.deg.values(), strict=True)
    return all(abs(one - other) <= SAME_DEG for one, other in pairs)


def _held_alike(a: SeenPosture, b: SeenPosture) -> bool:
    if a.gripping and b.gripping:  # the object stays gripped while the fingers press
        return True
    if a.opening_mm is None or b.opening_mm is None:
        return a.opening_mm is b.opening_mm
    return a.gripping == b.gripping and abs(a.opening_mm - b.opening_mm) < SAME_OPENING_MM


# Stepping, forwards and backwards, using the calls of an arm. Each call carries out one step and
# waits for its end; `run` carries out the rest. A step that was stopped stays the next one until it
# is asked for. The arm's own `pause` pauses a sequence too.


@known_attributes
class Stepper:
    """A running sequence: `at` counts the steps done, so `steps[at]` is the next one."""

    def __init__(self, arm: Arm, steps: StepList, points: Mapping[str, Point]) -> None:
        """Stand before the first step. Raises `BadRequest` for an empty sequence."""
        made_of(StepList, "a sequence", 'arm.points.sequence("stack")')("steps", steps)
        made_of(Mapping, "points by their names", "arm.points")("points", points)
        if not steps.steps:
            raise BadRequest("the sequence has no steps")
        self._arm = arm
        self.points = points
        self.steps = steps.steps
        self.at = 0
        self.running = False
        self._halted = False
        self._under_way: Step | None = None

    @property
    def next(self) -> Step | None:
        """The step that `forward` would carry out, None at the end."""
        at = self.at  # read once: another thread may be carrying out a step
        return self.steps[at] if at < len(self.steps) else None

    @property
    def before(self) -> tuple[Step, str] | None:
        """The effect of `backward`: the step that it undoes, and the point that it goes to.

        An arm that was stopped on its way to a point goes back to where it came from.
        """
        found = self._back()
        return None if found is None else (found[0], self.steps[found[1]].point)

    def _back(self) -> tuple[Step, int] | None:
        """Return the step to be undone, and the index of the step to the point before it."""
        moves, under_way = self._moves_done(), self._under_way
        ago = 2 if under_way is None else 1
        return (under_way or self.steps[moves[-1]], moves[-ago]) if len(moves) >= ago else None

    def forward(self, since: int | None = None) -> Step:
        """Carry out the next step. Raises `Refused` at the end, and what the motion raises.

        `since` is the arm's count of `stops` when this was decided on: after a later stop the step
        does not begin.
        """
        step = self.next
        if step is None:
            raise Refused("the sequence is at its end: step back, or begin again")
        self._done(step, self._arm.stops if since is None else since)
        return step

    def backward(self, since: int | None = None) -> str:
        """Go back to the point before, by the same kind of motion; return its name.

        The fingers stay as they are: a block stays gripped.
        """
        found = self._back()
        if found is None:
            raise Refused("the sequence has no earlier point")
        step, target = found
        point = self.steps[target].point
        stops = self._arm.stops if since is None else since
        self._require_no_stop(stops)
        self._go(point, step, stops)
        self.at = target + 1
        return point

    def run(self, shown: Callable[[Step], object] | None = None, since: int | None = None) -> int:
        """Carry out the remaining steps, or until `halt`; return the number of steps.

        `shown` is called with each step before it begins. A stop at any time, also between two
        steps, ends the sequence with `Stopped`.
        """
        stops, began = self._arm.stops if since is None else since, self.at
        self._halted, self.running = False, True
        try:
            while (step := self.next) is not None and not self._halted:
                if shown is not None:
                    shown(step)
                self._done(step, stops)
        finally:
            self.running = False
        return self.at - began

    def halt(self) -> None:
        """End `run` after the present step. May be called from any thread."""
        self._halted = True

    def rewind(self) -> None:
        """Go back to before the first step. Moves nothing."""
        self.at, self._under_way = 0, None

    # -- one step -----------------------------------------------------------------------------

    def _done(self, step: Step, stops: int) -> None:
        self._require_no_stop(stops)
        if step.point:
            self._go(step.point, step, stops)
        elif step.gripper is not None:
            at = self.points.get(last_point(self.steps[: self.at]))
            self._arm.start(finger_move(step, at), stops=stops).wait()
        else:
            self._wait(step.wait_s or 0.0, stops)
        self.at += 1

    def _go(self, point: str, step: Step, stops: int) -> None:
        kind = LineMove if step.how == "line" else JointMove
        handle = self._arm.start(kind(self.points[point].joints, step.speed), stops=stops)
        self._under_way = step if self._moves_done() else None
        handle.wait()
        self._under_way = None
        self._require_no_stop(stops)

    def _wait(self, time_s: float, stops: int) -> None:
        try:
            Waits(self._arm, since=stops).delay(time_s)
        except Stopped:
            self._require_no_stop(stops)
            raise

    def _require_no_stop(self, stops: int) -> None:
        if self._arm.stops != stops:
            raise Stopped(f"the sequence was stopped at step {self.at + 1}")

    def _moves_done(self) -> list[int]:
        return [index for index, step in enumerate(self.steps[: self.at]) if step.point]
