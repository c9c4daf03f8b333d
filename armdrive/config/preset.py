"""A preset with an arm file's corrections: lengths, limits, speeds, steps, directions, guards."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from armdrive.config.guards import guards_of
from armdrive.config.sections import read_posture
from armdrive.errors import ArmFileError
from armdrive.text.toml import joint_range, number, refuse_unknown, require_table, within
from kinematics.limits import JointRange
from kinematics.presets import ArmPreset, Reference, cable_transmission, preset
from kinematics.spaces import JOINT_NAMES
from kinematics.transmission import Transmission

LENGTHS = ("base_height_mm", "upper_arm_mm", "forearm_mm", "hand_mm")
"""The keys of a preset's lengths."""
LONGEST_MM = 10_000.0
"""No link of an arm is longer."""


def corrected(model: ArmPreset, table: Mapping[str, Any]) -> ArmPreset:
    """Apply an arm file's corrections to its preset."""
    arm = model.arm
    lengths = require_table(table.get("lengths", {}), "lengths")
    refuse_unknown(lengths, list(LENGTHS), "lengths")
    changed: dict[str, Any] = {key: number(v, f"lengths.{key}") for key, v in lengths.items()}
    for key, length_mm in changed.items():  # others would take for ever to be guarded
        within(f"lengths.{key}", length_mm, -LONGEST_MM, LONGEST_MM)
    arm = replace(arm, limits=_limits(arm.limits, table.get("limits_deg", {})), **changed)
    model = replace(
        model,
        arm=arm,
        joint_speeds_rad_s=_speeds(model.joint_speeds_rad_s, table.get("speeds_deg_s", {})),
        guards=guards_of(table.get("guards", {}), arm, model.guards),
        transmission=_transmission(model, table),
    )
    if "reference" in table:
        pose = read_posture(table["reference"], "reference", arm.has_yaw)
        model = replace(model, reference=replace(model.reference or Reference(pose), pose=pose))
    return replace(model, verified=model.verified or _filled_in(model, table))


def _filled_in(model: ArmPreset, table: Mapping[str, Any]) -> bool:
    """Tell whether a file gives every number that a template only stands in for.

    The template's own numbers, all written out, are still nobody's measurement.
    """
    turning = [] if model.transmission is None else model.transmission.motors[:5]
    whole = (
        bool(turning)
        and set(table.get("lengths", {})) == set(LENGTHS)
        and {motor.name for motor in turning} == set(table.get("steps_per_turn", {}))
    )
    known = preset(model.key)
    return whole and (model.arm, model.transmission) != (known.arm, known.transmission)


LENGTHS = ("base_height_mm", "upper_arm_mm", "forearm_mm", "hand_mm")
"""The keys of [lengths], fields of the preset's arm."""


def _joint_table(table: object, where: str) -> Mapping[str, Any]:
    entries = require_table(table, where)
    refuse_unknown(entries, list(JOINT_NAMES), where)
    return entries


def _limits(limits: tuple[JointRange, ...], table: object) -> tuple[JointRange, ...]:
    entries = _joint_table(table, "limits_deg")
    return tuple(
        joint_range(entries[joint], f"limits_deg.{joint}") if joint in entries else known
        for joint, known in zip(JOINT_NAMES, limits, strict=True)
    )


def _speeds(speeds: tuple[float, ...], table: object) -> tuple[float, ...]:
    entries = _joint_table(table, "speeds_deg_s")
    for joint, value in entries.items():
        where = f"speeds_deg_s.{joint}"
        if number(value, where) <= 0.0:
            raise ArmFileError(f"{where} must be above 0")
        within(where, number(value, where), 0.01, 3600.0)
    return tuple(
        math.radians(entries[joint]) if joint in entries else known
        for joint, known in zip(JOINT_NAMES, speeds, strict=True)
    )


def _transmission(model: ArmPreset, table: Mapping[str, Any]) -> Transmission | None:
    """Apply steps per turn (or per mm) and signs to the preset's transmission."""
    transmission = model.transmission
    keys = ("steps_per_turn", "steps_per_mm", "motor_signs", "joint_signs")
    if transmission is None:
        if not any(key in table for key in keys):
            return None
        # nothing is known but the mechanics: every number has to be the file's
        transmission = cable_transmission(1.0, 1.0, 1.0, 1.0, 1.0)
        turning = [motor.name for motor in transmission.motors[:-1]]
        given = require_table(table.get("steps_per_turn", {}), "steps_per_turn")
        if "steps_per_mm" not in table or any(name not in given for name in turning):
            raise ArmFileError(
                f"no motor steps are known of the {model.title}: give steps_per_mm and, under "
                f"[steps_per_turn], {', '.join(turning)}"
            )
    names = [motor.name for motor in transmission.motors]
    turning = names[: len(transmission.joint_names)]
    turns = require_table(table.get("steps_per_turn", {}), "steps_per_turn")
    refuse_unknown(turns, turning, "steps_per_turn")
    per_unit = {
        name: _positive(steps, f"steps_per_turn.{name}") / math.tau for name, steps in turns.items()
    }
    if "steps_per_mm" in table:
        per_unit[names[-1]] = _positive(table["steps_per_mm"], "steps_per_mm")
    motors = tuple(
        replace(motor, steps_per_unit=math.copysign(per_unit[motor.name], motor.steps_per_unit))
        if motor.name in per_unit
        else motor
        for motor in transmission.motors
    )
    axes = [*transmission.joint_names, "gripper"][: len(names)]
    return replace(transmission, motors=motors).with_signs(
        motors=_signs(table, "motor_signs", names), coordinates=_signs(table, "joint_signs", axes)
    )


def _positive(value: object, where: str) -> float:
    steps = number(value, where)
    if steps <= 0.0:
        raise ArmFileError(f"{where} must be above 0: directions belong into motor_signs")
    within(where, steps, 0.1, 10_000_000.0)
    return steps


def _signs(table: Mapping[str, Any], where: str, names: list[str]) -> tuple[int, ...]:
    """Return 1 or -1 for each name: -1 where a direction is the other one than the preset's."""
    entries = require_table(table.get(where, {}), where)
    refuse_unknown(entries, names, where)
    for name, sign in entries.items():
        if sign not in (1, -1) or isinstance(sign, bool):
            raise ArmFileError(f"{where}.{name} must be 1 or -1: 1 keeps the preset's direction")
    return tuple(int(entries.get(name, 1)) for name in names)
