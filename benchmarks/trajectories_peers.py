"""Other people's planners: found, or said to be missing; and random motions for all of them."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Iterator
from random import Random
from types import ModuleType

from kinematics import ArmPreset, Joints, KinematicsError, MotionLimits, Pose, preset
from kinematics.paths.curves import straight_line

ARM = "minimover5"
HARD_RAD_S2 = 2.0


def peer(name: str) -> ModuleType | None:
    """Return a module that is installed, else None."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return importlib.import_module(name)
    except ImportError:
        return None


def missing(*names: str) -> str:
    """Say which of these are not installed."""
    absent = [name for name in names if peer(name) is None]
    return f"; not installed: {', '.join(absent)}" if absent else ""


def model() -> ArmPreset:
    """Return the arm that is moved."""
    return preset(ARM)


def joint_limits(jerk_s: float = 0.0, *, motors: bool = True) -> MotionLimits:
    """Return the limits of its joints, each reaching 2 rad/s^2, and of its motors."""
    arm = model()
    rows = arm.transmission.without_gripper().matrix if motors else ()
    speeds = arm.joint_speeds_rad_s
    return MotionLimits(speeds, (HARD_RAD_S2,) * len(speeds), jerk_s, rows, 400.0)


def postures(random: Random) -> Iterator[Joints]:
    """Yield postures within the limits, without end."""
    bounds = [(one.low_rad, one.high_rad) for one in model().arm.limits]
    while True:
        yield Joints(tuple(random.uniform(low, high) for low, high in bounds))


def ways(random: Random) -> Iterator[tuple[Joints, Pose]]:
    """Yield postures and goals up to 150 mm and half a rad away that a line may lead to."""
    arm = model().arm
    for start in postures(random):
        pose = arm.fk(start)
        goal = Pose(
            pose.x_mm + random.uniform(-150.0, 150.0),
            pose.y_mm + random.uniform(-150.0, 150.0),
            pose.z_mm + random.uniform(-100.0, 100.0),
            pose.pitch_rad + random.uniform(-0.5, 0.5),
            pose.roll_rad,
        )
        try:
            straight_line(arm, start, goal).solve(1.0, start)
        except KinematicsError:
            continue
        yield start, goal
