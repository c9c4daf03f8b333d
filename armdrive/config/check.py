"""Checks the whole arm that a file describes, and remarks on a file without problems."""

from __future__ import annotations

import math
from collections.abc import Iterator

from armdrive.config.arm import ArmConfig, DialectSection
from armdrive.errors import ArmError
from kinematics.errors import KinematicsError
from kinematics.spaces import Pose


def unusable(config: ArmConfig, dialect: DialectSection) -> Iterator[str]:
    """Yield problems of the whole arm whose keys are all valid: motors, postures out of reach."""
    yield from _motors(config, dialect)
    postures = [("park", config.park)]
    if config.model.reference is not None:
        postures.append(("reference", config.model.reference.pose))
    for section, pose in postures:
        if pose is not None:
            yield from _posture(config, section, pose)
    if config.homing is not None:
        for broken in config.model.arm.violations(config.homing.joints):
            yield (
                f"homing.joints_deg.{broken.joint} is {math.degrees(broken.value_rad):g}, beyond "
                f"its limit of {math.degrees(broken.bound_rad):g}: correct it, or limits_deg."
                f"{broken.joint}"
            )


def _motors(config: ArmConfig, dialect: DialectSection) -> Iterator[str]:
    transmission = config.model.transmission
    if transmission is None:
        yield (
            f"no motor steps are known of the {config.model.title}: give steps_per_mm and "
            "[steps_per_turn]"
        )
        return
    try:
        driven = dialect.abilities_with(config).motors
    except (ArmError, KinematicsError) as error:
        yield str(error)
        return
    if len(transmission.motors) != driven:
        yield (
            f"the arm has {len(transmission.motors)} motors, but its controller ({dialect.title}) "
            f"drives {driven}: list every motor of the controller, or correct gripper.kind"
        )


def _posture(config: ArmConfig, section: str, pose: Pose) -> Iterator[str]:
    arm = config.model.arm
    try:
        joints = arm.ik(pose)
    except KinematicsError as error:
        yield f"[{section}] cannot be reached: {error}"
        return
    if section == "park":
        broken = config.model.guards.violation(arm, joints)
        if broken is not None:
            yield f"[{section}]: {broken.sentence}; raise it or correct [guards]"


def remarks_on(config: ArmConfig) -> Iterator[str]:
    """Yield remarks that are no errors, but good to know before the arm is driven."""
    if not config.connection.port:
        yield "no port is named, so the arm can only be simulated: write connection.port"
    if not config.model.verified:
        yield (
            "its numbers are a template: Cartesian motion is refused until every key of [lengths] "
            "and [steps_per_turn] is given as measured (`armdrive config show NAME --toml` prints "
            "the template's, which do not count unchanged), or, of a link table, verified = true "
            "in its model file"
        )
    yield from config.model.unused
    if config.homing is None and config.model.reference is None:
        yield "no homing and no reference posture: to reference it, call `declare_posture()`"
    if config.park is None and config.model.reference is None:
        yield "no park posture: write [park]"
