"""What programs do. Each action draws its own numbers, makes its calls, and returns the error."""

import math
import random
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any

from armdrive.arm import Arm
from armdrive.arm.connected import PATIENCE, Handle
from armdrive.connect.runner import PATIENCE_S
from armdrive.dialects.controller import HOMING_MARGIN_S, in_turn
from armdrive.errors import Stopped
from armdrive.motion.execute import Moved
from armdrive.moves import Jog
from armdrive.sim.world.table import TableBlock
from armdrive.status import State, Status
from kinematics import LinePart
from tests.conformance.motions import shifted

from .goals import (
    beyond_a_limit,
    grasped,
    joint_goal,
    joints_reached,
    nearby_pose,
    pose_reached,
    posture_reached,
    span_to,
)
from .laws import TypedError, call
from .stage import Stage
from .watch import SPEED_WINDOW_S, Command, Excuse, Reaches

TIMEOUT_MARGIN_S = PATIENCE_S + 10.0
"""A motion has to end within `PATIENCE` times its planned duration, and this margin."""
HOMING_S = 20.0
"""A simulated arm seeks its switches for about this long."""

Action = Callable[[Stage, random.Random], TypedError | None]


def arm_of(stage: Stage) -> Arm:
    """Return the program that drives the arm; there has to be one."""
    assert stage.arm is not None
    return stage.arm


def command_of(
    stage: Stage, what: str, reaches: Reaches | None = None, *, speed: float = 1.0
) -> Command:
    """Return a command, with its goal if the position is known."""
    known = arm_of(stage).parts.core.position_known
    return Command(what, known, reaches=reaches if known else None, speed=speed)


def speed_of(draw: random.Random) -> float:
    """Draw a fraction of the speed limits."""
    return draw.choice((0.3, 0.6, 1.0))


def in_deg(goal: Mapping[str, float]) -> dict[str, float]:
    """Return angles by the names of arguments, such as `shoulder_deg`."""
    return {f"{name}_deg": deg for name, deg in goal.items()}


def in_rad(goal: Mapping[str, float]) -> dict[str, float]:
    """Return angles in rad."""
    return {name: math.radians(deg) for name, deg in goal.items()}


# -- Motions --------------------------------------------------------------------------------------


def move_j(stage: Stage, draw: random.Random) -> TypedError | None:
    """Move some joints, sometimes beyond a limit."""
    goal, takes_s = joint_goal(stage, draw)
    speed = speed_of(draw)
    if draw.random() < 0.1:
        goal[next(iter(goal))] = draw.choice((-400.0, 400.0))
    elif draw.random() < 0.1:
        goal = beyond_a_limit(stage, draw)
    return move_to_joints(stage, goal, takes_s, speed)


def move_to_joints(
    stage: Stage, goal: Mapping[str, float], takes_s: float = 10.0, speed: float = 1.0
) -> TypedError | None:
    """Move joints to a goal in degrees. `takes_s` is the duration at full speed."""
    arm, longest_s = arm_of(stage), takes_s / speed * PATIENCE + TIMEOUT_MARGIN_S
    what = f"move_j({goal}, {speed})"
    command = command_of(stage, what, joints_reached(stage, in_rad(goal)), speed=speed)
    command.span = span_to(stage, goal)
    return call(stage, lambda: arm.move_j(speed=speed, **in_deg(goal)), command, longest_s)


def move_tip(stage: Stage, draw: random.Random) -> TypedError | None:
    """Move to a pose nearby, or to one that is out of reach: by joints, in a line, or by a path."""
    arm, how = arm_of(stage), draw.choices(("move_to", "move_l", "move_path"), (3, 3, 1))[0]
    goal = nearby_pose(stage, draw)
    command = command_of(stage, f"{how}({goal})", pose_reached(stage, goal))
    act: Callable[[], object] = lambda: getattr(arm, how)(goal)  # noqa: E731
    if how == "move_path":
        corner = LinePart(nearby_pose(stage, draw), draw.choice((0.0, 2.0)))
        act = lambda: arm.move_path([corner, LinePart(goal)])  # noqa: E731
    return call(stage, act, command, 10.0 + TIMEOUT_MARGIN_S)


def jog_increment(stage: Stage, draw: random.Random) -> TypedError | None:
    """Jog by an increment; it may be clipped if the result says so."""
    arm = arm_of(stage)
    here, _ = stage.posture()
    name, turn_deg, up_mm = (
        draw.choice(here.names),
        draw.uniform(-3.0, 3.0),
        draw.uniform(-8.0, 8.0),
    )
    if draw.random() < 0.3:
        reaches = pose_reached(stage, shifted(arm.model.arm.fk(here), z_mm=up_mm))
        command = command_of(stage, f"jog up {up_mm}", reaches)
        return call(stage, lambda: arm.jog_l(z_mm=up_mm), command, 10.0 + TIMEOUT_MARGIN_S)
    goal = {name: here.deg[name] + turn_deg}
    command = command_of(stage, f"jog to {goal}", joints_reached(stage, in_rad(goal)))
    by = {f"{name}_deg": turn_deg}
    return call(stage, lambda: arm.jog_j(**by), command, 10.0 + TIMEOUT_MARGIN_S)


