"""The arm file: everything that is particular to one physical arm, one number in one place.

TOML. `model` names a preset of kinematics; every other key corrects it or describes the wiring.
Or it names a model file, and the other keys say what its link table does not (modelarm.py).
A file without corrections is two lines long. Unknown keys are refused with the nearest known one.
"""

from __future__ import annotations

import hashlib
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

from armdrive.armsections import (
    Connection,
    GripperSettings,
    HomingSettings,
    MotionSettings,
    read_posture,
)
from armdrive.dialects import Dialect, dialect
from armdrive.errors import ArmFileError, BadRequest
from armdrive.presetarm import corrected
from armdrive.sections import (
    number,
    read_section,
    refuse_unknown,
    require_table,
)
from kinematics import (
    PRESETS,
    ArmModel,
    Joints,
    KinematicsError,
    Pose,
    preset,
)

M = TypeVar("M", bound=ArmModel)

MODEL_FILE = ".toml"
"""How a `model` ends that is no preset's key but a model file's path."""


@dataclass(frozen=True, slots=True)
class Source:
    """Where an arm comes from: its file as a table, and the folder that the file lies in."""

    table: Mapping[str, Any]
    folder: Path = Path()


@dataclass(frozen=True, slots=True)
class ArmConfig:
    """One physical arm, ready to be driven: its model with every correction applied.

    `device` holds what the section of the dialect's own name says, as that dialect's settings.
    `source` is no part of the arm: it lets the arm's file be written again.
    """

    name: str
    title: str
    model: ArmModel
    connection: Connection = field(default_factory=Connection)
    motion: MotionSettings = field(default_factory=MotionSettings)
    gripper: GripperSettings = field(default_factory=GripperSettings)
    device: Any = None
    homing: HomingSettings | None = None
    park: Pose | None = None
    source: Source | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.device is None:
            object.__setattr__(self, "device", dialect(self.connection.dialect).settings()())

    @property
    def calibration(self) -> str:
        """A fingerprint of the numbers that give steps their meaning.

        A saved position is worth nothing under another model or transmission.
        """
        meaning = repr((self.model.arm.meaning, self.model.transmission, self.model.reference))
        return hashlib.sha256(meaning.encode()).hexdigest()[:16]


def config_of_preset(key: str, *, name: str, connection: Connection) -> ArmConfig:
    """Return an arm as it leaves the factory, on the given wire."""
    model = preset(key)
    bursts = _bursts(dialect(connection.dialect))
    settings = MotionSettings(**bursts)
    source = Source({"model": key})
    return ArmConfig(name, model.title, model, connection, settings, source=source)


def _port_of(row: Dialect) -> dict[str, Any]:
    """Return how a dialect's port is opened unless an arm file says otherwise."""
    return {"baud": row.baud, "raise_dtr": row.raise_dtr}


def _bursts(row: Dialect) -> dict[str, float]:
    """Return how long a dialect's motions are unless an arm file says otherwise."""
    able = row.abilities
    return {"jog_burst_s": able.jog_burst_s, "planned_burst_s": able.planned_burst_s}


def load_arm_file(path: Path) -> ArmConfig:
    """Read an arm file. Raises `ArmFileError` that names the file, the key and the mend."""
    table = read_arm_table(path)
    try:
        return parse_arm_file(table, name=path.stem, folder=path.parent)
    except (ArmFileError, KinematicsError) as error:
        raise ArmFileError(f"{path}: {error}") from None


