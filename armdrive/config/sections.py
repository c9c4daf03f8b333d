"""The sections of an arm file: wire, motion, gripper, fingers, postures, frames, homing, guards."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from types import MappingProxyType
from typing import Any

from armdrive.abilities import BITS_A_BYTE
from armdrive.errors import ArmFileError
from armdrive.moves import BASE_FRAME, TOOL_FRAME
from armdrive.tasks import HomeDevice
from armdrive.text.toml import (
    TomlTable,
    between,
    check_settings,
    joint_range,
    number,
    setting,
    text,
)
from kinematics.errors import KinematicsError
from kinematics.frames.user_frame import UserFrame
from kinematics.geometry import ArmGeometry
from kinematics.guards import AngleSum, Guards, link_names
from kinematics.guards.shapes import Box
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose
from kinematics.transmission import Transmission

# How the path of an arm's URDF ends; one that is still to be made is refused as it is read.
URDF_ENDINGS = (".urdf", ".xacro")

# How the path of a model file ends: a link table, or a URDF.
MODEL_ENDINGS = (".toml", *URDF_ENDINGS)


def is_model_file(word: str) -> bool:
    """Return whether a word names a model file rather than a built-in model."""
    return word.lower().endswith(MODEL_ENDINGS)


def is_urdf(word: str) -> bool:
    """Return whether a word names a URDF."""
    return word.lower().endswith(URDF_ENDINGS)


# Names of frames that every arm has (motion/frames.py).
RESERVED_FRAMES = (BASE_FRAME, TOOL_FRAME)


@dataclass(frozen=True, slots=True)
class Connection:
    """Which wire leads to the arm; ports are opened with DTR and RTS off unless it says other.

    `baud` is the dialect's own unless the file gives another. A board that is reset by opening
    its port is spared that from the second time on by `raise_dtr` and `keep_dtr_on_close`.
    `usb_serial` finds an adapter under whatever name its port has. With `reconnect` a lost wire is
    looked for until it is back; the arm then stands in error-stop.
    """

    dialect: str = setting(means="what the controller speaks")
    port: str = setting("", "/dev/ttyUSB0, COM3, socket://HOST:PORT, udp://HOST:PORT, can:...")
    baud: int = setting(9600, "the dialect's own unless it was changed", low=50, high=4_000_000)
    raise_dtr: bool = setting(False, "the port is opened with DTR and RTS off")
    keep_dtr_on_close: bool = setting(
        False, "with raise_dtr: later opens do not reset a board that resets on DTR"
    )
    usb_serial: str = setting("", "an adapter's serial number (armdrive ports): under any name")
    reconnect: bool = setting(False, "reconnect a lost connection; ends in error-stop")

    def __post_init__(self) -> None:
        check_settings(self, "connection")

    @property
    def byte_s(self) -> float:
        """How long a byte takes on a serial wire."""
        return BITS_A_BYTE / self.baud

    @property
    def names_port(self) -> bool:
        """Whether a port is named, by its own name or by its adapter's serial number."""
        return bool(self.port or self.usb_serial)

    @property
    def keeps_dtr(self) -> bool:
        """Whether later opens of the port do not reset a board that resets on DTR."""
        return self.raise_dtr and self.keep_dtr_on_close


