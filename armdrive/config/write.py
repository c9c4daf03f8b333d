"""A whole arm file with every default in it, from an arm as it is understood.

Read back, it gives the same arm to the last bit, so that a remembered position stays valid.
"""

from __future__ import annotations

import copy
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.config.backlash import SLIDING, TURNING, Keyed, backlash_keys
from armdrive.config.guards import guard_table
from armdrive.config.preset import LENGTHS
from armdrive.errors import ArmFileError
from armdrive.text.toml import key, require_format, require_table, value
from armdrive.text.toml_document import COMMENT_AT, FORMAT_ENTRY, TomlEntry, TomlSection, document
from kinematics.presets import ArmPreset
from kinematics.spaces import Pose
from kinematics.transmission import MotorSpec, Transmission

_MOST_DIGITS = 17


def complete(config: ArmConfig, table: Mapping[str, Any]) -> str:
    """Return the text; `table` is the arm file as it was read, for the name of its model."""
    return document(_sections(config, table), f"{config.name}: every key with its value.")


def _sections(config: ArmConfig, table: Mapping[str, Any]) -> Iterator[TomlSection]:
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
        yield TomlSection(
            f"frames.{name}", tuple(TomlEntry(key, value) for key, value in frame.items())
        )
    yield from _homing(config)
    if isinstance(model, ArmPreset):
        yield TomlSection(
            "lengths", tuple(TomlEntry(key, getattr(model.arm, key)) for key in LENGTHS)
        )
        yield from _preset_motors(model, table)
        turning = [(name, deg) for name, key, deg in _backlash(config) if key == TURNING]
        yield TomlSection(TURNING, tuple(TomlEntry(name, deg) for name, deg in turning))
    elif model.transmission is not None:
        yield from _motors(model.transmission, _backlash(config))
        yield from _fingers(config)
    names = model.arm.joint_names
    limits = [[_deg(each.low_rad), _deg(each.high_rad)] for each in model.arm.limits]
    yield TomlSection("limits_deg", tuple(map(TomlEntry, names, limits)))
    yield TomlSection(
        "speeds_deg_s", tuple(map(TomlEntry, names, map(_deg, model.joint_speeds_rad_s)))
    )
    if any(config.accelerations_rad_s2):
        given = zip(names, config.accelerations_rad_s2, strict=True)
        own = tuple(TomlEntry(name, _deg(slope)) for name, slope in given if slope is not None)
        yield TomlSection("accelerations_deg_s2", own)
    guards = guard_table(model.guards, _deg)
    yield TomlSection("guards", tuple(TomlEntry(key, value) for key, value in guards.items()))


def _top(config: ArmConfig, table: Mapping[str, Any]) -> TomlSection:
    entries = [FORMAT_ENTRY, TomlEntry("model", table["model"]), TomlEntry("title", config.title)]
    transmission = config.model.transmission
    if isinstance(config.bare, ArmPreset) and transmission and transmission.has_gripper:
        entries.append(TomlEntry("steps_per_mm", abs(transmission.motors[-1].steps_per_unit)))
        entries += [TomlEntry(key, mm) for _, key, mm in _backlash(config) if key == SLIDING]
    return TomlSection("", tuple(entries))


def _backlash(config: ArmConfig) -> tuple[Keyed, ...]:
    transmission = config.model.transmission
    return () if transmission is None else (*backlash_keys(config.backlash_steps, transmission),)


def _settings(name: str, values: Any) -> TomlSection:
    known = [(each.name, getattr(values, each.name)) for each in fields(values)]
    return TomlSection(
        name, tuple(TomlEntry(key, value) for key, value in known if value is not None)
    )


def _posture(name: str, pose: Pose) -> TomlSection:
    entries = [
        TomlEntry("x_mm", pose.x_mm),
        TomlEntry("y_mm", pose.y_mm),
        TomlEntry("z_mm", pose.z_mm),
        TomlEntry("pitch_deg", _deg(pose.pitch_rad)),
        TomlEntry("roll_deg", _deg(pose.roll_rad)),
    ]
    if pose.yaw_rad is not None:
        entries.append(TomlEntry("yaw_deg", _deg(pose.yaw_rad)))
    return TomlSection(name, tuple(entries))


def _homing(config: ArmConfig) -> Iterator[TomlSection]:
    if config.homing is None:
        return
    entries = (
        TomlEntry("opening_mm", config.homing.opening_mm),
        TomlEntry("groups", config.homing.groups),
    )
    yield TomlSection("homing", entries)
    joints = config.homing.joints
    yield TomlSection("homing.joints_deg", tuple(map(TomlEntry, joints.names, map(_deg, joints))))


def _preset_motors(model: ArmPreset, table: Mapping[str, Any]) -> Iterator[TomlSection]:
    if model.transmission is None:
        return
    turning = model.transmission.motors[: len(model.transmission.joint_names)]
    yield TomlSection(
        "steps_per_turn", tuple(TomlEntry(m.name, _turn(m.steps_per_unit)) for m in turning)
    )
    for section in ("motor_signs", "joint_signs"):
        signs: Mapping[str, int] = table.get(section, {})
        yield TomlSection(section, tuple(map(TomlEntry, signs, signs.values())))


def _motors(transmission: Transmission, backlash: Sequence[Keyed]) -> Iterator[TomlSection]:
    seen = [*transmission.joint_names, "opening"][: len(transmission.motors)]
    for index, motor in enumerate(transmission.motors):
        slides = index >= len(transmission.joint_names)
        key = "steps_per_mm" if slides else "steps_per_turn"
        steps = motor.steps_per_unit if slides else _turn(motor.steps_per_unit)
        entries = [
            TomlEntry("name", motor.name),
            TomlEntry(key, steps),
            TomlEntry("sees", _sees(motor, seen)),
        ]
        if motor.follows:
            names = [each.name for each in transmission.motors]
            follows = {names[earlier]: ratio for earlier, ratio in motor.follows}
            entries.append(TomlEntry("follows", follows))
        entries += [TomlEntry(key, size) for name, key, size in backlash if name == motor.name]
        yield TomlSection("motors", tuple(entries), array=True)


