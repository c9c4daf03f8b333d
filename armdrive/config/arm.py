"""Reads the arm file: everything that is particular to one physical arm, each number stated once.

In TOML. `model` names a preset of kinematics, and every other key corrects it or describes the
wiring; or it names a model file, and the other keys add what its link table lacks (link_model.py).
The shortest file is two lines long. An unknown key is an error that suggests the nearest known one.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar, runtime_checkable

from armdrive.abilities import Abilities, budget
from armdrive.config.preset import MOTOR_KEYS, corrected
from armdrive.config.sections import (
    SLIDING,
    TURNING,
    Connection,
    GripperSettings,
    HomingSettings,
    MotionSettings,
    is_model_file,
    is_urdf,
    read_accelerations,
    read_backlash,
    read_frames,
    read_homing,
    read_posture,
)
from armdrive.errors import ArmError, ArmFileError, BadRequest, Refused
from armdrive.errors.printable import command_line
from armdrive.text.reading import read_toml
from armdrive.text.toml import (
    FORMAT_KEY,
    TomlTable,
    require_format,
    require_table,
    text,
)
from kinematics.errors import KinematicsError
from kinematics.frames.user_frame import UserFrame
from kinematics.geometry import Tool
from kinematics.presets import ArmModel, preset
from kinematics.spaces import Pose
from kinematics.text import counted
from kinematics.transmission import Transmission

M = TypeVar("M", bound=ArmModel)


@dataclass(frozen=True, slots=True)
class ConfigSource:
    """The table of an arm's file, and the folder of that file."""

    table: Mapping[str, Any]
    folder: Path = Path()


@dataclass(frozen=True, slots=True)
class ArmConfig:
    """One physical arm: its model with every correction, and all settings.

    `device` has the settings of the dialect's own section. `source` allows the file to be written
    again, and is no part of the arm. `untooled` is the model with empty fingers if `model` holds a
    tool.
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
        """The model with empty fingers."""
        return self.untooled or self.model

    @property
    def transmission(self) -> Transmission:
        """The motors of an arm that is driven. Raises `Refused` for a model without motors."""
        if self.model.transmission is None:
            raise Refused(
                f"the {self.model.title} has no motor steps: use a model with motors, and give "
                "steps_per_turn in its arm file"
            )
        return self.model.transmission

    @property
    def motor_ranges(self) -> tuple[float, ...]:
        """How far each motor turns between its joints' limits, in steps; empty if not known."""
        model = self.model
        low_mm, high_mm = model.gripper_range_mm
        spans = [one.high_rad - one.low_rad for one in model.arm.limits]
        turning = model.transmission
        return () if turning is None else turning.most_steps([*spans, high_mm - low_mm])

    @property
    def calibration(self) -> str:
        """A fingerprint of the numbers that give steps their meaning.

        A saved position is invalid for another model, transmission or backlash.
        """
        # without backlash nothing is added, so that files without any keep their old fingerprint
        numbers = (self.bare.arm.meaning, self.model.transmission, self.model.reference)
        meaning = repr((*numbers, self.backlash_steps) if self.backlash_steps else numbers)
        return hashlib.sha256(meaning.encode()).hexdigest()[:16]


class DialectSection(Protocol):
    """The part of a dialect that the arm file needs."""

    @property
    def name(self) -> str:
        """The name of the dialect and of its own section."""

    @property
    def title(self) -> str:
        """The controller's name in words."""

    @property
    def baud(self) -> int:
        """The default baud rate."""

    @property
    def raise_dtr(self) -> bool:
        """The default of `raise_dtr`."""

    @property
    def abilities(self) -> Abilities:
        """The device's abilities before an arm's settings are known."""

    def settings(self) -> type[Any]:
        """Return the dataclass of its own section."""

    def abilities_with(self, config: ArmConfig) -> Abilities:
        """Return the device's abilities with an arm's settings. Raises if these do not fit."""


# Returns a dialect by its name, or for None the dialect of a file that names none.
#
# It raises `BadRequest`, which suggests the nearest name.
FindDialect = Callable[[str | None], DialectSection]


def _bursts(dialect: DialectSection, baud: int) -> dict[str, float]:
    """Return the default lengths of a dialect's motions on this wire."""
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


def read_arm_table(path: Path) -> dict[str, Any]:
    """Return an arm file as its table. Raises `ArmFileError` for what cannot be read as TOML."""
    return read_toml(path, "the arm file", ArmFileError)


def read_arm(table: TomlTable, find: FindDialect, *, name: str, folder: Path) -> ArmConfig | None:
    """Read the whole file and note every problem; return None if they leave no arm.

    Of a file in another format nothing can be judged. Where the model or the dialect is unknown,
    what depends on it is left out.
    """
    problems = table.problems
    if not problems.attempt(lambda: _has_our_format(table), False):
        return None
    word = problems.attempt(lambda: _model_word(table), None)
    linked = word is not None and is_model_file(word)
    preset_model = None if word is None or linked else problems.attempt(lambda: preset(word), None)
    known = problems.attempt(lambda: _dialect(table, find), None)
    dialect = known or find(None)  # whatever it is, the other sections are read as well
    if linked or preset_model:
        table.allow(_keys(table, str(word), known))
    title = table.value("title", text, "")
    port = {"dialect": dialect.name, "baud": dialect.baud, "raise_dtr": dialect.raise_dtr}
    connection = table.table("connection").section(Connection, port) or Connection(dialect.name)
    motion = table.table("motion").section(MotionSettings, _bursts(dialect, connection.baud))
    gripper = table.table("gripper").section(GripperSettings)
    tool = table.table("tool").section(Tool)
    frames = read_frames(table.table("frames"))
    device = table.table(dialect.name).section(dialect.settings())
    model: ArmModel | None = None
    if linked:
        model = problems.attempt(lambda: _described(table, folder, gripper), None)
    elif preset_model is not None:
        model = problems.attempt(lambda: corrected(preset_model, table), None)
    if model is None:
        return None
    # an unknown kind of gripper leaves it open how many motors there are: assume all of them
    fitted = model if gripper is None else _with_gripper(model, gripper)
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


