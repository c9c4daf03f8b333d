"""The checks of the arguments of an arm's public calls, by annotation."""

from __future__ import annotations

import os
from collections.abc import Mapping
from types import MappingProxyType

from armdrive.errors.arguments import (
    BASIC,
    Rule,
    call,
    expected,
    made_of,
    number,
    several,
    text,
    whole,
    wrong,
)
from armdrive.moves import ONE_MOVE, PARTS, Jog
from armdrive.registry import DEFAULT
from armdrive.runtime.clock import SimulatedClock
from armdrive.storage.points import Point
from kinematics.spaces import POSE_EXAMPLE, Joints, Pose

ANGLES = '{"shoulder_deg": 40}'
LINES = "high=3, or high=(1, 2)"


def _angles(name: str, value: object) -> object:
    """Accept a mapping of amounts by name, like the call's keywords."""
    if isinstance(value, Mapping) and all(isinstance(word, str) for word in value):
        return {word: number(word, amount) for word, amount in value.items()}
    raise wrong(name, value, "values by their names", f"{ANGLES}, or as keywords: shoulder_deg=40")


def _joint_goal(name: str, value: object) -> object:
    """Accept all joint angles of the arm, or a mapping like `_angles`."""
    return value if isinstance(value, Joints) else _angles(name, value)


def _lines(name: str, value: object) -> object:
    """Accept the number of an input or output, or several numbers."""
    return _SEVERAL_LINES(name, value) if hasattr(value, "__iter__") else whole(name, value)


def _pace(name: str, value: object) -> object:
    """Accept a word, a number or a clock; the pace itself checks the word."""
    known = value is None or isinstance(value, str | SimulatedClock)
    return value if known else number(name, value)


_PLACE = made_of(
    (Pose, Joints, Point, str), "a pose, joint angles, a point or the name of a point", POSE_EXAMPLE
)
_SEVERAL_LINES = several(whole, "a number counted from 1, or several", LINES)

# The check for each parameter annotation.
#
# Simulated arms and pendant programs are recognized by their attributes, because importing their
# classes would load the simulation for a real arm and the pendant code for every arm.
RULES: Mapping[str, Rule] = MappingProxyType(
    {
        **BASIC,
        "Accept": expected(
            "True, False or a function",
            "accept=True",
            lambda value: isinstance(value, bool) or callable(value),
        ),
        "Angles": _angles,
        "Jog": made_of(Jog, "a jog", "Jog.joint(shoulder=1)"),
        "Joints | Angles": _joint_goal,
        "Joints | Pose": made_of((Joints, Pose), "joint angles or a pose", POSE_EXAMPLE),
        "Lines": _lines,
        "Operator": call,
        "PaceChoice": _pace,
        "Move": ONE_MOVE,
        "Path | str": made_of((str, os.PathLike), "the path of a file", '"recording.jsonl"'),
        "PendantProgram": expected(
            "a program",
            "arm.controller.read_program()",
            lambda value: hasattr(value, "rows") and hasattr(value, "require_origin"),
        ),
        "Place": _PLACE,
        "ProgramView": call,
        "Pose": made_of(Pose, "a pose", POSE_EXAMPLE),
        "Sequence[PathPart]": PARTS,
        "Sequence[str]": several(text, "a list of lines", '["$100=250"]'),
        "SimulatedArm": expected(
            "a simulated arm", "", lambda value: hasattr(value, "world") and hasattr(value, "link")
        ),
        "GroupReport": call,
        "Unpack[JointAngles]": number,
        "Unpack[JointJog]": number,
        "Unpack[TipJog]": number,
        "frame: str": made_of(str, "the name of a frame", '"base" or "tool"'),
        "target: str": made_of(str, "the name of an arm or a port", f'"sim:{DEFAULT}"'),
    }
)
