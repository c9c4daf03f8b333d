"""`LostTargets` excuses shared joints alone, by a bounded angle, while the bus loses targets."""

import math
import random

import pytest

from kinematics import Motors

from .faults import FAULTS
from .physical import Command
from .speeds import WINDOW_S
from .stage import Stage

LOSES = next(fault for fault in FAULTS if fault.name == "frames lost")


def losing(words: str) -> Stage:
    """Return a stage of CiA 402 drives on which the fault with these words has begun."""
    for seed in range(100):
        stage = Stage("cia402", random.Random(seed), 0)
        if words in LOSES.begin(stage):
            return stage
    raise AssertionError(words)


def breaks(stage: Stage, joint: str, beyond_deg: float, speed: float = 1.0) -> bool:
    """Move a joint beyond its limit during a command; return whether the watch finds that."""
    arm = stage.config.model.arm
    past_rad = arm.limits[arm.joint_names.index(joint)].low_rad - math.radians(beyond_deg)
    there = stage.world.body.transmission.to_motors(
        stage.world.joints.replace(**{joint: past_rad}), 0.0
    )
    stage.watch.begin(Command("move_j", position_known=True, speed=speed))
    stage.world._shift(there - stage.world.motors, stage.now_s)
    return any("beyond its limit" in each for each in stage.watch.broken)


@pytest.mark.parametrize(
    ("joint", "beyond_deg", "speed", "broken"),
    [
        ("wrist_pitch", 0.79, 1.0, False),
        ("wrist_roll", 0.79, 1.0, False),
        ("wrist_pitch", 3.0, 0.5, True),
        ("wrist_pitch", 2.0, 0.2, True),
        ("base", 0.79, 1.0, True),
    ],
)
def test_a_shared_joint_may_leave_its_path_by_the_targets_that_one_motor_may_miss(
    joint, beyond_deg, speed, broken
):
    assert breaks(losing("0.1 --from host"), joint, beyond_deg, speed) is broken


@pytest.mark.parametrize("words", ["next --from host", "0.1 --from device"])
def test_only_targets_that_may_be_lost_in_a_row_excuse_it(words):
    assert breaks(losing(words), "wrist_pitch", 0.79)


def test_the_excuse_ends_with_the_fault():
    stage = losing("0.1 --from host")
    stage.sleep(2.1)
    assert breaks(stage, "wrist_pitch", 0.79)


@pytest.mark.parametrize(
    ("after_s", "share", "brakes", "broken"),
    [
        (0.0, 1.4, False, False),
        (2.6, 1.4, False, True),
        (0.0, 1.5, False, True),
        (0.0, 5.0, True, False),
        (2.6, 5.0, True, True),
        (0.0, 5.5, True, True),
    ],
)
def test_a_drive_that_catches_up_and_one_that_brakes_then_may_be_that_much_faster(
    after_s, share, brakes, broken
):
    stage = losing("0.1 --from host --for 2.0")
    stage.sleep(after_s)
    stage.watch.lost_targets.brakes = lambda: brakes
    limit = stage.config.model.joint_speeds_rad_s[0]
    per_rad = stage.world.body.transmission.matrix[0][0]
    turn = round(share * limit * WINDOW_S * per_rad)
    stage.watch.begin(Command("move_j", position_known=True))
    for number in range(3):
        stage.world.drive(Motors((turn, 0, 0, 0, 0, 0)), stage.now_s + number * WINDOW_S)
    assert any("its limit is" in each for each in stage.watch.broken) is broken
