"""What a sentence asks a person to do, in the words of each interface: one table.

A sentence names an action as a Python program calls it, in backquotes: "look at the arm, then call
`reset()`". That is right if a Python program catches the error. Every other interface prints the
sentence through `presented`, which puts in its own words: "run `armdrive reset`" on the command
line, "type `reset`" at the prompt of `armdrive shell`, "press R" at the desk. So a sentence may
pass through statuses, records and sockets, and is right wherever it is printed. Every Python call
that a sentence names has a row here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True, slots=True)
class Wording:
    """An action in the words of a Python program and of the other interfaces.

    `{name}` in `desk` stands for the key of that row of the desk's table.
    """

    python: str
    command_line: str
    shell: str
    desk: str


# Actions that every interface offers: "call `reset()`" asks for one, "`reset()`" names it.
ACTIONS = (
    Wording("reset()", "armdrive reset", "reset", "{reset}"),
    Wording("enable()", "armdrive enable", "enable", "{motors}"),
    Wording("disable()", "armdrive disable", "disable", "{motors}"),
    Wording("home()", "armdrive home", "home", "{reference}"),
)

# Whole phrases, for actions that some interfaces offer only in a roundabout way.
PHRASES = (
    Wording(
        "call `reference.confirm_restored()`, or connect with `allow_restored=True`",
        "run the command in a terminal and answer its question, or add `--allow-restored`",
        "type `home`, or start the shell with `--allow-restored`",
        "press {confirm}",
    ),
    Wording(
        "call `home()` with an operator, run the program with `armdrive run` in a terminal",
        "run `armdrive home` in a terminal",
        "type `home` in a terminal",
        "press {reference}",
    ),
    Wording(
        "call `reference.verify()` with an operator",
        "run `armdrive verify` in a terminal",
        "leave the shell and run `armdrive verify` in a terminal",
        "leave the desk and run `armdrive verify`",
    ),
    Wording(
        "call `reference.declare()`",
        "run `armdrive home --declare JOINT=DEG ...`",
        "leave the shell and run `armdrive home --declare JOINT=DEG ...`",
        "leave the desk and run `armdrive home --declare JOINT=DEG ...`",
    ),
    Wording(
        "call `gripper.open()` or `gripper.close()`",
        "run `armdrive move --gripper MM`",
        "type `open_now` or `close_now`",
        "press {grip-open} or {grip-closed}",
    ),
    Wording(
        "call `gripper.close()` with a width",
        "run `armdrive move --gripper MM`",
        "type `open_now` with a width",
        "use the gripper's jog keys",
    ),
    Wording(
        "call `resume()`, or run `armdrive resume` in another terminal",
        "run `armdrive resume`",
        "run `armdrive resume` in another terminal",
        "run `armdrive resume` in another terminal",
    ),
    Wording("call `reconnect()`", "run the command again", "type `reconnect`", "press {reconnect}"),
    Wording(
        "add `again=True` to replace the present one",
        "add `--again` to replace the present one",
        "type `remember` to replace the present one",
        "press {points-again} on it",
    ),
    Wording("add `overwrite=True`", "add `--force`", "add `over`", "remove it first"),
    Wording("call `moved_to()`", "add `--shift`", "add `--shift`", "add `--shift`"),
    Wording("call `without_origin()`", "add `--as-is`", "add `--as-is`", "add `--as-is`"),
)

# Python's words, with the words of an interface for each.
Words = Mapping[str, str]


def _words(pairs: Iterator[tuple[str, str]]) -> Words:
    """Return the pairs with the longest first, and each at the beginning of a sentence too."""
    both = {}
    for python, own in sorted(pairs, key=lambda pair: -len(pair[0])):
        both[python] = own
        both[python[0].upper() + python[1:]] = own[0].upper() + own[1:]
    return MappingProxyType(both)


def _pairs(verb: str, quote: str, own: Callable[[Wording], str]) -> Iterator[tuple[str, str]]:
    """Yield every wording in Python with an interface's own, whose verb asks for an action."""
    for action in ACTIONS:
        shown = f"{quote}{own(action)}{quote}"
        yield f"call `{action.python}`", f"{verb} {shown}"
        yield f"`{action.python}`", shown
    yield from ((phrase.python, own(phrase)) for phrase in PHRASES)


COMMAND_LINE = _words(_pairs("run", "`", lambda row: row.command_line))
SHELL = _words(_pairs("type", "`", lambda row: row.shell))


def desk_words(label: Callable[[str], str]) -> Words:
    """Return the words of the desk; `label` returns the label of the key of a row."""

    def own(row: Wording) -> str:
        return re.sub(r"\{([a-z-]+)\}", lambda found: label(found[1]), row.desk)

    return _words(_pairs("press", "", own))


def presented(sentence: str, words: Words) -> str:
    """Return a sentence in the words of an interface; presenting it again changes nothing."""
    if "`" not in sentence:
        return sentence
    pattern = "|".join(map(re.escape, words))
    return re.sub(pattern, lambda found: words[found[0]], sentence)