# More frequent status requests would fill the wire.
_POLL_LEAST_S = 0.05


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """How the arm is moved.

    Bursts are the longest motions sent at once, which on a device that cannot abort are the
    stopping time; setting `planned_burst_s` accepts longer ones for planned motion, for good.
    Between bursts, a device that does not coordinate its motors keeps within `deviation_mm`. A
    held jog takes `jog_ramp_s` from rest to full speed, and no more than a burst where nothing is
    queued. `unreferenced_speed` caps jogging while the position is not known.
    """

    jog_burst_s: float = setting(
        0.15, "the longest motion sent at once while jogging: the stopping time", low=0.02, high=0.5
    )
    jog_ramp_s: float = setting(
        0.2, "a held jog takes this long from rest to full speed, or a burst", low=0.0, high=2.0
    )
    planned_burst_s: float = setting(
        0.15, "the same for planned motion; longer is smoother and stops later", low=0.02, high=10.0
    )
    line_tolerance_mm: float = setting(
        0.5, "how far the tip may leave a straight line", low=0.05, high=10.0
    )
    deviation_mm: float = setting(
        5.0, "the same of a controller that does not coordinate its motors", low=0.5, high=100.0
    )
    tip_speed_mm_s: float = setting(100.0, "Cartesian jogging at full speed", low=1.0, high=1000.0)
    unreferenced_speed: float = setting(
        0.25, "jogging is no faster than this while the position is unknown", low=0.01, high=1.0
    )
    idle_poll_s: float = setting(
        0.8, "how often a standing arm is polled; 0 is never", low=0.0, high=60.0
    )
    ramp_s: float = setting(
        0.0, "planned motion: the time to full speed (GRBL boards: 0.15)", low=0.0, high=10.0
    )
    jerk_s: float = setting(
        0.0, "and the time in which the acceleration builds up (GRBL: 0.05)", low=0.0, high=2.0
    )

    def __post_init__(self) -> None:
        check_settings(self, "motion")
        if 0.0 < self.idle_poll_s < _POLL_LEAST_S:
            raise ArmFileError(
                f"motion.idle_poll_s must be 0, or from {_POLL_LEAST_S:g} to 60, not "
                f"{self.idle_poll_s:g}"
            )


# The kind of a gripper that a digital output switches: it is open or closed.
OUTPUT = "output"

GRIPPER_KINDS = ("stepper", "servo", OUTPUT, "none")


@dataclass(frozen=True, slots=True)
class GripperSettings:
    """The gripper: `trip_force_n` is the force at which its switch closes (unverified).

    The fingers approach an object by `approach_steps` at a time. `kind` says what moves them: a
    stepper of the arm's own transmission, a servo or a digital output of its controller, or
    nothing.
    """

    kind: str = setting(
        "stepper", "what moves the fingers: stepper, servo, output or none", words=GRIPPER_KINDS
    )
    trip_force_n: float = setting(
        2.2, "unverified: the force at which the grip switch closes", low=0.0, high=100.0
    )
    max_force_n: float = setting(35.0, "a grasp is never firmer", low=0.0, high=200.0)
    approach_steps: int = setting(
        16, "motor steps of one closing burst while grasping", low=1, high=100
    )

    def __post_init__(self) -> None:
        check_settings(self, "gripper")
        if self.max_force_n < self.trip_force_n:
            raise ArmFileError(
                f"gripper.max_force_n must be from {self.trip_force_n:g} (gripper.trip_force_n) "
                f"to 200, not {self.max_force_n:g}"
            )

    @property
    def commanded(self) -> bool:
        """Whether the controller moves the fingers on command, and no motor of the arm does."""
        return self.kind in ("servo", OUTPUT)


@dataclass(frozen=True, slots=True)
class FingerModel:
    """The gripper that a motor drives: its range and speed, and steps per N once it touches."""

    range_mm: tuple[float, float] = setting(means="between the tips, closed and widest")
    speed_mm_s: float = setting(means="how fast they open", low=0.01, high=10_000.0)
    steps_per_n: float | None = setting(
        None, "closing steps for each newton; without it nothing is grasped", low=1e-3, high=1e6
    )

    def __post_init__(self) -> None:
        low, high = self.range_mm
        if low >= high:
            raise ArmFileError("fingers.range_mm: the first number must be below the second")


@dataclass(frozen=True, slots=True)
class PostureSettings:
    """A posture in mm and degrees."""

    x_mm: float = setting(means="the finger tips, forward from the base axis")
    y_mm: float = setting(means="to the left")
    z_mm: float = setting(means="above the table")
    pitch_deg: float = setting(means="of the hand; -90 points straight down")
    roll_deg: float = setting(0.0, "of the hand about its own axis")

    def pose(self) -> Pose:
        """Return the pose."""
        return Pose.of(**{each.name: getattr(self, each.name) for each in fields(self)})


