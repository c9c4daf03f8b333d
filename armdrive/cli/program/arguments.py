"""The options of the commands that run and make programs, and their help."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from armdrive.cli.options import (
    ONLY_DRIVEN,
    Action,
    Declare,
    Value,
    add_actions,
    add_allow_restored,
    add_arm_options,
    add_driven_arm_options,
    add_force_option,
    add_json_option,
    add_options,
    count,
    duration,
    loops,
    naming,
    positive,
)
from armdrive.errors import BadRequest
from armdrive.moves import REST_S
from armdrive.sim.world.table import TableBlock, block_of

# --- demo


DEMO_SPEED = 8.0


def _demo(parser: argparse.ArgumentParser) -> None:
    """Watch the simulated arm pick up and stack blocks.

    Options:
      --pace FACTOR  in a terminal, show it this many times faster than real time (%(default)g)
      --ascii        draw without braille characters

    The command checks the finished tower in the simulated world itself: it ends with exit code 1 if
    a block is out of place. The demonstration has a world of its own, so the simulated arm of the
    other commands does not change. On your own arm, use
    `armdrive run examples/stacking.arm`, which is rehearsed first.

    """
    add_options(parser, _demo)
    parser.set_defaults(pace=DEMO_SPEED)
    add_json_option(parser)


# --- pendant


def _into_file(action: argparse.ArgumentParser) -> None:
    add_force_option(action)
    add_allow_restored(action)


def _into_arm(action: argparse.ArgumentParser) -> None:
    """Add the options of `pendant write`.

    Options:
      --yes           do not ask before writing
      --leave-others  keep rows that are not in the file

    One of:
      --shift         change the numbers, so that rows lead to the same places as before
      --as-is         write the numbers as they are, wherever they lead now
    """
    add_options(action, _into_arm)
    add_allow_restored(action)


# Every action of `pendant`.
PENDANT_ACTIONS: Mapping[str, Action] = MappingProxyType({
    "show": Action("print the program in the arm, row by row",
                   "program.pendant:show", naming(more=add_allow_restored)),
    "read": Action("copy the program from the arm to a file",
                   "program.pendant:read", naming("file", more=_into_file)),
    "write": Action("copy a file to the arm, and check it by reading it back",
                    "program.pendant:write", naming("file", more=_into_arm)),
})  # fmt: skip


def _pendant(parser: argparse.ArgumentParser) -> None:
    """Copy the program in the arm's own memory to a file and back.

    Nothing moves. The file is text, which you can read, compare and edit.

    Examples:
      armdrive pendant show                              print the program in the arm
      armdrive pendant read monday.pendant               copy the program to a file
      armdrive pendant write monday.pendant              copy the file to the arm
      armdrive pendant write monday.pendant --shift      after the arm was homed again

    Every action prints JSON with --json.

    """
    add_actions(parser, PENDANT_ACTIONS)


# --- run


# How the name of a Python script ends.
SCRIPT = ".py"


def _run(parser: argparse.ArgumentParser) -> None:
    """Run a program file or a Python script, or only check it.

    Operands:
      PROGRAM     a .arm or .py file
      [WORD ...]  arguments of a Python script

    Rehearsal:
      --check            rehearse it, or run a script on simulated arms; moves nothing
      --plot [FILE]      rehearse it and draw the tip's path, into a .svg or .png file or here;
                         moves nothing
      --input N=on|off   the state of an input in a rehearsal (default off); may be repeated
      --assume-width MM  the width of the object that a real arm finds in a rehearsal (default none)
      --yes              run it even if the rehearsal failed because of an assumption
      --put NAME,X,Y[,WIDTH[,HEIGHT]]
                         put a block on a simulated arm's table first, or move it there, mm;
                         may be repeated

    How it runs:
      --step          wait for Enter before each motion
      --loops N       repeat it N times, 0 = endless (default 1)
      --resume        continue where it was interrupted
      --record FILE   keep a recording of the run
      --speed SPEED   slow every motion to this fraction, 0.5 or 50%
      --pace FACTOR   run a simulated arm this many times as fast as real time (default: no waiting)

    A program file is rehearsed on the arm's simulated twin before its first motion. --resume
    continues an interrupted program. `armdrive pause`, `resume`, `slow 20%`, `stop`, `status` and
    `watch` work from another terminal. Ctrl-C stops the arm; a second Ctrl-C leaves at once. See
    docs/how-to/running.md.

    Examples:
      armdrive run stack.arm --check                      rehearse it; moves nothing
      armdrive run stack.arm --check --plot path.svg      with a picture of the tip's path
      armdrive run stack.arm --step                       Enter before each motion
      armdrive run stack.arm --loops 10 --speed 50%
      armdrive run stack.arm --resume                     continue where it was interrupted
      armdrive run stack.py one two --check               a script, followed by its own arguments

    """
    add_options(parser, _run, VALUES)
    add_force_option(parser)
    add_allow_restored(parser)
    add_arm_options(parser)


def _input(word: str) -> tuple[int, bool]:
    name, _, state = word.partition("=")
    if state not in ("on", "off"):
        raise BadRequest(f"write it like 3=on, not {word!r}")
    return count(name), state == "on"


# --- shell


def _shell(parser: argparse.ArgumentParser) -> None:
    """Type the words of a program at a prompt; each runs at once.

    Options:
      --put NAME,X,Y[,WIDTH[,HEIGHT]]
                      put a block on a simulated arm's table first, or move it there, mm;
                      may be repeated
      --speed SPEED   slow every motion to this fraction, 0.5 or 50%
      --pace FACTOR   run a simulated arm this many times as fast as real time (default: no waiting)

    Each line is checked and carried out when you enter it; a block (repeat, while, if, define ...
    end) when you enter its end. Names, subprograms and the speed remain. `help` lists the words,
    and `save stack.arm` saves the lines as a program. Ctrl-C stops the arm. See
    docs/how-to/running.md.

    Examples:
      armdrive shell
      armdrive shell --arm bench
      armdrive shell --put A,250,0                a block on the simulated arm's table
      armdrive shell < morning.txt                lines of a file; ends at the first error

    """
    add_options(parser, _shell, VALUES)
    add_allow_restored(parser)
    add_arm_options(parser)


def _block(words: str) -> TableBlock:
    if not 2 <= words.count(",") <= 4:
        raise BadRequest(f"write it like A,250,0 or A,250,0,30,20, not {words!r}")
    return block_of(words.split(","))


# The kinds of values of `run` and `shell`.
VALUES: Mapping[str, Value] = MappingProxyType({
    "PROGRAM": Path, "N=on|off": _input, "--assume-width MM": positive, "N": loops,
    "NAME,X,Y[,WIDTH[,HEIGHT]]": _block,
})  # fmt: skip


# --- teach


def _teach(parser: argparse.ArgumentParser) -> None:
    """Record a program as another program moves the arm.

    Operands:
      PROGRAM         a new .arm file

    Options:
      --line          make every move a straight line
      --speed SPEED   of every move, 0.5 or 50%
      --waits         record how long the arm rested
      --rest SECONDS  how long the arm must rest at a place to record it (default %(default)g)
      --force         overwrite an existing file and its points

    Wherever the arm rests becomes a saved point, and the motion to it a line of the program, until
    Ctrl-C or the end of the other program. Recording never moves the arm. The lines are those of
    docs/reference/programs.md: edit them as you like.

    Examples:
      armdrive jog                              in one terminal: jog the arm
      armdrive teach stack.arm                  in another: Ctrl-C ends the recording
      armdrive teach stack.arm --line --speed 30%
      armdrive run stack.arm --check            rehearse it; moves nothing

    """
    add_options(parser, _teach, {"SECONDS": duration})
    parser.set_defaults(speed=1.0, rest=REST_S)
    add_driven_arm_options(parser, ONLY_DRIVEN)


ARGUMENTS: Mapping[str, Declare] = MappingProxyType(
    {
        "demo": _demo,
        "pendant": _pendant,
        "run": _run,
        "shell": _shell,
        "teach": _teach,
    }
)