def _has_our_format(table: TomlTable) -> bool:
    require_format(table.entries)
    return True


def _model_word(table: TomlTable) -> str:
    word = table.entries.get("model")
    if not isinstance(word, str):
        raise ArmFileError('the key model is missing, for example model = "teachmover"')
    return word


def _dialect(table: TomlTable, find: FindDialect) -> DialectSection:
    wiring = require_table(table.entries.get("connection", {}), "connection")
    spoken = wiring.get("dialect")
    if not isinstance(spoken, str | None):
        raise ArmFileError(f"connection.dialect must be text, not {spoken!r}")
    try:
        return find(spoken)
    except BadRequest as error:
        raise ArmFileError(f"connection.dialect: {error}") from None


def _keys(table: TomlTable, model: str, dialect: DialectSection | None) -> Iterator[str]:
    """Yield the keys that a file with this model may have at its top."""
    yield from LINKED_KEYS if is_model_file(model) else PRESET_KEYS
    if is_urdf(model):
        yield "urdf"
    if dialect is not None:
        yield dialect.name
    else:  # any section may be the one of the dialect that was meant
        yield from (key for key, value in table.entries.items() if isinstance(value, Mapping))


def _with_gripper(model: M, gripper: GripperSettings) -> M:
    """Return the model, without the gripper's motor if something else moves the fingers."""
    if gripper.kind == "stepper" or model.transmission is None:
        return model
    return replace(model, transmission=model.transmission.without_gripper())


def _holding(model: M, tool: Tool) -> ArmModel:
    """Return the model with a tool in its fingers, and the tool's thickness in its guards."""
    arm = model.arm.with_tool(tool)
    guards, links = model.guards, len(arm.moving_points)
    # a tool is one more link; a file that gives its thickness in radii_mm keeps it
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
# The keys of an arm with a link table.
LINKED_KEYS = (*COMMON_KEYS, "motors", "fingers")
# The keys of an arm of the Mini-mover's build.
PRESET_KEYS = (*COMMON_KEYS, "lengths", *MOTOR_KEYS, TURNING, SLIDING)


# Checks of the whole arm, and remarks on a file without problems.


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
                f"homing.joints_deg.{broken.joint} is {math.degrees(broken.value):g}, beyond "
                f"its limit of {math.degrees(broken.bound):g}: correct it, or limits_deg."
                f"{broken.joint}"
            )


def _motors(config: ArmConfig, dialect: DialectSection) -> Iterator[str]:
    transmission = config.model.transmission
    if transmission is None:
        yield (
            f"the motor steps of the {config.model.title} are not known: give steps_per_mm and "
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
            f"the arm has {counted(len(transmission.motors), 'motor')}, but its controller "
            f"({dialect.title}) "
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
    if not config.connection.names_port:
        yield "no port is named, so the arm can only be simulated: write connection.port"
    if not config.model.verified:
        yield (
            "its numbers are a template: Cartesian motion is refused until every key of [lengths] "
            "and [steps_per_turn] is given as measured (`armdrive config show NAME` prints "
            "the template's, which do not count unchanged), or, of a link table, verified = true "
            "in its model file"
        )
    yield from config.model.unused
    if config.homing is None and config.model.reference is None:
        yield "no homing and no reference posture: to reference it, call `reference.declare()`"
    if config.park is None and config.model.reference is None:
        yield "no park posture: write [park]"
    yield from _homing_remarks(config)
    yield from limit_remarks(config)


def _homing_remarks(config: ArmConfig) -> Iterator[str]:
    """Yield each motor that homes before a joint that it passes over, as a cable does.

    That joint then still stands anywhere, and the motor's own joint may come to its end before the
    switch closes. Seen on a simulated Mini-mover whose elbow homed before its shoulder.
    """
    turning, homing = config.model.transmission, config.homing
    if turning is None or homing is None:
        return
    turns = {motor - 1: turn for turn, group in enumerate(homing.groups) for motor in group}
    for index, turn in turns.items():
        for joint in range(min(index, len(config.model.arm.limits))):
            if turning.matrix[index][joint] and turns[joint] > turn:
                yield (
                    f"homing.groups: motor {index + 1} ({turning.motors[index].name}) passes over "
                    f"the {config.model.arm.joint_names[joint]}, which homes later, and may not "
                    f"reach its switch: home motor {joint + 1} before it"
                )


@runtime_checkable
class HasLimits(Protocol):
    """Settings of a controller that can end a motion where a limit switch closes."""

    hard_limits: bool
    hard_limits_checked: str

    @property
    def limit_inputs(self) -> Mapping[str, int]:
        """The input bit of each limit switch, by its axis; in the order of the motors."""


def limit_remarks(config: ArmConfig) -> tuple[str, ...]:
    """Say where hard limits are counted on that were never seen to work."""
    device = config.device
    if not isinstance(device, HasLimits) or not device.hard_limits or device.hard_limits_checked:
        return ()
    limits = command_line("config", "limits", config.name)
    remark = (
        "hard_limits is set, and no switch was ever seen to raise an alarm; some boards accept the "
        f"setting and do nothing: run `{limits}` and press each switch"
    )
    return (remark,)