# -- Jogs that end by themselves, by a release, or never ------------------------------------------


@contextmanager
def expected_expiry(stage: Stage, what: str) -> Iterator[Callable[[float], None]]:
    """Check that a jog expires by itself: add the bound of a stop at the moment of its expiry.

    The caller calls the yielded function before each request to jog, with the duration of the jog
    in s. A later request replaces the expiry of the one before.
    """
    expires_s = math.inf

    def expire() -> None:
        if stage.now_s >= expires_s:
            stage.add_stop_bound(what)

    def expires_in(for_s: float) -> None:
        nonlocal expires_s
        stage.watch.clear_bounds()  # the previous jog may have expired already
        expires_s = stage.now_s + for_s
        stage.timeline.at(expires_s, expire)

    try:
        yield expires_in
    finally:
        expires_s = math.inf


def jog_for_a_time(stage: Stage, draw: random.Random) -> TypedError | None:
    """Jog two joints for a time."""
    names = draw.sample(arm_of(stage).model.arm.joint_names, 2)
    axes = {name: draw.uniform(-1.0, 1.0) for name in names}
    for_s, speed = draw.uniform(0.1, 0.7), speed_of(draw)
    command = command_of(stage, f"jog_j({axes}, {speed}, {for_s:.2f} s)", speed=speed)

    def act() -> None:
        with expected_expiry(stage, "the time of a jog was over") as expires_in:
            expires_in(for_s)
            arm_of(stage).jog_j(speed=speed, duration_s=for_s, **axes)

    return call(stage, act, command, for_s + TIMEOUT_MARGIN_S)


MAX_HOLD_S = 1.0
"""The longest hold that the driver grants; a longer request expires after this time."""


def _hold(
    stage: Stage, draw: random.Random, for_s: float, then: Callable[[], object], renewals: int = 0
) -> TypedError | None:
    """Hold a jog of one joint, perhaps renew it, and do something else then."""
    arm, speed = arm_of(stage), speed_of(draw)
    jog = Jog.joint(**{draw.choice(arm.model.arm.joint_names): draw.choice((-1.0, 1.0))})
    command = command_of(stage, f"hold({jog}, {for_s:.2f} s)", speed=speed)
    command.verified = False

    def act() -> None:
        with expected_expiry(stage, "an abandoned hold expired") as expires_in:
            for number in range(renewals + 1):
                expires_in(min(for_s, MAX_HOLD_S))
                if not arm.parts.core.position_known:  # then a new hold has no limits
                    command.position_known = False
                arm.jogging.hold(jog, speed=speed, for_s=for_s)
                if number < renewals:
                    arm.sleep(draw.uniform(0.0, for_s))
            then()
            arm.sleep(4.0)

    return call(stage, act, command, TIMEOUT_MARGIN_S)


def hold_and_release(stage: Stage, draw: random.Random) -> TypedError | None:
    """Hold a jog, and release it."""
    arm, after_s = arm_of(stage), draw.uniform(0.0, 0.6)

    def release() -> None:
        arm.sleep(after_s)
        status = arm.status
        arm.jogging.release()
        if status.state is State.MOVING:
            stage.add_bound("released", status.stop_time_s, status.stop_distance_mm)

    return _hold(stage, draw, 0.8, release)


def abandon_hold(stage: Stage, draw: random.Random) -> TypedError | None:
    """Hold a jog, and never release it: it expires while the program goes on."""
    return _hold(stage, draw, draw.uniform(0.1, 1.5), lambda: None, draw.choice((0, 0, 1, 3)))


def hold_and_vanish(stage: Stage, draw: random.Random) -> TypedError | None:
    """Hold a jog, and suspend or kill the program: the jog expires all the same."""
    after_s, for_s = draw.uniform(0.0, 1.0), draw.choice((0.0, 0.4, 1.5, 4.0))

    def vanish() -> None:
        if for_s:
            stage.suspend(for_s)
        else:
            stage.pace.kill()

    return _hold(
        stage,
        draw,
        draw.uniform(0.1, 1.5),
        lambda: stage.timeline.at(stage.now_s + after_s, vanish),
    )


# -- Stops and pauses -----------------------------------------------------------------------------

SWEEP_S = 2.0
"""The longest duration of a motion that is stopped or paused on its way."""


