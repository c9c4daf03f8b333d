"""The actions of a mission. Each draws its own numbers, makes its calls, and returns the error."""

import math
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

from .arrival import GraspAim, JointsAim, PostureAim
from .goals import (
    arm_of,
    beyond_a_limit,
    command_of,
    joint_goal,
    joints_aim,
    nearby_pose,
    pose_aim,
    span_to,
    speed_of,
)
from .laws import TypedError, call
from .physical import Aim, Command
from .speeds import WINDOW_S
from .stage import Stage, suspend

TIMEOUT_MARGIN_S = PATIENCE_S + 10.0
"""A motion has to end within `PATIENCE` times its planned duration, and this margin."""

HOMING_S = 20.0
"""A simulated arm seeks its switches for about this long."""

Action = Callable[[Stage], TypedError | None]


def move_j(stage: Stage) -> TypedError | None:
    """Move some joints, sometimes beyond a limit."""
    goal, takes_s = joint_goal(stage)
    speed = speed_of(stage.draw)
    if stage.draw.random() < 0.1:
        goal[next(iter(goal))] = stage.draw.choice((-400.0, 400.0))
    elif stage.draw.random() < 0.1:
        goal = beyond_a_limit(stage)
    return move_to_joints(stage, goal, takes_s, speed)


def move_to_joints(
    stage: Stage, goal: Mapping[str, float], takes_s: float, speed: float
) -> TypedError | None:
    """Move joints to a goal in degrees. `takes_s` is the duration at full speed."""
    longest_s = takes_s / speed * PATIENCE + TIMEOUT_MARGIN_S
    aim = joints_aim(stage, goal)
    what = f"move_j({goal}, {speed})"
    command = command_of(stage, what, aim, speed=speed, span=span_to(stage, aim))
    return call(stage, lambda: arm_of(stage).move_j(speed=speed, **goal), command, longest_s)


def move_certainly(stage: Stage, goal: Mapping[str, float]) -> TypedError | None:
    """Move to a goal that the driver must allow."""
    return move_to_joints(stage, goal, 10.0, 1.0)


def move_to(stage: Stage) -> TypedError | None:
    """Move to a pose nearby, or to one that is out of reach."""
    goal = nearby_pose(stage)
    command = command_of(stage, f"move_to({goal})", pose_aim(stage, goal))
    return call(stage, lambda: arm_of(stage).move_to(goal), command, 10.0 + TIMEOUT_MARGIN_S)


def move_l(stage: Stage) -> TypedError | None:
    """Move to a pose along a line."""
    goal = nearby_pose(stage)
    command = command_of(stage, f"move_l({goal})", pose_aim(stage, goal))
    return call(stage, lambda: arm_of(stage).move_l(goal), command, 10.0 + TIMEOUT_MARGIN_S)


def move_path(stage: Stage) -> TypedError | None:
    """Move around a corner to a pose."""
    corner, goal = nearby_pose(stage), nearby_pose(stage)
    moves = [LinePart(corner, stage.draw.choice((0.0, 2.0))), LinePart(goal)]
    command = command_of(stage, f"move_path({corner}, {goal})", pose_aim(stage, goal))
    return call(stage, lambda: arm_of(stage).move_path(moves), command, 10.0 + TIMEOUT_MARGIN_S)


def jog_increment(stage: Stage) -> TypedError | None:
    """Jog by an increment; it may be clipped if the result says so."""
    arm = arm_of(stage)
    here, _ = stage.posture()
    name = stage.draw.choice(arm.model.arm.joint_names)
    by = {f"{name}_deg": stage.draw.uniform(-3.0, 3.0)}
    aim: Aim
    if stage.draw.random() < 0.3:
        by = {"z_mm": stage.draw.uniform(-8.0, 8.0)}
        goal = shifted(arm.model.arm.fk(here), z_mm=by["z_mm"])
        aim, jog = pose_aim(stage, goal, clipped=True), arm.jog_l
    else:
        goal_deg = {word: here.deg[name] + turn for word, turn in by.items()}
        aim, jog = joints_aim(stage, goal_deg, clipped=True), arm.jog_j
    command = command_of(stage, f"jog({by})", aim)
    return call(stage, lambda: jog(**by), command, 10.0 + TIMEOUT_MARGIN_S)


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
        stage.schedule.at(expires_s, expire)

    try:
        yield expires_in
    finally:
        expires_s = math.inf


