"""The three spaces of an arm as three types: task (`Pose`), joint (`Joints`), motor (`Motors`).

Units: mm, rad and whole motor steps. Degrees appear only in `Pose.of`, `Joints.of` and the
properties named `_deg`, which are edges where a person reads or types.
"""

from __future__ import annotations

import dataclasses
import math
import operator
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, SupportsIndex, TypedDict, Unpack

from kinematics.errors import (
    BadNumber,
    KinematicsError,
    check_fields,
    finite,
    hand_angle,
    require,
    suggestion,
)
from kinematics.text import counted, deg_text, mm_text, shown_name, tenths

# The endings of a joint's name that state the unit of its angle.
_UNITS = ("deg", "rad")

# Joints of the Mini-mover's build, from the table to the hand.
JOINT_NAMES = ("base", "shoulder", "elbow", "wrist_pitch", "wrist_roll")

# What an error shows if something else is given.
POSE_EXAMPLE = "Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90)"
JOINTS_EXAMPLE = "Joints.of(0, 40, -60, -70, 0)"

# Six rows, one column a joint: the tip's velocity (mm per rad or mm of the joint) along the
# world's x, y and z, then its rate of turning (rad per rad or mm) about them.
Jacobian = tuple[tuple[float, ...], ...]


class Coordinates(TypedDict, total=False):
    """The coordinates of a pose as `Pose.of` and `Pose.replace` name them."""

    x_mm: float
    y_mm: float
    z_mm: float
    pitch_deg: float
    roll_deg: float
    yaw_deg: float


# The names of a pose's coordinates with their units, in order; most arms have no yaw.
COORDINATES = tuple(Coordinates.__annotations__)

# The same by their names without units, as a person types them: x, y, z, pitch, roll, yaw.
POSE_FIELDS: Mapping[str, str] = MappingProxyType(
    {key.partition("_")[0]: key for key in COORDINATES}
)


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the finger tips are, in mm, and how the hand points: a pitch of -pi/2 is straight down.

    x, y, z in mm from the point of the table under the base axis, z up. Pitch is the elevation
    of the hand above the horizontal, seen in the vertical plane through the base axis and the
    tip, outwards: -pi/2 points at the table. Roll is about the hand's own axis, in the hand's
    frame. Raises `BadNumber` for anything that is not a finite number, and for an angle of more
    than two turns: -90 is meant in degrees.

    `yaw_rad` is None except for an arm of six joints, which points its hand where it likes: its
    pitch is the elevation of the hand, and its yaw the direction, about the vertical and counted
    from x, of the vertical plane that the hand lies in.
    """

    x_mm: float
    y_mm: float
    z_mm: float
    pitch_rad: float
    roll_rad: float = 0.0
    yaw_rad: float | None = None

    def __post_init__(self) -> None:
        check_fields(self, finite, *_LENGTHS)
        check_fields(self, hand_angle, *_ANGLES)
        if self.yaw_rad is not None:
            check_fields(self, hand_angle, "yaw_rad")

    @classmethod
    def of(
        cls,
        *,
        x_mm: float,
        y_mm: float,
        z_mm: float,
        pitch_deg: float,
        roll_deg: float = 0.0,
        yaw_deg: float | None = None,
    ) -> Pose:
        """Make a pose from mm and degrees."""
        return cls(
            x_mm,
            y_mm,
            z_mm,
            hand_angle("pitch_deg", pitch_deg),
            hand_angle("roll_deg", roll_deg),
            None if yaw_deg is None else hand_angle("yaw_deg", yaw_deg),
        )

    def replace(self, **coordinates: Unpack[Coordinates]) -> Pose:
        """Return this pose with the named coordinates at new values: `pose.replace(z_mm=80)`.

        Raises `KinematicsError` for an unknown coordinate, and `BadNumber`.
        """
        new: dict[str, Any] = {}
        for name, value in coordinates.items():
            if name not in COORDINATES:
                known = ", ".join(COORDINATES)
                hint = suggestion(name, COORDINATES)
                raise KinematicsError(f"no coordinate is named {name!r}; a pose has {known}{hint}")
            axis, _, unit = name.rpartition("_")
            new[f"{axis}_rad" if unit == "deg" else name] = (
                hand_angle(name, value) if unit == "deg" else value
            )
        return dataclasses.replace(self, **new)

    @property
    def position_mm(self) -> tuple[float, float, float]:
        """The finger tips' x, y and z."""
        return self.x_mm, self.y_mm, self.z_mm

    @property
    def pitch_deg(self) -> float:
        """Pitch in degrees, for people."""
        return math.degrees(self.pitch_rad)

    @property
    def roll_deg(self) -> float:
        """Roll in degrees, for people."""
        return math.degrees(self.roll_rad)

    @property
    def yaw_deg(self) -> float | None:
        """Yaw in degrees, for people; None where the arm has none."""
        return None if self.yaw_rad is None else math.degrees(self.yaw_rad)

    def __repr__(self) -> str:  # a pose without yaw as ever: remembered positions depend on it
        given = [f"{name}={getattr(self, name)!r}" for name in _COORDINATES]
        given += [] if self.yaw_rad is None else [f"yaw_rad={self.yaw_rad!r}"]
        return f"Pose({', '.join(given)})"

    def __str__(self) -> str:
        yaw_deg = self.yaw_deg
        yaw = "" if yaw_deg is None else f", yaw {deg_text(yaw_deg)}"
        return (
            f"x {tenths(self.x_mm)}, y {tenths(self.y_mm)}, z {mm_text(self.z_mm)}, "
            f"pitch {deg_text(self.pitch_deg)}, roll {deg_text(self.roll_deg)}{yaw}"
        )


