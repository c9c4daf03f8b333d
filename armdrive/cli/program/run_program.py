"""Rehearses and runs program files: shows the run, and keeps its journal."""

from __future__ import annotations

import argparse
import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.options import ARM_OPTIONS, typed_again
from armdrive.cli.presenter import Result, as_json, say, show, tell
from armdrive.cli.program.run_arm import connect_to_run, keep_recording, stands_at
from armdrive.cli.program.run_output import Display, show_place
from armdrive.cli.program.run_person import RunTerminal, standard_input, stopped_by_interrupt
from armdrive.errors import ArmInUse, DeviceFault, LinkError
from armdrive.errors.printable import command_line
from armdrive.programs.acts import RunStep
from armdrive.programs.journal import Journal, resumed_plan
from armdrive.programs.problems import SourceLines, mark_of
from armdrive.programs.program import ArmProgram, Machine, Program, read_program_file
from armdrive.programs.progress import duration, line_words
from armdrive.programs.rehearsal import (
    BEFORE_RUN_S,
    CHECK_S,
    Rehearsal,
    RehearsalOptions,
    SeenArm,
    rehearsal_lines,
    rehearsal_view,
    rehearse,
    require_rehearsed,
    time_limit,
)
from armdrive.programs.running import Performer, ProgramRun, RunPlan
from armdrive.render.canvas import draws_braille
from armdrive.render.sketch import Sketch, save_sketches, terminal_lines
from kinematics.geometry import Point
from kinematics.text import counted

T = TypeVar("T")


def run_program(options: argparse.Namespace) -> int:
    """Run or rehearse a program file."""
    program = read_program_file(options.program)
    if options.check:
        return check_program(options, program)
    with (
        contextlib.closing(connect_to_run(options)) as arm,
        stopped_by_interrupt(lambda: [arm], as_json=as_json(options)),
    ):
        return _RunningProgram(program, arm, options).run()


def _plan(source: ArmProgram, arm: Arm | None, options: argparse.Namespace) -> RunPlan:
    """Return what the options ask for, from its beginning or from where it was interrupted."""
    plan = RunPlan(source.machine)
    if options.resume:
        how, move = resume_command(options), move_command(options)
        plan = resumed_plan(plan, source, options.program, arm, how=how, move=move)
    return plan if options.loops is None else replace(plan, loops=options.loops)


class _RunningProgram:
    """One run of a program file on a connected arm."""

    def __init__(self, program: Program, arm: Arm, options: argparse.Namespace) -> None:
        self._program = program
        self._arm = arm
        self._options = options
        self._stops = arm.stops  # a stop during the rehearsal counts as well

    def run(self) -> int:
        """Rehearse, carry out, and say how it ended."""
        plan = _plan(ArmProgram(self._program, self._arm.config), self._arm, self._options)
        seen, how = SeenArm.of(self._arm), _rehearsal_options(self._options)
        rehearsal = rehearse(seen, plan, time_limit(BEFORE_RUN_S), how)
        try:
            require_rehearsed(rehearsal, anyway=self._options.yes)
        except BaseException as error:
            if not as_json(self._options):
                show_place(rehearsal.at, self._program.lines, rehearsal.refusal or error)
            raise
        self._arm.enable()
        with Display(self._program.lines, as_json=as_json(self._options)).shown() as display:
            self._begin(display, rehearsal, plan)
            person = RunTerminal(self._arm, display, standard_input().keys)
            performer = Performer(self._arm, person, since=self._stops, outputs=plan.outputs)
            return self._carry_out(plan, performer, display)

    def _begin(self, display: Display, rehearsal: Rehearsal, plan: RunPlan) -> None:
        progress = rehearsal.progress(plan.loops)
        display.run.use(self._arm)
        display.run.follow(progress, share=rehearsal.share, loops=plan.loops)
        total_s = progress.total_s
        takes = "" if total_s is None else f", about {duration(total_s)}"
        if rehearsal.endless is not None or not rehearsal.whole:
            takes = f", rehearsed for {duration(rehearsal.took_s)}{rehearsal.end_words}"
        assumed = "".join(f"\nassumed: {each}" for each in rehearsal.assumptions)
        event = {
            "event": "begin",
            "program": str(self._options.program),
            "arm": self._arm.config.name,
            "simulated": self._arm.simulated,
            "left_s": None if total_s is None else round(total_s, 1),
            "rehearsed_whole": rehearsal.whole,
            "endless": None if rehearsal.endless is None else rehearsal.endless.line,
            "assumptions": [str(each) for each in rehearsal.assumptions],
        }
        display.tell(event, f"{self._options.program}{takes}{assumed}")

    def _carry_out(self, plan: RunPlan, performer: Performer, display: Display) -> int:
        path, digest = self._options.program.resolve(), self._program.digest
        journal = Journal(self._arm, performer, path, digest, plan.loops)

        def wait(step: RunStep, _: Machine) -> None:
            if self._options.step and step.moves:
                line = display.run.line_at(step.mark) or step.name
                performer.hold(line_words(step.mark.line, line))

        before = [journal.begins, wait, display.begins]
        run = ProgramRun(plan, performer, before=before, after=[display.ended])
        try:
            run.carry_out()
        except BaseException as error:
            mark = mark_of(error, None if run.at is None else run.at.mark)
            resume = "" if run.at is None else resume_command(self._options)
            text = f"ended early: {counted(run.done, 'act')} done; {stands_at(self._arm)}"
            display.failed(mark, error, text, resume)
            raise
        finally:
            keep_recording(self._arm, self._options)
        journal.finish()
        text = f"{counted(run.done, 'act')} in {duration(run.took_s)}; {stands_at(self._arm)}"
        display.finished(self._arm, run.done, run.took_s, text)
        return 0


