"""Arms of the Mini-mover's build as data: lengths, limits, speeds, transmission, guards.

Units: mm, rad, motor half-steps, N. Where sources disagree, the value here is a default that an
arm file or a calibration overrides.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from kinematics.errors import UnknownPreset
from kinematics.five_axis import FiveAxisArm
from kinematics.geometry import ArmGeometry
from kinematics.guards import Guards
from kinematics.limits import JointRange
from kinematics.spaces import Pose
from kinematics.transmission import MotorSpec, Transmission

POUND_FORCE_N = 4.448
MM_PER_INCH = 25.4


@dataclass(frozen=True, slots=True)
class Reference:
    """The posture from which an arm without switches counts its steps."""

    pose: Pose
    opening_mm: float = 0.0


@dataclass(frozen=True, slots=True)
class ArmModel:
    """What is known of one kind of arm before a particular one has been measured.

    `transmission` and `reference` are None if nothing is published. Joint speeds are in the order
    of the joints, at full load. `grip_steps_per_n` is how many steps of closing
    add one newton once the fingers touch. `verified` says that programs which drive this arm
    publish the numbers; if it is False, the preset is a template, and Cartesian motion is refused
    until the owner has filled in the numbers. `notes` gives the sources, and `unused` what a
    description of the arm holds and this model does not.
    """

    key: str
    title: str
    arm: ArmGeometry
    transmission: Transmission | None
    joint_speeds_rad_s: tuple[float, ...]
    gripper_range_mm: tuple[float, float]
    gripper_speed_mm_s: float
    grip_steps_per_n: float | None
    reference: Reference | None
    guards: Guards
    verified: bool
    notes: str
    unused: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ArmPreset(ArmModel):
    """A preset model of an arm of the Mini-mover's build."""

    arm: FiveAxisArm


