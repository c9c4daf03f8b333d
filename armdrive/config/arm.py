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
from armdrive.config.preset import MOTOR_KEYS, corrected
from armdrive.config.sections import (
    SLIDING,
    TURNING,
    Connection,
    GripperSettings,
    HomingSettings,
    MotionSettings,
    read_accelerations,
    read_backlash,
    read_frames,
    read_homing,
    read_posture,
)
from armdrive.errors import ArmFileError, BadRequest
from armdrive.text.reading import read_toml
from armdrive.text.toml import (
    FORMAT_KEY,
    Problems,
    TomlTable,
    require_format,
    require_table,
    text,
)
from kinematics.errors import KinematicsError
from kinematics.five_axis.tool_arm import holding
from kinematics.frames.user_frame import UserFrame
from kinematics.geometry import Tool
from kinematics.presets import PRESETS, ArmModel, ArmPreset, preset
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
    """Turn a parsed TOML document into an arm; a model file is looked for from `folder`.

    Raises `ArmFileError` for the first thing that is wrong.
    """
    problems = Problems()
    config = read_arm(TomlTable(table, "", problems), sections, name=name, folder=folder)
    problems.require_none()
    if config is None:
        raise ArmFileError("the arm file describes no arm")
    return config


def read_arm(
    table: TomlTable, sections: DialectSections, *, name: str, folder: Path
) -> ArmConfig | None:
    """Read the whole file and note every problem; return None if they leave no arm.

    If the format, the model's name or the dialect is wrong, nothing else can be judged.
    """
    problems = table.problems
    known = problems.attempt(lambda: _basics(table, sections), None)
    if known is None:
        return None
    preset_model, dialect = known
    linked = preset_model is None
    table.allow([*(LINKED_KEYS if linked else PRESET_KEYS), dialect.name])
    title = table.value("title", text, "")
    port = {"dialect": dialect.name, "baud": dialect.baud, "raise_dtr": dialect.raise_dtr}
    connection = table.table("connection").section(Connection, port) or Connection(dialect.name)
    motion = table.table("motion").section(MotionSettings, _bursts(dialect, connection.baud))
    gripper = table.table("gripper").section(GripperSettings)
    tool = table.table("tool").section(Tool)
    frames = read_frames(table.table("frames"))
    device = table.table(dialect.name).section(dialect.settings())
    model: ArmModel | None
    if preset_model is None:
        model = problems.attempt(lambda: _described(table, folder, gripper), None)
    else:
        model = problems.attempt(lambda: corrected(preset_model, table), None)
    if model is None:
        read_posture(table, "park", has_yaw=True)
        return None
    # an unknown kind of gripper leaves it open how many motors there are: assume all of them
    kind_known = gripper is not None and _is_as_given(gripper, table)
    fitted = _with_gripper(model, gripper) if gripper is not None and kind_known else model
    homing = read_homing(table.table("homing"), fitted) if "homing" in table.entries else None
    park = read_posture(table, "park", fitted.arm.has_yaw)
    accelerations = read_accelerations(table, fitted.arm.joint_names)
    backlash = read_backlash(table, fitted.transmission)
    held = problems.attempt(lambda: _holding(fitted, tool), fitted) if tool else fitted
    if problems.found or gripper is None or motion is None or tool is None:
        return None
    return ArmConfig(
        name=name,
        title=title or model.title,
        model=held,
        connection=connection,
        motion=motion,
        gripper=gripper,
        device=device,
        homing=homing,
        park=park,
        tool=tool,
        untooled=fitted if tool else None,
        frames=frames,
        accelerations_rad_s2=accelerations,
        backlash_steps=backlash,
        source=ConfigSource(table.entries, folder),
    )


def _basics(table: TomlTable, sections: DialectSections) -> tuple[ArmPreset | None, DialectSection]:
    """Return the preset, None of an arm of a model file, and the dialect.

    Raises `ArmFileError`, and `KinematicsError` for a preset that there is not.
    """
    require_format(table.entries)
    word = table.entries.get("model")
    if not isinstance(word, str):
        raise ArmFileError('the key model is missing, for example model = "teachmover"')
    wiring = require_table(table.entries.get("connection", {}), "connection")
    spoken = wiring.get("dialect", sections.default)
    if not isinstance(spoken, str):
        raise ArmFileError(f"connection.dialect must be text, not {spoken!r}")
    try:
        dialect = sections.find(spoken)
    except BadRequest as error:
        raise ArmFileError(f"connection.dialect: {error}") from None
    linked = word not in PRESETS and word.lower().endswith(MODEL_FILE)
    return None if linked else preset(word), dialect


def _is_as_given(gripper: GripperSettings, table: TomlTable) -> bool:
    """Return whether the kind of the gripper is the one that the file gives, and not a default."""
    return bool(gripper.kind == table.table("gripper").entries.get("kind", gripper.kind))


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


def _described(table: TomlTable, folder: Path, gripper: GripperSettings | None) -> ArmModel | None:
    from armdrive.config.link_model import model_of  # few arms need a link table and its solver

    return model_of(table, folder, gripper or GripperSettings())


COMMON_KEYS = (
    FORMAT_KEY, "model", "title", "connection", "motion", "gripper", "homing", "park", "tool",
    "frames", "accelerations_deg_s2", "reference", "limits_deg", "speeds_deg_s", "guards",
)  # fmt: skip
LINKED_KEYS = (*COMMON_KEYS, "motors", "fingers")
"""The keys of an arm that is described by a link table."""
PRESET_KEYS = (*COMMON_KEYS, "lengths", *MOTOR_KEYS, TURNING, SLIDING)
"""The keys of an arm of the Mini-mover's build."""
