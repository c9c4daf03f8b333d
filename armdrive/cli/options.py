"""Parsers of commands and actions, made from their help; the kinds of values; an arm's options.

The docstring of a command is its help, and the lists of options there declare them: `add_options`.
"""

from __future__ import annotations

import argparse
import inspect
import itertools
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, NoReturn

from armdrive.errors import BadRequest
from armdrive.registry import DIALECTS
from armdrive.text.numbers import number, parse_speed, whole
from kinematics.errors import nearest_word
from kinematics.text import filled, folded, sentence

# Declares the options of a command or an action, most of them by its docstring: `add_options`.
#
# The docstring of a command is its help: a sentence, options, notes and examples. An action's
# sentence is that of its row.
Declare = Callable[[argparse.ArgumentParser], None]

# Reads a value as a person types it, or lists those that there are.
Value = Callable[[str], Any] | Collection[str]


@dataclass(frozen=True, slots=True, eq=False)
class Action:
    """An action of a command, as `list` of `points`: its line of help, its function, its options.

    The function is written `drive.points:show`; its module is imported when the action runs.
    """

    summary: str
    function: str
    declare: Declare


def add_actions(parser: argparse.ArgumentParser, actions: Mapping[str, Action]) -> None:
    """Add the actions of a command; the caller has to name one of them."""
    listed = parser.add_subparsers(dest="action", required=True, metavar="ACTION", prog=parser.prog)
    for name, row in actions.items():
        words = help_of(row.declare, row.summary)
        action = listed.add_parser(name, help=row.summary, **words)
        row.declare(action)
        found = examples(parser, action.prog)
        if found and not examples(action, action.prog):  # the command shows them for its actions
            action.epilog = "\n".join([action.epilog or "", "", "Examples:", *found]).lstrip()
        action.set_defaults(function=row.function)


NOTHING: Mapping[str, Any] = MappingProxyType({})


class HelpFormatter(argparse.HelpFormatter):
    """Prints a usage line of one line: names of options stand below it, with what they mean.

    Paragraphs are filled to the width of the terminal. Indented lines, such as examples, stay
    lines, and are folded if they are too long.
    """

    def add_usage(
        self,
        usage: str | None,
        actions: Iterable[argparse.Action],
        groups: Iterable[argparse._MutuallyExclusiveGroup],  # noqa: ARG002
        prefix: str | None = None,
    ) -> None:
        """Show what has to be typed, and that there are options."""
        needed = [each for each in actions if each.required or not each.option_strings]
        others = argparse.Action(["OPTIONS"], "options", nargs=0)
        super().add_usage(usage, [*needed, others], (), prefix)

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        rows: list[str] = []
        for is_prose, lines in itertools.groupby(text.splitlines(), _is_prose):
            if is_prose:
                rows += filled(" ".join(lines), width)
            else:
                rows += [row for line in lines for row in folded(line, width)]
        return "\n".join(f"{indent}{row}" for row in rows)

    def _split_lines(self, text: str, width: int) -> list[str]:
        return filled(" ".join(text.split()), width)


def _is_prose(line: str) -> bool:
    return bool(line) and not line.startswith(" ")


def examples(parser: argparse.ArgumentParser, prog: str) -> list[str]:
    """Return the lines of a parser's help that show how `prog` is typed, and what it then does.

    An example that goes on on the next line is left out.
    """
    lines = (parser.epilog or "").splitlines()
    shown = [line for line in lines if line.strip().startswith(f"{prog} ")]
    return [line for line in shown if not line.endswith("\\")]


