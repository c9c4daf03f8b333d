"""Run a program: a program file (.arm) or a Python script (.py), rehearsed or for good.

A program file is rehearsed on the arm's simulated twin before its first motion. What was
interrupted is taken up again with --resume. From another terminal `armdrive pause`, `resume`,
`slow 20`, `stop`, `status` and `watch` work as ever; Ctrl-C stops the arm, a second one leaves at
once. docs/running.md tells more.

Examples:
  armdrive run stack.arm --check                      rehearse it; moves nothing
  armdrive run stack.arm --check --plot path.svg      with a picture of the tip's path
  armdrive run stack.arm --step                       Enter before each motion
  armdrive run stack.arm --loops 10 --speed 50
  armdrive run stack.arm --resume                     go on where it was interrupted
  armdrive run stack.py one two --check               a script, its own arguments behind its name

"""

from __future__ import annotations

import argparse
from pathlib import Path

from armdrive.cli.arm_options import add_allow_restored, add_arm_options, add_pace_option
from armdrive.cli.block_options import add_put_option
from armdrive.cli.options import number, positive
from armdrive.errors import BadRequest
from armdrive.render.sketch import check_output

PROGRAM, SCRIPT = ".arm", ".py"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "program", type=Path, metavar="PROGRAM", help=f"a {PROGRAM} or {SCRIPT} file"
    )
    parser.add_argument("words", nargs="*", metavar="WORD", help="arguments of a Python script")
    before = parser.add_argument_group("before it runs")
    before.add_argument("--check", action="store_true", help="rehearse it; moves nothing")
    before.add_argument(
        "--plot",
        nargs="?",
        const="",
        metavar="FILE",
        help="rehearse it and draw the tip's path, into a .svg or .png file or here; moves nothing",
    )
    before.add_argument(
        "--input",
        action="append",
        type=_input,
        default=[],
        metavar="N=on|off",
        help="what a rehearsal takes an input for (else off); may be repeated",
    )
    before.add_argument(
        "--assume-width",
        type=positive,
        metavar="MM",
        help="what a rehearsal's fingers find where no block is known (else nothing)",
    )
    before.add_argument(
        "--yes", action="store_true", help="run it though a rehearsal failed on an assumption"
    )
    add_put_option(before)
    how = parser.add_argument_group("how it runs")
    how.add_argument("--step", action="store_true", help="wait for Enter before each motion")
    how.add_argument(
        "--loops", type=_loops, metavar="N", help="run it so often, 0 for ever (default 1)"
    )
    how.add_argument("--speed", type=number, metavar="PERCENT", help="go slower than it asks for")
    how.add_argument("--resume", action="store_true", help="go on where it was interrupted")
    how.add_argument("--record", type=Path, metavar="FILE", help="keep a recording of the run")
    add_pace_option(how)
    add_allow_restored(parser)
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Run or rehearse the program."""
    if options.plot is not None:
        options.check = True
        _check_plot(options.plot)
    ending = options.program.suffix.lower()
    if ending == PROGRAM:
        if options.words:
            raise BadRequest(f"a program file takes no arguments: {' '.join(options.words)}")
        from armdrive.cli.program.run_program import run_program

        return run_program(options)
    if ending == SCRIPT:
        from armdrive.cli.program.run_script import run_script

        return run_script(options)
    raise BadRequest(f"{options.program} is no program: one ends in {PROGRAM} or {SCRIPT}")


def _check_plot(output: str) -> None:
    if output:
        check_output(Path(output))


def _input(word: str) -> tuple[int, bool]:
    name, _, state = word.partition("=")
    if not (name.isascii() and name.isdecimal() and int(name) > 0 and state in ("on", "off")):
        raise argparse.ArgumentTypeError(f"write it like 3=on, not {word!r}")
    return int(name), state == "on"


def _loops(word: str) -> int:
    if not (word.isascii() and word.isdecimal()):
        raise argparse.ArgumentTypeError(f"{word!r} is not a whole number from 0 on")
    return int(word)