# The commands that resume an interrupted program: on the same arm, and no faster.


def resume_command(options: argparse.Namespace) -> str:
    """Return the command that resumes this run, as carefully as it was begun."""
    how = typed_again(options, "speed", "pace", "assume_width", "step")
    for number, on in options.input:
        how += ["--input", f"{number}={'on' if on else 'off'}"]
    # without --yes, which a person has to give again
    return command_line("run", options.program, *_which(options), *how, "--resume")


def move_command(options: argparse.Namespace) -> str:
    """Return the beginning of a command that moves the arm of this run."""
    return command_line("move", *_which(options), *typed_again(options, "speed"))


def _which(options: argparse.Namespace) -> list[str]:
    return typed_again(options, *ARM_OPTIONS, "allow_restored")


# Rehearsing only: what was found, for people and for programs, and a picture of the tip's path.


def check_program(options: argparse.Namespace, program: Program) -> int:
    """Rehearse a program file on the arm that the options name, and report what was found."""
    source = ArmProgram(program, chosen_target(options).config)
    seen, plan, unasked = _seen(options, lambda arm: _plan(source, arm, options))
    rehearsal = rehearse(seen, plan, time_limit(CHECK_S), _rehearsal_options(options))
    return report(rehearsal, options, program.lines, unasked)


def _seen(options: argparse.Namespace, look: Callable[[Arm | None], T]) -> tuple[SeenArm, T, str]:
    """Ask the arm where it stands, have another look at it, and let it go again.

    The last result says why the arm could not be asked; `look` got None then.
    """
    try:
        with contextlib.closing(connect_to_run(options)) as arm:
            return SeenArm.of(arm), look(arm), ""
    except (LinkError, ArmInUse, DeviceFault) as error:
        target = chosen_target(options)
        unasked = f"the {target.config.title} cannot be asked where it stands ({error})"
        return SeenArm.unasked(target), look(None), unasked


def _rehearsal_options(options: argparse.Namespace) -> RehearsalOptions:
    """Return what the options say about a rehearsal."""
    return RehearsalOptions(
        dict(options.input), options.assume_width, options.check, options.plot is not None
    )


def report(
    rehearsal: Rehearsal, options: argparse.Namespace, lines: SourceLines, unasked: str
) -> int:
    """Report a rehearsal, draw the path if that is wanted; raise what refused it."""
    drawn = Path(options.plot) if options.plot else None
    view = {"event": "rehearsal", "not_asked": unasked or None, **rehearsal_view(rehearsal)}
    text = rehearsal_lines(rehearsal, lines) + [f"assumed: {unasked}"] * bool(unasked)
    show(Result(view, text), options)
    if drawn is not None or (options.plot is not None and not as_json(options)):
        draw_path(rehearsal.path, f"path of the tip in {options.program.name}", drawn)
    if drawn is not None:
        tell(options, f"path written to {drawn}")
    if rehearsal.refusal is not None:
        if not as_json(options):
            show_place(rehearsal.at, lines, rehearsal.refusal)
        raise rehearsal.refusal
    return 0


def draw_path(path: Sequence[Point], title: str, output: Path | None) -> None:
    """Draw the tip's path from the side and from above, into a file or into the terminal."""
    side = tuple((math.hypot(x, y), z) for x, y, z in path)
    above = tuple((x, y) for x, y, _ in path)
    sketches = (
        Sketch((side,), (), "distance from the base axis", "height z"),
        Sketch((above,), (), "x", "y"),
    )
    if output is not None:
        save_sketches(sketches, title, output)
        return
    for line in terminal_lines(sketches, braille=draws_braille()):
        say(line)
