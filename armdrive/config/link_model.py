"""The model file: a serial arm as a link table in TOML, in mm and degrees.

Any number of joints, in either convention. Unknown keys are refused with the nearest known one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from armdrive.config.backlash import SLIDING, TURNING
from armdrive.config.guards import guards_of
from armdrive.errors import ArmFileError
from armdrive.text.reading import read_toml
from armdrive.text.toml import (
    FORMAT_KEY,
    joint_range,
    number,
    read_section,
    refuse_unknown,
    require_format,
    require_table,
    within,
)
from kinematics.chains.arm import ChainArm
from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, JointKind
from kinematics.chains.tables import chain_of_rows
from kinematics.errors import KinematicsError
from kinematics.frames.orientations import RPY
from kinematics.frames.transforms import Transform, transform
from kinematics.guards.guards import Guards
from kinematics.presets import ArmModel, Reference
from kinematics.spaces import Pose
from kinematics.transmission import MotorSpec, Transmission

ENDING = ".toml"

MOST_LINKS = 100
"""No arm has so many; what is worked out of a chain takes time with their number squared."""

_TOP_KEYS = (
    FORMAT_KEY, "name", "title", "source", "verified", "convention", "base", "tool", "links",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Model:
    """A model as its file describes it: name, title, where its numbers come from, links.

    `verified` is False where the file says that nobody has measured them on an arm yet.
    """

    name: str
    title: str
    source: str
    chain: Chain
    verified: bool = True


@dataclass(frozen=True, slots=True)
class Placement:
    """A frame in another: position in mm, turned by Rot(z, phi) Rot(y, theta) Rot(x, psi)."""

    x_mm: float = 0.0
    y_mm: float = 0.0
    z_mm: float = 0.0
    phi_deg: float = 0.0
    theta_deg: float = 0.0
    psi_deg: float = 0.0

    def frame(self) -> Transform:
        """Return it as a transform, exact at whole quarter turns."""
        angles = map(math.radians, (self.phi_deg, self.theta_deg, self.psi_deg))
        turned = RPY(*angles).rotation()
        clean = tuple(tuple(_clean(entry) for entry in row) for row in turned)
        return transform(clean, (self.x_mm, self.y_mm, self.z_mm))  # type: ignore[arg-type]


def is_model_file(word: str) -> bool:
    """Whether a word names a model file rather than a built-in model."""
    return word.lower().endswith(ENDING)


def read_model(path: str | Path) -> Model:
    """Read a model file. Raises `ArmFileError`, which names the file and the key."""
    place = Path(path)
    document = read_toml(place, "the model file", ArmFileError)
    try:
        return parse_model(document, name=place.stem)
    except (ArmFileError, KinematicsError) as error:
        raise ArmFileError(f"{place}: {error}") from None


def parse_model(document: Mapping[str, Any], *, name: str = "model") -> Model:
    """Return the model of a parsed file; `name` is used where it gives none.

    Raises `ArmFileError` for a wrong key or value of the file, `KinematicsError` for links that
    make no chain.
    """
    require_format(document)
    refuse_unknown(document, list(_TOP_KEYS), "")
    called = _text(document, "name", name)
    rows = document.get("links", [])
    if not isinstance(rows, list) or not rows:
        raise ArmFileError("a model needs at least one link, each written under [[links]]")
    if len(rows) > MOST_LINKS:
        raise ArmFileError(f"a model has at most {MOST_LINKS} links, not {len(rows)}")
    chain = chain_of_rows(
        [require_table(row, "links") for row in rows],
        convention=_convention(_text(document, "convention", Convention.STANDARD.value)),
        base=read_section(Placement, document.get("base", {}), "base").frame(),
        tool=read_section(Placement, document.get("tool", {}), "tool").frame(),
        name=called,
    )
    verified = document.get("verified", True)
    if not isinstance(verified, bool):
        raise ArmFileError(f"verified must be true or false, not {verified!r}")
    title, source = _text(document, "title", called), _text(document, "source", "")
    return Model(called, title, source, chain, verified)


def _text(document: Mapping[str, Any], key: str, default: str) -> str:
    value = document.get(key, default)
    if not isinstance(value, str):
        raise ArmFileError(f"{key} must be text, not {value!r}")
    return value


def _convention(word: str) -> Convention:
    for one in Convention:
        if one.value == word:
            return one
    known = " or ".join(repr(one.value) for one in Convention)
    raise ArmFileError(f"convention must be {known}, not {word!r}")


def _clean(entry: float) -> float:
    """Return the entry of a rotation without the rounding of quarter turns."""
    whole = float(round(number(entry, "rotation")))
    return whole if abs(entry - whole) < 1e-15 else entry


# An arm that is given by a model file: its motors, speeds and fingers from the arm file.
#
# Nothing is known of such an arm beforehand, so that what a preset would say is required here.
# Angles are in degrees in the file and in rad in what is made of it.

OPENING = "opening"
"""What a gripper's motor sees beside the joints."""

