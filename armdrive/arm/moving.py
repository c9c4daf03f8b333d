"""Planned motion: from where the arm stands, audited as a whole, then handed to the engine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from armdrive.arm.connected import StatusView
from armdrive.arm.handle import Handle
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import PATIENCE_S, Parts
from armdrive.errors import BadRequest, OutOfBounds, Refused, Stopped
from armdrive.motion import execute as motion
from armdrive.motion.execute import Moved
from armdrive.motion.gripper import require_gripper, set_gripper
from armdrive.motion.plan import MotionPlan, plan_joints, plan_route, speed_fraction
from armdrive.motion.preview import Preview, preview_goal
from armdrive.motion.resolve import (
    TOOL,
    Ground,
    LineGoal,
    PoseGoal,
    ResolvedGoal,
    goal_in_base,
)
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.states import Event, after
from armdrive.status import State, Trust
from kinematics.errors import finite
from kinematics.paths.parts import ArcMove, JointMove, Move
from kinematics.spaces import Joints, Motors, Pose

PATIENCE = 4.0
"""A motion that takes this many times longer than planned, and then some, is given up."""

WAYS = JOINT, LINE = "joint", "line"
"""How `go` gets somewhere."""

PARK_HEIGHT_MM = 30.0
PARK_RISE_MM = 60.0


class Moving:
    """The planned motions of one arm."""

    def __init__(self, parts: Parts, view: StatusView) -> None:
        self._parts = parts
        self._view = view
        self._core = parts.core
        self._config = parts.config

    def begin(self, goal: ResolvedGoal, speed: float) -> Handle[Moved]:
        """Plan a way to a goal and hand it to the engine, unless a stop comes meanwhile."""
        stops = self._parts.runner.stops
        if goal.cartesian:
            self._core.require_geometry()
        fraction = speed_fraction(speed)

        def plan(here: ArmCoordinates) -> MotionPlan:
            return goal.plan(Ground(self._config, self._view.speeds, here), fraction)

        return self._start(plan, stops)

    def begin_path(self, moves: Sequence[Move], speed: float, frame: str) -> Handle[Moved]:
        """Plan several moves as one, and hand them to the engine."""
        self._core.require_geometry()
        fraction = speed_fraction(speed)
        if not moves:
            raise BadRequest("a path needs at least one move, for example LineMove(pose)")
        if frame == TOOL:
            raise BadRequest(
                "the tool's frame goes along with the arm: give a path in the base or in a frame "
                "of the arm file"
            )

        def plan(here: ArmCoordinates) -> MotionPlan:
            route = [_in_base(self._config, here.joints, move, frame) for move in moves]
            return plan_route(self._config, self._view.speeds, here, route, fraction)

        return self._start(plan)

    def move_fingers(self, opening_mm: float, speed: float) -> Moved:
        """Bring the fingers to an opening, and wait for the end."""
        opening_mm, fraction = finite("opening_mm", opening_mm), speed_fraction(speed)
        if not self._core.transmission.has_gripper:
            return self._set_gripper(opening_mm)

        def plan(here: ArmCoordinates) -> MotionPlan:
            there = ArmCoordinates(here.joints, opening_mm)
            return plan_joints(self._config, self._view.speeds, here, there, fraction)

        return self._start(plan).wait()

    def _set_gripper(self, opening_mm: float) -> Moved:
        """Command a gripper that is no stepper; the fingers take their own time."""
        runner = self._parts.runner
        with self._parts.pace.lock:
            require_gripper(self._core)
            after(self._core.state, Event.MOVE)
            task = runner.submit(set_gripper(self._parts.wire, opening_mm), alone=True)
        return runner.finish(task, PATIENCE_S)

    def move_motors(self, steps: Sequence[int], speed: float, stops: int | None) -> Moved:
        """Move each motor by whole steps from where it is; see `Arm.move_motors`."""
        core, runner = self._core, self._parts.runner
        motors, needed = Motors(tuple(steps)), core.controller.abilities.motors
        if len(motors) != needed:
            raise BadRequest(f"{needed} step counts are needed, not {len(motors)}")
        fraction = speed_fraction(speed)
        with self._parts.pace.lock:
            if core.state is not State.HOMING:
                after(core.state, Event.MOVE)
            if stops is not None and runner.stops != stops:
                raise Stopped("a stop was asked for before the motors began to turn")
            body = motion.bench_move(self._parts.wire, self._view.speeds, motors, fraction)
            task = runner.submit(body, alone=True)
        return runner.finish(task, PATIENCE_S * 10)

    def go_over(self, goal: Pose, speed: float) -> Moved:
        """Go to a pose; where a guard is in the way, rise first, as a person would."""
        try:
            return self.begin(PoseGoal(goal), speed).wait()
        except OutOfBounds:
            self.begin(LineGoal(raised(self._view.pose, PARK_RISE_MM)), speed).wait()
            return self.begin(PoseGoal(goal), speed).wait()

    @property
    def park_pose(self) -> Pose:
        """Where `park` goes: as the arm file says, else a little above the reference mark."""
        return self._config.park or self.above_mark

    @property
    def above_mark(self) -> Pose:
        """The pose a little above the reference mark. Raises `Refused` where there is none."""
        if self._config.model.reference is None:
            raise Refused("this arm has no park posture: write [park] into its arm file")
        return raised(self._config.model.reference.pose, PARK_HEIGHT_MM)

    def preview(self, goal: ResolvedGoal, speed: float) -> Preview:
        """Return what a motion to a goal would be, or why it is refused."""
        fraction = speed_fraction(speed)
        with self._parts.pace.lock:
            here, controller = self._core.position.coordinates, self._core.controller
            hindrance = self._hindrance(goal)
            known = self._core.belief.trust is not Trust.UNKNOWN
        if not known:
            return Preview(None, hindrance)
        ground = Ground(self._config, self._view.speeds, here)
        return preview_goal(ground, controller, goal, fraction, hindrance)

    def _hindrance(self, goal: ResolvedGoal) -> Refused | None:
        """Return why no motion to such a goal may begin now, whatever its way."""
        try:
            if goal.cartesian:
                self._core.require_geometry()
            self._core.require_reference()
            after(self._core.state, Event.MOVE)
            self._core.require_settings()
        except Refused as refusal:
            return refusal
        return None

    def _start(
        self, plan: Callable[[ArmCoordinates], MotionPlan], stops: int | None = None
    ) -> Handle[Moved]:
        """Plan from where the arm is, and hand the audited plan to the engine.

        A stop finds nothing to end before that: with `stops`, one that was asked for since then
        is what becomes of the motion.
        """
        core, runner = self._core, self._parts.runner
        with self._parts.pace.lock:
            core.require_reference()
            after(core.state, Event.MOVE)
            made = plan(core.position.coordinates)
            if stops is not None and runner.stops != stops:
                raise Stopped("a stop was asked for before the motion began")
            task = runner.submit(motion.follow(self._parts.wire, made), alone=True)
        return Handle(runner, task, made.duration_s * PATIENCE + PATIENCE_S)


def raised(pose: Pose, by_mm: float) -> Pose:
    """Return a pose straight above another."""
    return replace(pose, z_mm=pose.z_mm + by_mm)


def _in_base(config: ArmConfig, joints: Joints, move: Move, frame: str) -> Move:
    """Return a move with its poses as the base sees them."""
    if isinstance(move, JointMove):
        return move
    goal = goal_in_base(config, joints, move.goal, frame)
    if isinstance(move, ArcMove):
        return replace(move, goal=goal, via=goal_in_base(config, joints, move.via, frame))
    return replace(move, goal=goal)