def cable_transmission(
    base: float, shoulder: float, elbow: float, wrist: float, gripper: float
) -> Transmission:
    """Return the Mini-mover's cable mechanics for these steps per rad (gripper: per mm).

    Each motor sees absolute link angles: shoulder forward and elbow down are positive, the two
    wrist motors share pitch and roll as sum and difference, and the gripper's motor follows the
    elbow's step for step.
    """
    return Transmission(
        (
            MotorSpec("base", base, (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
            MotorSpec("shoulder", shoulder, (0.0, -1.0, 0.0, 0.0, 0.0, 0.0)),
            MotorSpec("elbow", elbow, (0.0, -1.0, -1.0, 0.0, 0.0, 0.0)),
            MotorSpec("right wrist", wrist, (0.0, -1.0, -1.0, -1.0, -1.0, 0.0)),
            MotorSpec("left wrist", wrist, (0.0, -1.0, -1.0, -1.0, 1.0, 0.0)),
            MotorSpec("gripper", gripper, (0.0, 0.0, 0.0, 0.0, 0.0, 1.0), follows=((2, 1),)),
        )
    )


def _left_wrist_first(transmission: Transmission) -> Transmission:
    """Return the same mechanics with the two wrist motors swapped."""
    base, shoulder, elbow, right, left, gripper = transmission.motors
    return Transmission((base, shoulder, elbow, left, right, gripper), transmission.joint_names)


_LIMITS = (
    JointRange.of(-90, 90),
    JointRange.of(-35, 144),
    JointRange.of(-149, 0),
    JointRange.of(-90, 90),
    JointRange.of(-360, 360),
)
_FULL_LOAD = (0.37, 0.15, 0.23, 1.31, 1.31)
_OPENING = (0.0, 76.0)
_GRIPPER_SPEED = 20.0
_GRIP_STEPS_PER_N = 32.0 / POUND_FORCE_N
_HALF_STEPS = cable_transmission(
    base=7072 / math.tau,
    shoulder=7072 / math.tau,
    elbow=4158 / math.tau,
    wrist=1536 / math.tau,
    gripper=371 / MM_PER_INCH,
)
_ON_THE_TABLE = Reference(Pose.of(x_mm=127.0, y_mm=0.0, z_mm=0.0, pitch_deg=-90.0))

_TEACHMOVER = ArmPreset(
    key="teachmover",
    title="Microbot TeachMover",
    arm=FiveAxisArm(193.7, 177.8, 177.8, 96.5, _LIMITS),
    transmission=_HALF_STEPS,
    joint_speeds_rad_s=_FULL_LOAD,
    gripper_range_mm=_OPENING,
    gripper_speed_mm_s=_GRIPPER_SPEED,
    grip_steps_per_n=_GRIP_STEPS_PER_N,
    reference=_ON_THE_TABLE,
    guards=Guards(),
    verified=True,
    notes="Lengths, guards and steps per turn from public TeachMover programs, limits and speeds "
    "from its papers. Published steps per radian of elbow and wrist contradict the per-turn "
    "figures, which are used. Programs disagree on the signs of base and roll: calibrate them.",
)

_MINIMOVER = replace(
    _TEACHMOVER,
    key="minimover5",
    title="Microbot Mini-mover 5",
    arm=FiveAxisArm(195.0, 177.8, 177.8, 96.5, _LIMITS),
    notes="Lengths from McKerrow, chapter 4, section 16 (Microbot's own papers give a base height "
    "of 193.7 mm). Steps, limits, speeds and guards are the TeachMover's, of the same mechanics.",
)


def _drives_on_shafts(
    *, key: str, title: str, drive: str, steps: str, unit: str, per_turn: int, per_mm: int
) -> ArmPreset:
    """Return a template of the mechanics with one drive per motor shaft, for its counts."""
    gears = {"base": 50, "shoulder": 50, "elbow": 40, "wrist": 20}
    per_rad = {name: gear * per_turn / math.tau for name, gear in gears.items()}
    return replace(
        _MINIMOVER,
        key=key,
        title=title,
        transmission=cable_transmission(**per_rad, gripper=float(per_mm)),
        grip_steps_per_n=_GRIP_STEPS_PER_N * per_mm / (371 / MM_PER_INCH),
        verified=False,
        notes=f"A template: the Mini-mover's mechanics with a {drive} drive on each motor's shaft, "
        f"its steps the {steps}. Nobody sells it: gears of 50, 50, 40 and 20 to 1 and the "
        f"gripper's {per_mm} {unit} per mm stand in for those of your arm; limits, speeds and the "
        "reference posture are the Mini-mover's.",
    )


_MINIMOVER_MKS = _drives_on_shafts(
    key="minimover5-mks",
    title="Mini-mover on MKS drives",
    drive="closed-loop",
    steps="counts of their encoders",
    unit="counts",
    per_turn=16384,
    per_mm=2400,
)

_MINIMOVER_CIA402 = _drives_on_shafts(
    key="minimover5-cia402",
    title="Mini-mover on CiA 402 drives",
    drive="CANopen",
    steps="increments in which the drives count, 10,000 a turn",
    unit="increments",
    per_turn=10_000,
    per_mm=1500,
)

_ALPHA2 = replace(
    _TEACHMOVER,
    key="alpha2",
    title="Microbot Alpha II",
    arm=FiveAxisArm(215.0, 177.8, 177.8, 129.5, _LIMITS),
    transmission=None,
    grip_steps_per_n=None,
    reference=None,
    guards=Guards(outer_radius_mm=None),
    verified=False,
    notes="Lengths from Asokan's lecture on the arm's link table. No steps per turn and no "
    "reference posture are published; limits, speeds and guards are the TeachMover's, as a start, "
    "without its outer radius, which is shorter than this arm's reach.",
)

_ROBKO01 = replace(
    _TEACHMOVER,
    key="robko01",
    title="Robko 01",
    arm=FiveAxisArm(190.0, 178.0, 178.0, 92.0, _LIMITS),
    transmission=_left_wrist_first(
        cable_transmission(base=1222.7, shoulder=1161.4, elbow=680.1, wrist=244.7, gripper=27.0)
    ).with_signs(motors=(1, 1, -1, 1, 1, 1)),
    grip_steps_per_n=None,
    notes="Lengths and steps per radian from the arm's own Python software; its elbow counts "
    "backward as positive, and its left wrist motor comes first. The unit of its gripper figure "
    "(27.0) is taken as steps per mm, and limits, speeds, guards and the gripper's elbow coupling "
    "as the TeachMover's: check them. No reference posture is published: the TeachMover's mark on "
    "the table serves.",
)

_ARMDROID1 = replace(
    _TEACHMOVER,
    key="armdroid1",
    title="Colne Armdroid 1",
    grip_steps_per_n=None,
    verified=False,
    notes="A template: no reliable lengths or steps per turn of this arm were found. Every number "
    "is the TeachMover's, whose mechanics it resembles, so that it can be jogged and simulated; "
    "measure lengths, steps, signs, limits and the reference posture before trusting any of them.",
)

# The preset arms by name.
PRESETS: Mapping[str, ArmPreset] = MappingProxyType(
    {
        preset.key: preset
        for preset in (
            _MINIMOVER,
            _TEACHMOVER,
            _ALPHA2,
            _ROBKO01,
            _ARMDROID1,
            _MINIMOVER_MKS,
            _MINIMOVER_CIA402,
        )
    }
)


def preset(key: str) -> ArmPreset:
    """Return the preset of this key. Raises `UnknownPreset` with the nearest name."""
    found = PRESETS.get(key) if isinstance(key, str) else None
    if found is None:
        raise UnknownPreset(key, PRESETS)
    return found
