"""`Arm`: the calls that a program makes. Each hands a flow to the engine and waits for its end.

All of them may be called from any thread; `stop`, `estop` and `status` while another call waits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, TypeVar

from armdrive.abilities import Abilities
from armdrive.core import Coordinates, Core, Hold
from armdrive.dialects import dialect
from armdrive.engine import Engine, Flow, Task
from armdrive.errors import (
    ArmError,
    BadRequest,
    LinkLost,
    NoAnswer,
    OperatorNeeded,
    OutOfBounds,
    Refused,
)
from armdrive.flows import idling, jogging, motion, referencing
from armdrive.flows.exchange import Wire
from armdrive.flows.jogging import Jogged
from armdrive.flows.motion import Moved
from armdrive.gripper import Gripper
from armdrive.handle import Handle
from armdrive.intents import GRIPPER_AXIS, Jog, Space
from armdrive.planning import (
    Plan,
    Speeds,
    named_joints,
    plan_joints,
    plan_line,
    posture_for,
    speed_fraction,
)
from armdrive.posture import Operator, PostureRequest
from armdrive.states import Event, after
from armdrive.status import State, Status
from armdrive.trust import Evidence
from kinematics import ArmPreset, Joints, Motors, Pose
from kinematics.errors import finite

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from armdrive.pace import Pace
    from armdrive.record import Recorder
    from armdrive.sim.twin import Twin
    from armdrive.transports.link import Link

T = TypeVar("T")

PATIENCE = 4.0
"""A motion that takes this many times longer than planned, and then some, is given up."""

PATIENCE_S = 60.0


class Arm:
    """One arm, connected. Make one with `Arm.connect`; use it in a `with` statement."""

    def __init__(
        self,
        config: ArmConfig,
        link: Link,
        pace: Pace,
        *,
        simulated: bool,
        recorder: Recorder | None = None,
        allow_restored: bool = False,
        operator: Operator | None = None,
    ) -> None:
        """Connect over an open link. Raises `NoAnswer` where no such arm answers; moves nothing."""
        self.config = config
        self.pace = pace
        self.simulated = simulated
        self.twin: Twin | None = None
        self._operator = operator
        self._on_close: list[Callable[[], None]] = []
        controller = dialect(config.connection.dialect).controller(config)
        self.core = Core(config, controller, recorder)
        self.core.allow_restored = allow_restored
        self.engine = Engine(
            link, controller, idle=self._idle, stopping=self._stopping, lost=self._lost
        )
        self.wire = Wire(self.engine, self.core)
        self.speeds = Speeds(
            config.model.joint_speeds_rad_s,
            config.model.gripper_speed_mm_s,
            controller.usable_rate_hz(math.inf),
            self.core.transmission,
        )
        self.gripper = Gripper(self)
        self._session: Task[Jogged] | None = None
        self._idling = idling.Idling(self.wire)
        pace.start(self.engine)
        try:
            self.finish(self.submit(referencing.connect(self.wire)), PATIENCE_S)
        except BaseException:
            self._release()
            raise

    @classmethod
    def connect(cls, target: str = "sim:teachmover", **options: Any) -> Arm:
        """Connect to an arm by the name of its arm file, a port with `dialect=`, or `sim:NAME`.

        Options: `dialect`, `baud`, `pace` ("simulated", "real", or a factor of real time for a
        simulated arm), `allow_restored`, `operator`. With `ARMDRIVE_FORCE_SIM=1` in the
        environment every arm is its simulated twin. Raises `PortUnavailable`, `ArmFileError`,
        `BadRequest`, `NoAnswer`.
        """
        from armdrive.connecting import connect

        return connect(target, **options)

    def __enter__(self) -> Self:
        if self.core.state is State.DISABLED:
            self.enable()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    # -- what is known ------------------------------------------------------------------------

    @property
    def status(self) -> Status:
        """A frozen picture of this moment."""
        with self.pace.lock:
            return self.core.status(
                link=self.engine.link.description,
                simulated=self.simulated,
                now_s=self.engine.now_s,
                last_sent=self.engine.last_sent,
                last_answer=self.engine.last_answer,
            )

    @property
    def model(self) -> ArmPreset:
        """The arm's model: geometry, limits, transmission, reference posture."""
        return self.config.model

    @property
    def abilities(self) -> Abilities:
        """What the arm's controller can do."""
        return self.core.controller.abilities

    @property
    def joints(self) -> Joints:
        """The acknowledged joint angles. Raises `NotReferenced` while the position is unknown."""
        return self._known(self.status.joints)

    @property
    def pose(self) -> Pose:
        """The acknowledged pose. Raises `NotReferenced` while the position is unknown."""
        return self._known(self.status.pose)

    def _known(self, value: T | None) -> T:
        if value is None:
            self.core.require_reference()
            raise ArmError("the position is not known")
        return value

    # -- planned motion -----------------------------------------------------------------------

    def move_j(
        self, *, speed: float = 1.0, wait: bool = True, **joints_deg: float
    ) -> Moved | Handle[Moved]:
        """Move the named joints, `shoulder_deg=40, elbow_deg=-60`; the others stay.

        Straight in joint space. `speed` is a fraction of the limits. The whole way is audited
        first: `OutOfBounds` names the joint or guard, and nothing has moved.
        """
        fraction = speed_fraction(speed)
        if not joints_deg:
            raise BadRequest("name at least one joint, for example shoulder_deg=40")
        return self._move(
            lambda here: Coordinates(named_joints(here.joints, joints_deg), here.opening_mm),
            fraction,
            wait=wait,
        )

    def move_to(
        self, goal: Pose, *, speed: float = 1.0, wait: bool = True
    ) -> Moved | Handle[Moved]:
        """Move the tip to a pose by a joint motion, to the posture nearest to the present one.

        Raises `kinematics.Unreachable` with the nearest pose that can be reached.
        """
        fraction = speed_fraction(speed)
        return self._move(
            lambda here: Coordinates(posture_for(self.config, goal, here.joints), here.opening_mm),
            fraction,
            wait=wait,
        )

    def move_l(self, goal: Pose, *, speed: float = 1.0, wait: bool = True) -> Moved | Handle[Moved]:
        """Move the tip to a pose along a straight line in x, y, z, pitch and roll.

        Between bursts the tip leaves the line by at most `motion.line_tolerance_mm` of the arm
        file and one motor step. Raises `kinematics.PathBroken` where the line leaves the reach.
        """
        fraction = speed_fraction(speed)
        with self.pace.lock:
            self._ready()
            here = self.core.coordinates
            plan = plan_line(self.config, self.speeds, here, goal, fraction)
            handle = self._follow(plan)
        return handle.wait() if wait else handle

    def _move(
        self, goal: Callable[[Coordinates], Coordinates], fraction: float, *, wait: bool
    ) -> Moved | Handle[Moved]:
        with self.pace.lock:
            self._ready()
            here = self.core.coordinates
            plan = plan_joints(self.config, self.speeds, here, goal(here), fraction)
            handle = self._follow(plan)
        return handle.wait() if wait else handle

    def run_plan(self, goal: Callable[[Coordinates], Coordinates], fraction: float) -> Moved:
        """Plan a joint motion to a goal that depends on where the arm is, and carry it out."""
        moved = self._move(goal, fraction, wait=True)
        return moved if isinstance(moved, Moved) else moved.wait()

    def _ready(self) -> None:
        """Refuse planned motion that could not begin."""
        self.core.require_reference()
        after(self.core.state, Event.MOVE)

    def _follow(self, plan: Plan) -> Handle[Moved]:
        task = self.submit(motion.follow(self.wire, plan))
        return Handle(self, task, plan.duration_s * PATIENCE + PATIENCE_S)

    def move_motors(self, *steps: int, speed: float = 0.25) -> Moved:
        """Move each motor by whole steps from where it is, all together: for the bench.

        Knows neither limits nor guards and needs no reference.
        """
        motors = Motors(steps)
        if len(motors) != self.abilities.motors:
            raise BadRequest(f"{self.abilities.motors} step counts are needed, not {len(motors)}")
        fraction = speed_fraction(speed)
        with self.pace.lock:
            if self.core.state is not State.HOMING:
                after(self.core.state, Event.MOVE)
            task = self.submit(motion.bench_move(self.wire, self.speeds, motors, fraction))
        return self.finish(task, PATIENCE_S * 10)

    def park(self, *, speed: float = 1.0) -> Moved:
        """Go to the park posture of the arm file; by default, 30 mm above the reference mark."""
        goal = self.config.park or self._default_park()
        try:
            moved = self.move_to(goal, speed=speed)
        except OutOfBounds:
            # a guard is in the way: rise first, as a person would
            here = self.pose
            self.move_l(
                Pose(here.x_mm, here.y_mm, here.z_mm + PARK_RISE_MM, here.pitch_rad, here.roll_rad),
                speed=speed,
            )
            moved = self.move_to(goal, speed=speed)
        return moved if isinstance(moved, Moved) else moved.wait()

    def _default_park(self) -> Pose:
        reference = self.model.reference
        if reference is None:
            raise Refused("this arm has no park posture: write [park] into its arm file")
        mark = reference.pose
        return Pose(mark.x_mm, mark.y_mm, mark.z_mm + PARK_HEIGHT_MM, mark.pitch_rad, mark.roll_rad)

    # -- jogging ------------------------------------------------------------------------------

    def jog_j(
        self, *, speed: float = 0.25, duration_s: float | None = None, **axes: float
    ) -> Jogged:
        """Jog joints: by increments, `shoulder_deg=2, gripper_mm=5`, or for a time.

        With `duration_s` the axes are directions from -1 to 1, `shoulder=1`, that share the
        speed. Limits are met by stopping at them; `note` of the result says so. Allowed without
        a reference, then slow and without limits.
        """
        return self._jog(Space.JOINT, axes, speed, duration_s)

    def jog_l(
        self, *, speed: float = 0.25, duration_s: float | None = None, **axes: float
    ) -> Jogged:
        """Jog the tip: by increments, `x_mm=5, pitch_deg=-2`, or for a time, `x=1`."""
        return self._jog(Space.CARTESIAN, axes, speed, duration_s)

    def _jog(
        self, space: Space, axes: dict[str, float], speed: float, duration_s: float | None
    ) -> Jogged:
        fraction = speed_fraction(speed)
        strip = duration_s is None
        jog = Jog(space, tuple((_axis(word, strip=strip), value) for word, value in axes.items()))
        jogging.check_jog(self.core, jog)
        with self.pace.lock:
            if self.core.state is not State.HOMING:
                after(self.core.state, Event.MOVE)
            if duration_s is None:
                self.core.nudges.append((jog, fraction))
            else:
                time_s = finite("duration_s", duration_s)
                self.core.hold = Hold(jog, fraction, self.pace.now_s() + time_s)
            task = self._jogging()
        return self.finish(task, PATIENCE_S * 10)

    def hold(self, jog: Jog, *, speed: float, for_s: float) -> None:
        """Jog for `for_s` seconds and no longer unless called again; never waits.

        A refusal is the `notice` of the status.
        """
        with self.pace.lock:
            if self._may_jog(jog):
                until_s = self.pace.now_s() + min(for_s, LONGEST_HOLD_S)
                self.core.hold = Hold(jog, speed_fraction(speed), until_s)
                self._jogging()
        self.pace.wake()

    def nudge(self, jog: Jog, *, speed: float) -> None:
        """Jog by one increment; at most one more waits behind the one under way. Never waits."""
        with self.pace.lock:
            if self._may_jog(jog) and not self.core.nudges:
                self.core.nudges.append((jog, speed_fraction(speed)))
                self._jogging()
        self.pace.wake()

    def release(self) -> None:
        """End a held jog: the burst under way is the last."""
        self.core.hold = None

    def _may_jog(self, jog: Jog) -> bool:
        alive = self._session is not None and not self._session.done
        try:
            jogging.check_jog(self.core, jog)
            if not alive and self.core.state is not State.HOMING:
                after(self.core.state, Event.MOVE)
        except Refused as refusal:
            self.core.notice = str(refusal)
            return False
        return True

    def _jogging(self) -> Task[Jogged]:
        if self._session is None or self._session.done:
            self._session = self.submit(jogging.jog_session(self.wire, self.speeds))
        return self._session

    # -- stopping -----------------------------------------------------------------------------

    def request_stop(self) -> None:
        """Ask for a stop and return at once: the one call that a signal handler may make."""
        self.core.hold = None
        self.engine.stop_asked = True
        self.pace.wake()

    def stop(self) -> None:
        """Stop, and wait until the arm stands. Legal in every state, from any thread.

        A burst that is under way runs to its end; `status.stop_time_s` bounds it.
        """
        if not self._still():
            raise NoAnswer("the arm did not confirm that it stands; look at it")

    def estop(self) -> None:
        """Stop and latch error-stop; does not wait. Only `reset` leaves it, and moves nothing."""
        self.core.fault("emergency stop: look at the arm, then reset")
        self.request_stop()

    def reset(self) -> None:
        """Leave error-stop: wait until the line is quiet and read the registers. Moves nothing."""
        after(self.core.state, Event.RESET)
        self.finish(self.submit(referencing.reset(self.wire)), PATIENCE_S)

    # -- position -----------------------------------------------------------------------------

    def home(self, *, operator: Operator | None = None) -> Moved:
        """Take the reference posture, which an operator has to confirm.

        `operator` is called with a `PostureRequest`, may jog the arm, and returns True when it
        stands there. Without one, `OperatorNeeded`. A simulated arm has a simulated operator.
        """
        operator = operator or self._operator
        request = self.reference_request()
        if operator is None:
            raise OperatorNeeded(
                "this arm has no switches, so somebody has to look at it: run `armdrive home`, "
                "pass home(operator=...), or bring it to a known posture and call "
                f"declare_posture(). {request}"
            )
        self.finish(self.submit(referencing.begin_home(self.wire)), PATIENCE_S)
        confirmed = False
        try:
            confirmed = operator(request)
        finally:
            if not confirmed:
                self.finish(self.submit(referencing.end_home(self.wire)), PATIENCE_S)
        if not confirmed:
            raise OperatorNeeded(
                f"the posture was not confirmed: nothing was referenced. {request}"
            )
        self._vouch(request.joints, request.opening_mm, Evidence.HOMED)
        return Moved(self.joints, self.pose, 0.0, 0.0, 0, "referenced")

    def confirm_reference(self) -> None:
        """Say that the arm stands in its reference posture now."""
        request = self.reference_request()
        after(self.core.state, Event.MOVE)
        self._vouch(request.joints, request.opening_mm, Evidence.HOMED)

    def declare_posture(self, posture: Joints | Pose, *, opening_mm: float = 0.0) -> None:
        """Say that the arm stands in this posture now, by joints or by pose. Moves nothing."""
        joints = self.model.arm.ik(posture) if isinstance(posture, Pose) else posture
        self.model.arm.check(joints)
        after(self.core.state, Event.MOVE)
        self._vouch(joints, finite("opening_mm", opening_mm), Evidence.DECLARED)

    def confirm_restored(self) -> None:
        """Say that the arm stands as its record shows it: planned motion is allowed again."""
        if self.status.joints is None or self.core.belief.trust.value != "restored":
            raise Refused("there is no restored position to confirm: run home()")
        self.finish(self.submit(referencing.confirm_record(self.wire)), PATIENCE_S)

    def reference_request(self) -> PostureRequest:
        """Return the posture that a reference is taken in."""
        reference = self.model.reference
        if reference is None:
            raise Refused(
                f"no reference posture is known of the {self.config.title}: use declare_posture()"
            )
        joints = self.model.arm.ik(reference.pose)
        return PostureRequest(self, reference.pose, joints, reference.opening_mm)

    def _vouch(self, joints: Joints, opening_mm: float, evidence: Evidence) -> None:
        there = Coordinates(joints, opening_mm)
        task = self.submit(referencing.take_reference(self.wire, there, evidence))
        self.finish(task, PATIENCE_S)

    # -- power, outputs, time -----------------------------------------------------------------

    def enable(self) -> None:
        """Allow motion. Moves nothing."""
        self.finish(self.submit(referencing.enable(self.wire)), PATIENCE_S)

    def disable(self) -> None:
        """Switch the motor current off: **the arm can sag**, so `park` first.

        The position is suspect from then on. On a TeachMover this is `@RESET`.
        """
        after(self.core.state, Event.DISABLE)
        self.finish(self.submit(referencing.disable(self.wire)), PATIENCE_S)

    def set_outputs(self, bits: int) -> None:
        """Write the output bits. Moves nothing."""
        after(self.core.state, Event.MOVE)
        self.finish(self.submit(idling.set_outputs(self.wire, bits)), PATIENCE_S)

    def read_inputs(self) -> int:
        """Read the input bits now."""
        self.finish(self.submit(referencing.poll(self.wire)), PATIENCE_S)
        return self.core.inputs or 0

    def sleep(self, time_s: float) -> None:
        """Let time pass on the arm's own clock."""
        self.pace.wait(lambda: False, max(finite("time_s", time_s), 0.0))

    def close(self) -> None:
        """Stop, remember the position, and give the port back. Closing twice is no error."""
        if self.core.state is not State.DISCONNECTED:
            try:
                self.stop()
            finally:
                with self.pace.lock:
                    self.core.mark_still()
                    self.core.happen(Event.LOST)
        self._release()

    def on_close(self, call: Callable[[], None]) -> None:
        """Have something done once when the arm is closed."""
        self._on_close.append(call)

    # -- inside -------------------------------------------------------------------------------

    def submit(self, flow: Flow[T]) -> Task[T]:
        """Hand a flow to the engine. Raises `WrongState` while another is waiting there."""
        with self.pace.lock:
            task = self.engine.start(flow)
        self.pace.wake()
        return task

    def finish(self, task: Task[T], timeout_s: float) -> T:
        """Wait for a task; whatever interrupts the wait stops the arm."""
        try:
            ended = self.pace.wait(lambda: task.done, timeout_s)
        except BaseException:
            self._still()
            raise
        if not ended:
            self._still()
            raise NoAnswer(f"the motion had not ended after {timeout_s:.0f} s and was stopped")
        return task.result()

    def _still(self) -> bool:
        self.request_stop()
        return self.pace.wait(lambda: not self.engine.busy, PATIENCE_S)

    def _release(self) -> None:
        self.pace.close()
        self.engine.link.close()
        calls, self._on_close = self._on_close, []
        for call in calls:
            call()

    def _idle(self, now_s: float) -> tuple[float, Flow[Any] | None]:
        return self._idling.due(now_s)

    def _stopping(self) -> None:
        if self.core.state in (State.MOVING, State.HOMING):
            self.core.happen(Event.STOP)

    def _lost(self, lost: LinkLost) -> None:
        self.core.error = str(lost)
        self.core.happen(Event.LOST)
        self.core.mark_lost()


PARK_HEIGHT_MM = 30.0
PARK_RISE_MM = 60.0
LONGEST_HOLD_S = 1.0
"""A held jog is renewed at least this often, or it ends."""


def _axis(word: str, *, strip: bool) -> str:
    """Turn `shoulder_deg` or `x_mm` into the axis it names."""
    if not strip:
        return word
    for unit in ("_deg", "_mm"):
        if word.endswith(unit):
            axis = word.removesuffix(unit)
            if (unit == "_mm") == (axis in ("x", "y", "z", GRIPPER_AXIS)):
                return axis
    raise BadRequest(
        f"{word!r} names no increment: write for example shoulder_deg=2, x_mm=5 or gripper_mm=3, "
        "or give duration_s= with directions such as shoulder=1"
    )
