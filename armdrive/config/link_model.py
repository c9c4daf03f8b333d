"""The model file: a serial arm by its links or joint axes in TOML, in mm and degrees, or as URDF.

Any number of joints, in either convention. Unknown keys are refused with the nearest known one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from armdrive.config.preset import MOST_STEPS, SPEED
from armdrive.config.sections import (
    OPENING,
    SLIDING,
    TURNING,
    FingerModel,
    GripperSettings,
    guards_of,
    is_urdf,
    read_posture,
)
from armdrive.errors import ArmFileError
from armdrive.text.reading import read_text, read_toml
from armdrive.text.toml import (
    FORMAT_KEY,
    Problems,
    TomlTable,
    between,
    joint_range,
    named,
    number,
    require_format,
    setting,
    whole,
)
from kinematics.chains.arm import ChainArm
from kinematics.chains.assignment import JointAxis, ZeroPosition, assign_frames, tip_frame
from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.chains.urdf import MOST_CHARACTERS, read_urdf
from kinematics.errors import KinematicsError
from kinematics.frames.orientations import RPY
from kinematics.frames.transforms import Transform, compose, transform, translation
from kinematics.frames.vectors import unit
from kinematics.guards import Guards
from kinematics.presets import ArmModel, Reference
from kinematics.transmission import MotorSpec, Transmission

# No arm has more links; the time of computations grows with the square of their number.
MOST_LINKS = 100

# Keys of a file with a link table, and of one with joint axes.
_OF_LINKS, _OF_AXES = ("links", "base", "tool"), ("axes", "tip")


@dataclass(frozen=True, slots=True)
class Model:
    """A model as its file describes it; `source` says where its numbers come from.

    `verified` is False if the file says that they are not measured on an arm. `unused` says what a
    URDF holds and the chain does not, and `angles` how joint angles count, if that needs saying.
    `zero` holds the joint axes of a file that gives these instead of links.
    """

    name: str
    title: str
    source: str
    chain: Chain
    verified: bool = True
    unused: tuple[str, ...] = ()
    angles: str = ""
    zero: ZeroPosition | None = None


@dataclass(frozen=True, slots=True)
class Placement:
    """A frame in another: position in mm, turned by Rot(z, phi) Rot(y, theta) Rot(x, psi)."""

    x_mm: float = setting(0.0, "the origin, seen from the other frame")
    y_mm: float = setting(0.0, "along its y")
    z_mm: float = setting(0.0, "along its z")
    phi_deg: float = setting(0.0, "turned about z first")
    theta_deg: float = setting(0.0, "then about its own y")
    psi_deg: float = setting(0.0, "then about its own x")

    def frame(self) -> Transform:
        """Return the transform, exact at whole quarter turns."""
        angles = map(math.radians, (self.phi_deg, self.theta_deg, self.psi_deg))
        turned = RPY(*angles).rotation()
        clean = tuple(tuple(_clean(entry) for entry in row) for row in turned)
        return transform(clean, (self.x_mm, self.y_mm, self.z_mm))  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True)
class UrdfSettings(Placement):
    """Which part of a URDF is the arm, and where the hand's frame is in that of its last link."""

    base_link: str = setting("", "the link on the table; by default the one that no joint moves")
    tip_link: str = setting("", "the link that the hand's frame is in; by default the arm's end")
    height_mm: float = setting(0.0, "of the base link's origin above the table")


def read_model(path: str | Path) -> Model:
    """Read a model file. Raises `ArmFileError`, which names the file and the key."""
    problems = Problems()
    return problems.required(_described(Path(path), problems, UrdfSettings()))


def _described(place: Path, problems: Problems, settings: UrdfSettings) -> Model | None:
    """Read a model file, and note each of its problems with its path."""
    if is_urdf(place.name):
        return problems.attempt(lambda: _urdf_model(place, settings), None)
    document = problems.attempt(lambda: read_toml(place, "the model file", ArmFileError), None)
    if document is None:
        return None
    own = Problems()
    found = own.attempt(lambda: _model(TomlTable(document, "", own), place.stem), None)
    for sentence in own.found:
        problems.note(f"{place}: {sentence}")
    return found