TABLE_ALONE = Guards(inner_radius_mm=None, outer_radius_mm=None, hand_wrist_radius_mm=None)
"""The guards of an arm that nothing is known of, unless its file asks for more."""

Posed = Callable[[object, str, bool], Pose]
"""Reads a posture of an arm file: its table, its name, and whether it has a yaw."""


@dataclass(frozen=True, slots=True)
class FingerModel:
    """The gripper that a motor drives: its range and speed, and steps per N once it touches."""

    range_mm: tuple[float, float]
    speed_mm_s: float
    steps_per_n: float | None = None

    def __post_init__(self) -> None:
        low, high = self.range_mm
        if low >= high:
            raise ArmFileError("fingers.range_mm: the first number must be below the second")
        within("fingers.speed_mm_s", self.speed_mm_s, 0.01, 10_000.0)
        if self.steps_per_n is not None:
            within("fingers.steps_per_n", self.steps_per_n, 1e-3, 1e6)


@dataclass(frozen=True, slots=True)
class Motor:
    """One motor as the file has it; `sees` by joint, `follows` by the name of another motor.

    Its backlash is read in config/backlash.py.
    """

    name: str
    steps_per_turn: float | None
    steps_per_mm: float | None
    sees: Mapping[str, float]
    follows: Mapping[str, int]


def model_of(table: Mapping[str, Any], folder: Path, posed: Posed) -> ArmModel:
    """Return the model that an arm file describes together with its model file.

    Raises `ArmFileError` that names the key, and `KinematicsError` for what makes no arm.
    """
    described = read_model(folder / table["model"])
    _check_names(described.chain.joint_names)
    arm = ChainArm(_limited(described.chain, table.get("limits_deg", {})))
    transmission = _transmission(arm.joint_names, table.get("motors"))
    fingers = _fingers(table, transmission)
    speeds = _speeds(arm.joint_names, table.get("speeds_deg_s"))
    reference = table.get("reference")
    return ArmModel(
        key=described.name,
        title=described.title,
        arm=arm,
        transmission=transmission,
        joint_speeds_rad_s=speeds,
        no_load_speeds_rad_s=speeds,
        gripper_range_mm=fingers.range_mm,
        gripper_speed_mm_s=fingers.speed_mm_s,
        grip_steps_per_n=fingers.steps_per_n,
        reference=(
            None if reference is None else Reference(posed(reference, "reference", arm.has_yaw))
        ),
        guards=guards_of(table.get("guards", {}), arm, TABLE_ALONE),
        verified=described.verified,
        notes=described.source,
    )


def _check_names(names: tuple[str, ...]) -> None:
    """Refuse names that calls could not use, as `wrist_pitch_deg=10`, or that mean the gripper."""
    for name in names:
        if not name.isidentifier() or name in (OPENING, "gripper"):
            raise ArmFileError(
                f"a joint that is driven cannot be called {name!r}: give it another name in the "
                "model file, one word such as wrist_pitch"
            )


NO_FINGERS = FingerModel((0.0, 1.0), 1.0)
"""What stands where no motor drives a gripper, so that nothing is ever computed from it."""


def _fingers(table: Mapping[str, Any], transmission: Transmission) -> FingerModel:
    if transmission.has_gripper:
        if "fingers" not in table:
            raise ArmFileError(
                "a motor drives a gripper, so [fingers] is needed, for example range_mm = [0, 76] "
                "and speed_mm_s = 20"
            )
        return read_section(FingerModel, table["fingers"], "fingers")
    if "fingers" not in table:
        return NO_FINGERS
    kind = require_table(table.get("gripper", {}), "gripper").get("kind", "stepper")
    if kind not in ("servo", "output"):
        raise ArmFileError(
            "[fingers] stands there, but no motor has steps_per_mm to drive them, and gripper.kind "
            'is neither "servo" nor "output"'
        )
    return read_section(FingerModel, table["fingers"], "fingers")


