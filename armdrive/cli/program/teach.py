"""Teach sequences: record them as the arm moves, edit, run, copy and export them."""

from __future__ import annotations

import argparse
import math
import re
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import armdrive.programs as programs
from armdrive.cli.arm_files import chosen_points, chosen_target
from armdrive.cli.drive.control_requests import one_holder
from armdrive.cli.options import names_arm
from armdrive.cli.presenter import Result, show, tell
from armdrive.cli.terminal_operator import ready_arm, settled_arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.target import find
from armdrive.errors import BadRequest, Refused
from armdrive.errors.printable import command_line
from armdrive.motion.plan import audit_opening
from armdrive.programs.teaching import steps as editing
from armdrive.programs.teaching.export import program_of
from armdrive.programs.teaching.sequence import Choices, Stepper, StepRecorder, seen_in
from armdrive.programs.teaching.shape import Offset, Reshape, mirrored, offset
from armdrive.programs.teaching.steps import Edited, parse_step
from armdrive.status import status_view
from armdrive.storage.files import require_free, write_named
from armdrive.storage.lock_client import watch_holder
from armdrive.storage.point_file import Points, points_of
from armdrive.storage.points import Step, StepList, check_name
from kinematics.text import counted

LOOK_EVERY_S = 0.1


def record(options: argparse.Namespace) -> Result:
    """Record until Ctrl-C, or until the arm is given back."""
    name = one_holder(options)
    config = (chosen_target(options) if names_arm(options) else find(name)).config
    book = points_of(config.name, config.model.arm)
    _require_free(book, options)
    how = "line" if options.line else "joint"
    recorder = StepRecorder(options.name, Choices(how, options.speed, options.waits, options.rest))
    what = f"recording {name} as {options.name}: a step wherever it comes to rest"
    tell(options, f"{what}; Ctrl-C ends it")
    keep = partial(_keep, options, book, recorder)
    try:
        for view in watch_holder(name, LOOK_EVERY_S):
            if view["state"] == "disconnected":
                break
            keep(recorder.see(seen_in(view, config.model.arm.joint_names), time.monotonic()))
    except KeyboardInterrupt:  # how a recording ends
        pass
    finally:
        keep(recorder.end(time.monotonic()))
    if not recorder.steps:
        raise Refused("nothing was recorded: the arm was never seen at rest")
    count = f"{counted(len(recorder.steps), 'step')} over {counted(len(recorder.points), 'point')}"
    return Result(None, f"{options.name}: {count}, in {book.path}")


def _keep(
    options: argparse.Namespace, book: Points, recorder: StepRecorder, made: tuple[Step, ...]
) -> None:
    """Write the latest steps down at once, so that no way to end loses any, and print them."""
    first = len(recorder.steps) - len(made)
    if made:
        again = options.again or first > 0  # later steps replace those of this recording
        book.put_all(recorder.points, {recorder.name: recorder.sequence}, again=again)
    for number, step in enumerate(made, first + 1):
        view = {"step": number, "text": str(step)}
        show(Result(view, f"{number:>3}  {step}"), options)


def _require_free(book: Points, options: argparse.Namespace) -> None:
    """Refuse a name that is taken before anything is recorded, not after it."""
    taught = book.read()
    check_name(options.name)
    numbered = re.compile(f"{options.name}-[0-9]+")
    mine = [name for name in taught.points if numbered.fullmatch(name)]
    if not options.again and (options.name in taught.sequences or mine):
        taken = ", ".join([*mine, *[options.name] * (options.name in taught.sequences)])
        raise BadRequest(f"there is {taken} already: choose another name, or add --again")


# Editing a sequence step by step, in the arm's file of points.


def _changed(
    options: argparse.Namespace,
    change: Callable[[StepList], StepList | Edited],
    *,
    new: bool = False,
) -> Result:
    """Change a sequence of the arm that the options name, which stays unconnected.

    With `new` there may be none of that name yet.
    """
    _, book = chosen_points(options)
    before = book.sequences.get(options.name) if new else book.sequence(options.name)
    made = change(StepList() if before is None else before)
    after = made if isinstance(made, Edited) else Edited(made)
    book.put_sequence(options.name, after.steps, instead_of=before)
    return _shown(options.name, after)


def _shown(name: str, made: Edited) -> Result:
    """Return a sequence as it is now."""
    steps = made.steps.steps
    lines = [f"{index:>3}  {step}" for index, step in enumerate(steps, 1)]
    lines += [f"note: {note}" for note in made.notes]
    view = {"name": name, "steps": [str(step) for step in steps], "notes": list(made.notes)}
    return Result(view, lines)


def _appended(steps: StepList, step: Step) -> StepList:
    return editing.inserted(steps, len(steps.steps) + 1, (step,))


