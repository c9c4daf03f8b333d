"""Completion in the shell: `armdrive completion bash` prints a script, which shtab writes.

shtab reads the same parsers that read the command line, so the script knows every command and
option.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import shtab

from armdrive.cli.commands import EXIT_CODES_TOPIC, GROUPS
from armdrive.cli.drive.arguments import ARGUMENTS as DRIVE
from armdrive.cli.learn.arguments import ARGUMENTS as LEARN
from armdrive.cli.look.arguments import ARGUMENTS as LOOK
from armdrive.cli.options import CommandParser, Declare, help_of
from armdrive.cli.presenter import Result
from armdrive.cli.program.arguments import ARGUMENTS as PROGRAM
from armdrive.cli.program.arguments import SCRIPT
from armdrive.cli.set_up.arguments import ARGUMENTS as SET_UP
from armdrive.errors.table import ENTRIES
from armdrive.programs.language import ENDING
from kinematics.textbook.systems import MODEL_NAMES

ALL: Mapping[str, Declare] = MappingProxyType({**DRIVE, **PROGRAM, **SET_UP, **LOOK, **LEARN})


def completion(options: argparse.Namespace) -> Result:
    """Print the script of a shell."""
    return Result(None, script(options.shell).rstrip().split("\n"), verbatim=True)


def script(shell: str) -> str:
    """Return the completion script of a shell."""
    return str(shtab.complete(whole_parser(), shell))


def whole_parser() -> CommandParser:
    """Return a parser of the whole command line, from which shtab knows what to complete where."""
    parser = CommandParser(prog="armdrive")
    commands = parser.add_subparsers(metavar="COMMAND", prog="armdrive")
    for rows in GROUPS.values():
        for name, (_, brief) in rows.items():
            command = commands.add_parser(name, help=brief, **help_of(ALL[name]))
            ALL[name](command)
            _hint(command)
    topics = commands.add_parser("help", help="explain a command")
    topics.add_argument("command", choices=[*ALL, EXIT_CODES_TOPIC])
    return parser


def _hint(parser: argparse.ArgumentParser) -> None:
    """Say for each argument of a command and of its actions what its values are."""
    for argument in parser._actions:  # noqa: SLF001 - as shtab itself reads a parser
        if isinstance(argument, argparse._SubParsersAction):  # noqa: SLF001
            for action in argument.choices.values():
                _hint(action)
        elif argument.dest in _FIXED:
            argument.choices = _FIXED[argument.dest]
        elif not argument.choices and (values := _values(argument)):
            argument.complete = values  # type: ignore[attr-defined]


# Values of arguments that are the same from day to day.
_FIXED: Mapping[str, Iterable[str]] = MappingProxyType(
    {
        "code": [row.code for row in ENTRIES],
        "model": MODEL_NAMES,
        "system": MODEL_NAMES,
    }
)


def _values(argument: argparse.Action) -> Any:
    """Return the files that complete a value, by what the argument is called."""
    if argument.dest == "program":
        return shtab.glob(f"*{ENDING}", f"*{SCRIPT}")
    if argument.type is Path or argument.metavar == "FILE" or argument.dest in ("file", "answers"):
        return shtab.FILE
    return None
