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
from armdrive.cli.program.run_common import connect_to_run, show_place, slow_down
from armdrive.cli.program.run_output import RunOutput
from armdrive.errors import ArmError, ArmInUse, DeviceFault, LinkError
from armdrive.errors.table import error_view
from armdrive.programs.acts import Look
from armdrive.programs.program import Machine
from armdrive.programs.progress import Took
from armdrive.programs.rehearsal import CHECK_S, Patience, Rehearsal, SeenArm
from armdrive.programs.run_view import duration, line_words
from armdrive.programs.running import RunPlan, no_machine
from armdrive.programs.script_rehearsal import rehearse_script
from armdrive.programs.scripts import own_traceback
from armdrive.render.canvas import can_braille
from armdrive.render.sketch import Sketch, save_sketches, sketch_rows
from kinematics.errors import KinematicsError
from kinematics.geometry import Point

MOST_COLUMNS, MOST_ROWS = 110, 30


def look_at_arm(
    options: argparse.Namespace, planned: Callable[[Arm | None], RunPlan]
) -> tuple[SeenArm, RunPlan, str]:
    """Connect to ask where the arm stands, plan a rehearsal, and let the arm go again.

    The text says why the arm could not be asked, if it could not.
    """
    try:
        arm = connect_to_run(options)
    except (LinkError, ArmInUse, DeviceFault) as error:
        target = chosen_target(options)
        why = f"the {target.config.title} cannot be asked where it stands ({error})"
        return SeenArm(target.config), planned(None), why
    with contextlib.closing(arm):
        slow_down(arm, options)
        return SeenArm.of(arm), planned(arm), ""


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
    rehearsal: Rehearsal, options: argparse.Namespace, lines: list[str], unasked: str
) -> int:
    """Say what a rehearsal found, draw the path where that is wanted; raise what refused it."""
    output = Path(options.plot) if options.plot else None
    view = {"event": "rehearsal", "not_asked": unasked or None, **rehearsal_view(rehearsal)}
    text = rehearsal_lines(rehearsal, lines) + [f"assumed: {unasked}"] * bool(unasked)
    show(Result(view, text), options)
    if output is not None or (options.plot is not None and not as_json(options)):
        draw_path(rehearsal.path, f"path of the tip in {options.program.name}", output)
    if output is not None:
        tell(options, f"path written to {output}")
    if rehearsal.refusal is not None:
        if not as_json(options):
            show_place(rehearsal.at, lines, rehearsal.refusal)
        raise rehearsal.refusal
    return 0


def rehearsal_lines(rehearsal: Rehearsal, lines: Sequence[str]) -> list[str]:
    """Return a rehearsal as lines of text: what each line takes, and how often."""
    found = []
    acts = [each for loop in rehearsal.loops for each in loop]
    for line in dict.fromkeys(each.mark.line for each in acts):
        took = [each for each in acts if each.mark.line == line]
        count = _times(took)
        times = f" x {count}" if count > 1 else ""
        text = lines[line - 1].strip() if 0 < line <= len(lines) else took[0].what
        found.append(f"{duration(_total_s(took) / count):>12}{times:<6} {line_words(line, text)}")
    runs = len([loop for loop in rehearsal.loops if loop])
    loops = f", {runs} loops" if runs > 1 else ""
    found.append(
        f"{duration(rehearsal.took_s):>12} for {len(acts)} acts{loops}{rehearsal.end_words}"
    )
    found += [f"assumed: {each}" for each in rehearsal.assumptions]
    return found


def rehearsal_view(rehearsal: Rehearsal) -> dict[str, Any]:
    """Return a rehearsal as plain data."""
    refusal, at = rehearsal.refusal, rehearsal.at
    return {
        "took_s": round(rehearsal.took_s, 3),
        "acts": sum(map(len, rehearsal.loops)),
        "whole": rehearsal.whole,
        "endless": None if rehearsal.endless is None else rehearsal.endless.line,
        "lines": _by_line([each for loop in rehearsal.loops for each in loop]),
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


def _by_line(acts: Sequence[Took]) -> list[dict[str, Any]]:
    lines = dict.fromkeys(each.mark.line for each in acts)
    return [
        {
            "line": line,
            "times": _times(took := [each for each in acts if each.mark.line == line]),
            "took_s": round(_total_s(took), 3),
        }
        for line in lines
    ]


def _times(took: Sequence[Took]) -> int:
    """Return how often a line is carried out; looks that it takes for itself are not counted."""
    return len([each for each in took if each.what != Look.__name__]) or len(took)


def _total_s(acts: Sequence[Took]) -> float:
    return sum(each.took_s for each in acts)


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


# The rehearsal of a Python script.


def check_script(options: argparse.Namespace, lines: list[str]) -> int:
    """Rehearse a script on the arm that the options name, and report what was found."""
    plan = rehearsal_plan(options)
    seen, _, unasked = look_at_arm(options, lambda _: plan)
    output = RunOutput(as_json=as_json(options))
    prints = contextlib.redirect_stdout(sys.stderr) if as_json(options) else None
    with prints or contextlib.nullcontext():
        patience = Patience(CHECK_S, output.rehearsing)
        rehearsal = rehearse_script(options.program, options.words, seen, plan, patience)
    output.wipe()
    if (code := _own_error(rehearsal, options)) is not None:
        return code
    return report(rehearsal, options, lines, unasked)


def _own_error(rehearsal: Rehearsal, options: argparse.Namespace) -> int | None:
    """Show the traceback of an error that is the script's own; return what it ends with."""
    error = rehearsal.refusal
    if error is None or isinstance(error, ArmError | KinematicsError):
        return None
    put_error(own_traceback(error, options.program))
    return 1
