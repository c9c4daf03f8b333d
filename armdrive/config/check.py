"""Everything that is wrong with an arm file at once, and what is worth knowing of a right one.

Reading a file stops at its first error. To find the next, the key at fault is found by taking
keys away one by one until the complaint changes, and reading goes on without it.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from armdrive.config.arm import ArmConfig, DialectSection, DialectSections, parse
from armdrive.errors import ArmError, ArmFileError
from armdrive.text.toml import FORMAT_KEY
from kinematics.errors import KinematicsError
from kinematics.spaces import Pose

MOST_PROBLEMS = 50
MOST_READ = 3000
"""To find a key at fault, the file is read once more without each of its keys: no more than so
often in all, which takes a few seconds. Ten faulty keys of a file with 300 keys are found."""

_BASIC = ((FORMAT_KEY,), ("model",), ("connection", "dialect"))
"""Where one of these is wrong, nothing else can be judged."""

Path_: TypeAlias = tuple[str | int, ...]
Read: TypeAlias = Callable[[dict[str, Any]], ArmConfig]
"""Turns a table into an arm, or raises what is wrong with it."""


def problems_of(
    table: dict[str, Any], sections: DialectSections, name: str, folder: Path
) -> list[str]:
    """Return one sentence for each thing that is wrong, in the order in which they are found."""
    read_table = partial(parse, sections=sections, name=name, folder=folder)
    left = copy.deepcopy(table)
    found: list[str] = []
    read = 0
    while len(found) < MOST_PROBLEMS:
        complaint = _complaint(left, read_table)
        if complaint is None:
            break
        found.append(complaint)
        read += sum(1 for _ in _paths(left))
        if read > MOST_READ:
            break
        smaller = _without_fault(left, complaint, read_table)
        if smaller is None:
            return found
        left = smaller
    if not found:
        config = read_table(table)
        found += _unusable(config, sections.find(config.connection.dialect))
    return found


def _complaint(table: dict[str, Any], read: Read) -> str | None:
    try:
        read(table)
    except (ArmFileError, KinematicsError) as error:
        return str(error)
    return None


def _without_fault(table: dict[str, Any], complaint: str, read: Read) -> dict[str, Any] | None:
    """Return the table without the key at fault, None where no single key is."""
    for path in sorted(_paths(table), key=len, reverse=True):
        smaller = _without(table, path)
        now = _complaint(smaller, read)
        if now != complaint and not (now and _blames_absence(now, path)):
            return None if path in _BASIC else smaller
    return None


def _blames_absence(complaint: str, path: Path_) -> bool:
    """Tell whether a complaint is about the very key that was taken away."""
    return "missing" in complaint or "needed" in complaint or f"needs {path[-1]}" in complaint


def _paths(table: Any, before: Path_ = ()) -> Iterator[Path_]:
    pairs = table.items() if isinstance(table, dict) else enumerate(table)
    for key, value in pairs:
        yield (*before, key)
        if isinstance(value, dict) or (
            isinstance(value, list) and any(isinstance(one, dict) for one in value)
        ):
            yield from _paths(value, (*before, key))


def _without(table: dict[str, Any], path: Path_) -> dict[str, Any]:
    copied = copy.deepcopy(table)
    inner: Any = copied
    for key in path[:-1]:
        inner = inner[key]
    del inner[path[-1]]
    return copied


def _unusable(config: ArmConfig, dialect: DialectSection) -> Iterator[str]:
    """Give what every key allows and the arm does not: motors, postures out of reach."""
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
    """Give what is no error but worth knowing before the arm is driven."""
    if not config.connection.port:
        yield "no port is named, so that the arm is only simulated: write connection.port"
    if not config.model.verified:
        yield (
            "its numbers are a template: Cartesian motion is refused until every key of [lengths] "
            "and [steps_per_turn] is given as measured (`armdrive config show NAME --toml` prints "
            "the template's, which do not count unchanged), or, of a link table, verified = true "
            "in its model file"
        )
    if config.homing is None and config.model.reference is None:
        yield "no homing and no reference posture: to reference it, call `declare_posture()`"
    if config.park is None and config.model.reference is None:
        yield "no park posture: write [park]"