def add(options: argparse.Namespace) -> Result:
    """Add a step at the end."""
    step = _typed_step(options)
    return _changed(options, lambda steps: _appended(steps, step), new=True)


def insert(options: argparse.Namespace) -> Result:
    """Put a step before another."""
    step = _typed_step(options)
    return _changed(options, lambda steps: editing.inserted(steps, options.at, (step,)))


def _typed_step(options: argparse.Namespace) -> Step:
    """Return the step of the options. Raises `OutOfBounds` for an opening beyond the fingers."""
    step = parse_step(" ".join(options.step))
    if isinstance(step.gripper, float):
        audit_opening(chosen_target(options).config, step.gripper)
    return step


def remove(options: argparse.Namespace) -> Result:
    """Take steps away."""
    return _changed(options, lambda steps: editing.removed(steps, options.first, options.last))


def move(options: argparse.Namespace) -> Result:
    """Put a step in another place."""
    return _changed(options, lambda steps: editing.moved(steps, options.old, options.new))


def retime(options: argparse.Namespace) -> Result:
    """Change speeds and waits."""
    timing = editing.Timing(options.speed, options.wait, options.factor, options.wait_factor)
    span = (options.first, options.last)
    return _changed(options, lambda steps: editing.retimed(steps, timing, *span))


def reverse(options: argparse.Namespace) -> Result:
    """Make the reverse of a sequence."""
    _, book = chosen_points(options)
    made = editing.reverse(book.sequence(options.name), book.read().points)
    book.put_sequence(options.new, made.steps, instead_of=None)
    return _shown(options.new, made)


def here(options: argparse.Namespace) -> Result:
    """Save the arm's present place as the next step."""
    check_name(options.point or options.name)  # before anything is opened or asked
    with settled_arm(options) as arm:
        taught = arm.points.read()
        point = options.point or _free_name(options.name, taught.points)
        arm.points.teach(point)
        before = taught.sequences.get(options.name)
        step = Step(point, "line" if options.line else "joint", options.speed)
        after = _appended(before or StepList(), step)
        arm.points.put_sequence(options.name, after, instead_of=before)
    return _shown(options.name, Edited(after))


def _free_name(sequence: str, taken: Mapping[str, object]) -> str:
    numbers = range(1, len(taken) + 2)
    return next(name for n in numbers if (name := f"{sequence}-{n}") not in taken)


def run_sequence(options: argparse.Namespace) -> Result:
    """Run a sequence, step by step."""
    _, book = chosen_points(options)
    book.sequence(options.name)  # refused before anything is opened
    with ready_arm(options) as arm:
        taught = arm.points.read()
        stepper = Stepper(arm, arm.points.sequence(options.name), taught.points)
        stops = arm.stops
        for _ in range(options.times):
            stepper.rewind()
            # a stop between two rounds ends it as well
            stepper.run(lambda step: tell(options, f"{stepper.at + 1:>3}  {step}"), since=stops)
        return Result(status_view(arm.status))


# New points and sequences from old ones, and a sequence as a program.


def shape(options: argparse.Namespace) -> Result:
    """Derive new points and sequences, check every one, and write all or none."""
    config, book = chosen_points(options)
    new = check_name(options.new)
    made = _change(options, config).taught(options.name, new, book.read())
    book.put_all(made.points, made.sequences, again=options.again)
    lines = [f"{name}: {point.joints}" for name, point in made.points.items()]
    lines += [
        f"{name}: sequence of {counted(len(each.steps), 'step')}"
        for name, each in made.sequences.items()
    ]
    view = {"name": new, "points": list(made.points), "sequences": list(made.sequences)}
    return Result(view, lines)


def _change(options: argparse.Namespace, config: ArmConfig) -> Reshape:
    if options.action == "copy":
        return Reshape(config, lambda joints: joints)
    if options.action == "mirror":
        return Reshape(config, partial(mirrored, config), f"{options.name} mirrored")
    by = Offset(options.x, options.y, options.z, math.radians(options.turn))
    shape = partial(offset, config, by=by)
    return Reshape(config, shape, f"{options.name} offset by {by}")


def export(options: argparse.Namespace) -> Result:
    """Write the program to a file, which may exist only with --force."""
    path = Path(options.file)
    require_free(path, overwrite=options.force)
    config, book = chosen_points(options)
    steps, taught = book.sequence(options.name), book.read()
    tree = program_of(options.name, steps, taught.points, config.model.arm.fk)
    program = programs.written_program(tree, str(path))
    write_named(path, program.text.encode("utf-8"))
    return Result(
        {"file": str(path), "sha256": program.digest, "steps": len(steps.steps)},
        f"{options.name} is now {path}; `{command_line('run', path, '--check')}` rehearses it",
    )
