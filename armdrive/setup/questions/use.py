"""Questions about the gripper, homing, postures, guards, and the directions of the motors."""

from __future__ import annotations

from armdrive.dialog.conversation import (
    Reader,
    bounds,
    choice,
    groups,
    number,
    numbers,
    several,
    yes_or_no,
)
from armdrive.setup.draft import GRIPPER_MOTOR, Draft
from armdrive.setup.questions.arm import ArmRow, fixed, plain, typed
from armdrive.setup.templates import COUPLED, GRIPPERS

PULLED_OFF_DEG = 2.0
"""How far inside its limits an arm is taken to stand after homing."""

POSTURE = ("x", "y", "z", "pitch", "roll")


def _posture(draft: Draft) -> Reader:
    names = (*POSTURE, "yaw") if len(draft.joints) == 6 else POSTURE
    read = numbers(names)

    def posture(line: str) -> tuple[float, ...]:
        return () if line in ("", "none") else tuple(read(line))

    return posture


def _model_arm_steps(draft: Draft) -> bool:
    return draft.preset is None and draft.stepped


def _has_fingers(draft: Draft) -> bool:
    return draft.preset is None and draft.gripper != "none"


def _asks_fingers(draft: Draft) -> bool:
    return draft.stepped and draft.measured and not draft.published_motors


def _homes(draft: Draft) -> bool:
    return draft.dialect.abilities.own_homing and bool(draft.get("homing.own"))


def _homed_at(draft: Draft, one: str) -> str:
    upwards = draft.preset is not None or draft.direction(one) > 0
    low, high = draft.range_of(one)
    return f"{high - PULLED_OFF_DEG if upwards else low + PULLED_OFF_DEG:g}"


def _motor_names(draft: Draft) -> tuple[str, ...]:
    return (*draft.motors, GRIPPER_MOTOR) if draft.stepped else draft.motors


_DIRECTIONS = (
    ("skip", "later: `armdrive config signs NAME` finds them"),
    ("find", "now: each motor turns a little, and you say what you saw"),
    ("known", "I know which ones count the other way"),
)

ROWS = (
    ArmRow(
        "gripper.kind", "What moves the gripper?",
        "A coupled stepper is the Mini-mover's: its cable passes over the elbow.",
        lambda draft: choice(draft.grippers),
        lambda draft, _one: draft.grippers[0],
        when=lambda draft: len(draft.grippers) > 1,
        choices=lambda draft: tuple((kind, GRIPPERS[kind]) for kind in draft.grippers),
    ),
    ArmRow(
        "gripper.over", "Which motor does the gripper's cable follow?",
        "Every step of that motor is added to the gripper's, so that the fingers stand still.",
        lambda draft: choice(draft.motors),
        lambda draft, _one: draft.motors[min(2, len(draft.motors) - 1)],
        when=lambda draft: _model_arm_steps(draft) and draft.gripper == COUPLED,
        choices=lambda draft: tuple((motor, "") for motor in draft.motors),
    ),
    ArmRow(
        "fingers.mm_per_turn", "How many mm do the fingers open for one turn of their motor?",
        "Of the motor's shaft. Turn it ten times and measure.",
        fixed(number(0.01, 1000.0, "mm")), when=_asks_fingers,
    ),
    ArmRow(
        "fingers.range", "Opening of the fingers, closed and widest, in mm?", "Between the tips.",
        fixed(bounds), plain("0 76"), when=_has_fingers,
    ),
    ArmRow(
        "fingers.speed", "How fast do the fingers open, in mm a second?", "Begin low.",
        fixed(number(0.01, 1000.0)), plain("10"), when=_has_fingers,
    ),
    ArmRow(
        "homing.own", "Does the arm home by its own switches?",
        "The controller then drives each motor to its switch when `armdrive home` asks for it.",
        fixed(yes_or_no),
        lambda draft, _one: "yes" if draft.template.homes else "no",
        when=lambda draft: draft.dialect.abilities.own_homing,
    ),
    ArmRow(
        "homing.joints.{one}", "Where does {one} stand after homing, in degrees?",
        "Measured on the arm, after the controller has pulled off its switch.",
        fixed(number(-3600.0, 3600.0)), _homed_at, when=_homes,
        each=lambda draft: draft.joints,
    ),
    ArmRow(
        "homing.opening", "How far open are the fingers after homing, in mm?",
        "0 where they are closed.", fixed(number(0.0, 1000.0, "mm")), plain("0"),
        when=lambda draft: _homes(draft) and draft.stepped,
    ),
    ArmRow(
        "homing.groups", "Which motors home after which? (own: the controller's own order)",
        "By number: 3; 2; 1 4 5 homes motor 3, then 2, then 1, 4 and 5 together. Lift what could "
        "hit something first.",
        lambda draft: groups(len(_motor_names(draft))), plain("own"), when=_homes,
    ),
    ArmRow(
        "reference", "A posture that you can find again? x y z/mm pitch roll/deg (or none)",
        "An arm without switches counts its steps from there: finger tips on a mark, hand straight "
        "down. A sixth number is the yaw of an arm of six joints.",
        _posture, plain("none"), when=lambda draft: draft.preset is None,
    ),
    ArmRow(
        "park", "Where does it park? x y z/mm pitch roll/deg (none: above the reference)",
        "Where `armdrive move --park` goes. A sixth number is the yaw of an arm of six joints.",
        _posture, plain("none"),
    ),
    ArmRow(
        "guards.tolerance_mm", "How far below the table may rounding put the tip, in mm?",
        "No point of the arm is planned to go further below the table than this.",
        fixed(number(0.0, 1000.0, "mm")),
        lambda draft, _one: typed((draft.preset.guards.tolerance_mm if draft.preset else 1.0,)),
    ),
    ArmRow(
        "signs", "Which way do the motors turn?",
        "Programs for these arms disagree on directions, so they are found on each arm.",
        fixed(choice(("skip", "find", "known"))),
        lambda draft, _one: "known" if "reversed.motors" in draft.around.given else "skip",
        choices=lambda _draft: _DIRECTIONS,
    ),
    ArmRow(
        "reversed.motors", "Which motors count the other way? (names with commas, or none)",
        "The other way than the template has it.",
        lambda draft: several(_motor_names(draft)), plain("none"),
        when=lambda draft: draft.get("signs") == "known",
        choices=lambda draft: tuple((motor, "") for motor in _motor_names(draft)),
    ),
    ArmRow(
        "reversed.joints", "Which joints are reversed as a whole? (names with commas, or none)",
        "The wrist's roll, where its two motors are the other way round.",
        lambda draft: several(draft.joints), plain("none"),
        when=lambda draft: draft.get("signs") == "known",
        choices=lambda draft: tuple((joint, "") for joint in draft.joints),
    ),
)  # fmt: skip
"""Asked last, in this order."""
