"""What a rehearsal found, for people and for programs, and a picture of the tip's path."""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.presenter import Result, as_json, put_error, say, show, tell
from armdrive.cli.program.run_common import connect_to_run, slow_down
from armdrive.cli.program.run_output import RunOutput
from armdrive.errors import ArmError, ArmInUse, DeviceFault, LinkError
from armdrive.errors.table import error_view
from armdrive.programs.problems import SourceLines
from armdrive.programs.program import Machine
from armdrive.programs.progress import duration, line_words
from armdrive.programs.rehearsal import CHECK_S, Patience, Rehearsal, SeenArm
from armdrive.programs.running import RunPlan, no_machine
from armdrive.programs.script_rehearsal import rehearse_script
from armdrive.programs.scripts import own_traceback
from armdrive.render.canvas import can_braille
from armdrive.render.sketch import Sketch, save_sketches, sketch_rows
from kinematics.errors import KinematicsError
from kinematics.geometry import Point

MOST_COLUMNS, MOST_ROWS = 110, 30


def check(
    options: argparse.Namespace,
    lines: SourceLines,
    planned: Callable[[Arm | None], RunPlan],
    performed: Callable[[SeenArm, RunPlan, Patience], Rehearsal],
) -> int:
    """Ask the arm where it stands, let it go again, rehearse, and report what was found."""
    try:
        with contextlib.closing(connect_to_run(options)) as arm:
            slow_down(arm, options)
            seen, plan, unasked = SeenArm.of(arm), planned(arm), ""
    except (LinkError, ArmInUse, DeviceFault) as error:
        target = chosen_target(options)
        seen, plan = SeenArm(target.config), planned(None)
        unasked = f"the {target.config.title} cannot be asked where it stands ({error})"
    output = RunOutput(as_json=as_json(options))
    rehearsal = performed(seen, plan, Patience(CHECK_S, output.rehearsing))
    output.wipe()
    if isinstance(rehearsal.refusal, ArmError | KinematicsError | None):
        return report(rehearsal, options, lines, unasked)
    put_error(own_traceback(rehearsal.refusal, options.program))
    return 1


def rehearsal_plan(
    options: argparse.Namespace, source: Callable[[], Machine] = no_machine
) -> RunPlan:
    """Return what a rehearsal assumes, as the options say."""
    return RunPlan(
        source,
        inputs=dict(options.input),
        width_mm=options.assume_width,
        settle=options.check,
        traced=options.plot is not None,
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
        output = RunOutput(as_json=as_json(options))
        output.place(rehearsal.at, lines, rehearsal.refusal)
        raise rehearsal.refusal
    return 0


def rehearsal_lines(rehearsal: Rehearsal, lines: SourceLines) -> list[str]:
    """Return a rehearsal as lines of text: what each line takes, and how often."""
    found = []
    for line, count, took in rehearsal.by_line():
        times = f" x {count}" if count > 1 else ""
        text = lines.get((took.mark.file, line), took.what).strip()
        found.append(f"{duration(took.took_s / count):>12}{times:<6} {line_words(line, text)}")
    runs = len([loop for loop in rehearsal.loops if loop])
    loops = f", {runs} loops" if runs > 1 else ""
    acts = sum(map(len, rehearsal.loops))
    found.append(f"{duration(rehearsal.took_s):>12} for {acts} acts{loops}{rehearsal.end_words}")
    return found + [f"assumed: {each}" for each in rehearsal.assumptions]


def rehearsal_view(rehearsal: Rehearsal) -> dict[str, Any]:
    """Return a rehearsal as plain data."""
    refusal, at = rehearsal.refusal, rehearsal.at
    return {
        "took_s": round(rehearsal.took_s, 3),
        "acts": sum(map(len, rehearsal.loops)),
        "whole": rehearsal.whole,
        "endless": None if rehearsal.endless is None else rehearsal.endless.line,
        "lines": [
            {"line": line, "times": times, "took_s": round(took.took_s, 3)}
            for line, times, took in rehearsal.by_line()
        ],
        "assumptions": [
            {
                "line": None if each.mark is None else each.mark.line,
                "text": each.text,
                "matters": each.matters,
            }
            for each in rehearsal.assumptions
        ],
        "refused": None if refusal is None else error_view(refusal),
        "line": None if at is None else at.line,
    }


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
    braille = can_braille(sys.stdout.encoding, os.environ)
    columns, rows = shutil.get_terminal_size()
    width = (min(columns - 1, MOST_COLUMNS) - 1) // 2
    height = max(min(rows - 6, MOST_ROWS), 8)
    pictures = [sketch_rows(each, width, height, braille=braille) for each in sketches]
    for row in zip(*pictures, strict=True):
        say(" ".join(row).rstrip())
    for sketch in sketches:
        say(sketch.caption)


def check_script(options: argparse.Namespace, lines: SourceLines) -> int:
    """Rehearse a script on the arm that the options name, and report what was found."""

    def performed(seen: SeenArm, plan: RunPlan, patience: Patience) -> Rehearsal:
        # what a script prints is no JSON: it goes where the words for people go
        prints = contextlib.redirect_stdout(sys.stderr) if as_json(options) else None
        with prints or contextlib.nullcontext():
            return rehearse_script(options.program, options.words, seen, plan, patience)

    return check(options, lines, lambda _: rehearsal_plan(options), performed)
