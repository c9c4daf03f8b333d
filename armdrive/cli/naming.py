"""Remedies name a command; of an arm that was named, that command has to name it as well."""

from __future__ import annotations

import argparse
import re
import shlex

_OF_AN_ARM = ("disable", "enable", "home", "jog", "move", "reset", "status", "verify")
"""The commands that remedies tell to run, and that act on the arm that their options name."""

_MENDING = "`armdrive doctor --mend`"
"""Needs the arm file: it says what is expected."""

_COMMAND = re.compile(rf"`armdrive ((?:{'|'.join(_OF_AN_ARM)})(?: --[a-z-]+)*)`")


def with_arm(sentence: str, options: argparse.Namespace) -> str:
    """Return a sentence whose commands name the arm as the options of this one did."""
    words = _named(options)
    if not words:
        return sentence
    if getattr(options, "arm", None):
        mending = f"`armdrive doctor --arm {shlex.quote(str(options.arm))} --mend`"
        sentence = sentence.replace(_MENDING, mending)
    return _COMMAND.sub(lambda found: f"`armdrive {_insert(found[1], words)}`", sentence)


def _insert(command: str, words: str) -> str:
    if "--arm" in command:
        return command
    name, _, rest = command.partition(" ")
    return " ".join(filter(None, (name, words, rest)))


def _named(options: argparse.Namespace) -> str:
    given = [
        (f"--{name}", str(value))
        for name in ("arm", "sim", "port", "dialect")
        if (value := getattr(options, name, None))
    ]
    return shlex.join(word for pair in given for word in pair)
