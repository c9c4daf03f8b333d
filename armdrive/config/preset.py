"""A preset with an arm file's corrections: lengths, limits, speeds, steps, directions, guards."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from armdrive.config.sections import guards_of, read_posture
from armdrive.errors import ArmFileError
from armdrive.text.toml import TomlTable, between, joint_range
from kinematics.presets import ArmPreset, Reference, cable_transmission, preset
from kinematics.spaces import JOINT_NAMES
from kinematics.transmission import Transmission

# The keys of [lengths], fields of the preset's arm.
LENGTHS = ("base_height_mm", "upper_arm_mm", "forearm_mm", "hand_mm")
# No link of an arm is longer; guarding a longer one would take too long.
LONGEST_MM = 10_000.0
# Degrees a second of a joint.
SPEED = between(0.01, 3600.0)
# Steps of a motor for a turn, or a mm.
MOST_STEPS = 10_000_000.0
STEPS = between(0.1, MOST_STEPS, "directions belong into motor_signs")


def corrected(model: ArmPreset, table: TomlTable) -> ArmPreset:
    """Apply an arm file's corrections to its preset."""
    lengths: dict[str, Any] = table.by_name("lengths", LENGTHS, between(-LONGEST_MM, LONGEST_MM))
    limits = table.by_name("limits_deg", JOINT_NAMES, joint_range)
    speeds = table.by_name("speeds_deg_s", JOINT_NAMES, SPEED)
    known = zip(JOINT_NAMES, model.arm.limits, strict=True)
    limited = tuple(limits.get(name, bounds) for name, bounds in known)
    arm = table.problems.attempt(lambda: replace(model.arm, limits=limited, **lengths), model.arm)
    known_speeds = zip(JOINT_NAMES, model.joint_speeds_rad_s, strict=True)
    fixed = replace(
        model,
        arm=arm,
        joint_speeds_rad_s=tuple(
            math.radians(speeds[name]) if name in speeds else speed_rad_s
            for name, speed_rad_s in known_speeds
        ),
        guards=guards_of(table.table("guards"), arm, model.guards),
        transmission=_transmission(model, table),
    )
    pose = read_posture(table, "reference", arm.has_yaw)
    if pose is not None:
        fixed = replace(fixed, reference=replace(model.reference or Reference(pose), pose=pose))
    return replace(fixed, verified=model.verified or _filled_in(fixed, table.entries))


def _filled_in(model: ArmPreset, table: Mapping[str, Any]) -> bool:
    """Return whether a file replaces every number of an unverified preset by a measured one.

    The preset's own numbers do not count as measured, even if all are written out.
    """
    turning = [] if model.transmission is None else model.transmission.motors[:5]
    whole = (
        bool(turning)
        and set(table.get("lengths", {})) == set(LENGTHS)
        and {motor.name for motor in turning} == set(table.get("steps_per_turn", {}))
    )
    # numbers copied from the template are not measured, however many are written out
    known = preset(model.key)
    return whole and (model.arm, model.transmission) != (known.arm, known.transmission)


# The keys about a preset's motors.
MOTOR_KEYS = ("steps_per_turn", "steps_per_mm", "motor_signs", "joint_signs")


def _transmission(model: ArmPreset, table: TomlTable) -> Transmission | None:
    """Apply steps per turn (or per mm) and signs to the preset's transmission."""
    if model.transmission is None and not any(key in table.entries for key in MOTOR_KEYS):
        return None
    # without a known transmission, every number has to come from the file
    known = model.transmission or cable_transmission(1.0, 1.0, 1.0, 1.0, 1.0)
    names = [motor.name for motor in known.motors]
    turns = table.by_name("steps_per_turn", names[: len(known.joint_names)], STEPS)
    per_unit = {name: steps / math.tau for name, steps in turns.items()}
    per_mm = table.value("steps_per_mm", STEPS, None)
    if per_mm is not None:
        per_unit[names[-1]] = per_mm
    axes = [*known.joint_names, "gripper"][: len(names)]
    motor_signs = table.by_name("motor_signs", names, _sign)
    joint_signs = table.by_name("joint_signs", axes, _sign)
    if model.transmission is None and len(per_unit) < len(names):
        table.problems.note(
            f"the motor steps of the {model.title} are not known: give steps_per_mm and, under "
            f"[steps_per_turn], {', '.join(names[:-1])}"
        )
        return None
    motors = tuple(
        replace(
            motor,
            steps_per_unit=math.copysign(
                per_unit.get(motor.name, motor.steps_per_unit), motor.steps_per_unit
            ),
        )
        for motor in known.motors
    )
    return replace(known, motors=motors).with_signs(
        motors=tuple(motor_signs.get(name, 1) for name in names),
        coordinates=tuple(joint_signs.get(name, 1) for name in axes),
    )


def _sign(value: object, where: str) -> int:
    if value not in (1, -1) or isinstance(value, bool):
        raise ArmFileError(f"{where} must be 1 or -1: 1 keeps the preset's direction")
    return 1 if value == 1 else -1
