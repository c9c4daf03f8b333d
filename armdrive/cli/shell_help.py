"""Help at the prompt, made from the tables of words; and what there is to complete."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.errors import BadRequest
from armdrive.programs.language.words import (
    FORMS,
    FUNCTIONS,
    GROUPS,
    RESERVED,
    SPELLINGS,
    WORDS,
    Function,
    Word,
    usage,
)
from kinematics.errors import suggestion

if TYPE_CHECKING:
    from armdrive.cli.shell_entries import Shell
    from armdrive.programs.machine import Context

WIDTH = 34


def help_on(word: str, context: Context) -> list[str]:
    """Return what a word means, or all words with a line each. Raises `BadRequest`."""
    low = word.strip().lower()
    if not low:
        return _everything()
    from armdrive.cli.shell_words import OWN_WORDS

    found: list[str] = []
    if low in SPELLINGS:
        found += _of_word(WORDS[SPELLINGS[low]])
    if low in FUNCTIONS:
        found += _of_function(FUNCTIONS[low])
    found += [f"{row.pattern}\n  {row.says}" for row in FORMS if row.name == low]
    if low in OWN_WORDS:
        own = OWN_WORDS[low]
        found.append(f"{own.usage}\n  {own.says}")
    named = [each for each in context.defines if each.name.lower() == low]
    found += [f"{each.name}({', '.join(each.parameters)})\n  A subprogram." for each in named]
    if not found:
        known = (*SPELLINGS, *FUNCTIONS, *OWN_WORDS, *(row.name for row in FORMS))
        raise BadRequest(f"there is no word {word!r}{suggestion(low, known)}")
    return found


def _everything() -> list[str]:
    from armdrive.cli.shell_words import OWN_WORDS

    found = ["words of a program: `help WORD` tells more, docs/programs.md everything"]
    for title, words in GROUPS.items():
        found.append(f"  {title}: {', '.join(word.name for word in words)}")
    found.append(f"  Shape: {', '.join(row.name for row in FORMS)}")
    found.append(f"  Values: {', '.join((*FUNCTIONS, 'joints', 'here'))}; a value alone is shown")
    found.append("words of the shell")
    found += [f"  {row.usage:<{WIDTH}}{row.says}" for row in OWN_WORDS.values()]
    found.append("Ctrl-C stops what moves; a block ends with `end`")
    return found


def _of_word(word: Word) -> list[str]:
    old = f"\n  old spelling: {', '.join(each.upper() for each in word.old)}" if word.old else ""
    return [f"{usage(word)}\n  {word.says}\n  {word.example}{old}"]


def _of_function(row: Function) -> list[str]:
    return [f"{row.name}(...)\n  {row.says}\n  {row.example}"]


def known_words(shell: Shell) -> list[str]:
    """Return everything that can be completed at the prompt."""
    from armdrive.cli.shell_words import OWN_WORDS

    context = shell.session.context
    return [
        *(word for word in RESERVED if len(word) > 1),
        *OWN_WORDS,
        *context.variables,
        *(define.name for define in context.defines),
        *shell.arm.points,
    ]