def _sees(motor: MotorSpec, seen: Sequence[str]) -> dict[str, float]:
    return {name: share for name, share in zip(seen, motor.sees, strict=True) if share}


def _fingers(config: ArmConfig) -> Iterator[TomlSection]:
    model = config.model
    if model.transmission is None:
        return
    if not model.transmission.has_gripper and config.gripper.kind not in ("servo", "output"):
        return
    entries = [
        TomlEntry("range_mm", model.gripper_range_mm),
        TomlEntry("speed_mm_s", model.gripper_speed_mm_s),
    ]
    if model.grip_steps_per_n is not None:
        entries.append(TomlEntry("steps_per_n", model.grip_steps_per_n))
    yield TomlSection("fingers", tuple(entries))


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


# Changing single keys in the text of an arm file, and leaving every other line as it stands.
#
# The text is edited line by line, read back, and compared with the table that was wanted: a file
# that is laid out in a way that this cannot edit is refused rather than spoilt.

MOTORS = "motors"
_HEADER = re.compile(r"\s*\[")


@dataclass(frozen=True, slots=True)
class Change:
    """One key of an arm file, its new value, and why: `motors` are reached by their index."""

    path: tuple[str | int, ...]
    value: Any
    why: str

    @property
    def name(self) -> str:
        """The key as people write it."""
        return ".".join(map(str, self.path))


def amended(text: str, changes: Iterable[Change], order: Mapping[str, str] | None = None) -> str:
    """Return the text with these keys changed, and its motors in another order.

    `order` names, by the motor that was meant, the one that is really there. Raises
    `ArmFileError` where the file's format or layout is not understood; nothing is changed then.
    """
    before = tomllib.loads(text)
    require_format(before)
    changes = tuple(changes)
    lines = text.splitlines()
    for change in changes:
        lines = _changed(lines, change)
    if order:
        lines = _reordered(lines, order)
    after = "\n".join(lines).rstrip("\n") + "\n"
    if _read(after) != wanted(before, changes, order):
        by_hand = "; ".join(f"{each.name} = {value(each.value)}" for each in changes)
        raise ArmFileError(
            "the arm file is laid out in a way that cannot be edited here: write by hand, in an "
            f"editor, {by_hand or 'its [[motors]] in their real order'}"
        )
    return after


def wanted(
    table: Mapping[str, Any], changes: Iterable[Change], order: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Return the table as it should be read afterwards."""
    after: dict[str, Any] = copy.deepcopy(dict(table))
    for change in changes:
        inner: Any = after
        for step in change.path[:-1]:
            inner = inner[step] if isinstance(step, int) else inner.setdefault(step, {})
        inner[change.path[-1]] = change.value
    if order:
        named = {each["name"]: each for each in after[MOTORS]}
        after[MOTORS] = [named[order.get(each["name"], each["name"])] for each in after[MOTORS]]
    return after


def _read(text: str) -> dict[str, Any] | None:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return None


def _changed(lines: Sequence[str], change: Change) -> list[str]:
    """Return the lines with one key replaced, or added to its section."""
    start, end = _region(lines, change.path)
    name = str(change.path[-1])
    line = f"{key(name)} = {value(change.value)}".ljust(COMMENT_AT - 1) + f" # {change.why}"
    if start is None:
        return [*lines, "", f"[{change.path[0]}]", line]
    own = re.compile(rf'\s*"?{re.escape(name)}"?\s*=')
    for at in range(start, end):
        if own.match(lines[at]):
            return [*lines[:at], line, *lines[at + 1 :]]
    last = max((at for at in range(start, end) if _says(lines[at])), default=start - 1)
    return [*lines[: last + 1], line, *lines[last + 1 :]]


def _says(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _region(lines: Sequence[str], path: tuple[str | int, ...]) -> tuple[int | None, int]:
    """Return where a key's section begins (behind its header) and ends; None where it is not."""
    headers = [at for at, line in enumerate(lines) if _HEADER.match(line)]
    ends = dict(pairwise([*headers, len(lines)]))
    if len(path) == 1:
        return 0, headers[0] if headers else len(lines)
    name = str(path[0])
    own = [at for at in headers if _title(lines[at]) == name]
    nth = path[1] if isinstance(path[1], int) else 0
    if nth >= len(own):
        return None, len(lines)
    return own[nth] + 1, ends[own[nth]]


def _title(header: str) -> str:
    return header.partition("#")[0].strip().strip("[]").strip()


def _reordered(lines: Sequence[str], order: Mapping[str, str]) -> list[str]:
    """Return the lines with the tables of the motors in their real order."""
    headers = [at for at, line in enumerate(lines) if _HEADER.match(line)]
    ends = dict(pairwise([*headers, len(lines)]))
    own = [at for at in headers if _title(lines[at]) == MOTORS]
    blocks = [list(lines[at : ends[at]]) for at in own]
    named = {_name_of(block): block for block in blocks}
    if set(order) - set(named) or not own:
        return list(lines)  # found out when the text is read back
    placed = [named[order.get(_name_of(block), _name_of(block))] for block in blocks]
    out = list(lines)
    for at, block in reversed(list(zip(own, placed, strict=True))):
        out[at : ends[at]] = block
    return out


def _name_of(block: Sequence[str]) -> str:
    return str((_read("\n".join(block)) or {}).get(MOTORS, [{}])[0].get("name", ""))