def read_arm_table(path: Path) -> dict[str, Any]:
    """Return an arm file as its table. Raises `ArmFileError` for what cannot be read as TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ArmFileError(f"the arm file {path} cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ArmFileError(f"the arm file {path} is not valid TOML: {error}") from None


def parse_arm_file(table: Mapping[str, Any], *, name: str, folder: Path = Path()) -> ArmConfig:
    """Turn a parsed TOML document into an arm; a model file is looked for from `folder`."""
    word = table.get("model")
    if not isinstance(word, str):
        raise ArmFileError('the key model is missing, for example model = "teachmover"')
    wiring = require_table(table.get("connection", {}), "connection")
    row = _dialect_of(wiring)
    given = word not in PRESETS and word.lower().endswith(MODEL_FILE)
    keys = _MODEL_KEYS if given else _TOP_KEYS
    refuse_unknown(table, [*keys, row.name], "")
    title = table.get("title", "")
    if not isinstance(title, str):
        raise ArmFileError(f"title must be text, not {title!r}")
    gripper = read_section(GripperSettings, table.get("gripper", {}), "gripper")
    model = _described(table, folder) if given else corrected(preset(word), table)
    model = _with_gripper(model, gripper)
    motion = _bursts(row) | dict(require_table(table.get("motion", {}), "motion"))
    park = table.get("park")
    return ArmConfig(
        name=name,
        title=title or model.title,
        model=model,
        connection=read_section(Connection, _port_of(row) | dict(wiring), "connection"),
        motion=read_section(MotionSettings, motion, "motion"),
        gripper=gripper,
        device=read_section(row.settings(), table.get(row.name, {}), row.name),
        homing=_homing(table["homing"], model) if "homing" in table else None,
        park=read_posture(park, "park", model.arm.has_yaw) if park is not None else None,
        source=Source(table, folder),
    )


def _dialect_of(wiring: Mapping[str, Any]) -> Dialect:
    word = wiring.get("dialect", Connection().dialect)
    if not isinstance(word, str):
        raise ArmFileError(f"connection.dialect must be text, not {word!r}")
    try:
        return dialect(word)
    except BadRequest as error:
        raise ArmFileError(f"connection.dialect: {error}") from None


def _with_gripper(model: M, gripper: GripperSettings) -> M:
    """Return the model without a gripper's motor where something else moves the fingers."""
    if gripper.kind == "stepper" or model.transmission is None:
        return model
    return replace(model, transmission=model.transmission.without_gripper())


def _homing(table: object, model: ArmModel) -> HomingSettings:
    entries = require_table(table, "homing")
    refuse_unknown(entries, ["joints_deg", "opening_mm", "groups"], "homing")
    angles = require_table(entries.get("joints_deg", {}), "homing.joints_deg")
    names = list(model.arm.joint_names)
    refuse_unknown(angles, names, "homing.joints_deg")
    missing = [name for name in names if name not in angles]
    if missing:
        raise ArmFileError(
            f"homing.joints_deg is missing {', '.join(missing)}: where every joint stands once the "
            "device has homed"
        )
    turned = tuple(math.radians(number(angles[n], f"homing.joints_deg.{n}")) for n in names)
    opening_mm = number(entries.get("opening_mm", 0.0), "homing.opening_mm")
    return HomingSettings(Joints(turned, tuple(names)), opening_mm, _groups(entries, model))


def _groups(entries: Mapping[str, Any], model: ArmModel) -> tuple[tuple[int, ...], ...]:
    count = len(model.transmission.motors) if model.transmission is not None else 0
    groups = entries.get("groups", [])
    good = isinstance(groups, list) and all(
        isinstance(group, list)
        and group
        and all(type(motor) is int and 1 <= motor <= count for motor in group)
        for group in groups
    )
    if not good:
        raise ArmFileError(
            f"homing.groups lists motors by number, 1 to {count}, in the order in which they home, "
            "for example [[3], [2], [1, 4, 5]]"
        )
    return tuple(tuple(group) for group in groups)


def _described(table: Mapping[str, Any], folder: Path) -> ArmModel:
    from armdrive.modelarm import model_of  # few arms need a link table and its solver

    return model_of(table, folder, read_posture)


_COMMON_KEYS = ("model", "title", "connection", "motion", "gripper", "homing", "park")
_MODEL_KEYS = (
    *_COMMON_KEYS, "motors", "fingers", "speeds_deg_s", "limits_deg", "reference", "guards",
)  # fmt: skip
_TOP_KEYS = (
    *_COMMON_KEYS, "reference",
    "lengths", "limits_deg", "speeds_deg_s", "steps_per_turn", "steps_per_mm", "motor_signs",
    "joint_signs", "guards",
)  # fmt: skip
