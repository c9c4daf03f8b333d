"""The arm file: everything that is particular to one physical arm, one number in one place.

TOML. `model` names a preset of kinematics; every other key corrects it or describes the wiring.
Or it names a model file, and the other keys say what its link table does not (link_model.py).
A file without corrections is two lines long. Unknown keys are refused with the nearest known one.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

from armdrive.abilities import Abilities, budget
from armdrive.config.backlash import read_backlash
from armdrive.config.preset import corrected
from armdrive.config.sections import (
    Connection,
    GripperSettings,
    HomingSettings,
    MotionSettings,
    read_accelerations,
    read_frames,
    read_homing,
    read_posture,
)
from armdrive.errors import ArmFileError, BadRequest
from armdrive.text.reading import read_toml
from armdrive.text.toml import (
    FORMAT_KEY,
    read_section,
    refuse_unknown,
    require_format,
    require_table,
)
from kinematics.errors import KinematicsError
from kinematics.five_axis.tool_arm import holding
from kinematics.frames.user_frame import UserFrame
from kinematics.geometry import Tool
from kinematics.presets import PRESETS, ArmModel, preset
from kinematics.spaces import Pose

M = TypeVar("M", bound=ArmModel)

MODEL_FILE = ".toml"
"""How a `model` ends that is no preset's key but a model file's path."""


@dataclass(frozen=True, slots=True)
class ConfigSource:
    """Where an arm comes from: its file as a table, and the folder that the file lies in."""

    table: Mapping[str, Any]
    folder: Path = Path()


@dataclass(frozen=True, slots=True)
class ArmConfig:
    """One physical arm, ready to be driven: its model with every correction applied.

    `device` holds what the section of the dialect's own name says, checked, as that dialect's
    settings. `source` is no part of the arm: it lets the arm's file be written again. `untooled`
    is the model with nothing in its fingers, where `model` holds a tool.
    """

    name: str
    title: str
    model: ArmModel
    connection: Connection
    device: Any
    motion: MotionSettings = field(default_factory=MotionSettings)
    gripper: GripperSettings = field(default_factory=GripperSettings)
    homing: HomingSettings | None = None
    park: Pose | None = None
    tool: Tool = field(default_factory=Tool)
    frames: Mapping[str, UserFrame] = field(default_factory=dict)
    accelerations_rad_s2: tuple[float | None, ...] = ()
    backlash_steps: tuple[int, ...] = ()
    source: ConfigSource | None = field(default=None, compare=False, repr=False)
    untooled: ArmModel | None = None

    @property
    def bare(self) -> ArmModel:
        """The model with nothing in its fingers."""
        return self.untooled or self.model

    @property
    def calibration(self) -> str:
        """A fingerprint of the numbers that give steps their meaning.

        A saved position is worth nothing under another model or transmission, and where a motor
        is within its backlash nothing under another backlash.
        """
        numbers = (self.bare.arm.meaning, self.model.transmission, self.model.reference)
        meaning = repr((*numbers, self.backlash_steps) if self.backlash_steps else numbers)
        return hashlib.sha256(meaning.encode()).hexdigest()[:16]


class DialectSection(Protocol):
    """What an arm file needs to know of the dialect that its arm speaks."""

    @property
    def name(self) -> str:
        """The dialect's name, and that of its own section."""

    @property
    def title(self) -> str:
        """The controller, for people."""

    @property
    def baud(self) -> int:
        """The rate of its wire where the file gives no other."""

    @property
    def raise_dtr(self) -> bool:
        """How its port is opened where the file does not say."""

    @property
    def abilities(self) -> Abilities:
        """What the device can do before an arm's settings are known."""

    def settings(self) -> type[Any]:
        """Return the dataclass that checks its own section."""

    def abilities_with(self, config: ArmConfig) -> Abilities:
        """Return what the device can do with an arm's settings; raises where they do not fit."""


@dataclass(frozen=True, slots=True, eq=False)
class DialectSections:
    """The dialects that an arm file may name: `default` is the one of a file that names none.

    `find` looks one up by its name; raises `BadRequest` that suggests the nearest name.
    """

    default: str
    find: Callable[[str], DialectSection]


def config_of_preset(
    key: str, dialect: DialectSection, *, name: str, connection: Connection
) -> ArmConfig:
    """Return an arm as it leaves the factory, on the given wire."""
    model = preset(key)
    return ArmConfig(
        name,
        model.title,
        model,
        connection,
        dialect.settings()(),
        MotionSettings(**_bursts(dialect, connection.baud)),
        source=ConfigSource({"model": key}),
    )


def _port_of(dialect: DialectSection) -> dict[str, Any]:
    """Return how a dialect's port is opened unless an arm file says otherwise."""
    return {"dialect": dialect.name, "baud": dialect.baud, "raise_dtr": dialect.raise_dtr}