class CommandParser(argparse.ArgumentParser):
    """An argument parser whose errors are exceptions, which the runner prints as any other."""

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        """Read a value. A refusal keeps its own words, which argparse would hide."""
        try:
            return super()._get_value(action, arg_string)
        except argparse.ArgumentError as error:
            if isinstance(error.__context__, BadRequest):
                raise argparse.ArgumentError(action, str(error.__context__)) from None
            raise

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuse words that are left over: the parser of an action knows what it takes."""
        known, left = super().parse_known_args(args, namespace)
        if left:
            self.error(f"unrecognized arguments: {' '.join(left)}")
        return known, left

    def error(self, message: str) -> NoReturn:
        """Raise `BadRequest` with what is wrong, how the command is typed, and where help is."""
        words = message.removeprefix("argument ")
        if found := re.fullmatch(_UNKNOWN, words):
            word = found[1].partition("=")[0]
            words = (
                f"there is no option {word}"
                if word[0] == "-"
                else f"{word!r} is one argument too many"
            )
            words += _nearest(word, self._option_string_actions)
        usage = " ".join(self.format_usage().split()).removeprefix("usage: ")
        typed = f"type `{usage}`"
        if shown := examples(self, self.prog):
            command = re.split(" {2,}", shown[0].strip())[0]  # what it does stands behind it
            typed += f", as in `{command}`"
        raise BadRequest(f"{words}; {typed}; see `{self.prog} --help`")


def _nearest(word: str, known: Iterable[str]) -> str:
    """Return a hint at the most similar word; the dashes that options share do not count."""
    bare = {each.lstrip("-"): each for each in known}
    near = nearest_word(word.lstrip("-"), bare)
    return f" (did you mean {bare[near]}?)" if near else ""


_UNKNOWN = r"(?s)unrecognized arguments: (\S+).*"


# The help of a command, which declares its options.

# Headings of options of which one may be given at most, and of those that have to be given.
EXCLUSIVE, REQUIRED = "One of", "Required"

# Headings that make no group of their own in the help. All others do.
PLAIN = (EXCLUSIVE, REQUIRED, "Operands", "Options")

# Ends the help of an option that may be given several times: its value is a list.
REPEATED = "may be repeated"

_OPTIONS = re.compile(
    r"(?P<heading>[^\n]+):\n(?P<items>  --(?:.|\n)*)|Operands:\n(?P<operands>(?:.|\n)*)"
)


def help_of(declare: Declare, summary: str = "") -> Any:
    """Return the arguments of a parser that make the help of a command, or of an action."""
    first, *notes = (part for part in _paragraphs(declare) if not _OPTIONS.fullmatch(part))
    return {
        "description": sentence(summary) if summary else first,
        "formatter_class": HelpFormatter,
        "epilog": "\n\n".join(notes),
    }


def add_options(
    parser: argparse._ActionsContainer,
    declared: Callable[..., Any],
    values: Mapping[str, Value] = NOTHING,
) -> None:
    """Add the arguments and options that stand in the docstring of a function.

    They stand below a heading, a line each, as people type them, with their help two spaces or more
    to the right, or in deeper lines below:

        Operands:
          JOINT ...        at least one; [JOINT ...] may be none, [FILE] one or none

        Options:
          --line            without a value
          --speed SPEED     a fraction of the limits
          --plot [FILE]     draw the path, into a file or here
          --set NAME=VALUE  a list of values, because its help ends so: may be repeated

    Of options below `One of:` only one may be given, those below `Required:` have to be. Any other
    heading is that of a group in the help. `values` says of which kind a value is, as the table
    `VALUES` does, by its name or by its whole option. Percent signs need no doubling;
    `%(default)g` and `%(choices)s` are what argparse makes of them.
    """
    if declared.__doc__ is None:
        raise BadRequest("the options of commands stand in docstrings: run Python without -OO")
    kinds = {**VALUES, **values}
    for part in _paragraphs(declared):
        found = _OPTIONS.fullmatch(part)
        if found is None:
            continue
        heading = found["heading"] or "Operands"
        into = parser
        if heading == EXCLUSIVE:
            into = parser.add_mutually_exclusive_group()
        elif heading not in PLAIN:
            into = parser.add_argument_group(heading[0].lower() + heading[1:])
        for typed, meaning in _items(found["items"] or found["operands"]):
            _add_option(into, typed, meaning, kinds, required=heading == REQUIRED)


def _paragraphs(declared: Callable[..., Any]) -> list[str]:
    return inspect.cleandoc(declared.__doc__ or "").split("\n\n")


def _items(lines: str) -> Iterator[tuple[str, str]]:
    """Yield what is typed, and its help, for the lines of a list."""
    for item in re.split(r"\n(?=  \S)", lines):
        typed, _, meaning = re.sub("\n +", "  ", item.strip()).partition("  ")
        yield typed, " ".join(meaning.split())


# An option and its value, or an argument; in brackets what may be left out.
_TYPED = re.compile(
    r"(?P<option>--[a-z-]+)? ?(?P<maybe>\[)?(?P<value>\S*?)(?P<more> \.\.\.)?(?(maybe)\])"
)


def _add_option(
    into: argparse._ActionsContainer,
    typed: str,
    meaning: str,
    kinds: Mapping[str, Value],
    *,
    required: bool,
) -> None:
    found = _TYPED.fullmatch(typed)
    if found is None:
        raise ValueError(f"{typed!r} is no option: two spaces stand before its help")
    option, maybe, value, more = found.group("option", "maybe", "value", "more")
    # argparse formats a help with %: `%(default)g` is meant so, all else is a percent sign
    words: dict[str, Any] = {"help": re.sub(r"%(?!\()", "%%", meaning)}
    if not value:
        into.add_argument(option, action="store_true", **words)
        return
    # the whole option first: `--assume-width MM` is above 0, other MM are any number
    kind = kinds.get(typed, kinds.get(value))
    if callable(kind):
        words["type"] = kind
    elif kind is not None:
        words["choices"] = list(kind)
    if more or maybe:
        words["nargs"] = ("*" if maybe else "+") if more else "?"
    if option is None:
        if more and maybe:
            words["default"] = []  # without it, argparse names the argument among missing ones
        into.add_argument(value.lower() + "s" * bool(more), metavar=value, **words)
        return
    if maybe:
        words |= {"const": "", "type": str}  # argparse would read the constant as it reads a value
    if meaning.endswith(REPEATED):
        words |= {"action": "append", "default": []}
    into.add_argument(option, metavar=value, required=required, **words)


def add_switches(parser: argparse._ActionsContainer, switches: Mapping[str, str]) -> None:
    """Add options without a value, each with its help."""
    for name, meaning in switches.items():
        parser.add_argument(name, action="store_true", help=meaning)


JSON_OPTION = "--json"


def add_json_option(parser: argparse.ArgumentParser) -> None:
    """Add `--json`."""
    add_switches(parser, {JSON_OPTION: "print JSON"})


# The options that name an arm and how to reach it.
ARM_OPTIONS = ("arm", "sim", "port", "dialect", "baud")


def typed_again(options: argparse.Namespace, *names: str) -> list[str]:
    """Return the words that give a command these options once more, as far as they were given."""
    words = []
    for name in names:
        value, option = getattr(options, name, None), f"--{name.replace('_', '-')}"
        if value is None or value is False:  # 0 was given
            continue
        text = f"{value:g}" if isinstance(value, float) else str(value)
        if value is True:
            words.append(option)
        elif text.startswith("-"):  # argparse would take it for an option
            words.append(f"{option}={text}")
        else:
            words += [option, text]
    return words


# Values as people type them: `type=` of an option. Each raises `BadRequest`.


def name(text: str) -> str:
    """Return a name that is not empty: with an unset variable, `--arm "$ARM"` names no arm."""
    if not text.strip():
        raise BadRequest("the name is empty")
    return text


def positive(text: str) -> float:
    """Return a number above 0."""
    value = number(text)
    if value <= 0.0:
        raise BadRequest(f"{text!r} is not above 0")
    return value


def duration(text: str) -> float:
    """Return a time in seconds that is not negative."""
    value = number(text)
    if value < 0.0:
        raise BadRequest(f"{text!r} is below 0")
    return value


def count(text: str) -> int:
    """Return a whole number above 0."""
    return whole(text, 1)


def loops(text: str) -> int:
    """Return a whole number, where 0 stands for no end."""
    return whole(text, 0)


def named_number(text: str) -> tuple[str, float]:
    """Return the name and the number of `shoulder=40`; a name may be typed with - for _."""
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise BadRequest(f"write NAME=DEGREES, such as shoulder=40, not {text!r}")
    return name.strip().replace("-", "_"), number(value)


# The kind of a value, by its name in the help; one without a row is a text.
VALUES: Mapping[str, Value] = MappingProxyType({
    "NAME": name, "PORT": name, "RATE": count, "DIALECT": DIALECTS, "FILE": Path,
    "FACTOR": positive, "SECONDS": positive, "MM": number, "DEG": number, "SPEED": parse_speed,
})  # fmt: skip


# The options that choose an arm, and whether to trust its position.


def add_arm_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose an arm."""
    group = _add_choice(parser, "the default arm or the simulated TeachMover")
    add_switches(group, {"--fresh": "start the simulated arm over"})
    add_json_option(parser)