def _urdf_model(place: Path, settings: UrdfSettings) -> Model:
    """Read the URDF of an arm. Raises `ArmFileError`, which names the file."""
    document = read_text(place, "the URDF", ArmFileError, most_bytes=MOST_CHARACTERS)
    try:
        found = read_urdf(document, base=settings.base_link, tip=settings.tip_link)
    except KinematicsError as error:
        raise ArmFileError(f"{place}: {error}") from None
    chain = replace(
        found.chain,
        base=compose(translation(0.0, 0.0, settings.height_mm), found.chain.base),
        tool=compose(found.chain.tool, settings.frame()),
    )
    source = f"{place.name}, from link {found.base} to link {found.tip}"
    return Model(found.name, found.name, source, chain, unused=found.unused)


def parse_model(document: Mapping[str, Any], *, name: str = "model") -> Model:
    """Return the model of a parsed file; `name` is used if it gives none.

    Raises `ArmFileError` for the first problem.
    """
    problems = Problems()
    return problems.required(_model(TomlTable(document, "", problems), name))


@dataclass(frozen=True, slots=True)
class ModelHead:
    """The keys at the top of a model file."""

    name: str | None = setting(None, "its name; by default that of the file")
    title: str | None = setting(None, "shown wherever the model is named")
    source: str = setting("", "where the numbers come from")
    verified: bool = setting(True, "whether they are measured; if not, Cartesian motion is refused")
    convention: str = setting(
        "standard", "of the link table", words=tuple(each.value for each in Convention)
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class JointRow:
    """The joint of a row of [[links]] or [[axes]]; without limits unless they are given."""

    joint: str = setting("", "the joint's name; by default joint_1, joint_2, ...")
    kind: str = setting(
        "revolute", "how the joint moves", words=tuple(kind.value for kind in JointKind)
    )
    low_deg: float | None = setting(None, "lowest value of the joint; without it, no limit")
    high_deg: float | None = setting(None, "highest value of the joint; without it, no limit")
    low_mm: float | None = setting(None, "the same of a prismatic joint")
    high_mm: float | None = setting(None, "the same of a prismatic joint")

    def own(self, key: str, where: str) -> float | None:
        """Return a value in the unit of the joint, None if it is left out.

        Raises `ArmFileError` for a value in the unit of the other kind of joint.
        """
        turns = self.kind == JointKind.REVOLUTE.value
        unit, other = ("deg", "mm") if turns else ("mm", "deg")
        if getattr(self, f"{key}_{other}") is not None:
            raise ArmFileError(f"{where}: a {self.kind} joint has {key}_{unit}, not {key}_{other}")
        value: float | None = getattr(self, f"{key}_{unit}")
        return math.radians(value) if turns and value is not None else value

    def bounds(self, where: str) -> tuple[float, float]:
        """Return the lowest and the highest value, infinite without limits."""
        low, high = self.own("low", where), self.own("high", where)
        return -math.inf if low is None else low, math.inf if high is None else high

    def name(self, number: int) -> str:
        """Return the joint's name, by default with its number."""
        return self.joint or f"joint_{number}"


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkRow(JointRow):
    """One of [[links]], from the base on; what is left out is zero."""

    theta_deg: float = setting(0.0, "angle about z with the joint at zero")
    d_mm: float = setting(0.0, "distance along z with the joint at zero")
    a_mm: float = setting(0.0, "length of the link")
    alpha_deg: float = setting(0.0, "twist of the link")
    offset_deg: float | None = setting(None, "how far the table's zero lies from the joint's own")
    offset_mm: float | None = setting(None, "the same of a prismatic joint")

    def link(self, where: str) -> DHLink:
        """Return the link. Raises `ArmFileError`, which names the row."""
        low, high = self.bounds(where)
        theta, alpha = map(math.radians, (self.theta_deg, self.alpha_deg))
        offset = self.own("offset", where) or 0.0
        with _at(where):
            return DHLink(
                theta, self.d_mm, self.a_mm, alpha, JointKind(self.kind), offset, low, high
            )


def _model(table: TomlTable, name: str) -> Model | None:
    """Read the whole file and note every problem; return None if they leave no model.

    Raises `ArmFileError` for a format of which nothing else can be judged.
    """
    document = table.entries
    require_format(document)
    head = table.section(ModelHead, elsewhere=(FORMAT_KEY, *_OF_LINKS, *_OF_AXES)) or ModelHead()
    called, convention = head.name or name, Convention(head.convention)
    model = partial(Model, called, head.title or called, head.source, verified=head.verified)
    if any(key in document for key in _OF_AXES):
        for key in _OF_LINKS:
            if key in document:
                table.problems.note(f"a model with [[axes]] has no {key}: its frames are found")
        zero = read_axes(table)
        if zero is None or table.problems.found:
            return None
        chain = table.problems.attempt(
            lambda: assign_frames(zero.axes, zero.tool, convention, called).chain, None
        )
        return None if chain is None else model(chain, zero=zero)
    chain = _chain_of_links(table, convention, called)
    return None if chain is None else model(chain)


def _chain_of_links(table: TomlTable, convention: Convention, called: str) -> Chain | None:
    """Return the chain of a file's link table, None if there are any problems."""
    problems, given = table.problems, table.entries.get("links", [])
    # no array at all is one problem, and not also that of an array that cannot be read
    if not isinstance(given, list) or not given:
        problems.note("a model needs at least one link, each written under [[links]]")
        given = []
    if len(given) > MOST_LINKS:
        problems.note(f"a model has at most {MOST_LINKS} links, not {len(given)}")
    base, tool = (table.table(key).section(Placement) for key in ("base", "tool"))
    links, names = [], []
    for place, row in enumerate(table.rows("links")[:MOST_LINKS] if given else [], 1):
        read = row.section(LinkRow)
        if read is not None:
            links.append(problems.attempt(partial(read.link, row.where), None))
            names.append(read.name(place))
    whole = tuple(link for link in links if link is not None)
    if problems.found:
        return None
    before, after = ((placed or Placement()).frame() for placed in (base, tool))
    return problems.attempt(
        lambda: Chain(whole, convention, before, after, called, tuple(names)), None
    )


def _clean(entry: float) -> float:
    """Return the entry of a rotation without the rounding of quarter turns."""
    whole = float(round(number(entry, "rotation")))
    # cos(90 degrees) is 6e-17: parallel axes would count as skew ones
    return whole if abs(entry - whole) < 1e-15 else entry


# A model file that gives joint axes instead of links: `[[axes]]` and `[tip]`.
#
# Each axis is a point and a direction in the world while every joint is at zero; the tip is the
# tool's point there. `assign_frames` finds the link table.


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisRow(JointRow):
    """One of [[axes]]: the axis of a joint, from the base on."""

    point_mm: tuple[float, float, float] = setting(means="any point of the axis, in the world")
    direction: tuple[float, float, float] = setting(
        means="along the axis, of any length; a joint turns right-handed"
    )

    def axis(self, where: str, number: int) -> JointAxis:
        """Return the joint's axis. Raises `ArmFileError`, which names the row."""
        bounds, name = self.bounds(where), self.name(number)
        with _at(f"{where}.direction"):
            direction = unit(self.direction)
        return JointAxis(self.point_mm, direction, JointKind(self.kind), name, *bounds)


@dataclass(frozen=True, slots=True)
class Tip:
    """The tool in the world: its point, and how its frame is turned."""

    point_mm: tuple[float, float, float] = setting(means="the tip of the tool, in the world")
    approach: tuple[float, float, float] | None = setting(
        None, "z of the tool; by default along the last axis"
    )
    normal: tuple[float, float, float] | None = setting(
        None, "x of the tool, at 90 degrees to the approach"
    )

    def frame(self, last: JointAxis) -> Transform:
        """Return the tool's frame in the world. Raises `ArmFileError`."""
        with _at("tip"):
            return tip_frame(last, self.point_mm, self.approach, self.normal)


def read_axes(table: TomlTable) -> ZeroPosition | None:
    """Return the arm that a model file describes by its axes, None if they cannot be read."""
    before = table.problems.count
    rows = table.rows("axes")
    if not rows and table.problems.count == before:
        table.problems.note("a model needs at least one axis, each written under [[axes]]")
    if len(rows) > MOST_LINKS:
        table.problems.note(f"a model has at most {MOST_LINKS} axes, not {len(rows)}")
        return None
    axes = [_axis(row, number) for number, row in enumerate(rows, 1)]
    tip = table.table("tip").section(Tip)
    if table.problems.count > before or tip is None:
        return None
    found = tuple(axis for axis in axes if axis is not None)
    frame = table.problems.attempt(lambda: tip.frame(found[-1]), None)
    return None if frame is None else ZeroPosition(found, frame)


def _axis(row: TomlTable, number: int) -> JointAxis | None:
    read = row.section(AxisRow)
    if read is None:
        return None
    return row.problems.attempt(lambda: read.axis(row.where, number), None)


@contextmanager
def _at(where: str) -> Iterator[None]:
    """Say where in the file something is wrong that kinematics refuses."""
    try:
        yield
    except KinematicsError as error:
        raise ArmFileError(f"{where}: {error}") from None


# An arm with a model file: its motors, speeds and fingers come from the arm file.
#
# There is no preset, so its keys are required here. Angles are in degrees in the file, and in rad
# in the model.

# The default guards of an arm without a preset.
TABLE_ALONE = Guards(inner_radius_mm=None, outer_radius_mm=None, hand_wrist_radius_mm=None)


# A placeholder for an arm without a gripper's motor; nothing is computed from it.
NO_FINGERS = FingerModel((0.0, 1.0), 1.0)


def model_of(table: TomlTable, folder: Path, gripper: GripperSettings) -> ArmModel | None:
    """Return the model that an arm file describes together with its model file, if it does."""
    place = folder / table.entries["model"]
    urdf = table.table("urdf").section(UrdfSettings) or UrdfSettings()
    described = _described(place, table.problems, urdf)
    if described is None:  # every key below is by joint
        return None
    names = described.chain.joint_names
    _check_kinds(described.chain)
    _check_names(names)
    # joints that slide or cannot be named end the reading: every key below is by joint
    before = table.problems.count
    limited = _limited(described.chain, table)
    speeds = table.by_name("speeds_deg_s", names, SPEED, all_since="")
    transmission = table.problems.attempt(lambda: _transmission(names, table), None)
    if table.problems.count > before or transmission is None:
        return None
    arm = ChainArm(limited)
    fingers = _fingers(table, transmission, gripper)
    reference = read_posture(table, "reference", arm.has_yaw)
    return ArmModel(
        key=described.name,
        title=described.title,
        arm=arm,
        transmission=transmission,
        joint_speeds_rad_s=tuple(math.radians(speeds[name]) for name in names),
        gripper_range_mm=fingers.range_mm,
        gripper_speed_mm_s=fingers.speed_mm_s,
        grip_steps_per_n=fingers.steps_per_n,
        reference=None if reference is None else Reference(reference),
        guards=guards_of(table.table("guards"), arm, TABLE_ALONE),
        verified=described.verified,
        notes=described.source,
        unused=described.unused,
    )


def _check_kinds(chain: Chain) -> None:
    """Refuse a sliding joint before its missing motor and speed are complained of."""
    for name, kind in zip(chain.joint_names, chain.kinds, strict=True):
        if kind is JointKind.PRISMATIC:
            raise ArmFileError(
                f"joint {name!r} slides: only arms whose joints turn are driven. If it belongs to "
                "the gripper, let the model end before it (in a URDF, by tip_link in [urdf])"
            )


def _check_names(names: tuple[str, ...]) -> None:
    """Refuse names that calls could not use, as `wrist_pitch_deg=10`, or that mean the gripper."""
    for name in names:
        if not name.isidentifier() or name in (OPENING, "gripper"):
            raise ArmFileError(
                f"a joint that is driven cannot be called {name!r}: give it another name in the "
                "model file, one word such as wrist_pitch"
            )


def _fingers(table: TomlTable, transmission: Transmission, gripper: GripperSettings) -> FingerModel:
    if transmission.has_gripper and "fingers" not in table.entries:
        table.problems.note(
            "a motor drives a gripper, so [fingers] is needed, for example range_mm = [0, 76] "
            "and speed_mm_s = 20"
        )
    if "fingers" not in table.entries:
        return NO_FINGERS
    if not transmission.has_gripper and not gripper.commanded:
        table.problems.note(
            "[fingers] stands there, but no motor has steps_per_mm to drive them, and gripper.kind "
            'is neither "servo" nor "output"'
        )
    return table.table("fingers").section(FingerModel) or NO_FINGERS


def _limited(chain: Chain, table: TomlTable) -> Chain:
    """Return the chain with the arm file's limits instead of the model file's."""
    bounds = table.by_name("limits_deg", chain.joint_names, joint_range)
    links = []
    for name, link in zip(chain.joint_names, chain.links, strict=True):
        if name in bounds:
            link = replace(link, low=bounds[name].low_rad, high=bounds[name].high_rad)
        elif link.kind is JointKind.REVOLUTE and not math.isfinite(link.high - link.low):
            table.problems.note(
                f"joint {name!r} has no limits in its model: give limits_deg.{name} = [low, high]"
            )
        links.append(link)
    return replace(chain, links=tuple(links))


def _transmission(joints: tuple[str, ...], table: TomlTable) -> Transmission | None:
    """Return the motors of an arm file, None if one of them cannot be read.

    Raises `KinematicsError` for motors that do not determine the joints.
    """
    problems = table.problems
    before = problems.count
    rows = table.rows("motors")[: len(joints) + 2]  # more of them are refused, not read
    slides = ["steps_per_mm" in row.entries for row in rows]
    if any(slides[:-1]):
        problems.note("the gripper's motor, the one with steps_per_mm, must be the last")
    seen = (*joints, OPENING) if slides and slides[-1] else joints
    names = [str(row.entries.get("name")) for row in rows]
    if len(set(names)) != len(names):
        problems.note(f"motors need different names, not {', '.join(names)}")
    specs = tuple(_motor(row, seen, names[:index]) for index, row in enumerate(rows))
    return None if problems.count > before else Transmission(specs, joints)


STEPS = between(0.1, MOST_STEPS, "directions are signs in sees")
# The keys of one of [[motors]]; its backlash is read by `read_backlash` (config/sections.py).
MOTOR_KEYS = ("name", "steps_per_turn", "steps_per_mm", "sees", "follows", TURNING, SLIDING)


def _motor(row: TomlTable, seen: tuple[str, ...], earlier: list[str]) -> MotorSpec:
    row.allow(MOTOR_KEYS)
    name = row.required("name", named)
    turn, slide = (row.value(key, STEPS, None) for key in ("steps_per_turn", "steps_per_mm"))
    # whether the key is there, not whether its value could be read: that is a problem by itself
    if ("steps_per_turn" in row.entries) == ("steps_per_mm" in row.entries):
        row.problems.note(
            f"motor {name!r} needs steps_per_turn, or steps_per_mm where it drives a gripper"
        )
    sees = row.by_name("sees", seen, number)
    if "sees" not in row.entries and "steps_per_mm" in row.entries:
        sees = {OPENING: 1.0}
    elif not row.entries.get("sees"):
        row.problems.note(
            f"motor {name!r} sees no joint: write for example sees = {{ {seen[0]} = 1 }}"
        )
    follows = row.by_name("follows", earlier, whole)
    return MotorSpec(
        str(name),
        slide or (turn or 0.0) / math.tau,
        tuple(sees.get(one, 0.0) for one in seen),
        follows=tuple((earlier.index(other), ratio) for other, ratio in follows.items()),
    )