def _sweep(
    stage: Stage,
    draw: random.Random,
    what: str,
    then: Callable[[Arm, Handle[Moved], Command], Any],
    bound: Callable[[Status], tuple[float, float]] = lambda status: (
        status.stop_time_s,
        status.stop_distance_mm,
    ),
    *,
    arrives: bool = False,
) -> TypedError | None:
    """Begin a motion and interrupt it by `then`; the arm stops within the announced `bound`.

    `arrives`: the motion goes on afterwards and reaches its goal.
    """
    arm, (goal, takes_s) = arm_of(stage), joint_goal(stage, draw, 60.0, SWEEP_S)
    after_s = draw.uniform(0.0, 0.7)
    reaches = joints_reached(stage, in_rad(goal)) if arrives else None
    command = command_of(stage, f"{what} in move_j({goal})", reaches)
    command.span, command.verified = span_to(stage, goal), False

    def act() -> None:
        handle = arm.move_j(wait=False, **in_deg(goal))
        arm.sleep(after_s)
        status = arm.status
        if status.state is State.MOVING:
            stage.add_bound(what, *bound(status))
        then(arm, handle, command)

    return call(stage, act, command, takes_s * PATIENCE + TIMEOUT_MARGIN_S)


def stop(stage: Stage, draw: random.Random) -> TypedError | None:
    """Stop in motion."""
    return _sweep(stage, draw, "stop", lambda arm, *_: (arm.stop(), arm.sleep(2.0)))


def estop(stage: Stage, draw: random.Random) -> TypedError | None:
    """Make an emergency stop in motion. The call does not wait for the arm."""
    return _sweep(stage, draw, "estop", lambda arm, *_: (arm.estop(), arm.sleep(2.0)))


def pause(stage: Stage, draw: random.Random) -> TypedError | None:
    """Pause in motion, change the speed override, and resume to the end."""
    share = draw.choice((0.4, 1.0))

    def then(arm: Arm, handle: Handle[Moved], command: Command) -> None:
        arm.pause()
        for _ in range(10):
            if handle.done:  # a short motion has ended: later changes are not its fault
                break
            arm.sleep(0.1)
        stage.watch.clear_bounds()
        arm.speed_override = share
        arm.resume()

        def slowed() -> None:
            command.speed = share

        # motion that was sent ahead keeps its speed; it ends within `silent_time_s`
        stage.timeline.at(stage.now_s + arm.status.silent_time_s + SPEED_WINDOW_S, slowed)
        try:
            handle.wait()
        finally:
            arm.speed_override = 1.0

    def bound(status: Status) -> tuple[float, float]:
        return status.pause_time_s, status.pause_distance_mm

    return _sweep(stage, draw, "pause", then, bound, arrives=True)


# -- The gripper, inputs and outputs, and rest ----------------------------------------------------

BLOCK = "grasped"
BLOCK_MM = 6.0
"""The narrowest block: less counts as nothing between the fingers."""
CLEARANCE_MM = 2.0
"""How much wider than the block the fingers are open at least."""


def gripper(stage: Stage, draw: random.Random) -> TypedError | None:
    """Move the fingers, or grasp."""
    arm, opening_mm = arm_of(stage), draw.choice((10.0, 18.0, 24.0, 90.0))
    if arm.abilities.grip_switch and draw.random() < 0.4:
        return grasp(stage, draw)
    command = command_of(stage, f"gripper {opening_mm}", joints_reached(stage, {}, opening_mm))
    return call(stage, lambda: arm.gripper.open(opening_mm), command, 10.0 + TIMEOUT_MARGIN_S)


def grasp(stage: Stage, draw: random.Random) -> TypedError | None:
    """Grasp a block that was put between the fingers, or nothing."""
    world = stage.world
    widest_mm = world.opening_mm - CLEARANCE_MM
    x_mm, y_mm, z_mm = world.tip
    there = draw.random() < 0.7 and z_mm > 0.0 and widest_mm > BLOCK_MM
    if there:
        width_mm = draw.uniform(BLOCK_MM, widest_mm)
        world.put(TableBlock(BLOCK, x_mm, y_mm, width_mm=width_mm, height_mm=z_mm + CLEARANCE_MM))
    command = command_of(stage, "grasp a block" if there else "grasp", grasped)
    try:
        return call(stage, arm_of(stage).gripper.grasp, command, 60.0)
    finally:
        if there:
            world.take(BLOCK)


def outputs(stage: Stage, draw: random.Random) -> TypedError | None:
    """Set outputs, read inputs."""
    arm, bits = arm_of(stage), draw.choice((0, 5, 255, 256))
    return call(stage, lambda: arm.io.write(bits)) or call(stage, arm.io.read)


