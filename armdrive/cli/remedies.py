"""Remedies name a command. If this command named its arm, the next one has to name it as well."""

from __future__ import annotations

import argparse
import re
import shlex

_ARM_COMMANDS = ("disable", "enable", "home", "jog", "move", "reset", "resume", "status", "verify")
"""The commands in remedies that act on the arm that their options name."""

_MEND = "`armdrive doctor --mend`"
"""Needs the arm file, which says what is expected."""

_COMMAND = rf"`armdrive ((?:{'|'.join(_ARM_COMMANDS)})(?: --[a-z-]+)*)`"


def with_arm(sentence: str, options: argparse.Namespace) -> str:
    """Return a sentence whose commands name the arm as the options of this command do."""
    words = _arm_words(options)
    if not words:
        return sentence
    if getattr(options, "arm", None):
        mend = f"`armdrive doctor --arm {shlex.quote(str(options.arm))} --mend`"
        sentence = sentence.replace(_MEND, mend)
    return re.sub(_COMMAND, lambda found: f"`armdrive {_insert(found[1], words)}`", sentence)


def _insert(command: str, words: str) -> str:
    if "--arm" in command:
        return command
    name, _, rest = command.partition(" ")
    return " ".join(filter(None, (name, words, rest)))


def _arm_words(options: argparse.Namespace) -> str:
    given = [
        (f"--{name}", str(value))
        for name in ("arm", "sim", "port", "dialect")
        if (value := getattr(options, name, None))
    ]
    return shlex.join(word for pair in given for word in pair)
