"""Teach sequences: record them as the arm is moved, and edit them step by step."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from types import MappingProxyType

from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.options import Command
from armdrive.cli.presenter import emit, say
from armdrive.cli.program.teach_recording import record
from armdrive.programs.teaching import edit as editing
from armdrive.programs.teaching.edit import Edited
from armdrive.storage.point_file import Points, points_of
from armdrive.storage.points import Step, StepList, parse_step


def run(options: argparse.Namespace) -> int:
    """Do what was asked for."""
    return ACTIONS[options.action](options)


def _book(options: argparse.Namespace) -> Points:
    """Return the points of the arm that the options name, which stays unconnected."""
    config = chosen_target(options).config
    return points_of(config.name, config.model.arm)


def _changed(options: argparse.Namespace, change: Callable[[StepList], StepList]) -> int:
    book = _book(options)
    before = book.sequence(options.name)
    after = change(before)
    book.put_sequence(options.name, after, instead_of=before)
    return _shown(options, options.name, after)


def _shown(
    options: argparse.Namespace, name: str, steps: StepList, notes: tuple[str, ...] = ()
) -> int:
    """Print a sequence as it is now."""
    if options.json:
        emit({"name": name, "steps": [str(step) for step in steps.steps], "notes": list(notes)})
        return 0
    for index, step in enumerate(steps.steps, 1):
        say(f"{index:>3}  {step}")
    for note in notes:
        say(f"note: {note}")
    return 0


def _typed(options: argparse.Namespace) -> Step:
    return parse_step(" ".join(options.step))


def _add(options: argparse.Namespace) -> int:
    book, step = _book(options), _typed(options)
    before = book.sequences.get(options.name)
    steps = before or StepList()
    after = editing.inserted(steps, len(steps.steps) + 1, (step,))
    book.put_sequence(options.name, after, instead_of=before)
    return _shown(options, options.name, after)


def _insert(options: argparse.Namespace) -> int:
    step = _typed(options)
    return _changed(options, lambda steps: editing.inserted(steps, options.at, (step,)))


def _remove(options: argparse.Namespace) -> int:
    return _changed(options, lambda steps: editing.removed(steps, options.first, options.last))


def _move(options: argparse.Namespace) -> int:
    return _changed(options, lambda steps: editing.moved(steps, options.old, options.new))


def _retime(options: argparse.Namespace) -> int:
    timing = editing.Timing(options.speed, options.wait, options.factor, options.wait_factor)
    book = _book(options)
    before = book.sequence(options.name)
    made = editing.retimed(before, timing, options.first, options.last)
    book.put_sequence(options.name, made.steps, instead_of=before)
    return _shown(options, options.name, made.steps, made.notes)


def _reverse(options: argparse.Namespace) -> int:
    book = _book(options)
    made: Edited = editing.reverse(book.sequence(options.name), book.read().points)
    book.put_sequence(options.new, made.steps, instead_of=None)
    return _shown(options, options.new, made.steps, made.notes)


def _here(options: argparse.Namespace) -> int:
    with connect_chosen(options, allow_restored=True) as arm:
        if not options.json:
            say(arm.status.which)
        taught = arm.points.read()
        point = options.point or _free_name(options.name, taught.points)
        arm.points.teach(point)
        before = taught.sequences.get(options.name)
        step = Step(point, "line" if options.line else "joint", options.speed)
        steps = before or StepList()
        after = editing.inserted(steps, len(steps.steps) + 1, (step,))
        arm.points.put_sequence(options.name, after, instead_of=before)
    return _shown(options, options.name, after)


def _free_name(sequence: str, taken: Mapping[str, object]) -> str:
    numbers = range(1, len(taken) + 2)
    return next(name for n in numbers if (name := f"{sequence}-{n}") not in taken)


ACTIONS: Mapping[str, Command] = MappingProxyType(
    {
        "record": record,
        "here": _here,
        "add": _add,
        "insert": _insert,
        "remove": _remove,
        "move": _move,
        "retime": _retime,
        "reverse": _reverse,
    }
)
"""What does each action."""