_LENGTHS = ("x_mm", "y_mm", "z_mm")
_ANGLES = ("pitch_rad", "roll_rad")
# The coordinates of every pose; some arms add a yaw.
_COORDINATES = (*_LENGTHS, *_ANGLES)


NO_YAW = "this arm has five joints: it cannot take a yaw, which follows from the position"


def refuse_yaw(pose: Pose) -> None:
    """Raise `KinematicsError` for a pose with a yaw, which no arm of five joints can take."""
    if pose.yaw_rad is not None:
        raise KinematicsError(NO_YAW)


@dataclass(frozen=True, slots=True)
class Joints:
    """Joint angles: `joints.base_deg`, `joints["base"]` in rad; in the order of the arm's `names`.

    They are relative. Of the Mini-mover's build: base; shoulder, the elevation of the upper arm, up
    positive; elbow, forearm elevation minus upper-arm elevation; wrist pitch, hand elevation minus
    forearm elevation; wrist roll. Iterates over the angles in rad. An attribute, an index and
    `replace` take the name of any joint of the arm, with its unit; `joints["base"]` is in rad.
    """

    angles_rad: tuple[float, ...]
    names: tuple[str, ...] = JOINT_NAMES

    if TYPE_CHECKING:  # the usual joints; `__getattr__` gives these and any other joint's
        base_deg: ClassVar[float]
        shoulder_deg: ClassVar[float]
        elbow_deg: ClassVar[float]
        forearm_roll_deg: ClassVar[float]
        wrist_pitch_deg: ClassVar[float]
        wrist_roll_deg: ClassVar[float]
        base_rad: ClassVar[float]
        shoulder_rad: ClassVar[float]
        elbow_rad: ClassVar[float]
        forearm_roll_rad: ClassVar[float]
        wrist_pitch_rad: ClassVar[float]
        wrist_roll_rad: ClassVar[float]

    def __post_init__(self) -> None:
        if type(self.angles_rad) is not tuple:
            try:
                object.__setattr__(self, "angles_rad", tuple(self.angles_rad))
            except TypeError:
                raise KinematicsError(
                    f"joint angles are a list of numbers, not {self.angles_rad!r}"
                ) from None
        if len(self.angles_rad) != len(self.names):
            raise KinematicsError(
                f"{counted(len(self.names), 'joint angle is', 'joint angles are')} needed "
                f"({', '.join(self.names)}), not {len(self.angles_rad)}"
            )
        if not all(type(angle) is float and angle - angle == 0.0 for angle in self.angles_rad):
            named = zip(self.names, self.angles_rad, strict=True)
            angles = tuple(finite(f"{name}_rad", angle) for name, angle in named)
            object.__setattr__(self, "angles_rad", angles)

    @classmethod
    def of(cls, *angles_deg: float, names: tuple[str, ...] = JOINT_NAMES) -> Joints:
        """Make joint angles from degrees, in the order of the joints."""
        named = ((f"angles_deg[{index}]", angle) for index, angle in enumerate(angles_deg))
        return cls(tuple(math.radians(finite(name, angle)) for name, angle in named), names)

    @property
    def deg(self) -> dict[str, float]:
        """Angles in degrees by joint name, for people."""
        return {
            name: math.degrees(angle)
            for name, angle in zip(self.names, self.angles_rad, strict=True)
        }

    def replace(self, **angles: float) -> Joints:
        """Return these joints with the named ones at new angles.

        `base=` and `base_rad=` are in rad, `base_deg=` is in degrees. Raises `KinematicsError` for
        an unknown joint, and `BadNumber`.
        """
        new = list(self.angles_rad)
        for name, angle in angles.items():
            index, unit = self._named(name)
            new[index] = math.radians(finite(name, angle)) if unit == "deg" else angle
        return Joints(tuple(new), self.names)

    def __iter__(self) -> Iterator[float]:
        return iter(self.angles_rad)

    def __len__(self) -> int:
        return len(self.angles_rad)

    def __getitem__(self, joint: int | str) -> float:
        if not isinstance(joint, str):
            return self.angles_rad[joint]
        index, unit = self._named(joint)
        return math.degrees(self.angles_rad[index]) if unit == "deg" else self.angles_rad[index]

    if not TYPE_CHECKING:  # else a type checker would take any name for an attribute

        def __getattr__(self, name: str) -> float:
            """Return a joint's angle: `base_deg`, `turret_rad`. Raises `AttributeError`."""
            joint, _, unit = name.rpartition("_")
            if unit in _UNITS and joint in self.names:
                return self[name]
            hint = suggestion(name, self._with_units) if joint else ""
            raise AttributeError(f"Joints has no attribute {name!r}{hint}", name=name, obj=self)

    def __dir__(self) -> list[str]:
        return [*object.__dir__(self), *self._with_units]

    @property
    def _with_units(self) -> tuple[str, ...]:
        return tuple(f"{name}_{unit}" for name in self.names for unit in _UNITS)

    def _named(self, name: str) -> tuple[int, str]:
        """Return the index of the joint that a name means, and the unit of its angle."""
        joint, _, unit = (name, "", "rad") if name in self.names else name.rpartition("_")
        if joint in self.names and unit in _UNITS:
            return self.names.index(joint), unit
        raise KinematicsError(
            f"no joint is named {name!r}; this arm has {', '.join(self.names)}"
            f"{suggestion(name, (*self.names, *self._with_units))}"
        )

    def __str__(self) -> str:
        return ", ".join(
            f"{shown_name(name)} {deg_text(angle)}" for name, angle in self.deg.items()
        )