def _limited(chain: Chain, table: object) -> Chain:
    """Return the chain with the arm file's limits in the place of the model file's."""
    entries = require_table(table, "limits_deg")
    refuse_unknown(entries, list(chain.joint_names), "limits_deg")
    links = []
    for name, link in zip(chain.joint_names, chain.links, strict=True):
        if name in entries:
            bounds = joint_range(entries[name], f"limits_deg.{name}")
            link = replace(link, low=bounds.low_rad, high=bounds.high_rad)
        elif link.kind is JointKind.REVOLUTE and not math.isfinite(link.high - link.low):
            raise ArmFileError(
                f"joint {name!r} has no limits in its model: give limits_deg.{name} = [low, high]"
            )
        links.append(link)
    return replace(chain, links=tuple(links))


def _speeds(names: tuple[str, ...], table: object) -> tuple[float, ...]:
    entries = require_table(table, "speeds_deg_s")
    refuse_unknown(entries, list(names), "speeds_deg_s")
    missing = [name for name in names if name not in entries]
    if missing:
        raise ArmFileError(f"[speeds_deg_s] is missing {', '.join(missing)}")
    for name in names:
        within(f"speeds_deg_s.{name}", number(entries[name], f"speeds_deg_s.{name}"), 0.01, 3600.0)
    return tuple(math.radians(entries[name]) for name in names)


def _transmission(joints: tuple[str, ...], rows: object) -> Transmission:
    if not isinstance(rows, list) or not rows:
        raise ArmFileError("an arm of a model file needs its motors, each written under [[motors]]")
    motors = [_motor(row, f"motors[{index}]") for index, row in enumerate(rows, 1)]
    slides = [motor.steps_per_mm is not None for motor in motors]
    if any(slides[:-1]):
        raise ArmFileError("the gripper's motor, the one with steps_per_mm, must be the last")
    seen = (*joints, OPENING) if slides[-1] else joints
    names = [motor.name for motor in motors]
    if len(set(names)) != len(names):
        raise ArmFileError(f"motors need different names, not {', '.join(names)}")
    specs = tuple(_spec(motor, seen, names[:index]) for index, motor in enumerate(motors))
    return Transmission(specs, joints)


def _motor(row: object, where: str) -> Motor:
    entries = require_table(row, where)
    refuse_unknown(entries, [*Motor.__dataclass_fields__, TURNING, SLIDING], where)
    name = entries.get("name")
    if not isinstance(name, str) or not name:
        raise ArmFileError(f'{where} needs a name, for example name = "base"')
    turn, slide = (_steps(entries, key, where) for key in ("steps_per_turn", "steps_per_mm"))
    if (turn is None) == (slide is None):
        raise ArmFileError(
            f"motor {name!r} needs steps_per_turn, or steps_per_mm where it drives a gripper"
        )
    sees = require_table(entries.get("sees", {OPENING: 1} if slide else {}), f"{where}.sees")
    follows = require_table(entries.get("follows", {}), f"{where}.follows")
    for other, ratio in follows.items():
        if type(ratio) is not int:
            raise ArmFileError(f"{where}.follows.{other} must be a whole number, not {ratio!r}")
    shares = {joint: number(one, f"{where}.sees.{joint}") for joint, one in sees.items()}
    return Motor(name, turn, slide, shares, dict(follows))


def _steps(entries: Mapping[str, Any], key: str, where: str) -> float | None:
    if key not in entries:
        return None
    steps = number(entries[key], f"{where}.{key}")
    if steps <= 0.0:
        raise ArmFileError(f"{where}.{key} must be above 0: directions are signs in sees")
    within(f"{where}.{key}", steps, 0.1, 10_000_000.0)
    return steps


def _spec(motor: Motor, seen: tuple[str, ...], earlier: list[str]) -> MotorSpec:
    refuse_unknown(motor.sees, list(seen), f"motors.{motor.name}.sees")
    refuse_unknown(motor.follows, earlier, f"motors.{motor.name}.follows")
    if not motor.sees:
        raise ArmFileError(
            f"motor {motor.name!r} sees no joint: write for example sees = {{ {seen[0]} = 1 }}"
        )
    per_unit = motor.steps_per_mm or (motor.steps_per_turn or 0.0) / math.tau
    return MotorSpec(
        motor.name,
        per_unit,
        tuple(motor.sees.get(name, 0.0) for name in seen),
        follows=tuple((earlier.index(other), ratio) for other, ratio in motor.follows.items()),
    )
