"""The sections of an arm file as values: its wire, motion, gripper, frames, homing and parking."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from armdrive.errors import ArmFileError
from armdrive.text.toml import number, read_section, refuse_unknown, require_table, within
from kinematics.frames.user_frame import UserFrame
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose

RESERVED_FRAMES = ("base", "tool")
"""Names of frames that every arm has (motion/resolve.py)."""


@dataclass(frozen=True, slots=True)
class Connection:
    """Which wire leads to the arm; ports are opened with DTR and RTS off unless it says other.

    `baud` is the dialect's own unless the file gives another. A board that is reset by opening
    its port is spared that from the second time on by `raise_dtr` and `keep_dtr_on_close`.
    `usb_serial` finds an adapter under whatever name its port has. With `reconnect` a lost wire is
    looked for until it is back; the arm then stands in error-stop.
    """

    dialect: str
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
    Between bursts, a device that does not coordinate its motors keeps within `straying_mm`. A
    held jog takes `jog_ramp_s` from rest to full speed, and no more than a burst where nothing is
    queued. `unreferenced_speed` caps jogging while the position is not known.
    """

    jog_burst_s: float = 0.15
    jog_ramp_s: float = 0.2
    planned_burst_s: float = 0.15
    line_tolerance_mm: float = 0.5
    straying_mm: float = 5.0
    tip_speed_mm_s: float = 100.0
    unreferenced_speed: float = 0.25
    idle_poll_s: float = 0.8
    ramp_s: float = 0.0
    jerk_s: float = 0.0

    def __post_init__(self) -> None:
        for name, (low, high) in _MOTION_BOUNDS.items():
            within(f"motion.{name}", getattr(self, name), low, high)
        if self.idle_poll_s != 0.0:  # 0 is never; a look takes its time on the wire
            within("motion.idle_poll_s", self.idle_poll_s, 0.05, _MOTION_BOUNDS["idle_poll_s"][1])


_MOTION_BOUNDS = {
    "jog_burst_s": (0.02, 0.5),
    "jog_ramp_s": (0.0, 2.0),
    "planned_burst_s": (0.02, 10.0),
    "line_tolerance_mm": (0.05, 10.0),
    "straying_mm": (0.5, 100.0),
    "tip_speed_mm_s": (1.0, 1000.0),
    "unreferenced_speed": (0.01, 1.0),
    "idle_poll_s": (0.0, 60.0),
    "ramp_s": (0.0, 10.0),
    "jerk_s": (0.0, 2.0),
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
class FrameSettings:
    """A frame of the user's own, as the base sees it: its origin, and how it is turned.

    By yaw about z, then by pitch about its y, then by roll about its x.
    """

    x_mm: float = 0.0
    y_mm: float = 0.0
    z_mm: float = 0.0
    yaw_deg: float = 0.0
    pitch_deg: float = 0.0
    roll_deg: float = 0.0

    def frame(self) -> UserFrame:
        """Return it as a frame."""
        yaw, pitch, roll = map(math.radians, (self.yaw_deg, self.pitch_deg, self.roll_deg))
        return UserFrame.turned((self.x_mm, self.y_mm, self.z_mm), yaw, pitch, roll)


@dataclass(frozen=True, slots=True)
class HomingSettings:
    """The device's own homing: the joints where it ends, and which motors home after which.

    `groups` lists motor numbers from 1; without it the device homes all of them by its own order.
    """

    joints: Joints
    opening_mm: float = 0.0
    groups: tuple[tuple[int, ...], ...] = ()


def read_frames(table: object) -> Mapping[str, UserFrame]:
    """Read the frames of an arm file. Raises `ArmFileError` for a name that means another."""
    rows = require_table(table, "frames")
    for name in rows:
        if name in RESERVED_FRAMES or not name.isidentifier():
            raise ArmFileError(
                f"frames.{name}: a frame's name is one word of letters and digits, and neither "
                f"{' nor '.join(RESERVED_FRAMES)}"
            )
    return MappingProxyType(
        {
            name: read_section(FrameSettings, row, f"frames.{name}").frame()
            for name, row in rows.items()
        }
    )


def read_posture(table: object, where: str, has_yaw: bool) -> Pose:
    """Read a posture of an arm file."""
    kind = YawedPostureSettings if has_yaw else PostureSettings
    return read_section(kind, table, where).pose()


# Tables of an arm file that are read joint by joint or motor by motor: homing, accelerations.


def read_accelerations(
    table: Mapping[str, Any], names: tuple[str, ...]
) -> tuple[float | None, ...]:
    """Return the accelerations that the file gives, None for a joint that it says nothing of."""
    where = "accelerations_deg_s2"
    entries = require_table(table.get(where, {}), where)
    refuse_unknown(entries, list(names), where)
    for name, value in entries.items():
        within(f"{where}.{name}", number(value, f"{where}.{name}"), 0.1, 1e6)
    given = (entries.get(name) for name in names)
    found = tuple(None if value is None else math.radians(value) for value in given)
    return found if entries else ()


def read_homing(table: object, model: ArmModel) -> HomingSettings:
    """Return the device's own homing: where every joint stands afterwards, and the order."""
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
