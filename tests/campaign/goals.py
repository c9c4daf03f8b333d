"""Goals near where an arm is, and commands that promise how it gets there."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping

from armdrive.arm import Arm
from armdrive.whereabouts import Coordinates
from kinematics import Motors, Pose
from tests.conformance.going import beside

from .physical import Command
from .stage import Stage

LONGEST_S = 0.8
"""An action's motion is made so short where the arm is slow."""


BESIDE_DEG = (0.2, 0.6)
"""Nearer than this, an arm that stands on whole steps could be beyond its limit."""
COUPLED = (1, 2, 3)
"""Joints that other joints' motors move as well, or the other way round."""
TRIES = 8


def stand_beside_limits(stage: Stage) -> None:
    """Have an arm that is switched on stand where joints are beside their limits, out of guards."""
    draw, arm, body = stage.draw, stage.config.model.arm, stage.world.body
    for _ in range(TRIES):
        joints, opening_mm = body.transmission.to_joints(stage.world.motors)
        for index in draw.sample(COUPLED, draw.randint(1, 2)):
            bounds, inside_rad = arm.limits[index], math.radians(draw.uniform(*BESIDE_DEG))
            angle = draw.choice((bounds.low_rad + inside_rad, bounds.high_rad - inside_rad))
            joints = joints.replace(**{joints.names[index]: angle})
        if not stage.watch.inside_mm(joints):
            stage.bring_to(joints, opening_mm)
            return


def speed_of(draw: random.Random) -> float:
    return draw.choice((0.3, 0.6, 1.0))


def command_of(stage: Stage, what: str, span: tuple[Motors, Motors] | None = None) -> Command:
    arm = arm_of(stage)
    slack_mm = 0.0 if arm.abilities.coordinated else stage.config.motion.straying_mm
    return Command(what, arm.core.position_known, span, slack_mm=slack_mm)


def arm_of(stage: Stage) -> Arm:
    assert stage.arm is not None
    return stage.arm


def joint_goal(stage: Stage, most_deg: float = 15.0) -> tuple[dict[str, float], float]:
    """Return a goal beside the present posture, and how long the way there takes."""
    arm, draw = arm_of(stage), stage.draw
    start = arm.core.coordinates
    chosen = draw.sample(start.joints.names, draw.randint(1, 3))
    turns = {name: math.radians(draw.uniform(-most_deg, most_deg)) for name in chosen}
    here = dict(zip(start.joints.names, start.joints, strict=True))
    if draw.random() < 0.8:  # up to the limit, and not beyond it
        limits = dict(zip(start.joints.names, arm.model.arm.limits, strict=True))
        for name, turn in turns.items():
            low, high = limits[name].low_rad, limits[name].high_rad
            turns[name] = min(max(here[name] + turn, low), high) - here[name]
    whole = Coordinates(
        start.joints.replace(**{name: here[name] + turn for name, turn in turns.items()}),
        start.opening_mm,
    )
    whole_s = arm.speeds.duration_s(start, whole, 1.0)
    share = min(LONGEST_S / whole_s, 1.0) if whole_s > 0.0 else 1.0
    goal = {f"{name}_deg": math.degrees(here[name] + share * turn) for name, turn in turns.items()}
    return goal, whole_s * share


def span_to(stage: Stage, goal_deg: Mapping[str, float]) -> tuple[Motors, Motors]:
    arm = arm_of(stage)
    turned = {name.removesuffix("_deg"): math.radians(deg) for name, deg in goal_deg.items()}
    start = arm.core.coordinates
    transmission = stage.world.body.transmission
    return stage.look(), transmission.to_motors(start.joints.replace(**turned), start.opening_mm)


def pose_beside(stage: Stage) -> Pose:
    draw, arm = stage.draw, arm_of(stage)
    here = arm.model.arm.fk(arm.core.coordinates.joints)
    reach = 12.0 if draw.random() < 0.9 else 2000.0
    return beside(here, *(draw.uniform(-reach, reach) for _ in range(3)))