@dataclass(frozen=True, slots=True)
class YawedPostureSettings(PostureSettings):
    """A posture of an arm with six joints, whose hand has a heading of its own."""

    yaw_deg: float = setting(0.0, "the hand's heading, of an arm of six joints")


# Without a park posture in its file an arm parks this far above its reference mark.
PARK_HEIGHT_MM = 30.0


@dataclass(frozen=True, slots=True)
class FrameSettings:
    """A frame of the user's own: its origin in the base frame, and its orientation.

    It is turned by yaw about z, then by pitch about its y, then by roll about its x.
    """

    x_mm: float = setting(0.0, "the origin, seen from the base")
    y_mm: float = setting(0.0, "to the left")
    z_mm: float = setting(0.0, "above the table")
    yaw_deg: float = setting(0.0, "turned about z first")
    pitch_deg: float = setting(0.0, "then about its own y")
    roll_deg: float = setting(0.0, "then about its own x")

    def frame(self) -> UserFrame:
        """Return the frame."""
        yaw, pitch, roll = map(math.radians, (self.yaw_deg, self.pitch_deg, self.roll_deg))
        return UserFrame.turned((self.x_mm, self.y_mm, self.z_mm), yaw, pitch, roll)


@dataclass(frozen=True, slots=True)
class HomingKeys:
    """The keys of [homing] without its joints; without `groups` the device has its own order."""

    opening_mm: float = setting(0.0, "how far open the fingers are after homing")
    groups: tuple[tuple[int, ...], ...] = setting(
        (), "motors by number, in the order in which they home"
    )


@dataclass(frozen=True, slots=True)
class HomingSettings:
    """The device's own homing: the joints where it ends, and the order of the motors.

    `groups` lists motor numbers from 1; without it the device homes all motors in its own order.
    """

    joints: Joints
    opening_mm: float = 0.0
    groups: tuple[tuple[int, ...], ...] = ()

    def requests(self) -> list[HomeDevice]:
        """Return what is asked of the device, one request after the other."""
        groups = (tuple(motor - 1 for motor in group) for group in self.groups)
        return [HomeDevice((group,)) for group in groups] or [HomeDevice()]


def read_frames(table: TomlTable) -> Mapping[str, UserFrame]:
    """Read the frames of an arm file; a reserved name is a problem."""
    found = {}
    for name in table.entries:
        if name in RESERVED_FRAMES or not name.isidentifier():
            table.problems.note(
                f"frames.{name}: a frame's name is one word of letters and digits, and neither "
                f"{' nor '.join(RESERVED_FRAMES)}"
            )
        elif (settings := table.table(name).section(FrameSettings)) is not None:
            found[name] = settings.frame()
    return MappingProxyType(found)


def read_posture(table: TomlTable, key: str, has_yaw: bool) -> Pose | None:
    """Read a posture of an arm file; None if it is missing or wrong."""
    if key not in table.entries:
        return None
    kind = YawedPostureSettings if has_yaw else PostureSettings
    settings = table.table(key).section(kind)
    return None if settings is None else table.problems.attempt(settings.pose, None)


def read_accelerations(table: TomlTable, names: tuple[str, ...]) -> tuple[float | None, ...]:
    """Return the accelerations of the file, None for a joint that it leaves out."""
    found = table.by_name("accelerations_deg_s2", names, between(0.1, 1e6))
    each = (math.radians(found[name]) if name in found else None for name in names)
    return tuple(each) if found else ()


def read_homing(table: TomlTable, model: ArmModel) -> HomingSettings | None:
    """Read the section of the device's own homing; None if joints are missing."""
    given = table.section(HomingKeys, elsewhere=["joints_deg"]) or HomingKeys()
    names = model.arm.joint_names
    why = ": where every joint stands once the device has homed"
    angles = table.by_name("joints_deg", names, number, all_since=why)
    motors = len(model.transmission.motors) if model.transmission is not None else 0
    if given.groups and (wrong := wrong_homing_order(given.groups, motors, len(names))):
        table.problems.note(f"homing.groups: {wrong}")
    if len(angles) < len(names):
        return None
    turned = tuple(math.radians(angles[name]) for name in names)
    return HomingSettings(Joints(turned, names), given.opening_mm, given.groups)


