"""Teach sequences: record them as the arm is moved, and edit them step by step.

A sequence and its points stand in the arm's file of points (docs/points.md, docs/teaching.md).

Examples:
  armdrive teach record stack               the arm is jogged in another terminal; Ctrl-C ends it
  armdrive teach here stack                 name the place where the arm stands, as the next step
  armdrive teach add stack gripper grasp    a step at the end
  armdrive teach insert stack 3 to above along a line at 30%
  armdrive teach remove stack 4 6           steps 4 to 6
  armdrive teach move stack 5 2             step 5 becomes step 2
  armdrive teach retime stack --factor 0.5  half as fast, waits as they are
  armdrive teach reverse stack unstack      the way back, under a new name

Every action prints JSON with --json.

"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from types import MappingProxyType

from armdrive.cli.arm_options import add_arm_options
from armdrive.cli.chosen_arm import chosen_target, connect_chosen
from armdrive.cli.options import count, fraction, number
from armdrive.cli.presenter import emit, say, say_which
from armdrive.cli.program.teach_recording import record
from armdrive.programs.teaching import edit as editing
from armdrive.programs.teaching.edit import Edited
from armdrive.programs.teaching.record import REST_S
from armdrive.storage.point_file import Points, points_of
from armdrive.storage.points import Step, StepList, parse_step

Deed = Callable[[argparse.Namespace], int]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the actions, each with its own options."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, (_, words, summary) in ACTIONS.items():
        action = actions.add_parser(name, help=summary, description=summary)
        action.add_argument("name", metavar="SEQUENCE")
        for word in words:
            action.add_argument(word, type=count, metavar=word.upper())
        _OPTIONS.get(name, _no_more)(action)
        add_arm_options(action)


def _no_more(_: argparse.ArgumentParser) -> None:
    """Add no options."""


def _step_words(action: argparse.ArgumentParser) -> None:
    action.add_argument("step", nargs="+", metavar="WORD", help="the step, as `points show` has it")


def _to_last(action: argparse.ArgumentParser) -> None:
    action.add_argument("last", type=count, nargs="?", metavar="LAST", help="... up to this one")


def _retime_words(action: argparse.ArgumentParser) -> None:
    action.add_argument("first", type=count, nargs="?", metavar="FIRST", help="one step only ...")
    _to_last(action)
    action.add_argument("--speed", type=fraction, help="a new speed, a fraction of the limits")
    action.add_argument("--factor", type=number, default=1.0, help="times the speed there is")
    action.add_argument("--wait", type=number, metavar="SECONDS", help="a new time for waits")
    action.add_argument("--wait-factor", type=number, default=1.0, help="times the waits there are")


def _here_words(action: argparse.ArgumentParser) -> None:
    action.add_argument("--point", metavar="NAME", help="what to call the place")
    action.add_argument("--line", action="store_true", help="to be gone to along a straight line")
    action.add_argument("--speed", type=fraction, default=1.0, help="a fraction of the limits")


def _record_words(action: argparse.ArgumentParser) -> None:
    action.add_argument("--line", action="store_true", help="every way along a straight line")
    action.add_argument("--speed", type=fraction, default=1.0, help="of every way")
    action.add_argument("--waits", action="store_true", help="keep how long the arm stood")
    action.add_argument(
        "--rest", type=number, default=REST_S, metavar="SECONDS",
        help=f"a place is where the arm stands for so long (default {REST_S:g})",
    )  # fmt: skip
    action.add_argument("--again", action="store_true", help="write over what is there")


def _reverse_words(action: argparse.ArgumentParser) -> None:
    action.add_argument("new", metavar="NEW", help="what the way back is called")


_OPTIONS: Mapping[str, Callable[[argparse.ArgumentParser], None]] = MappingProxyType(
    {
        "record": _record_words,
        "here": _here_words,
        "add": _step_words,
        "insert": _step_words,
        "remove": _to_last,
        "retime": _retime_words,
        "reverse": _reverse_words,
    }
)


def run(options: argparse.Namespace) -> int:
    """Do what was asked for."""
    deed, _, _ = ACTIONS[options.action]
    return deed(options)


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
            say_which(arm.status)
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


def _record(options: argparse.Namespace) -> int:
    return record(options)


ACTIONS: Mapping[str, tuple[Deed, tuple[str, ...], str]] = MappingProxyType(
    {
        "record": (_record, (), "record an arm that another program drives, until Ctrl-C"),
        "here": (_here, (), "name the place where the arm stands, as the next step"),
        "add": (_add, (), "add a step at the end, of a new sequence too"),
        "insert": (_insert, ("at",), "put a step before another"),
        "remove": (_remove, ("first",), "take steps away"),
        "move": (_move, ("old", "new"), "put a step in another place"),
        "retime": (_retime, (), "change speeds and waits, of all steps or of some"),
        "reverse": (_reverse, (), "make a sequence that goes the way back"),
    }
)
"""Every action: what does it, the numbers of steps that it wants, and its line of help."""