def angles_of(joints: Joints, names: tuple[str, ...]) -> tuple[float, ...]:
    """Return the angles of an arm's joints, in rad. Raises `KinematicsError` for other joints.

    The same joints in another order are others: formulas know them by their place.
    """
    require("joints", joints, Joints, JOINTS_EXAMPLE)
    if joints.names == names:
        return joints.angles_rad
    if len(joints) != len(names):
        raise KinematicsError(f"this arm has {counted(len(names), 'joint')}, not {len(joints)}")
    raise KinematicsError(
        f"the joints of this arm are {', '.join(names)}, in this order, not "
        f"{', '.join(joints.names)}"
    )


def _whole(motor: int, count: SupportsIndex) -> int:
    """Return a count of steps as Python's int, also one of numpy's."""
    name = f"motor {motor} steps"
    finite(name, count)
    try:
        return operator.index(count)
    except TypeError:
        raise BadNumber(name, count, "must be a whole number") from None


class Motors(tuple[int, ...]):
    """Whole motor steps, one a motor: an absolute position, or the difference of two.

    `a - b` is the relative move from b to a; `a + d` is where that move ends.
    """

    __slots__ = ()

    def __new__(cls, steps: Iterable[int] = ()) -> Motors:
        """Make motor steps; raises `BadNumber` for anything but whole numbers."""
        made = super().__new__(cls, steps)
        for count in made:
            if type(count) is not int:
                return super().__new__(cls, [_whole(*motor) for motor in enumerate(made, 1)])
        return made

    def __sub__(self, other: Motors) -> Motors:
        return Motors._of(other, [a - b for a, b in zip(self, other, strict=True)])

    def __add__(self, other: tuple[int, ...]) -> Motors:  # type: ignore[override]
        return Motors._of(other, [a + b for a, b in zip(self, other, strict=True)])

    @classmethod
    def _of(cls, other: tuple[int, ...], steps: list[int]) -> Motors:
        """Return sums with `other`: they are whole if it is, so that nothing has to be checked."""
        return tuple.__new__(cls, steps) if type(other) is cls else cls(steps)

    @property
    def largest(self) -> int:
        """The largest count of any motor, without its sign; 0 where nothing moves."""
        return max((abs(count) for count in self), default=0)
