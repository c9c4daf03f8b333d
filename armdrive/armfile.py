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
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, TypeVar

from armdrive.dialects import Dialect, dialect
from armdrive.errors import ArmFileError, BadRequest
from armdrive.guardfile import guards_of
from armdrive.sections import (
    joint_range,
    number,
    read_section,
    refuse_unknown,
    require_table,
    within,
)
from kinematics import (
    PRESETS,
    ArmModel,
    ArmPreset,
    JointRange,
    Joints,
    KinematicsError,
    Pose,
    Reference,
    Transmission,
    cable_transmission,
    preset,
)
from kinematics.spaces import JOINT_NAMES

M = TypeVar("M", bound=ArmModel)

MODEL_FILE = ".toml"
"""How a `model` ends that is no preset's key but a model file's path."""


@dataclass(frozen=True, slots=True)
class Connection:
    """Which wire leads to the arm; ports are opened with DTR and RTS off unless it says other.

    `baud` is the dialect's own unless the file gives another. A board that is reset by opening
    its port is spared that from the second time on by `raise_dtr` and `keep_dtr_on_close`.
    `usb_serial` finds an adapter under whatever name its port has. With `reconnect` a lost wire is
    looked for until it is back; the arm then stands in error-stop.
    """

    dialect: str = "teachmover"
    port: str = ""
    baud: int = 9600
    raise_dtr: bool = False
    keep_dtr_on_close: bool = False
    usb_serial: str = ""
    reconnect: bool = False

    def __post_init__(self) -> None:
        within("connection.baud", self.baud, 50, 4_000_000)


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """How the arm is moved.

    Bursts are the longest motions sent at once, which on a device that cannot abort are the
    stopping time; setting `planned_burst_s` accepts longer ones for planned motion, for good.
    Between bursts, a device that does not coordinate its motors keeps within `straying_mm`.
    `unreferenced_speed` caps jogging while the position is not known.
    """

    jog_burst_s: float = 0.15
    planned_burst_s: float = 0.15
    line_tolerance_mm: float = 0.5
    straying_mm: float = 5.0
    tip_speed_mm_s: float = 100.0
    unreferenced_speed: float = 0.25
    idle_poll_s: float = 0.8

    def __post_init__(self) -> None:
        for name, (low, high) in _MOTION_BOUNDS.items():
            within(f"motion.{name}", getattr(self, name), low, high)


_MOTION_BOUNDS = {
    "jog_burst_s": (0.02, 0.5),
    "planned_burst_s": (0.02, 10.0),
    "line_tolerance_mm": (0.05, 10.0),
    "straying_mm": (0.5, 100.0),
    "tip_speed_mm_s": (1.0, 1000.0),
    "unreferenced_speed": (0.01, 1.0),
    "idle_poll_s": (0.0, 60.0),
}


GRIPPER_KINDS = ("stepper", "servo", "output", "none")


@dataclass(frozen=True, slots=True)
class GripperSettings:
    """The gripper: `trip_force_n` is the force at which its switch closes (unverified).

    The fingers approach an object by `approach_steps` at a time. `kind` says what moves them: a
    stepper of the arm's own transmission, a servo or a digital output of its controller, or
    nothing.
    """

    kind: str = "stepper"
    trip_force_n: float = 2.2
    max_force_n: float = 35.0
    approach_steps: int = 16

    def __post_init__(self) -> None:
        if self.kind not in GRIPPER_KINDS:
            known = ", ".join(GRIPPER_KINDS)
            raise ArmFileError(f"gripper.kind is one of {known}, not {self.kind!r}")
        within("gripper.trip_force_n", self.trip_force_n, 0.0, 100.0)
        within("gripper.max_force_n", self.max_force_n, self.trip_force_n, 200.0)
        within("gripper.approach_steps", self.approach_steps, 1, 100)


