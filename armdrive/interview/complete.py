"""A whole arm file with every default in it, from an arm as it is understood.

Read back, it gives the same arm to the last bit, so that a remembered position stays valid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

from armdrive.armfile import ArmConfig
from armdrive.backlashfile import SLIDING, TURNING, Keyed, backlash_keys
from armdrive.guardfile import guard_table
from armdrive.interview.rows_arm import LENGTHS
from armdrive.interview.toml_text import Entry, Section, document
from armdrive.sections import require_table
from kinematics import ArmPreset, MotorSpec, Pose, Transmission

_MOST_DIGITS = 17


def complete(config: ArmConfig, table: Mapping[str, Any]) -> str:
    """Return the text; `table` is the arm file as it was read, for the name of its model."""
    return document(_sections(config, table), f"{config.name}: every key with its value.")


def _sections(config: ArmConfig, table: Mapping[str, Any]) -> Iterator[Section]:
    yield _top(config, table)
    yield _settings("connection", config.connection)
    yield _settings("motion", config.motion)
    yield _settings("gripper", config.gripper)
    yield _settings(config.connection.dialect, config.device)
    model = config.bare
    if model.reference is not None:
        yield _posture("reference", model.reference.pose)
    if config.park is not None:
        yield _posture("park", config.park)
    if config.tool:
        yield _settings("tool", config.tool)
    for name, frame in require_table(table.get("frames", {}), "frames").items():
        yield Section(f"frames.{name}", tuple(Entry(key, value) for key, value in frame.items()))
    yield from _homing(config)
    if isinstance(model, ArmPreset):
        yield Section("lengths", tuple(Entry(key, getattr(model.arm, key)) for key in LENGTHS))
        yield from _preset_motors(model, table)
        turning = [(name, deg) for name, key, deg in _backlash(config) if key == TURNING]
        yield Section(TURNING, tuple(Entry(name, deg) for name, deg in turning))
    elif model.transmission is not None:
        yield from _motors(model.transmission, _backlash(config))
        yield from _fingers(config)
    names = model.arm.joint_names
    limits = [[_deg(each.low_rad), _deg(each.high_rad)] for each in model.arm.limits]
    yield Section("limits_deg", tuple(map(Entry, names, limits)))
    yield Section("speeds_deg_s", tuple(map(Entry, names, map(_deg, model.joint_speeds_rad_s))))
    if any(config.accelerations_rad_s2):
        given = zip(names, config.accelerations_rad_s2, strict=True)
        own = tuple(Entry(name, _deg(slope)) for name, slope in given if slope is not None)
        yield Section("accelerations_deg_s2", own)
    guards = guard_table(model.guards, _deg)
    yield Section("guards", tuple(Entry(key, value) for key, value in guards.items()))


def _top(config: ArmConfig, table: Mapping[str, Any]) -> Section:
    entries = [Entry("model", table["model"]), Entry("title", config.title)]
    transmission = config.model.transmission
    if isinstance(config.bare, ArmPreset) and transmission and transmission.has_gripper:
        entries.append(Entry("steps_per_mm", abs(transmission.motors[-1].steps_per_unit)))
        entries += [Entry(key, mm) for _, key, mm in _backlash(config) if key == SLIDING]
    return Section("", tuple(entries))


def _backlash(config: ArmConfig) -> tuple[Keyed, ...]:
    transmission = config.model.transmission
    return () if transmission is None else (*backlash_keys(config.backlash_steps, transmission),)


def _settings(name: str, values: Any) -> Section:
    known = [(each.name, getattr(values, each.name)) for each in fields(values)]
    return Section(name, tuple(Entry(key, value) for key, value in known if value is not None))


def _posture(name: str, pose: Pose) -> Section:
    entries = [
        Entry("x_mm", pose.x_mm),
        Entry("y_mm", pose.y_mm),
        Entry("z_mm", pose.z_mm),
        Entry("pitch_deg", _deg(pose.pitch_rad)),
        Entry("roll_deg", _deg(pose.roll_rad)),
    ]
    if pose.yaw_rad is not None:
        entries.append(Entry("yaw_deg", _deg(pose.yaw_rad)))
    return Section(name, tuple(entries))


def _homing(config: ArmConfig) -> Iterator[Section]:
    if config.homing is None:
        return
    entries = Entry("opening_mm", config.homing.opening_mm), Entry("groups", config.homing.groups)
    yield Section("homing", entries)
    joints = config.homing.joints
    yield Section("homing.joints_deg", tuple(map(Entry, joints.names, map(_deg, joints))))


def _preset_motors(model: ArmPreset, table: Mapping[str, Any]) -> Iterator[Section]:
    if model.transmission is None:
        return
    turning = model.transmission.motors[: len(model.transmission.joint_names)]
    yield Section("steps_per_turn", tuple(Entry(m.name, _turn(m.steps_per_unit)) for m in turning))
    for section in ("motor_signs", "joint_signs"):
        signs: Mapping[str, int] = table.get(section, {})
        yield Section(section, tuple(map(Entry, signs, signs.values())))


def _motors(transmission: Transmission, backlash: Sequence[Keyed]) -> Iterator[Section]:
    seen = [*transmission.joint_names, "opening"][: len(transmission.motors)]
    for index, motor in enumerate(transmission.motors):
        slides = index >= len(transmission.joint_names)
        key = "steps_per_mm" if slides else "steps_per_turn"
        steps = motor.steps_per_unit if slides else _turn(motor.steps_per_unit)
        entries = [Entry("name", motor.name), Entry(key, steps), Entry("sees", _sees(motor, seen))]
        if motor.follows:
            names = [each.name for each in transmission.motors]
            follows = {names[earlier]: ratio for earlier, ratio in motor.follows}
            entries.append(Entry("follows", follows))
        entries += [Entry(key, size) for name, key, size in backlash if name == motor.name]
        yield Section("motors", tuple(entries), array=True)


def _sees(motor: MotorSpec, seen: Sequence[str]) -> dict[str, float]:
    return {name: share for name, share in zip(seen, motor.sees, strict=True) if share}


def _fingers(config: ArmConfig) -> Iterator[Section]:
    model = config.model
    if model.transmission is None:
        return
    if not model.transmission.has_gripper and config.gripper.kind not in ("servo", "output"):
        return
    entries = [
        Entry("range_mm", model.gripper_range_mm),
        Entry("speed_mm_s", model.gripper_speed_mm_s),
    ]
    if model.grip_steps_per_n is not None:
        entries.append(Entry("steps_per_n", model.grip_steps_per_n))
    yield Section("fingers", tuple(entries))


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