def add_driven_arm_options(parser: argparse.ArgumentParser, otherwise: str) -> None:
    """Add the options that choose an arm that a program is driving; `otherwise` is without one."""
    _add_choice(parser, otherwise)
    add_json_option(parser)


def _add_choice(parser: argparse.ArgumentParser, otherwise: str) -> argparse._ArgumentGroup:
    """Add the options that name an arm and how to reach it.

    Options:
      --arm NAME         an arm file, by name or path
      --sim DIALECT      a simulated arm: %(choices)s
      --port PORT        a serial port or an address
      --dialect DIALECT  the dialect of the arm on --port, one of the same
      --baud RATE        the baud rate of --port
    """
    group = parser.add_argument_group("which arm", f"Without one of these options, {otherwise}.")
    add_options(group, _add_choice)
    return group


def naming(*words: str, more: Declare | None = None) -> Declare:
    """Return a function that declares names, the action's own options, and the arm."""

    def declare(action: argparse.ArgumentParser) -> None:
        for word in words:
            action.add_argument(word, metavar=word.upper())
        if more is not None:
            more(action)
        add_arm_options(action)

    return declare


EVERY_DRIVEN = "every arm that your programs are driving"
ONLY_DRIVEN = "the only arm that your programs are driving"


def names_arm(options: argparse.Namespace) -> bool:
    """Return whether the options name an arm; otherwise the default one is meant."""
    return any(getattr(options, name) for name in ARM_OPTIONS)


def add_allow_restored(parser: argparse.ArgumentParser) -> None:
    """Add `--allow-restored`, for a command that plans motion."""
    meaning = "trust the position that an earlier command saved, without asking"
    add_switches(parser, {"--allow-restored": meaning})


def add_force_option(parser: argparse._ActionsContainer) -> None:
    """Add `--force`, for a command that writes a file that a person names."""
    add_switches(parser, {"--force": "overwrite an existing file"})
