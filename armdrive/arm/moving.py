"""Planned motion: to joint angles, to a pose, along a line, to the park posture, by raw steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Literal, Unpack, overload

from armdrive.arm.devices import Place, PointCalls
from armdrive.arm.handle import Handle
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import PATIENCE_S
from armdrive.errors import BadRequest, OutOfBounds, Refused, Stopped
from armdrive.motion import execute as motion
from armdrive.motion.execute import Moved
from armdrive.motion.gripper import require_gripper, set_gripper
from armdrive.motion.plan import MotionPlan, plan_joints, plan_route, speed_fraction
from armdrive.motion.preview import Preview, preview_goal
from armdrive.motion.resolve import BASE, TOOL, Ground, JointGoal, ResolvedGoal, goal_in_base
from armdrive.moves import Angles, JointAngles, by_name
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.states import Event, after
from armdrive.status import State, Trust
from kinematics.paths.parts import ArcMove, JointMove, Move
from kinematics.spaces import Joints, Motors, Pose

PATIENCE = 4.0
"""A motion that takes this many times longer than planned, and then some, is given up."""

WAYS = JOINT, LINE = "joint", "line"
"""How `go` gets somewhere."""

PARK_HEIGHT_MM = 30.0
PARK_RISE_MM = 60.0


class MoveCalls(PointCalls):
    """The calls that move to a goal."""

    @overload
    def move_j(
        self,
        angles_deg: Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: Literal[True] = True,
        **joints_deg: Unpack[JointAngles],
    ) -> Moved: ...
    @overload
    def move_j(
        self,
        angles_deg: Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: Literal[False],
        **joints_deg: Unpack[JointAngles],
    ) -> Handle[Moved]: ...
    def move_j(
        self,
        angles_deg: Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: bool = True,
        **joints_deg: Unpack[JointAngles],
    ) -> Moved | Handle[Moved]:
        """Move the named joints, `shoulder_deg=40, elbow_deg=-60`; the others stay.

        Joints that a model file names otherwise are given in a mapping, `{"turret_deg": 30}`.
        Straight in joint space. `speed` is a fraction of the limits. The whole way is audited
        first: `OutOfBounds` names the joint or guard, and nothing has moved. With `wait=False` a
        `Handle` is returned at once.
        """
        handle = self._go(JointGoal(by_name(angles_deg, joints_deg)), speed)
        return handle.wait() if wait else handle

    @overload
    def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[True] = True
    ) -> Moved: ...
    @overload
    def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> Handle[Moved]: ...
    def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | Handle[Moved]:
        """Move the tip to a pose by a joint motion, to the posture nearest to the present one.

        Or to a named point, `move_to("pick")`: to its joints; the fingers stay as they are.
        The pose is one of `frame`: the base, a frame of the arm file, or the tool, in which it is
        a change from where the tool is (frames.py).
        Raises `kinematics.Unreachable` or `OutOfBounds` with the nearest pose that is allowed.
        """
        handle = self._go(self.goal_of(goal, frame), speed)
        return handle.wait() if wait else handle

    @overload
    def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[True] = True
    ) -> Moved: ...
    @overload
    def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> Handle[Moved]: ...
    def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | Handle[Moved]:
        """Move the tip to a pose, or to a named point's, along a straight line.

        Straight in x, y, z, pitch and roll. Of a point, `note` says so where the line ends in
        another posture than it was taught in.
        `frame` is as of `move_to`: `move_l(Pose.of(x_mm=0, y_mm=0, z_mm=-30, pitch_deg=0),
        frame="tool")` draws the hand 30 mm back.
        The tip leaves the line by at most `motion.line_tolerance_mm` of the arm file and what one
        motor step is worth. Raises `kinematics.PathBroken` where the line leaves the reach.
        """
        handle = self._go(self.goal_of(goal, frame, line=True), speed)
        return handle.wait() if wait else handle

    def go(self, place: Place, *, how: str = "joint", speed: float = 1.0) -> Handle[Moved]:
        """Begin to move to a pose or a point, by a "joint" motion or along a "line"; never waits.

        As a step of a sequence says it: `move_to` and `move_l` with `wait=False`.
        """
        if how not in WAYS:
            raise BadRequest(f"how is {' or '.join(map(repr, WAYS))}, not {how!r}")
        return self._go(self.goal_of(place, line=how == LINE), speed)

    def move_gripper(self, opening_mm: float, speed: float) -> Moved:
        """Bring the fingers to an opening in mm; see `Arm.gripper`."""
        if not self.core.transmission.has_gripper:
            return self._set_gripper(opening_mm)
        return self._start(
            lambda here: plan_joints(
                self.config, self.speeds, here, ArmCoordinates(here.joints, opening_mm), speed
            )
        ).wait()

    def _set_gripper(self, opening_mm: float) -> Moved:
        """Command a gripper that is no stepper; the fingers take their own time."""
        with self.pace.lock:
            require_gripper(self.core)
            after(self.core.state, Event.MOVE)
            task = self.submit(set_gripper(self.wire, opening_mm), alone=True)
        return self.finish(task, PATIENCE_S)

    def move_motors(self, *steps: int, speed: float = 0.25, stops: int | None = None) -> Moved:
        """Move each motor by whole steps from where it is, all together: for the bench.

        Knows neither limits nor guards and needs no reference. With `stops`, the count of stops
        when it was asked for, one that came since then keeps it from beginning: raises `Stopped`.
        """
        motors = Motors(steps)
        if len(motors) != self.abilities.motors:
            raise BadRequest(f"{self.abilities.motors} step counts are needed, not {len(motors)}")
        fraction = speed_fraction(speed)
        with self.pace.lock:
            if self.core.state is not State.HOMING:
                after(self.core.state, Event.MOVE)
            if stops is not None and self.stops != stops:
                raise Stopped("a stop was asked for before the motors began to turn")
            flow = motion.bench_move(self.wire, self.speeds, motors, fraction)
            task = self.submit(flow, alone=True)
        return self.finish(task, PATIENCE_S * 10)

    def park(self, *, speed: float = 1.0) -> Moved:
        """Go to the park posture of the arm file; by default, 30 mm above the reference mark."""
        return self.go_over(self.config.park or self.above_mark(), speed)

    def go_over(self, goal: Pose, speed: float) -> Moved:
        """Go to a pose; where a guard is in the way, rise first, as a person would."""
        try:
            return self.move_to(goal, speed=speed)
        except OutOfBounds:
            self.move_l(raised(self.pose, PARK_RISE_MM), speed=speed)
            return self.move_to(goal, speed=speed)

    def above_mark(self) -> Pose:
        """Return the pose a little above the reference mark."""
        if self.model.reference is None:
            raise Refused("this arm has no park posture: write [park] into its arm file")
        return raised(self.model.reference.pose, PARK_HEIGHT_MM)

    def _go(self, goal: ResolvedGoal, speed: float) -> Handle[Moved]:
        """Plan a way to a goal and hand it to the engine, unless a stop comes meanwhile."""
        stops = self.stops
        if goal.cartesian:
            self.core.require_geometry()
        fraction = speed_fraction(speed)

        def plan(here: ArmCoordinates) -> MotionPlan:
            return goal.plan(Ground(self.config, self.speeds, here), fraction)

        return self._start(plan, stops)

    def _start(
        self, plan: Callable[[ArmCoordinates], MotionPlan], stops: int | None = None
    ) -> Handle[Moved]:
        """Plan from where the arm is, and hand the audited plan to the engine.

        A stop finds nothing to end before that: with `stops`, one that was asked for since then
        is what becomes of the motion.
        """
        with self.pace.lock:
            self.core.require_reference()
            after(self.core.state, Event.MOVE)
            made = plan(self.core.coordinates)
            if stops is not None and self.stops != stops:
                raise Stopped("a stop was asked for before the motion began")
            task = self.submit(motion.follow(self.wire, made), alone=True)
        return Handle(self.runner, task, made.duration_s * PATIENCE + PATIENCE_S)


def raised(pose: Pose, by_mm: float) -> Pose:
    """Return a pose straight above another."""
    return replace(pose, z_mm=pose.z_mm + by_mm)


# Motion along arcs, and along several moves as one, with blends between them.


class RouteCalls(MoveCalls):
    """The calls that move along a way of several parts, or a round one."""

    @overload
    def move_c(
        self,
        via: Pose,
        goal: Pose,
        *,
        speed: float = 1.0,
        frame: str = BASE,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    def move_c(
        self, via: Pose, goal: Pose, *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> Handle[Moved]: ...
    def move_c(
        self, via: Pose, goal: Pose, *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | Handle[Moved]:
        """Move the tip along the arc of a circle, through `via`, to a pose.

        Of `via` only x, y and z count; the hand turns evenly to the goal's pitch and roll. Raises
        `kinematics.NoArc` for points on one line, and `PathBroken` where the arc leaves the reach.
        """
        return self._along([ArcMove(via, goal)], speed, frame, wait)

    @overload
    def move_path(
        self,
        moves: Sequence[Move],
        *,
        speed: float = 1.0,
        frame: str = BASE,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    def move_path(
        self, moves: Sequence[Move], *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> Handle[Moved]: ...
    def move_path(
        self, moves: Sequence[Move], *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | Handle[Moved]:
        """Move through several moves as one: `LineMove`, `ArcMove`, `PoseMove`, `JointMove`.

        A move with `blend_mm` is left for the next one so far before its end, without stopping;
        without, the arm stops there. The whole way is audited first, in one posture of the arm.
        `note` of the result tells of blends that had to be smaller.
        """
        return self._along(moves, speed, frame, wait)

    def _along(
        self, moves: Sequence[Move], speed: float, frame: str, wait: bool
    ) -> Moved | Handle[Moved]:
        self.core.require_geometry()
        fraction = speed_fraction(speed)
        if not moves:
            raise BadRequest("a path needs at least one move, for example LineMove(pose)")
        if frame == TOOL:
            raise BadRequest(
                "the tool's frame goes along with the arm: give a path in the base or in a frame "
                "of the arm file"
            )
        handle = self._start(
            lambda here: plan_route(
                self.config,
                self.speeds,
                here,
                [_in_base(self.config, here.joints, move, frame) for move in moves],
                fraction,
            )
        )
        return handle.wait() if wait else handle


def _in_base(config: ArmConfig, joints: Joints, move: Move, frame: str) -> Move:
    """Return a move with its poses as the base sees them."""
    if isinstance(move, JointMove):
        return move
    goal = goal_in_base(config, joints, move.goal, frame)
    if isinstance(move, ArcMove):
        return replace(move, goal=goal, via=goal_in_base(config, joints, move.via, frame))
    return replace(move, goal=goal)


# Seeing a motion before it is asked for: the very plan that would be carried out, measured.


class PreviewCalls(MoveCalls):
    """The call that plans and does not move."""

    def preview(
        self,
        goal: Place | Angles | None = None,
        *,
        line: bool = False,
        frame: str = BASE,
        speed: float = 1.0,
        **joints_deg: Unpack[JointAngles],
    ) -> Preview:
        """Return what a motion would be, or why it is refused. Sends nothing, moves nothing.

        `preview(pose)` (or a named point) foresees `move_to`, `preview(pose, line=True)` foresees
        `move_l`, and `preview(shoulder_deg=40)` or a mapping foresees `move_j`. A refusal is part
        of the answer: its typed error, and where the arm could go instead. Raises `BadRequest` for
        what is no goal.
        """
        fraction = speed_fraction(speed)
        if goal is None or isinstance(goal, Mapping):
            if line or frame != BASE:
                raise BadRequest("a line and a frame are of a pose: give one")
            return self._foreseen(JointGoal(by_name(goal, joints_deg)), fraction)
        if joints_deg:
            raise BadRequest("give a pose or joint angles, not both")
        return self._foreseen(self.goal_of(goal, frame, line=line), fraction)

    def _foreseen(self, goal: ResolvedGoal, fraction: float) -> Preview:
        with self.pace.lock:
            here, controller = self.core.coordinates, self.core.controller
            hindrance, known = self._hindrance(goal), self.core.belief.trust is not Trust.UNKNOWN
        if not known:
            return Preview(None, hindrance)
        ground = Ground(self.config, self.speeds, here)
        return preview_goal(ground, controller, goal, fraction, hindrance)

    def _hindrance(self, goal: ResolvedGoal) -> Refused | None:
        """Return why no motion to such a goal may begin now, whatever its way."""
        try:
            if goal.cartesian:
                self.core.require_geometry()
            self.core.require_reference()
            after(self.core.state, Event.MOVE)
            self.core.require_settings()
        except Refused as refusal:
            return refusal
        return None
