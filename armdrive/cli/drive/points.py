"""Named points of an arm: name the present place, list, go to one, run a sequence over them."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.drive.points_shaping import shape
from armdrive.cli.drive.preview_report import show_preview
from armdrive.cli.options import Command
from armdrive.cli.presenter import emit, say, say_lines
from armdrive.cli.terminal_person import settle_trust
from armdrive.programs.teaching.sequence import Stepper
from armdrive.status import joints_view, pose_view, status_view
from armdrive.storage.point_file import Points, points_of
from armdrive.storage.points import Point, StepList


def run(options: argparse.Namespace) -> int:
    """Do what was asked for."""
    return ACTIONS[options.action](options)


def _book(options: argparse.Namespace) -> Points:
    """Return the points of the arm that the options name, which stays unconnected."""
    config = chosen_target(options).config
    return points_of(config.name, config.model.arm)


# -- without the arm --------------------------------------------------------------------------


def _list(options: argparse.Namespace) -> int:
    book = _book(options)
    taught = book.read()
    if options.json:
        emit(
            {
                "file": str(book.path),
                "points": {name: _point_view(each) for name, each in taught.points.items()},
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
        emit({"name": options.name, **_point_view(point), "pose": pose_view(pose)})
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


def _export(options: argparse.Namespace) -> int:
    from armdrive.cli.drive.points_export import export  # the only action that needs the language

    return export(options)


def _said(options: argparse.Namespace, text: str) -> int:
    if options.json:
        emit({"done": text})
    else:
        say(text)
    return 0


# -- with the arm -----------------------------------------------------------------------------


def _connected(options: argparse.Namespace, *, allow_restored: bool = False) -> Arm:
    return connect_chosen(options, allow_restored=allow_restored)


def _save(options: argparse.Namespace) -> int:
    with _connected(options, allow_restored=True) as arm:
        if not options.json:
            say(arm.status.which)
        point = arm.points.teach(options.name, note=options.note, again=options.again)
    if options.json:
        emit({"name": options.name, **_point_view(point)})
    else:
        say(f"{options.name}: {point.joints}")
    return 0


def _go(options: argparse.Namespace) -> int:
    how = "line" if options.line else "joint"
    with _connected(options, allow_restored=options.allow_restored) as arm:
        if not options.json:
            say(arm.status.which)
        settle_trust(arm)
        if options.preview:
            seen = arm.preview(options.name, line=options.line, speed=options.speed)
            return show_preview(seen, as_json=options.json)
        moved = arm.go(options.name, how=how, speed=options.speed).wait()
        if options.json:
            emit(status_view(arm.status))
        else:
            say(str(moved))
    return 0


def _run(options: argparse.Namespace) -> int:
    with _connected(options, allow_restored=options.allow_restored) as arm:
        if not options.json:
            say(arm.status.which)
        settle_trust(arm)
        taught = arm.points.read()
        stepper = Stepper(arm, arm.points.sequence(options.name), taught.points)
        shown = None if options.json else lambda step: say(f"{stepper.at + 1:>3}  {step}")
        stops = arm.stops
        for _ in range(options.times):
            stepper.rewind()
            stepper.run(shown, since=stops)  # a stop between two times ends it as well
        if options.json:
            emit(status_view(arm.status))
    return 0


def _point_view(point: Point) -> dict[str, Any]:
    return {
        "joints": joints_view(point.joints),
        "gripper_mm": point.opening_mm,
        "note": point.note,
        "taught": None if point.taught is None else point.taught.isoformat(),
    }


def _steps_view(steps: StepList) -> dict[str, Any]:
    return {"note": steps.note, "steps": [str(step) for step in steps.steps]}


ACTIONS: Mapping[str, Command] = MappingProxyType(
    {
        "list": _list,
        "show": _show,
        "save": _save,
        "go": _go,
        "run": _run,
        "rename": _rename,
        "delete": _delete,
        "copy": shape,
        "mirror": shape,
        "export": _export,
        "offset": shape,
    }
)
"""What does each action."""
