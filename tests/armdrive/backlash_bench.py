"""A driven arm whose trains have play, and how far the physical arm is from where it should be."""

from __future__ import annotations

import random
from dataclasses import replace

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.registry.simulate import simulate
from armdrive.status import State

PLAY = 12
DIALECTS = ("teachmover", "robko01", "armdroid", "grbl")
JOINTS = ("base", "shoulder", "elbow", "wrist_pitch", "wrist_roll")
MIDDLE = dict(zip(JOINTS, (0.0, 42.0, -75.0, -30.0, 0.0), strict=True))


def config_of(dialect, backlash=PLAY, **motion):
    config = simulated_config(dialect)
    count = len(config.model.transmission.motors)
    widths = (backlash,) * count if isinstance(backlash, int) else tuple(backlash)
    return replace(
        config,
        model=replace(config.model, verified=True),
        backlash_steps=widths if any(widths) else (),
        motion=replace(config.motion, **motion),
    )


def played_arm(dialect, *, play=PLAY, backlash=PLAY, home=True, motion=None, **options):
    """Connect to an arm with play, by a driver that takes it for so much backlash."""
    config = config_of(dialect, backlash, **(motion or {}))
    arm = Arm(connect_simulated(config, twin=simulate(config, play=play, **options)))
    if home:
        if arm.status.state is State.DISABLED:
            arm.enable()
        refer(arm)
    return arm


def refer(arm):
    """Come to a posture from one side, and say which one it is."""
    wide = 2 * max(arm.config.backlash_steps or (PLAY,))
    arm.move_motors(*(-wide for _ in arm.status.acknowledged), speed=1.0)
    arm.move_motors(*(wide for _ in arm.status.acknowledged), speed=1.0)
    arm.declare_posture(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)


def off_steps(arm):
    """Return how far the motor is off that is furthest from where it is said to be."""
    return (arm.twin.world.motors - arm.status.acknowledged).largest


def off_mm(arm):
    world, pose = arm.twin.world, arm.pose
    return max(
        abs(there - said)
        for there, said in zip(world.tip, (pose.x_mm, pose.y_mm, pose.z_mm), strict=True)
    )


def shaken(arm, count, seed=1, deg=5.0):
    """Move to and fro at random; return how far the arm was off afterwards each time."""
    chance = random.Random(seed)
    found = []
    for _ in range(count):
        goal = {f"{name}_deg": mid + chance.uniform(-deg, deg) for name, mid in MIDDLE.items()}
        arm.move_j(speed=chance.choice([0.3, 1.0]), **goal)
        found.append(off_steps(arm))
    return found