def jog_for_a_time(stage: Stage) -> TypedError | None:
    """Jog two joints for a time."""
    names = stage.draw.sample(arm_of(stage).model.arm.joint_names, 2)
    axes = {name: stage.draw.uniform(-1.0, 1.0) for name in names}
    for_s, speed = stage.draw.uniform(0.1, 0.7), speed_of(stage.draw)
    command = command_of(stage, f"jog_j({axes}, {speed}, {for_s:.2f} s)", speed=speed)

    def act() -> None:
        with expected_expiry(stage, "the time of a jog was over") as expires_in:
            expires_in(for_s)
            arm_of(stage).jog_j(speed=speed, duration_s=for_s, **axes)

    return call(stage, act, command, for_s + TIMEOUT_MARGIN_S)


def hold_and_release(stage: Stage) -> TypedError | None:
    """Hold a jog, and release it."""
    arm, draw = arm_of(stage), stage.draw
    speed = speed_of(draw)
    jog = Jog.joint(**{draw.choice(arm.model.arm.joint_names): draw.choice((-1.0, 1.0))})
    command = command_of(stage, f"hold({jog})", speed=speed)
    command.verified = False

    def act() -> None:
        with expected_expiry(stage, "a hold expired") as expires_in:
            expires_in(0.8)
            arm.jogging.hold(jog, speed=speed, for_s=0.8)
            arm.sleep(draw.uniform(0.0, 0.6))
            status = arm.status
            arm.jogging.release()
            if status.state is State.MOVING:
                stage.add_bound("released", status.stop_time_s, status.stop_distance_mm)
            arm.sleep(2.0)

    return call(stage, act, command, TIMEOUT_MARGIN_S)


MAX_HOLD_S = 1.0
"""The longest hold that the driver grants; a longer request expires after this time."""


def abandon_hold(stage: Stage) -> TypedError | None:
    """Hold a jog, perhaps renew it, and never release it: it expires while the program goes on."""
    return _abandon(stage, lambda: None)


def hold_and_vanish(stage: Stage) -> TypedError | None:
    """Hold a jog, and suspend or kill the program: the jog expires all the same."""
    draw = stage.draw
    after_s = draw.uniform(0.0, 1.0)
    for_s = draw.choice((0.0, 0.4, 1.5, 4.0))

    def vanish() -> None:
        if for_s:
            suspend(stage, for_s)
        else:
            stage.pace.kill()

    return _abandon(stage, lambda: stage.schedule.at(stage.now_s + after_s, vanish))


def _abandon(stage: Stage, then: Callable[[], None]) -> TypedError | None:
    arm, draw = arm_of(stage), stage.draw
    speed, for_s = speed_of(draw), draw.uniform(0.1, 1.5)
    jog = Jog.joint(**{draw.choice(arm.model.arm.joint_names): draw.choice((-1.0, 1.0))})
    command = command_of(stage, f"hold({jog}, {for_s:.2f} s), never released", speed=speed)
    command.verified = False
    renewals = draw.choice((0, 0, 1, 3))

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


def _stop_bound(status: Status) -> tuple[float, float]:
    return status.stop_time_s, status.stop_distance_mm


def _pause_bound(status: Status) -> tuple[float, float]:
    return status.pause_time_s, status.pause_distance_mm


SWEEP_S = 2.0
"""The longest duration of a motion that is stopped or paused on its way."""


