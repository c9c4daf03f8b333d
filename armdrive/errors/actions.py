"""What a sentence asks a person to do, in the words of each interface: one table.

A sentence names an action as a Python program calls it, in backquotes: "look at the arm, then call
`reset()`". That is right where a Python program catches the error. Every other interface shows the
sentence through `presented`, which puts that interface's own words there: "run `armdrive reset`"
on the command line, "type `reset`" at the prompt of `armdrive shell`, "press R" at the desk. So a
sentence may pass through statuses, records and sockets, and is right wherever it is shown. No
sentence names a Python call that has no row here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True, slots=True)
class Action:
    """A call of the Python API that sentences name, and what the other interfaces offer for it.

    `command_line` and `shell` are what is typed, `key` is the row of the desk's table of keys.
    """

    python: str
    command_line: str
    shell: str
    key: str


ACTIONS = (
    Action("reset()", "armdrive reset", "reset", "reset"),
    Action("enable()", "armdrive enable", "enable", "motors"),
    Action("disable()", "armdrive disable", "disable", "motors"),
    Action("home()", "armdrive home", "home", "reference"),
)
"""What every interface can do. "call `reset()`" asks for it, "`reset()`" names it."""


@dataclass(frozen=True, slots=True)
class Phrase:
    """Words that ask for what not every interface can do in one step.

    `{name}` in `desk` is the key of that row of the desk's table.
    """

    python: str
    command_line: str
    shell: str
    desk: str


PHRASES = (
    Phrase(
        "call `confirm_restored()`, or connect with `allow_restored=True`",
        "run the command in a terminal and answer its question, or add `--allow-restored`",
        "type `home`, or start the shell with `--allow-restored`",
        "press {confirm}",
    ),
    Phrase(
        "call `home()` with an operator",
        "run `armdrive home` in a terminal",
        "type `home` in a terminal",
        "press {reference}",
    ),
    Phrase(
        "call `verify()` with an operator",
        "run `armdrive verify` in a terminal",
        "leave the shell and run `armdrive verify` in a terminal",
        "leave the desk and run `armdrive verify`",
    ),
    Phrase(
        "call `declare_posture()`",
        "run `armdrive home --declare`",
        "leave the shell and run `armdrive home --declare`",
        "leave the desk and run `armdrive home --declare`",
    ),
    Phrase(
        "call `gripper.open()` or `gripper.close()`",
        "run `armdrive move --gripper MM`",
        "type `open_now` or `close_now`",
        "leave the desk and run `armdrive move --gripper MM`",
    ),
    Phrase(
        "call `gripper.close()` with a width",
        "run `armdrive move --gripper MM`",
        "type `open_now` with a width",
        "leave the desk and run `armdrive move --gripper MM`",
    ),
    Phrase(
        "call `resume()`, or run `armdrive resume` in another terminal",
        "run `armdrive resume`",
        "run `armdrive resume` in another terminal",
        "run `armdrive resume` in another terminal",
    ),
    Phrase("call `moved_to()`", "add `--shift`", "add `--shift`", "add `--shift`"),
    Phrase("call `without_origin()`", "add `--as-is`", "add `--as-is`", "add `--as-is`"),
)

Words = Mapping[str, str]
"""What stands in a sentence, to what an interface says instead."""


def _words(pairs: Iterator[tuple[str, str]]) -> Words:
    """Return the pairs with the longest first, and each at the beginning of a sentence too."""
    both = {}
    for python, said in sorted(pairs, key=lambda pair: -len(pair[0])):
        both[python] = said
        both[python[0].upper() + python[1:]] = said[0].upper() + said[1:]
    return MappingProxyType(both)


def _typed(verb: str, word: Callable[[Action], str]) -> Iterator[tuple[str, str]]:
    for action in ACTIONS:
        yield f"call `{action.python}`", f"{verb} `{word(action)}`"
        yield f"`{action.python}`", f"`{word(action)}`"


def _command_line() -> Iterator[tuple[str, str]]:
    yield from _typed("run", lambda action: action.command_line)
    yield from ((phrase.python, phrase.command_line) for phrase in PHRASES)


def _shell() -> Iterator[tuple[str, str]]:
    yield from _typed("type", lambda action: action.shell)
    yield from ((phrase.python, phrase.shell) for phrase in PHRASES)


COMMAND_LINE = _words(_command_line())
SHELL = _words(_shell())


def desk_words(label: Callable[[str], str]) -> Words:
    """Return the words of the desk; `label` gives what is printed on the key of a row."""

    def pairs() -> Iterator[tuple[str, str]]:
        for action in ACTIONS:
            yield f"call `{action.python}`", f"press {label(action.key)}"
            yield f"`{action.python}`", label(action.key)
        for phrase in PHRASES:
            said = re.sub(r"\{([a-z-]+)\}", lambda found: label(found[1]), phrase.desk)
            yield phrase.python, said

    return _words(pairs())


def presented(sentence: str, words: Words) -> str:
    """Return a sentence in the words of an interface. It may be presented more than once."""
    if "`" not in sentence:
        return sentence
    pattern = "|".join(map(re.escape, words))
    return re.sub(pattern, lambda found: words[found[0]], sentence)