def rest(stage: Stage, draw: random.Random) -> TypedError | None:
    """Wait; nothing moves."""
    for_s = draw.choice((0.05, 0.5, 2.5, 5.0))
    return call(stage, lambda: arm_of(stage).sleep(for_s), None, for_s + TIMEOUT_MARGIN_S)


def disable(stage: Stage, draw: random.Random) -> TypedError | None:
    """Switch the motors off, and sometimes on again."""
    arm = arm_of(stage)
    error = call(stage, arm.disable)
    if error is None and draw.random() < 0.5:
        error = call(stage, lambda: arm.sleep(1.0)) or call(stage, arm.enable)
    return error


# -- Referencing and connecting -------------------------------------------------------------------


def home(stage: Stage, draw: random.Random) -> TypedError | None:
    """Reference the arm: its device seeks the switches, or the operator brings it to a posture."""
    if stage.config.homing is not None:
        return _home_by_switches(stage, lambda: None)
    arm = arm_of(stage)
    reference = arm.model.reference
    assert reference is not None
    joints = arm.model.arm.ik(reference.pose)
    command = Command("home", reaches=posture_reached(stage, joints, reference.opening_mm))
    return call(stage, arm.home, command, 120.0, references=True)


def stop_homing(stage: Stage, draw: random.Random) -> TypedError | None:
    """Stop an arm while it seeks its switches."""
    return _end_homing(stage, draw, "stop", hard=False)


def estop_homing(stage: Stage, draw: random.Random) -> TypedError | None:
    """Make an emergency stop while an arm seeks its switches."""
    return _end_homing(stage, draw, "estop", hard=True)


def _end_homing(stage: Stage, draw: random.Random, what: str, *, hard: bool) -> TypedError | None:
    after_s = draw.uniform(0.0, HOMING_S)

    def end() -> None:
        arm = stage.arm
        if arm is None or stage.pace.dead:
            return
        status = arm.status
        if status.state is State.HOMING:
            stage.add_bound(what, status.stop_time_s, status.stop_distance_mm)
            arm.request_stop(hard=hard)

    return _home_by_switches(stage, lambda: stage.timeline.at(stage.now_s + after_s, end))


def _home_by_switches(stage: Stage, begin: Callable[[], None]) -> TypedError | None:
    """Let the device seek its switches; `begin` is called when it begins."""
    arm, watch, homing = arm_of(stage), stage.watch, stage.config.homing
    assert homing is not None
    reaches = posture_reached(stage, homing.joints, homing.opening_mm)
    command = Command("home by its switches", reaches=reaches, homes=True)
    search, began_s = arm.parts.core.controller.search, stage.now_s
    lasts_s = in_turn(search(request).lasts for request in homing.requests()).s
    longest_s = lasts_s + len(stage.world.motors) * HOMING_MARGIN_S + TIMEOUT_MARGIN_S

    def act() -> None:
        begin()
        try:
            arm.home()
        except Stopped:
            arm.sleep(2.0)
            raise
        # no driver can know of a switch that is wrong, or of motors that left their orders
        if watch.stuck_until_s >= began_s or watch.excuse is not Excuse.NOTHING:
            watch.hidden = True

    return call(stage, act, command, longest_s, references=True)


def close_and_connect(stage: Stage, draw: random.Random) -> TypedError | None:
    """Close the connection, and connect another program."""
    error = call(stage, arm_of(stage).close)
    stage.program_ended()
    stage.sleep(draw.choice((0.0, 0.5, 3.0)))
    return error or connect(stage, draw)


def connect(stage: Stage, draw: random.Random) -> TypedError | None:
    """Connect a program; nothing moves."""
    options = {"allow_restored": draw.random() < 0.5, "automatic": draw.random() < 0.5}
    return call(stage, lambda: stage.connect(**options), references=True)


ACTIONS: Mapping[str, tuple[Action, int]] = MappingProxyType(
    {
        "move_j": (move_j, 6),
        "move the tip": (move_tip, 7),
        "jog by an increment": (jog_increment, 2),
        "jog for a time": (jog_for_a_time, 2),
        "hold and release": (hold_and_release, 2),
        "abandon a hold": (abandon_hold, 2),
        "hold and vanish": (hold_and_vanish, 1),
        "stop": (stop, 3),
        "estop": (estop, 2),
        "pause": (pause, 2),
        "gripper": (gripper, 2),
        "outputs": (outputs, 1),
        "rest": (rest, 2),
        "disable": (disable, 1),
        "home": (home, 1),
        "close and connect": (close_and_connect, 2),
    }
)
"""Every action with its weight in the draw."""
HOMING_ACTIONS: Mapping[str, tuple[Action, int]] = MappingProxyType(
    {"home": (home, 8), "stop homing": (stop_homing, 5), "estop homing": (estop_homing, 3)}
)
"""The actions of an arm with switches, besides the others."""