@dataclass(frozen=True, slots=True)
class PostureSettings:
    """A posture that a person can find again, in mm and degrees."""

    x_mm: float
    y_mm: float
    z_mm: float
    pitch_deg: float
    roll_deg: float = 0.0

    def pose(self) -> Pose:
        """Return it as a pose."""
        return Pose.of(**{each.name: getattr(self, each.name) for each in fields(self)})


@dataclass(frozen=True, slots=True)
class YawedPostureSettings(PostureSettings):
    """The same of an arm of six joints, whose hand has a heading of its own."""

    yaw_deg: float = 0.0


@dataclass(frozen=True, slots=True)
class HomingSettings:
    """The device's own homing: the joints where it ends, and which motors home after which.

    `groups` lists motor numbers from 1; without it the device homes all of them by its own order.
    """

    joints: Joints
    opening_mm: float = 0.0
    groups: tuple[tuple[int, ...], ...] = ()


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
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ArmFileError(f"the arm file {path} cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ArmFileError(f"the arm file {path} is not valid TOML: {error}") from None
    try:
        return parse_arm_file(table, name=path.stem, folder=path.parent)
    except (ArmFileError, KinematicsError) as error:
        raise ArmFileError(f"{path}: {error}") from None


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
    model = _described(table, folder) if given else _corrected(preset(word), table)
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
        park=_posture(park, "park", model.arm.has_yaw) if park is not None else None,
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

    return model_of(table, folder, _posture)


def _posture(table: object, where: str, has_yaw: bool) -> Pose:
    kind = YawedPostureSettings if has_yaw else PostureSettings
    return read_section(kind, table, where).pose()


_COMMON_KEYS = ("model", "title", "connection", "motion", "gripper", "homing", "park")
_MODEL_KEYS = (
    *_COMMON_KEYS, "motors", "fingers", "speeds_deg_s", "limits_deg", "reference", "guards",
)  # fmt: skip
_TOP_KEYS = (
    *_COMMON_KEYS, "reference",
    "lengths", "limits_deg", "speeds_deg_s", "steps_per_turn", "steps_per_mm", "motor_signs",
    "joint_signs", "guards",
)  # fmt: skip


def _corrected(model: ArmPreset, table: Mapping[str, Any]) -> ArmPreset:
    """Apply an arm file's corrections to its preset."""
    arm = model.arm
    lengths = require_table(table.get("lengths", {}), "lengths")
    refuse_unknown(lengths, list(_LENGTHS), "lengths")
    changed: dict[str, Any] = {key: number(v, f"lengths.{key}") for key, v in lengths.items()}
    arm = replace(arm, limits=_limits(arm.limits, table.get("limits_deg", {})), **changed)
    model = replace(
        model,
        arm=arm,
        joint_speeds_rad_s=_speeds(model.joint_speeds_rad_s, table.get("speeds_deg_s", {})),
        guards=guards_of(table.get("guards", {}), arm, model.guards),
        transmission=_transmission(model, table),
    )
    if "reference" in table:
        pose = _posture(table["reference"], "reference", arm.has_yaw)
        model = replace(model, reference=replace(model.reference or Reference(pose), pose=pose))
    return replace(model, verified=model.verified or _filled_in(model, table))


def _filled_in(model: ArmPreset, table: Mapping[str, Any]) -> bool:
    """Tell whether a file gives every number that a template only stands in for.

    The template's own numbers, all written out, are still nobody's measurement.
    """
    turning = [] if model.transmission is None else model.transmission.motors[:5]
    whole = (
        bool(turning)
        and set(table.get("lengths", {})) == set(_LENGTHS)
        and {motor.name for motor in turning} == set(table.get("steps_per_turn", {}))
    )
    known = preset(model.key)
    return whole and (model.arm, model.transmission) != (known.arm, known.transmission)


_LENGTHS = ("base_height_mm", "upper_arm_mm", "forearm_mm", "hand_mm")


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
        if number(value, f"speeds_deg_s.{joint}") <= 0.0:
            raise ArmFileError(f"speeds_deg_s.{joint} must be above 0")
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
