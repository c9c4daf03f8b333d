"""A driven arm whose gear trains have play, and how far the physical arm is off."""

import random
from dataclasses import replace

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.registry import simulate
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


def arm_with_play(dialect, *, play=PLAY, backlash=PLAY, home=True, motion=None, **options):
    """Connect to an arm with `play`, with a driver that compensates `backlash`. Both in steps."""
    config = config_of(dialect, backlash, **(motion or {}))
    arm = Arm(connect_simulated(config, twin=simulate(config, play=play, **options)))
    if home:
        if arm.status.state is State.DISABLED:
            arm.enable()
        reference_from_one_side(arm)
    return arm


def reference_from_one_side(arm):
    """Approach a posture from one side, and declare it."""
    wide = 2 * max(arm.config.backlash_steps or (PLAY,))
    arm.move_motors(*(-wide for _ in arm.status.acknowledged), speed=1.0)
    arm.move_motors(*(wide for _ in arm.status.acknowledged), speed=1.0)
    arm.reference.declare(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)


def off_steps(arm):
    """Return the largest distance of a motor from its acknowledged position, in steps."""
    return (arm.twin.world.motors - arm.status.acknowledged).largest


def off_mm(arm):
    world, pose = arm.twin.world, arm.pose
    return max(
        abs(there - said)
        for there, said in zip(world.tip, (pose.x_mm, pose.y_mm, pose.z_mm), strict=True)
    )


def move_at_random(arm, count, seed=1, deg=5.0):
    """Make random motions; return how far the arm was off after each, in steps."""
    chance = random.Random(seed)
    found = []
    for _ in range(count):
        goal = {f"{name}_deg": mid + chance.uniform(-deg, deg) for name, mid in MIDDLE.items()}
        arm.move_j(speed=chance.choice([0.3, 1.0]), **goal)
        found.append(off_steps(arm))
    return found
