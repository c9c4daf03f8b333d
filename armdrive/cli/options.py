"""Parsers of commands and actions, their help, the kinds of values, and the options of an arm."""

from __future__ import annotations

import argparse
import inspect
import itertools
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

from armdrive.errors import BadRequest
from armdrive.registry import DIALECTS
from armdrive.text.numbers import number
from kinematics.errors import nearest_word
from kinematics.text import filled, folded, sentence

Declare = Callable[[argparse.ArgumentParser], None]
"""Declares the options of a command or an action.

Its docstring is the help of a command: a sentence, notes and examples. An action's sentence is that
of its row.
"""


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
        elif found := re.fullmatch(_CHOICE, words):
            known = [word.strip("'") for word in found[3].split(", ")]
            words = f"{found[1]}: {found[2]!r} is none of {', '.join(known)}"
            words += _nearest(found[2], known)
        elif found := re.fullmatch(_REQUIRED, words):
            missing = found[1] or found[2]
            known = [each.choices for each in self._actions if each.metavar == missing]
            choices = ", ".join(map(str, known[0] or ())) if known else ""
            words = f"required: {missing}{f', one of {choices}' if choices else ''}"
        elif (option := self._option_string_actions.get(words.partition(":")[0])) is not None:
            form = option.metavar if isinstance(option.metavar, str) else ""
            words = words.replace(":", f" {form}:" if form else ":", 1)
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
_CHOICE = r"(?s)(.+): invalid choice: '?(.+?)'? \(choose from (.+)\)"
_REQUIRED = r"the following arguments are required: (.+)|one of the arguments (.+) is required"
"""Complaints of argparse that are put into other words here, with the words that are known."""


def help_of(declare: Declare, summary: str = "") -> Any:
    """Return the arguments of a parser that make the help of a command, or of an action."""
    first, _, notes = inspect.cleandoc(declare.__doc__ or "").partition("\n\n")
    return {
        "description": sentence(summary) if summary else first,
        "formatter_class": HelpFormatter,
        "epilog": notes,
    }


def add_switches(parser: argparse._ActionsContainer, switches: Mapping[str, str]) -> None:
    """Add options without a value, each with its help."""
    for name, meaning in switches.items():
        parser.add_argument(name, action="store_true", help=meaning)


def add_force_option(parser: argparse._ActionsContainer) -> None:
    """Add `--force`, for a command that writes a file that a person names."""
    add_switches(parser, {"--force": "overwrite an existing file"})


_MOST_DIGITS = 18
"""Whole numbers have 64 bits wherever they go: into a file, a socket or a system call."""


JSON_OPTION = "--json"


def add_json_option(parser: argparse.ArgumentParser) -> None:
    """Add `--json`."""
    parser.add_argument(JSON_OPTION, action="store_true", help="print JSON")


ARM_OPTIONS = ("arm", "sim", "port", "dialect", "baud")
"""The options that name an arm and how to reach it."""


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
    return _whole_from(text, 1, "above 0")


def loops(text: str) -> int:
    """Return a whole number, where 0 stands for no end."""
    return _whole_from(text, 0, "from 0 on")


def _whole_from(text: str, least: int, wanted: str) -> int:
    """Return a whole number of at least `least`; `wanted` is that bound in words."""
    plain = text.isascii() and text.isdecimal() and len(text) <= _MOST_DIGITS
    if not plain or int(text) < least:
        raise BadRequest(f"{text!r} is not a whole number {wanted}")
    return int(text)


def named_number(text: str) -> tuple[str, float]:
    """Return the name and the number of `shoulder=40`; a name may be typed with - for _."""
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise BadRequest(f"write NAME=DEGREES, such as shoulder=40, not {text!r}")
    return name.strip().replace("-", "_"), number(value)


SPEED_HELP = "a fraction of the limits: 0.5 or 50%%"


# The options that choose an arm, and whether to trust its position.


def add_arm_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose an arm."""
    group = _add_choice(parser, "the default arm or the simulated TeachMover")
    group.add_argument("--fresh", action="store_true", help="start the simulated arm over")
    add_json_option(parser)


def add_driven_arm_options(parser: argparse.ArgumentParser, otherwise: str) -> None:
    """Add the options that choose an arm that a program is driving; `otherwise` is without one."""
    _add_choice(parser, otherwise)
    add_json_option(parser)


def _add_choice(parser: argparse.ArgumentParser, otherwise: str) -> argparse._ArgumentGroup:
    group = parser.add_argument_group("which arm", f"Without one of these options, {otherwise}.")
    dialects = ", ".join(DIALECTS)
    group.add_argument("--arm", metavar="NAME", type=name, help="an arm file, by name or path")
    group.add_argument(
        "--sim", metavar="DIALECT", choices=list(DIALECTS), help=f"a simulated arm: {dialects}"
    )
    group.add_argument("--port", metavar="PORT", type=name, help="a serial port or an address")
    group.add_argument(
        "--dialect",
        metavar="DIALECT",
        choices=list(DIALECTS),
        help="the dialect of the arm on --port, one of the same",
    )
    group.add_argument("--baud", type=count, metavar="RATE", help="the baud rate of --port")
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
    parser.add_argument(
        "--allow-restored",
        action="store_true",
        help="trust the position that an earlier command saved, without asking",
    )


def add_pace_option(parser: argparse._ActionsContainer) -> None:
    """Add `--pace`, for a command that runs a simulated arm as fast as the computer can."""
    parser.add_argument(
        "--pace",
        type=positive,
        metavar="FACTOR",
        help="run a simulated arm this many times as fast as real time (default: no waiting)",
    )
