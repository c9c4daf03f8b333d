"""What a mission asks of its arm: each action draws its own numbers, and tells what it did."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from armdrive.arm import Arm
from armdrive.calls.moving import PATIENCE
from armdrive.calls.waiting import PATIENCE_S
from armdrive.flows.motion import Moved
from armdrive.handle import Handle
from armdrive.intents import Jog
from armdrive.status import State, Status

from .goals import arm_of, command_of, joint_goal, pose_beside, span_to, speed_of
from .laws import Typed, call
from .physical import Command
from .stage import Stage

ANSWERS_S = PATIENCE_S + 10.0
"""A motion is stopped so much later than several times its planned duration, at the latest."""

Action = Callable[[Stage], Typed | None]


def move_j(stage: Stage) -> Typed | None:
    """Move some joints, now and then beyond a limit."""
    goal, takes_s = joint_goal(stage)
    speed = speed_of(stage.draw)
    if stage.draw.random() < 0.1:
        goal[next(iter(goal))] = stage.draw.choice((-400.0, 400.0))
    longest_s = takes_s / speed * PATIENCE + ANSWERS_S
    command = command_of(stage, f"move_j({goal}, {speed})", span_to(stage, goal))
    return call(stage, lambda: arm_of(stage).move_j(speed=speed, **goal), command, longest_s)


def move_to(stage: Stage) -> Typed | None:
    """Move to a pose nearby, or one that is out of reach."""
    goal = pose_beside(stage)
    command = command_of(stage, f"move_to({goal})")
    return call(stage, lambda: arm_of(stage).move_to(goal), command, 10.0 + ANSWERS_S)


def move_l(stage: Stage) -> Typed | None:
    """Move to a pose along a line."""
    goal = pose_beside(stage)
    command = command_of(stage, f"move_l({goal})")
    return call(stage, lambda: arm_of(stage).move_l(goal), command, 10.0 + ANSWERS_S)


def jog_increment(stage: Stage) -> Typed | None:
    """Jog by an increment."""
    name = stage.draw.choice(arm_of(stage).model.arm.joint_names)
    by = {f"{name}_deg": stage.draw.uniform(-3.0, 3.0)}
    if stage.draw.random() < 0.3:
        by = {"z_mm": stage.draw.uniform(-8.0, 8.0)}
    command = command_of(stage, f"jog({by})")
    arm = arm_of(stage)
    jog = arm.jog_l if "z_mm" in by else arm.jog_j
    return call(stage, lambda: jog(**by), command, 10.0 + ANSWERS_S)


def jog_for_a_time(stage: Stage) -> Typed | None:
    """Jog two joints for a time."""
    names = stage.draw.sample(arm_of(stage).model.arm.joint_names, 2)
    axes = {name: stage.draw.uniform(-1.0, 1.0) for name in names}
    for_s, speed = stage.draw.uniform(0.1, 0.7), speed_of(stage.draw)
    command = command_of(stage, f"jog_j({axes}, {speed}, {for_s:.2f} s)")
    act = lambda: arm_of(stage).jog_j(speed=speed, duration_s=for_s, **axes)  # noqa: E731
    return call(stage, act, command, for_s + ANSWERS_S)


def hold_and_release(stage: Stage) -> Typed | None:
    """Hold a jog, and let go of it."""
    arm, draw = arm_of(stage), stage.draw
    jog = Jog.joint(**{draw.choice(arm.model.arm.joint_names): draw.choice((-1.0, 1.0))})
    command = command_of(stage, f"hold({jog})")
    command.verified = False

    def act() -> None:
        arm.hold(jog, speed=speed_of(draw), for_s=0.8)
        arm.sleep(draw.uniform(0.0, 0.6))
        if draw.random() < 0.8:
            status = arm.status
            arm.release()
            if status.state is State.MOVING:
                stage.promise("released", status.stop_time_s, status.stop_distance_mm)
        arm.sleep(2.0)

    return call(stage, act, command, ANSWERS_S)


def _stop_bound(status: Status) -> tuple[float, float]:
    return status.stop_time_s, status.stop_distance_mm


def _pause_bound(status: Status) -> tuple[float, float]:
    return status.pause_time_s, status.pause_distance_mm


def _sweep(
    stage: Stage,
    what: str,
    then: Callable[[Arm, Handle[Moved]], Any],
    bound: Callable[[Status], tuple[float, float]] = _stop_bound,
) -> Typed | None:
    """Begin a motion, and do something to it in mid-way: it stands within what was announced."""
    goal, takes_s = joint_goal(stage, 40.0)
    command = command_of(stage, f"{what} in move_j({goal})", span_to(stage, goal))
    command.verified = False
    arm, after_s = arm_of(stage), stage.draw.uniform(0.0, 0.7)

    def act() -> None:
        handle = arm.move_j(wait=False, **goal)
        arm.sleep(after_s)
        status = arm.status
        if status.state is State.MOVING:
            stage.promise(what, *bound(status))
        then(arm, handle)

    return call(stage, act, command, takes_s * PATIENCE + ANSWERS_S)


def stop(stage: Stage) -> Typed | None:
    """Stop in motion."""

    def then(arm: Arm, _: Handle[Moved]) -> None:
        arm.stop()
        arm.sleep(1.0)

    return _sweep(stage, "stop", then)


def estop(stage: Stage) -> Typed | None:
    """Stop in motion, and latch it. That does not wait."""

    def then(arm: Arm, _: Handle[Moved]) -> None:
        arm.estop()
        arm.sleep(2.0)

    return _sweep(stage, "estop", then)


def pause(stage: Stage) -> Typed | None:
    """Pause in motion, slow down, and go on."""
    share = stage.draw.choice((0.4, 1.0))

    def then(arm: Arm, handle: Handle[Moved]) -> None:
        arm.pause()
        arm.sleep(1.0)
        stage.watch.let_go_on()
        arm.speed_override = share
        arm.resume()
        try:
            handle.wait()
        finally:
            arm.speed_override = 1.0

    return _sweep(stage, "pause", then, _pause_bound)


def gripper(stage: Stage) -> Typed | None:
    """Bring the fingers somewhere, or grasp."""
    arm, draw = arm_of(stage), stage.draw
    opening_mm = draw.choice((10.0, 18.0, 24.0, 90.0))
    if arm.abilities.grip_switch and draw.random() < 0.2:
        return call(stage, arm.gripper.grasp, command_of(stage, "grasp"), 60.0)
    command = command_of(stage, f"gripper {opening_mm}")
    return call(stage, lambda: arm.gripper.move(opening_mm), command, 10.0 + ANSWERS_S)


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
    command = Command("home")
    error = call(stage, arm.home, command, 120.0)
    if error is None and not stage.twin.faults.active:
        stage.watch.referred()
    return error


def close_and_connect(stage: Stage) -> Typed | None:
    """End the program well, and begin another."""
    arm = arm_of(stage)
    error = call(stage, arm.close)
    stage.arm = None
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
        "jog by an increment": (jog_increment, 2),
        "jog for a time": (jog_for_a_time, 2),
        "hold and release": (hold_and_release, 2),
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