def _bursts(dialect: DialectSection, baud: int) -> dict[str, float]:
    """Return how long a dialect's motions are on this wire, unless an arm file says otherwise."""
    able = dialect.abilities
    found = budget(
        able.traffic,
        baud,
        usual_baud=dialect.baud,
        jog_burst_s=able.jog_burst_s,
        planned_burst_s=able.planned_burst_s,
        queued=able.queued_segments,
    )
    lengths = {"jog_burst_s": found.jog_burst_s, "planned_burst_s": found.planned_burst_s}
    return lengths | {"ramp_s": able.ramp_s, "jerk_s": able.jerk_s}


def load(path: Path, sections: DialectSections) -> ArmConfig:
    """Read an arm file. Raises `ArmFileError` that names the file, the key and the mend."""
    table = read_arm_table(path)
    try:
        return parse(table, sections, name=path.stem, folder=path.parent)
    except (ArmFileError, KinematicsError) as error:
        raise ArmFileError(f"{path}: {error}") from None


def read_arm_table(path: Path) -> dict[str, Any]:
    """Return an arm file as its table. Raises `ArmFileError` for what cannot be read as TOML."""
    return read_toml(path, "the arm file", ArmFileError)


def parse(
    table: Mapping[str, Any], sections: DialectSections, *, name: str, folder: Path = Path()
) -> ArmConfig:
    """Turn a parsed TOML document into an arm; a model file is looked for from `folder`."""
    require_format(table)
    word = table.get("model")
    if not isinstance(word, str):
        raise ArmFileError('the key model is missing, for example model = "teachmover"')
    wiring = require_table(table.get("connection", {}), "connection")
    dialect = _dialect_of(wiring, sections)
    given = word not in PRESETS and word.lower().endswith(MODEL_FILE)
    keys = _MODEL_KEYS if given else _TOP_KEYS
    refuse_unknown(table, [*keys, dialect.name], "")
    title = table.get("title", "")
    if not isinstance(title, str):
        raise ArmFileError(f"title must be text, not {title!r}")
    gripper = read_section(GripperSettings, table.get("gripper", {}), "gripper")
    model = _described(table, folder) if given else corrected(preset(word), table)
    model = _with_gripper(model, gripper)
    tool = read_section(Tool, table.get("tool", {}), "tool")
    connection = read_section(Connection, _port_of(dialect) | dict(wiring), "connection")
    motion = _bursts(dialect, connection.baud) | dict(
        require_table(table.get("motion", {}), "motion")
    )
    park = table.get("park")
    return ArmConfig(
        name=name,
        title=title or model.title,
        model=_holding(model, tool) if tool else model,
        connection=connection,
        motion=read_section(MotionSettings, motion, "motion"),
        gripper=gripper,
        device=read_section(dialect.settings(), table.get(dialect.name, {}), dialect.name),
        homing=read_homing(table["homing"], model) if "homing" in table else None,
        park=read_posture(park, "park", model.arm.has_yaw) if park is not None else None,
        tool=tool,
        untooled=model if tool else None,
        frames=read_frames(table.get("frames", {})),
        accelerations_rad_s2=read_accelerations(table, model.arm.joint_names),
        backlash_steps=read_backlash(table, model.transmission),
        source=ConfigSource(table, folder),
    )


def _dialect_of(wiring: Mapping[str, Any], sections: DialectSections) -> DialectSection:
    word = wiring.get("dialect", sections.default)
    if not isinstance(word, str):
        raise ArmFileError(f"connection.dialect must be text, not {word!r}")
    try:
        return sections.find(word)
    except BadRequest as error:
        raise ArmFileError(f"connection.dialect: {error}") from None


def _with_gripper(model: M, gripper: GripperSettings) -> M:
    """Return the model without a gripper's motor where something else moves the fingers."""
    if gripper.kind == "stepper" or model.transmission is None:
        return model
    return replace(model, transmission=model.transmission.without_gripper())


def _holding(model: M, tool: Tool) -> ArmModel:
    """Return the model with a tool in its fingers, as thick as the guards of links have to know."""
    arm = holding(model.arm, tool)
    guards, links = model.guards, len(arm.moving_points)
    if guards.radii_mm and len(guards.radii_mm) + 1 == links:
        guards = replace(guards, radii_mm=(*guards.radii_mm, tool.radius_mm))
    return ArmModel(
        **{each.name: getattr(model, each.name) for each in fields(ArmModel)}
        | {"arm": arm, "guards": guards}
    )


def _described(table: Mapping[str, Any], folder: Path) -> ArmModel:
    from armdrive.config.link_model import model_of  # few arms need a link table and its solver

    return model_of(table, folder, read_posture)


_COMMON_KEYS = (
    FORMAT_KEY, "model", "title", "connection", "motion", "gripper", "homing", "park", "tool",
    "frames", "accelerations_deg_s2",
)  # fmt: skip
_MODEL_KEYS = (
    *_COMMON_KEYS, "motors", "fingers", "speeds_deg_s", "limits_deg", "reference", "guards",
)  # fmt: skip
_TOP_KEYS = (
    *_COMMON_KEYS, "reference",
    "lengths", "limits_deg", "speeds_deg_s", "steps_per_turn", "steps_per_mm", "motor_signs",
    "joint_signs", "backlash_deg", "backlash_mm", "guards",
)  # fmt: skip