def wrong_homing_order(groups: Sequence[Sequence[int]], motors: int, joints: int) -> str:
    """Return what is wrong with the order in which motors home; empty if nothing is.

    Each motor that turns a joint homes once: otherwise the arm would count as referenced with a
    joint that sought no switch. The gripper's motor, the last one, may be left out.
    """
    listed = [motor for group in groups for motor in group]
    if not all(groups) or not set(listed) <= set(range(1, motors + 1)):
        return (
            f"list motors by number, 1 to {motors}, in the order in which they home, for example "
            "[[3], [2], [1, 4, 5]]"
        )
    if len(set(listed)) < len(listed):
        return "a motor is listed twice"
    left_out = sorted(set(range(1, joints + 1)) - set(listed))
    if left_out:
        numbers = ", ".join(map(str, left_out))
        return f"list every motor that turns a joint: {numbers} would seek no switch"
    return ""


# Backlash in whole motor steps: how far a motor turns after a reversal before the arm follows.

# The coordinate of a gripper's motor, in addition to the joints.
OPENING = "opening"

# The keys, of an arm file or of one of its [[motors]]; the second of a gripper's motor.
TURNING, SLIDING = "backlash_deg", "backlash_mm"

# More backlash is a loose screw, which arithmetic cannot compensate.
WIDTHS = {TURNING: between(0.0, 10.0), SLIDING: between(0.0, 5.0)}


def read_backlash(table: TomlTable, transmission: Transmission | None) -> tuple[int, ...]:
    """Return the steps of each motor; empty if no motor has any.

    Arms with [[motors]] state them there, others by the motors' names and at the top.
    """
    if transmission is None:
        return ()
    names = [motor.name for motor in transmission.motors]
    rows = {str(row.entries.get("name")): row for row in table.rows("motors")}
    turning = table.by_name(TURNING, names[: len(transmission.joint_names)], WIDTHS[TURNING])
    if SLIDING in table.entries and not transmission.has_gripper:
        table.problems.note(f"{SLIDING} is of a gripper's motor, and this arm has none")
    widths = []
    for index, name in enumerate(names):
        key = _key(transmission, index)
        size = turning.get(name, 0.0)
        if name in rows:
            size = rows[name].value(key, WIDTHS[key], 0.0)
        elif key == SLIDING:
            size = table.value(key, WIDTHS[key], 0.0)
        # not round(), which takes a half to the even number: 0.5 and 1.5 steps are 1 and 2
        widths.append(math.floor(_steps_per_unit(transmission, index) * size + 0.5))
    for name, row in rows.items():
        right = _key(transmission, names.index(name)) if name in names else "none: it moves nothing"
        for key in WIDTHS:
            if key in row.entries and key != right:
                row.problems.note(f"{row.at(key)}: the backlash of motor {name!r} is {right}")
    return tuple(widths) if any(widths) else ()


def backlash_keys(
    widths: tuple[int, ...], transmission: Transmission | None
) -> Iterator[tuple[str, str, float]]:
    """Yield motor, key and value for each motor with backlash, as a file has to state them."""
    for index, width in enumerate(widths):
        if transmission is not None and width:
            name = transmission.motors[index].name
            size = width / _steps_per_unit(transmission, index)
            yield name, _key(transmission, index), round(size, 9)


def _key(transmission: Transmission, motor: int) -> str:
    return TURNING if motor < len(transmission.joint_names) else SLIDING


def _steps_per_unit(transmission: Transmission, motor: int) -> float:
    """Return the steps of a degree, or of a mm."""
    scale = math.pi / 180.0 if _key(transmission, motor) == TURNING else 1.0
    return abs(transmission.motors[motor].steps_per_unit) * scale


def _mm(means: str, low: float = 0.0) -> Any:
    """Declare a length; one that is left out is that of the arm's model."""
    return setting(None, means, low=low, high=5000.0)


