"""`armdrive teach record`: write down what an arm does that another program drives."""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.control_requests import one_holder
from armdrive.cli.options import Command
from armdrive.cli.presenter import emit, say
from armdrive.connect.target import find
from armdrive.errors import ArmError, BadRequest, Refused
from armdrive.programs.teaching import edit as editing
from armdrive.programs.teaching.edit import Edited
from armdrive.programs.teaching.record import Choices, StepRecorder, seen_in
from armdrive.storage.lock_client import watch_holder
from armdrive.storage.point_file import Points, points_of
from armdrive.storage.points import Step, StepList, check_name, parse_step

LOOK_EVERY_S = 0.1


def record(options: argparse.Namespace) -> int:
    """Record until Ctrl-C, or until the arm is given back."""
    name = one_holder(options)
    named = options.arm or options.sim or options.port
    config = (chosen_target(options) if named else find(name)).config
    book = points_of(config.name, config.model.arm)
    _require_free(book, options)
    how = "line" if options.line else "joint"
    recorder = StepRecorder(options.name, Choices(how, options.speed, options.waits, options.rest))
    if not options.json:
        say(f"recording {name} as {options.name}: a step wherever it comes to rest; Ctrl-C ends it")
    kept = _Kept(options, book, recorder)
    try:
        _follow(recorder, watch_holder(name, LOOK_EVERY_S), config.model.arm.joint_names, kept)
    except KeyboardInterrupt:  # how a recording ends
        pass
    finally:
        kept.take(recorder.end(time.monotonic()))
    if not recorder.steps:
        raise Refused("nothing was recorded: the arm was never seen at rest")
    if not options.json:
        count = len(recorder.steps)
        say(f"{options.name}: {count} steps over {len(recorder.points)} points, in {book.path}")
    return 0


def _follow(
    recorder: StepRecorder, views: Iterator[Mapping[str, Any]], names: tuple[str, ...], kept: _Kept
) -> None:
    """Take up what is seen of an arm, until it is given back."""
    for view in views:
        if "state" not in view:
            raise ArmError(str(view.get("error", "the holder does not let itself be watched")))
        if view["state"] == "disconnected":
            return
        now_s = time.monotonic()
        kept.take(recorder.see(seen_in(view, names), now_s))


class _Kept:
    """Prints steps as they come, and writes them down at once: no way to end loses any."""

    def __init__(self, options: argparse.Namespace, book: Points, recorder: StepRecorder) -> None:
        self._json, self._again = options.json, options.again
        self._book = book
        self._recorder = recorder

    def take(self, made: tuple[Step, ...]) -> None:
        """Take the steps that were made last."""
        if not made:
            return
        recorder = self._recorder
        sequences = {recorder.name: recorder.sequence}
        self._book.put_all(recorder.points, sequences, again=self._again)
        self._again = True  # what stands there from now on is this recording
        for number, step in enumerate(made, len(recorder.steps) - len(made) + 1):
            if self._json:
                emit({"step": number, "text": str(step)})
            else:
                say(f"{number:>3}  {step}")


def _require_free(book: Points, options: argparse.Namespace) -> None:
    """Refuse a name that is taken before anything is recorded, not after it."""
    taught = book.read()
    check_name(options.name)
    numbered = re.compile(f"{options.name}-[0-9]+")
    mine = [name for name in taught.points if numbered.fullmatch(name)]
    if not options.again and (options.name in taught.sequences or mine):
        taken = ", ".join([*mine, *[options.name] * (options.name in taught.sequences)])
        raise BadRequest(f"there is {taken} already: take another name, or say --again")


# Teach sequences: record them as the arm is moved, and edit them step by step.


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
