"""What a mission asks of its arm: each action draws its own numbers, and tells what it did."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any

from armdrive.arm import Arm
from armdrive.arm.connected import Handle
from armdrive.arm.moving import PATIENCE
from armdrive.connect.parts import PATIENCE_S
from armdrive.motion.execute import Moved
from armdrive.moves import Jog
from armdrive.sim.world.table import TableBlock
from armdrive.status import State, Status
from kinematics import LinePart
from tests.conformance.going import beside

from .arrival import GraspAim, JointsAim, PostureAim
from .goals import (
    arm_of,
    beyond_a_limit,
    command_of,
    joint_goal,
    joints_aim,
    pose_aim,
    pose_beside,
    span_to,
    speed_of,
    supposed_motors,
    supposed_place,
)
from .laws import Typed, call
from .physical import Aim, Command
from .speeds import WINDOW_S
from .stage import Stage, suspend

ANSWERS_S = PATIENCE_S + 10.0
"""A motion is stopped so much later than several times its planned duration, at the latest."""

Action = Callable[[Stage], Typed | None]


def move_j(stage: Stage) -> Typed | None:
    """Move some joints, now and then beyond a limit."""
    goal, takes_s = joint_goal(stage)
    speed = speed_of(stage.draw)
    if stage.draw.random() < 0.1:
        goal[next(iter(goal))] = stage.draw.choice((-400.0, 400.0))
    elif stage.draw.random() < 0.1:
        goal = beyond_a_limit(stage)
    return move_to_joints(stage, goal, takes_s, speed)


def move_to_joints(
    stage: Stage, goal: Mapping[str, float], takes_s: float, speed: float
) -> Typed | None:
    """Move joints to a goal in degrees, which takes so long at full speed."""
    longest_s = takes_s / speed * PATIENCE + ANSWERS_S
    aim = joints_aim(stage, goal)
    what = f"move_j({goal}, {speed})"
    command = command_of(stage, what, aim, speed=speed, span=span_to(stage, aim))
    return call(stage, lambda: arm_of(stage).move_j(speed=speed, **goal), command, longest_s)


def move_certainly(stage: Stage, goal: Mapping[str, float]) -> Typed | None:
    """Move to a goal that nothing forbids."""
    return move_to_joints(stage, goal, 10.0, 1.0)


def move_to(stage: Stage) -> Typed | None:
    """Move to a pose nearby, or one that is out of reach."""
    goal = pose_beside(stage)
    command = command_of(stage, f"move_to({goal})", pose_aim(stage, goal))
    return call(stage, lambda: arm_of(stage).move_to(goal), command, 10.0 + ANSWERS_S)


def move_l(stage: Stage) -> Typed | None:
    """Move to a pose along a line."""
    goal = pose_beside(stage)
    command = command_of(stage, f"move_l({goal})", pose_aim(stage, goal))
    return call(stage, lambda: arm_of(stage).move_l(goal), command, 10.0 + ANSWERS_S)


def move_path(stage: Stage) -> Typed | None:
    """Move around a corner to a pose."""
    corner, goal = pose_beside(stage), pose_beside(stage)
    moves = [LinePart(corner, stage.draw.choice((0.0, 2.0))), LinePart(goal)]
    command = command_of(stage, f"move_path({corner}, {goal})", pose_aim(stage, goal))
    return call(stage, lambda: arm_of(stage).move_path(moves), command, 10.0 + ANSWERS_S)


def jog_increment(stage: Stage) -> Typed | None:
    """Jog by an increment: as far as asked, or less far where the result says so."""
    arm = arm_of(stage)
    here = supposed_place(stage)
    name = stage.draw.choice(arm.model.arm.joint_names)
    by = {f"{name}_deg": stage.draw.uniform(-3.0, 3.0)}
    aim: Aim
    if stage.draw.random() < 0.3:
        by = {"z_mm": stage.draw.uniform(-8.0, 8.0)}
        goal = beside(arm.model.arm.fk(here.joints), z_mm=by["z_mm"])
        aim, jog = pose_aim(stage, goal, clipped=True), arm.jog_l
    else:
        goal_deg = {word: here.joints.deg[name] + turn for word, turn in by.items()}
        aim, jog = joints_aim(stage, goal_deg, clipped=True), arm.jog_j
    command = command_of(stage, f"jog({by})", aim)
    return call(stage, lambda: jog(**by), command, 10.0 + ANSWERS_S)


@contextmanager
def expiring(stage: Stage, what: str) -> Iterator[Callable[[float], None]]:
    """Hold an arm to the end of a jog that nobody renews: it expires by itself.

    What this gives is to be called with how long each jog that is asked for may last from now on.
    From the moment at which the latest expires, the tip goes no longer and no further than the
    status announces then.
    """
    expires_s = math.inf

    def expire() -> None:
        if stage.now_s >= expires_s:
            stage.promise_stop(what)

    def lasts(for_s: float) -> None:
        nonlocal expires_s
        stage.watch.let_go_on()  # where the one before has expired by now
        expires_s = stage.now_s + for_s
        stage.agenda.at(expires_s, expire)

    try:
        yield lasts
    finally:
        expires_s = math.inf


def jog_for_a_time(stage: Stage) -> Typed | None:
    """Jog two joints for a time."""
    names = stage.draw.sample(arm_of(stage).model.arm.joint_names, 2)
    axes = {name: stage.draw.uniform(-1.0, 1.0) for name in names}
    for_s, speed = stage.draw.uniform(0.1, 0.7), speed_of(stage.draw)
    command = command_of(stage, f"jog_j({axes}, {speed}, {for_s:.2f} s)", speed=speed)

    def act() -> None:
        with expiring(stage, "the time of a jog was over") as lasts:
            lasts(for_s)
            arm_of(stage).jog_j(speed=speed, duration_s=for_s, **axes)

    return call(stage, act, command, for_s + ANSWERS_S)


def hold_and_release(stage: Stage) -> Typed | None:
    """Hold a jog, and let go of it."""
    arm, draw = arm_of(stage), stage.draw
    speed = speed_of(draw)
    jog = Jog.joint(**{draw.choice(arm.model.arm.joint_names): draw.choice((-1.0, 1.0))})
    command = command_of(stage, f"hold({jog})", speed=speed)
    command.verified = False

    def act() -> None:
        with expiring(stage, "a hold expired") as lasts:
            lasts(0.8)
            arm.hold(jog, speed=speed, for_s=0.8)
            arm.sleep(draw.uniform(0.0, 0.6))
            status = arm.status
            arm.release()
            if status.state is State.MOVING:
                stage.promise("released", status.stop_time_s, status.stop_distance_mm)
            arm.sleep(2.0)

    return call(stage, act, command, ANSWERS_S)


LONGEST_HOLD_S = 1.0
"""A hold that is asked for longer expires by then."""


def abandon_hold(stage: Stage) -> Typed | None:
    """Hold a jog, perhaps renew it, and never let go: it expires while the program does others."""
    return _abandon(stage, lambda: None)


def hold_and_vanish(stage: Stage) -> Typed | None:
    """Hold a jog, and be suspended or killed: it expires all the same."""
    draw = stage.draw
    after_s = draw.uniform(0.0, 1.0)
    for_s = draw.choice((0.0, 0.4, 1.5, 4.0))

    def vanish() -> None:
        if for_s:
            suspend(stage, for_s)
        else:
            stage.pace.die()

    return _abandon(stage, lambda: stage.agenda.at(stage.now_s + after_s, vanish))


def _abandon(stage: Stage, then: Callable[[], None]) -> Typed | None:
    arm, draw = arm_of(stage), stage.draw
    speed, for_s = speed_of(draw), draw.uniform(0.1, 1.5)
    jog = Jog.joint(**{draw.choice(arm.model.arm.joint_names): draw.choice((-1.0, 1.0))})
    command = command_of(stage, f"hold({jog}, {for_s:.2f} s), never released", speed=speed)
    command.verified = False
    renewals = draw.choice((0, 0, 1, 3))

    def act() -> None:
        with expiring(stage, "an abandoned hold expired") as lasts:
            for number in range(renewals + 1):
                lasts(min(for_s, LONGEST_HOLD_S))
                arm.hold(jog, speed=speed, for_s=for_s)
                if number < renewals:
                    arm.sleep(draw.uniform(0.0, for_s))
            then()
            arm.sleep(4.0)

    return call(stage, act, command, ANSWERS_S)


def _stop_bound(status: Status) -> tuple[float, float]:
    return status.stop_time_s, status.stop_distance_mm


def _pause_bound(status: Status) -> tuple[float, float]:
    return status.pause_time_s, status.pause_distance_mm


SWEEP_S = 2.0
"""What is stopped or paused would go on for longer than that takes."""


def _sweep(
    stage: Stage,
    what: str,
    then: Callable[[Arm, Handle[Moved], Command], Any],
    bound: Callable[[Status], tuple[float, float]] = _stop_bound,
    *,
    arrives: bool = False,
) -> Typed | None:
    """Begin a motion, and do something to it in mid-way: it stands within what was announced.

    A motion that goes on afterwards `arrives`.
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
            stage.promise(what, *bound(status), finishes=bound is _pause_bound)
        then(arm, handle, command)

    return call(stage, act, command, takes_s * PATIENCE + ANSWERS_S)