@dataclass(frozen=True, slots=True)
class GuardSettings:
    """The keys of [guards] without its arrays; a key that is left out keeps the model's guard."""

    tolerance_mm: float | None = setting(
        None, "how far below the table rounding may put the tip", low=0.0, high=50.0
    )
    inner_radius_mm: float | None = _mm("the tip keeps this far from the base axis ...")
    inner_height_mm: float | None = _mm("... while it is lower than this", -5000.0)
    outer_radius_mm: float | None = _mm("the tip goes no further out")
    hand_wrist_radius_mm: float | None = _mm(
        "a hand pointing backwards keeps its wrist this far away ..."
    )
    hand_tip_radius_mm: float | None = _mm("... while its tip is nearer than this")
    hand_height_mm: float | None = _mm("... and lower than this", -5000.0)
    base_radius_mm: float | None = _mm("the links keep out of a column this thick ...")
    base_top_mm: float | None = _mm("... up to this height", -5000.0)
    radii_mm: tuple[float, ...] | None = setting(
        None, "how thick each link is, from the upper arm to the hand", low=0.0, high=1000.0
    )


# The arrays of tables in [guards].
ARRAYS = ("boxes", "sums")


def guards_of(table: TomlTable, arm: ArmGeometry, known: Guards) -> Guards:
    """Return the known guards of an arm with the file's corrections."""
    before = table.problems.count
    given = table.section(GuardSettings, elsewhere=ARRAYS) or GuardSettings()
    changed: dict[str, Any] = {
        each.name: value
        for each in fields(given)
        if (value := getattr(given, each.name)) is not None
    }
    if "boxes" in table.entries:
        boxes = [row.section(Box) for row in table.rows("boxes")]
        changed["boxes"] = tuple(box for box in boxes if box is not None)
        _require_different(table, "keep-out boxes", [box.name for box in changed["boxes"]])
    if "sums" in table.entries:
        changed["sums"] = tuple(_sums(table, arm.joint_names))
        _require_different(table, "sums of joints", [one.name for one in changed["sums"]])
    # what does not fit the arm may only follow from what could not be read
    if table.problems.count > before:
        return known
    found = replace(known, **changed)
    return table.problems.attempt(lambda: _fitting(found, arm), known)


def guard_table(
    guards: Guards, degrees: Callable[[float], float] = math.degrees
) -> dict[str, object]:
    """Return the keys and values of these guards as a file states them."""
    known = {each.name: getattr(guards, each.name) for each in fields(GuardSettings)}
    known["boxes"] = [asdict(box) for box in guards.boxes]
    known["sums"] = [
        {
            "name": one.name,
            "joints": dict(one.shares),
            "range_deg": [degrees(one.low_rad), degrees(one.high_rad)],
        }
        for one in guards.sums
    ]
    return {key: value for key, value in known.items() if value not in (None, (), [])}


def _require_different(table: TomlTable, what: str, names: list[str]) -> None:
    if len(set(names)) != len(names):
        table.problems.note(f"{what} need different names, not {', '.join(names)}")


def _fitting(guards: Guards, arm: ArmGeometry) -> Guards:
    """Return the guards. Raises if the links' thickness is missing or does not fit the arm."""
    names = link_names(arm)
    if not guards.radii_mm and (guards.boxes or guards.base_radius_mm is not None):
        example = ", ".join("30" for _ in names)
        raise ArmFileError(
            "boxes and base_radius_mm need to know how thick the links are: under [guards] give "
            f"radii_mm = [{example}] for {', '.join(names)}; 0 for a line of no thickness"
        )
    try:
        guards.over(arm)
    except KinematicsError as error:
        raise ArmFileError(f"guards.radii_mm: {error}") from None
    return guards


def _sums(table: TomlTable, joints: tuple[str, ...]) -> Iterator[AngleSum]:
    for row in table.rows("sums"):
        row.allow(["name", "joints", "range_deg"])
        shares = row.by_name("joints", joints, number)
        if not any(shares.values()):
            row.problems.note(
                f"{row.where} needs joints, for example joints = {{ {joints[1]} = 1 }}"
            )
        name = row.value("name", text, " + ".join(shares))
        bounds = row.required("range_deg", joint_range)
        if bounds is not None:
            yield AngleSum(name, tuple(shares.items()), bounds.low_rad, bounds.high_rad)
