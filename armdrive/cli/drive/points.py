"""Named points of an arm: list, show and rename them, go to one, run a sequence over them."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from armdrive.cli.arm_files import chosen_target
from armdrive.cli.options import Command
from armdrive.cli.presenter import emit, say, say_lines
from armdrive.config.arm import ArmConfig
from armdrive.programs.teaching.shape import Offset, Shape, mirrored, offset, shaped
from armdrive.status import pose_view
from armdrive.storage.point_file import Points, points_of
from armdrive.storage.points import StepList, check_name, point_view


def run(options: argparse.Namespace) -> int:
    """Do what was asked for."""
    return ACTIONS[options.action](options)


def _book(options: argparse.Namespace) -> Points:
    """Return the points of the arm that the options name, which stays unconnected."""
    config = chosen_target(options).config
    return points_of(config.name, config.model.arm)


# -- the file of points ---------------------------------------------------------------------------


def _list(options: argparse.Namespace) -> int:
    book = _book(options)
    taught = book.read()
    if options.json:
        emit(
            {
                "file": str(book.path),
                "points": {name: point_view(each) for name, each in taught.points.items()},
                "sequences": {name: _steps_view(each) for name, each in taught.sequences.items()},
            }
        )
        return 0
    say(str(book.path))
    width = max(map(len, [*taught.points, *taught.sequences]), default=0) + 2
    for name, point in taught.points.items():
        say(f"  {name:<{width}}{point.joints}{f'   {point.note}' * bool(point.note)}")
    for name, steps in taught.sequences.items():
        note = f"   {steps.note}" * bool(steps.note)
        say(f"  {name:<{width}}sequence of {len(steps.steps)} steps{note}")
    if not (taught.points or taught.sequences):
        say("  no points yet: `armdrive points save NAME` names the place where the arm stands")
    return 0


def _show(options: argparse.Namespace) -> int:
    target = chosen_target(options)
    book = points_of(target.config.name, target.config.model.arm)
    steps = book.read().sequences.get(options.name)
    if steps is not None:
        if options.json:
            emit({"name": options.name, **_steps_view(steps)})
        else:
            for number, step in enumerate(steps.steps, 1):
                say(f"{number:>3}  {step}")
        return 0
    point = book[options.name]
    pose = target.config.model.arm.fk(point.joints)
    if options.json:
        emit({"name": options.name, **point_view(point), "pose": pose_view(pose)})
        return 0
    say(f"joints {point.joints}")
    say(f"tip {pose}")
    if point.opening_mm is not None:
        say(f"gripper {point.opening_mm:.1f} mm")
    if point.taught is not None:
        say(f"taught {point.taught:%Y-%m-%d %H:%M}")
    if point.note:
        say_lines(point.note)
    return 0


def _rename(options: argparse.Namespace) -> int:
    _book(options).rename(options.name, options.new)
    return _said(options, f"{options.name} is {options.new} now")


def _delete(options: argparse.Namespace) -> int:
    book = _book(options)
    taught = book.read()
    if options.name in taught.sequences:
        book.remove_sequence(options.name, instead_of=taught.sequences[options.name])
    else:
        del book[options.name]
    return _said(options, f"{options.name} is deleted")


def _said(options: argparse.Namespace, text: str) -> int:
    if options.json:
        emit({"done": text})
    else:
        say(text)
    return 0


def _steps_view(steps: StepList) -> dict[str, Any]:
    return {"note": steps.note, "steps": [str(step) for step in steps.steps]}


# -- new points and sequences from old ones ----------------------------------------------------


def _shape(options: argparse.Namespace) -> int:
    """Make the new from the old, look at every point, and write them all or none."""
    config = chosen_target(options).config
    book = points_of(config.name, config.model.arm)
    taught = book.read()
    points, sequences = shaped(
        config,
        options.name,
        check_name(options.new),
        (taught.points, taught.sequences),
        _change(options, config),
    )
    book.put_all(points, sequences, again=options.again)
    if options.json:
        emit({"name": options.new, "points": list(points), "sequences": list(sequences)})
    else:
        for name, point in points.items():
            say(f"{name}: {point.joints}")
        for name, steps in sequences.items():
            say(f"{name}: sequence of {len(steps.steps)} steps")
    return 0


def _change(options: argparse.Namespace, config: ArmConfig) -> tuple[Shape, str]:
    """Return how postures change, and the words for the notes."""
    if options.action == "copy":
        return (lambda joints: joints), ""
    if options.action == "mirror":
        return (lambda joints: mirrored(config, joints)), f"{options.name} mirrored"
    by = Offset(options.x, options.y, options.z, math.radians(options.turn))
    return (lambda joints: offset(config, joints, by)), f"{options.name} offset by {by}"


# -- what needs more than the file of points -----------------------------------------------------


def _elsewhere(options: argparse.Namespace) -> int:
    from armdrive.cli.drive import points_driving, points_export

    actions = {**points_driving.ACTIONS, "export": points_export.export}
    return actions[options.action](options)


ACTIONS: Mapping[str, Command] = MappingProxyType(
    {
        "list": _list,
        "show": _show,
        "save": _elsewhere,
        "go": _elsewhere,
        "run": _elsewhere,
        "rename": _rename,
        "delete": _delete,
        "copy": _shape,
        "mirror": _shape,
        "export": _elsewhere,
        "offset": _shape,
    }
)
"""What does each action."""