def stop(stage: Stage) -> Typed | None:
    """Stop in motion."""

    def then(arm: Arm, _: Handle[Moved], __: Command) -> None:
        arm.stop()
        arm.sleep(2.0)

    return _sweep(stage, "stop", then)


def estop(stage: Stage) -> Typed | None:
    """Stop in motion, and latch it. That does not wait."""

    def then(arm: Arm, _: Handle[Moved], __: Command) -> None:
        arm.estop()
        arm.sleep(2.0)

    return _sweep(stage, "estop", then)


def pause(stage: Stage) -> Typed | None:
    """Pause in motion, slow down, and go on to the end."""
    share = stage.draw.choice((0.4, 1.0))

    def then(arm: Arm, handle: Handle[Moved], command: Command) -> None:
        arm.pause()
        for _ in range(10):
            if handle.done:  # it was short: what befalls the arm from now on is not its fault
                break
            arm.sleep(0.1)
        stage.watch.let_go_on()
        arm.speed_override = share
        arm.resume()

        def slowed() -> None:
            command.speed = share

        # what had been sent ahead keeps its speed, for as long as a silent program's arm goes on
        stage.agenda.at(stage.now_s + arm.status.silent_time_s + WINDOW_S, slowed)
        try:
            handle.wait()
        finally:
            arm.speed_override = 1.0

    return _sweep(stage, "pause", then, _pause_bound, arrives=True)