def _sweep(
    stage: Stage,
    what: str,
    then: Callable[[Arm, Handle[Moved], Command], Any],
    bound: Callable[[Status], tuple[float, float]] = _stop_bound,
    *,
    arrives: bool = False,
) -> TypedError | None:
    """Begin a motion and interrupt it by `then`; the arm stops within the announced `bound`.

    `arrives`: the motion goes on afterwards and reaches its goal.
    """
    goal, takes_s = joint_goal(stage, 60.0, SWEEP_S)
    aim = joints_aim(stage, goal)
    span = span_to(stage, aim)
    command = command_of(stage, f"{what} in move_j({goal})", aim if arrives else None, span=span)
    command.verified = False
    arm, after_s = arm_of(stage), stage.draw.uniform(0.0, 0.7)

    def act() -> None:
        handle = arm.move_j(wait=False, **goal)
        arm.sleep(after_s)
        status = arm.status
        if status.state is State.MOVING:
            stage.add_bound(what, *bound(status), is_pause=bound is _pause_bound)
        then(arm, handle, command)

    return call(stage, act, command, takes_s * PATIENCE + TIMEOUT_MARGIN_S)


def stop(stage: Stage) -> TypedError | None:
    """Stop in motion."""

    def then(arm: Arm, _: Handle[Moved], __: Command) -> None:
        arm.stop()
        arm.sleep(2.0)

    return _sweep(stage, "stop", then)


def estop(stage: Stage) -> TypedError | None:
    """Make an emergency stop in motion. The call does not wait for the arm."""

    def then(arm: Arm, _: Handle[Moved], __: Command) -> None:
        arm.estop()
        arm.sleep(2.0)

    return _sweep(stage, "estop", then)


def pause(stage: Stage) -> TypedError | None:
    """Pause in motion, change the speed override, and resume to the end."""
    share = stage.draw.choice((0.4, 1.0))

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
        stage.schedule.at(stage.now_s + arm.status.silent_time_s + WINDOW_S, slowed)
        try:
            handle.wait()
        finally:
            arm.speed_override = 1.0

    return _sweep(stage, "pause", then, _pause_bound, arrives=True)


def gripper(stage: Stage) -> TypedError | None:
    """Move the fingers, or grasp."""
    arm, draw = arm_of(stage), stage.draw
    opening_mm = draw.choice((10.0, 18.0, 24.0, 90.0))
    if arm.abilities.grip_switch and draw.random() < 0.4:
        return grasp(stage)
    aim = JointsAim(stage.look(), {}, opening_mm, stage.near_steps)
    command = command_of(stage, f"gripper {opening_mm}", aim)
    return call(stage, lambda: arm.gripper.open(opening_mm), command, 10.0 + TIMEOUT_MARGIN_S)


BLOCK = "grasped"
BLOCK_MM = 6.0
"""The narrowest block: less counts as nothing between the fingers."""
CLEARANCE_MM = 2.0
"""How much wider than the block the fingers are open at least."""


def grasp(stage: Stage) -> TypedError | None:
    """Grasp a block that was put between the fingers, or nothing."""
    world, draw = stage.world, stage.draw
    widest_mm = world.opening_mm - CLEARANCE_MM
    x_mm, y_mm, z_mm = world.tip
    there = draw.random() < 0.7 and z_mm > 0.0 and widest_mm > BLOCK_MM
    if there:
        width_mm = draw.uniform(BLOCK_MM, widest_mm)
        world.put(TableBlock(BLOCK, x_mm, y_mm, width_mm=width_mm, height_mm=z_mm + CLEARANCE_MM))
    command = command_of(stage, "grasp a block" if there else "grasp", GraspAim())
    try:
        return call(stage, arm_of(stage).gripper.grasp, command, 60.0)
    finally:
        if there:
            world.take(BLOCK)


def outputs(stage: Stage) -> TypedError | None:
    """Set outputs, read inputs."""
    arm, bits = arm_of(stage), stage.draw.choice((0, 5, 255, 256))
    error = call(stage, lambda: arm.io.write(bits))
    return error or call(stage, arm.io.read)


def rest(stage: Stage) -> TypedError | None:
    """Wait; nothing moves."""
    for_s = stage.draw.choice((0.05, 0.5, 2.5, 5.0))
    return call(stage, lambda: arm_of(stage).sleep(for_s), None, for_s + TIMEOUT_MARGIN_S)


