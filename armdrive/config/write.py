"""Writes a whole arm file with every default.

Read back, it gives the same arm to the last bit, so a recorded position stays valid. The comments
are the meanings of the keys in the schema.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.config.preset import LENGTHS
from armdrive.config.sections import (
    OPENING,
    PARK_HEIGHT_MM,
    SLIDING,
    TURNING,
    FingerModel,
    GuardSettings,
    HomingKeys,
    backlash_keys,
    guard_table,
)
from armdrive.text.toml import (
    FORMAT_ENTRY,
    TomlEntry,
    TomlSection,
    document,
    require_table,
    rule_of,
)
from kinematics.presets import ArmPreset
from kinematics.spaces import Pose
from kinematics.transmission import Transmission

_MOST_DIGITS = 17

# The meanings of sections, and of keys that are written one by one.
MEANINGS: Mapping[str, str] = {
    "steps_per_mm": "gripper motor, steps per mm of opening",
    SLIDING: "its lost motion at reversals",
    "reference": "the posture that a reference is taken in",
    "park": f"where it parks, by default {PARK_HEIGHT_MM:g} mm above the reference",
    "tool": "a tool in the fingers: its point, seen from the finger tips",
    "homing.joints_deg": "where every joint stands after homing",
    "speeds_deg_s": "at full load",
    "accelerations_deg_s2": "of planned motion, instead of full speed after motion.ramp_s",
    "steps_per_turn": "motor steps per turn of the joint; directions are signs, below",
    TURNING: "lost motion at reversals, of what the motor turns",
    "motor_signs": "-1 where a motor counts the other way",
    "joint_signs": "-1 where a joint's positive direction is the other one",
    "sees": "joint = share; a negative one where it counts the other way",
    "follows": "whole steps added for each step of an earlier motor",
} | {each.name: rule_of(each).help for kind in (GuardSettings, HomingKeys) for each in fields(kind)}


def complete(config: ArmConfig, table: Mapping[str, Any]) -> str:
    """Return the text; `table` is the arm file as it was read, for the name of its model."""
    return document(_sections(config, table), f"{config.name}: every key with its value.")


def _section(name: str, values: Iterable[tuple[str, Any]], *, array: bool = False) -> TomlSection:
    entries = tuple(
        TomlEntry(key, value, MEANINGS.get(key, "")) for key, value in values if value is not None
    )
    return TomlSection(name, entries, MEANINGS.get(name, ""), array=array)


def _sections(config: ArmConfig, table: Mapping[str, Any]) -> Iterator[TomlSection]:
    """Yield every section in its order. Those without entries are not written."""
    model = config.bare
    transmission, names = model.transmission, model.arm.joint_names
    backlash = tuple(backlash_keys(config.backlash_steps, transmission))
    top = [("model", table["model"]), ("title", config.title)]
    if isinstance(model, ArmPreset) and transmission is not None and transmission.has_gripper:
        top.append(("steps_per_mm", abs(transmission.motors[-1].steps_per_unit)))
        top += [(key, mm) for _, key, mm in backlash if key == SLIDING]
    yield TomlSection("", (FORMAT_ENTRY, *_section("", top).entries))
    yield _as_read("urdf", table)
    yield _settings("connection", config.connection)
    yield _settings("motion", config.motion)
    yield _settings("gripper", config.gripper)
    yield _settings(config.connection.dialect, config.device)
    yield _posture("reference", None if model.reference is None else model.reference.pose)
    yield _posture("park", config.park)
    if config.tool:
        yield _settings("tool", config.tool)
    for name, frame in require_table(table.get("frames", {}), "frames").items():
        yield _section(f"frames.{name}", frame.items())
    if (homing := config.homing) is not None:
        yield _settings("homing", HomingKeys(homing.opening_mm, homing.groups))
        yield _section("homing.joints_deg", zip(names, map(_deg, homing.joints), strict=True))
    if isinstance(model, ArmPreset):
        yield _section("lengths", ((key, getattr(model.arm, key)) for key in LENGTHS))
        turning = () if transmission is None else transmission.motors[: len(names)]
        yield _section("steps_per_turn", ((m.name, _turn(m.steps_per_unit)) for m in turning))
        yield _as_read("motor_signs", table)
        yield _as_read("joint_signs", table)
        yield _section(TURNING, ((name, deg) for name, key, deg in backlash if key == TURNING))
    elif transmission is not None:
        yield from _motors(transmission, backlash)
        if transmission.has_gripper or config.gripper.commanded:
            range_mm, speed_mm_s = model.gripper_range_mm, model.gripper_speed_mm_s
            yield _settings("fingers", FingerModel(range_mm, speed_mm_s, model.grip_steps_per_n))
    limits = [[_deg(each.low_rad), _deg(each.high_rad)] for each in model.arm.limits]
    yield _section("limits_deg", zip(names, limits, strict=True))
    speeds = map(_deg, model.joint_speeds_rad_s)
    yield _section("speeds_deg_s", zip(names, speeds, strict=True))
    own = zip(names, config.accelerations_rad_s2, strict=False)  # none for a file without any
    given = ((name, _deg(slope)) for name, slope in own if slope is not None)
    yield _section("accelerations_deg_s2", given)
    yield _section("guards", guard_table(model.guards, _deg).items())


def _settings(name: str, values: Any) -> TomlSection:
    entries = (
        TomlEntry(each.name, getattr(values, each.name), rule_of(each).help)
        for each in fields(values)
        if getattr(values, each.name) is not None
    )
    return TomlSection(name, tuple(entries), MEANINGS.get(name, ""))


def _as_read(name: str, table: Mapping[str, Any]) -> TomlSection:
    return _section(name, require_table(table.get(name, {}), name).items())


def _posture(name: str, pose: Pose | None) -> TomlSection:
    if pose is None:
        return TomlSection(name, ())
    lengths = [("x_mm", pose.x_mm), ("y_mm", pose.y_mm), ("z_mm", pose.z_mm)]
    angles = [("pitch_deg", _deg(pose.pitch_rad)), ("roll_deg", _deg(pose.roll_rad))]
    yaw = [] if pose.yaw_rad is None else [("yaw_deg", _deg(pose.yaw_rad))]
    return _section(name, [*lengths, *angles, *yaw])


def _motors(
    transmission: Transmission, backlash: Sequence[tuple[str, str, float]]
) -> Iterator[TomlSection]:
    seen = [*transmission.joint_names, OPENING][: len(transmission.motors)]
    motors = [motor.name for motor in transmission.motors]
    for index, motor in enumerate(transmission.motors):
        slides = index >= len(transmission.joint_names)
        turn = _turn(motor.steps_per_unit)
        steps = ("steps_per_mm", motor.steps_per_unit) if slides else ("steps_per_turn", turn)
        sees = {name: share for name, share in zip(seen, motor.sees, strict=True) if share}
        follows = {motors[earlier]: ratio for earlier, ratio in motor.follows}
        lost = [(key, size) for name, key, size in backlash if name == motor.name]
        values = [("name", motor.name), steps, ("sees", sees), ("follows", follows or None), *lost]
        yield _section("motors", values, array=True)


def _deg(angle_rad: float) -> float:
    return shortest(math.degrees(angle_rad), math.radians, angle_rad)


def _turn(per_rad: float) -> float:
    return shortest(abs(per_rad) * math.tau, lambda steps: steps / math.tau, abs(per_rad))


def shortest(value: float, back: Callable[[float], float], wanted: float) -> float:
    """Return the number with the fewest digits near `value` that `back` turns into `wanted`."""
    near = (value, math.nextafter(value, math.inf), math.nextafter(value, -math.inf))
    for digits in range(1, _MOST_DIGITS + 1):
        for one in near:
            short = float(f"{one:.{digits}g}")
            if back(short) == wanted:
                return short
    return value