def gripper(stage: Stage) -> Typed | None:
    """Bring the fingers somewhere, or grasp."""
    arm, draw = arm_of(stage), stage.draw
    opening_mm = draw.choice((10.0, 18.0, 24.0, 90.0))
    if arm.abilities.grip_switch and draw.random() < 0.4:
        return grasp(stage)
    aim = JointsAim(supposed_motors(stage), {}, opening_mm, stage.near_steps)
    command = command_of(stage, f"gripper {opening_mm}", aim)
    return call(stage, lambda: arm.gripper.move(opening_mm), command, 10.0 + ANSWERS_S)


BLOCK = "grasped"
BLOCK_MM = 6.0
"""A block is wider than that: less counts as nothing between the fingers."""
ROOM_MM = 2.0
"""The fingers stand open by so much more than the block is wide."""


def grasp(stage: Stage) -> Typed | None:
    """Close on a block that somebody has put between the fingers, or on nothing."""
    world, draw = stage.world, stage.draw
    widest_mm = world.opening_mm - ROOM_MM
    x_mm, y_mm, z_mm = world.tip
    there = draw.random() < 0.7 and z_mm > 0.0 and widest_mm > BLOCK_MM
    if there:
        width_mm = draw.uniform(BLOCK_MM, widest_mm)
        world.put(TableBlock(BLOCK, x_mm, y_mm, width_mm=width_mm, height_mm=z_mm + ROOM_MM))
    command = command_of(stage, "grasp a block" if there else "grasp", GraspAim())
    try:
        return call(stage, arm_of(stage).gripper.grasp, command, 60.0)
    finally:
        world.take(BLOCK)


def outputs(stage: Stage) -> Typed | None:
    """Set outputs, read inputs."""
    arm, bits = arm_of(stage), stage.draw.choice((0, 5, 255, 256))
    error = call(stage, lambda: arm.set_outputs(bits))
    return error or call(stage, arm.read_inputs)


def rest(stage: Stage) -> Typed | None:
    """Do nothing for a while; nothing moves."""
    for_s = stage.draw.choice((0.05, 0.5, 2.5, 5.0))
    return call(stage, lambda: arm_of(stage).sleep(for_s), None, for_s + ANSWERS_S)


def disable(stage: Stage) -> Typed | None:
    """Switch the current off, and on again."""
    arm = arm_of(stage)
    error = call(stage, arm.disable)
    if error is None and stage.draw.random() < 0.5:
        error = call(stage, lambda: arm.sleep(1.0)) or call(stage, arm.enable)
    return error


def home(stage: Stage) -> Typed | None:
    """Have the operator bring the arm to its reference posture."""
    arm = arm_of(stage)
    reference = arm.model.reference
    assert reference is not None
    joints, near = arm.model.arm.ik(reference.pose), stage.watch.on_the_step
    command = Command("home", aim=PostureAim(joints, reference.opening_mm, near))
    with stage.watch.referencing() as ended_well:
        error = call(stage, arm.home, command, 120.0)
        if error is None:
            ended_well()
    return error


def close_and_connect(stage: Stage) -> Typed | None:
    """End the program well, and begin another."""
    arm = arm_of(stage)
    error = call(stage, arm.close)
    stage.leave()
    stage.sleep(stage.draw.choice((0.0, 0.5, 3.0)))
    return error or connect(stage)


def connect(stage: Stage) -> Typed | None:
    """Have a program connect. Nothing moves."""
    draw = stage.draw
    options = {
        "allow_restored": draw.random() < 0.5,
        "automatic": draw.random() < 0.5,
        "recorded": draw.random() < 0.25,
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
"""Every action, and how often it is drawn."""