def disable(stage: Stage) -> TypedError | None:
    """Switch the motors off, and sometimes on again."""
    arm = arm_of(stage)
    error = call(stage, arm.disable)
    if error is None and stage.draw.random() < 0.5:
        error = call(stage, lambda: arm.sleep(1.0)) or call(stage, arm.enable)
    return error


def home(stage: Stage) -> TypedError | None:
    """Reference the arm: its device seeks the switches, or the operator brings it to a posture."""
    if stage.homes:
        return _home_by_switches(stage, lambda: None)
    arm = arm_of(stage)
    reference = arm.model.reference
    assert reference is not None
    joints, near = arm.model.arm.ik(reference.pose), stage.watch.on_the_step
    command = Command("home", aim=PostureAim(joints, reference.opening_mm, near))
    with stage.watch.reference_attempt() as succeeded:
        error = call(stage, arm.home, command, 120.0)
        if error is None:
            succeeded.append(True)
    return error


def stop_homing(stage: Stage) -> TypedError | None:
    """Stop an arm while it seeks its switches."""
    return _end_homing(stage, "stop", hard=False)


def estop_homing(stage: Stage) -> TypedError | None:
    """Make an emergency stop while an arm seeks its switches."""
    return _end_homing(stage, "estop", hard=True)


def _end_homing(stage: Stage, what: str, *, hard: bool) -> TypedError | None:
    after_s = stage.draw.uniform(0.0, HOMING_S)

    def stop() -> None:
        arm = stage.arm
        if arm is None or stage.pace.dead:
            return
        status = arm.status
        if status.state is State.HOMING:
            stage.add_bound(what, status.stop_time_s, status.stop_distance_mm)
            arm.request_stop(hard=hard)

    return _home_by_switches(stage, lambda: stage.schedule.at(stage.now_s + after_s, stop))


def _home_by_switches(stage: Stage, begin: Callable[[], None]) -> TypedError | None:
    """Let the device seek its switches; `begin` is called when it begins."""
    arm, watch, homing = arm_of(stage), stage.watch, stage.config.homing
    assert homing is not None
    aim = PostureAim(homing.joints, homing.opening_mm, watch.on_the_step)
    command = Command("home by its switches", aim=aim, homes=True)
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
        _excuse_homed(stage, began_s)

    with watch.reference_attempt() as succeeded:
        watch.begin_reference(no_faults=stage.no_faults)
        error = call(stage, act, command, longest_s)
        if error is None:
            succeeded.append(True)
    return error


def _excuse_homed(stage: Stage, began_s: float) -> None:
    """Excuse motors that were moved in a homing, or whose switches were stuck: no driver can know.

    Nor can it know of a line that was changed and made the board home another axis.
    """
    watch = stage.watch
    stuck = {at for at, until_s in stage.stuck_until_s.items() if until_s >= began_s}
    watch.lose_track(watch.doubts.off_path | watch.moved_in_command | stuck)
    if watch.doubts.misdirected:
        watch.lose_track(range(len(stage.world.motors)))


def close_and_connect(stage: Stage) -> TypedError | None:
    """Close the connection, and connect another program."""
    arm = arm_of(stage)
    error = call(stage, arm.close)
    stage.program_ended()
    stage.sleep(stage.draw.choice((0.0, 0.5, 3.0)))
    return error or connect(stage)


def connect(stage: Stage) -> TypedError | None:
    """Connect a program; nothing moves."""
    draw = stage.draw
    options = {
        "allow_restored": draw.random() < 0.5,
        "automatic": draw.random() < 0.5,
    }
    return call(stage, lambda: stage.connect(**options))


ACTIONS: Mapping[str, tuple[Action, int]] = MappingProxyType(
    {
        "move_j": (move_j, 6),
        "move_to": (move_to, 3),
        "move_l": (move_l, 3),
        "move_path": (move_path, 1),
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
