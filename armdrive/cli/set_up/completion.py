"""Completion in the shell: `armdrive completion bash` prints a script, which shtab writes.

shtab reads the same parsers that read the command line, so the script knows every command and
option. The names of arm files and points change from day to day: on Tab, the script asks `armdrive
completion --names arms` for them.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import shtab

from armdrive.cli.arm_files import default_arm
from armdrive.cli.commands import EXIT_CODES_TOPIC, GROUPS
from armdrive.cli.drive.arguments import ARGUMENTS as DRIVE
from armdrive.cli.learn.arguments import ARGUMENTS as LEARN
from armdrive.cli.look.arguments import ARGUMENTS as LOOK
from armdrive.cli.options import CommandParser, Declare, help_of
from armdrive.cli.presenter import Result
from armdrive.cli.program.arguments import ARGUMENTS as PROGRAM
from armdrive.cli.program.arguments import SCRIPT
from armdrive.cli.set_up.arguments import ARGUMENTS as SET_UP
from armdrive.connect.target import find
from armdrive.errors import ArmError
from armdrive.errors.printable import command_line
from armdrive.errors.table import ENTRIES
from armdrive.programs.language import ENDING
from armdrive.registry.arm_files import arm_paths
from armdrive.storage.point_file import points_of
from kinematics.textbook.systems import MODEL_NAMES

ALL: Mapping[str, Declare] = MappingProxyType({**DRIVE, **PROGRAM, **SET_UP, **LOOK, **LEARN})


def completion(options: argparse.Namespace) -> Result:
    """Print the script of a shell, or the names that such a script asks for."""
    if options.names is not None:
        return Result(None, NAMES[options.names]())
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
            _hint(command, name)
    topics = commands.add_parser("help", help="explain a command")
    topics.add_argument("command", choices=[*ALL, EXIT_CODES_TOPIC])
    return parser


def _hint(parser: argparse.ArgumentParser, command: str) -> None:
    """Say for each argument of a command and of its actions what its values are."""
    for argument in parser._actions:  # noqa: SLF001 - as shtab itself reads a parser
        if isinstance(argument, argparse._SubParsersAction):  # noqa: SLF001
            for action in argument.choices.values():
                _hint(action, command)
        elif argument.dest in _FIXED:
            argument.choices = _FIXED[argument.dest]
        elif not argument.choices and (values := _values(argument, command)):
            argument.complete = values  # type: ignore[attr-defined]


# Values of arguments that are the same from day to day.
_FIXED: Mapping[str, Iterable[str]] = MappingProxyType(
    {
        "code": [row.code for row in ENTRIES],
        "model": MODEL_NAMES,
        "system": MODEL_NAMES,
    }
)


def _values(argument: argparse.Action, command: str) -> Any:
    """Return what completes a value, by what the argument is called; nothing if that is free."""
    if argument.dest == "program":
        return shtab.glob(f"*{ENDING}", f"*{SCRIPT}")
    if argument.type is Path or argument.metavar == "FILE" or argument.dest in ("file", "answers"):
        return shtab.FILE
    return _ASKED.get((command, argument.dest), _ASKED.get(("", argument.dest)))


# The names that change: printed one a line for the scripts.


def _arms() -> Iterable[str]:
    return [path.stem for path in arm_paths()]


def _points() -> Iterable[str]:
    config = find(default_arm()).config
    return tuple(points_of(config.name, config.model.arm))


def _quietly(names: Callable[[], Iterable[str]]) -> Callable[[], Iterable[str]]:
    """Turn an error into no completions: a message would appear in the middle of the line."""

    def listed() -> Iterable[str]:
        try:
            return names()
        except ArmError:
            return ()

    return listed


# What a script may ask for.
NAMES: Mapping[str, Callable[[], Iterable[str]]] = MappingProxyType(
    {
        "arms": _quietly(_arms),
        "points": _quietly(_points),
    }
)


def _ask(names: str) -> Any:
    """Return what asks for names on Tab, in each shell.

    For zsh that is a function of our own. zsh would run the command that shtab writes while it
    loads the script: once for each option that takes such a name, which takes a minute.
    """
    command = f"{command_line('completion', '--names', names)} 2>/dev/null"
    asked: dict[str, Any] = dict(shtab.cmd(command))
    function = f"_armdrive_{names}"
    asked["zsh"] = function
    asked["preamble"] |= {"zsh": f'\n{function}() {{\n  compadd "$@" -- ${{(f)"$({command})"}}\n}}'}
    return asked


# What completes the values of an argument, by its command (any, where none is named).
_ASKED: Mapping[tuple[str, str], Any] = MappingProxyType(
    {
        ("", "arm"): _ask("arms"),
        ("config", "name"): _ask("arms"),
        ("config", "arms"): _ask("arms"),
        ("points", "name"): _ask("points"),
    }
)
