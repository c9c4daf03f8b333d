"""What a person is told of a line that cannot be read."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from types import MappingProxyType

from lark import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from armdrive.programs.vocabulary import RESERVED, SHAPES, SPELLINGS
from kinematics.errors import suggestion

FOREIGN: Mapping[str, str] = MappingProxyType({
    "for": "`repeat 3 as i`",
    "elif": "`else if`",
    "endif": "`end`",
    "wend": "`end`",
    "next": "`end` or `continue`",
    "until": "`while not ...`",
    "print": "`type`",
    "say": "`type`",
    "sleep": "`delay`",
    "gosub": "the name of a subprogram, as `fetch(pick)`",
    "call": "the name of a subprogram, as `fetch(pick)`",
    "def": "`define`",
    "sub": "`define`",
    "let": "`x = 3`",
    "set": "`x = 3`",
})  # fmt: skip
"""What words of other languages are called here."""

_CHANGES = (":=", "+=", "-=", "*=", "/=")

_FIRST = re.compile(r"\s*(?:\d+\s*:?\s*)?([A-Za-z_][A-Za-z0-9_]*)")

_EXPECTED: Mapping[str, str] = MappingProxyType({
    "NUMBER": "a value", "PERCENT": "a value", "TEXT": "a value", "TRUTH": "a value",
    "JOINTS": "a value", "LPAR": "", "NOT": "a value", "MINUS": "",
    "RPAR": "`)`", "COMMA": "a comma", "EQUAL": "`=`", "NAME": "a name",
    "$END": "the end of the line",
    "PLUS": "", "TIMES": "", "OVER": "", "OR": "", "AND": "", "COMPARE": "", "DOT": "",
    "COMMENT": "", "COLON": "", "WORD": "a word", "LINK": "",
})  # fmt: skip
"""What the parser's expectations are called; nothing where naming them would only be noise."""


def mistake(error: UnexpectedInput, line: str) -> tuple[int, str]:
    """Return the column at which a line cannot be read on, and why."""
    if isinstance(error, UnexpectedCharacters):
        return error.column, _unknown_sign(line, error.column)
    column = getattr(error, "column", None)
    token = getattr(error, "token", None)
    if column is None or column < 1 or token is None or token.type == "$END":
        column, found = len(line.rstrip()) + 1, ""
    else:
        found = str(token)
    first = _first_word(line, column)
    if first is not None:
        return first
    expected = set(error.accepts or ()) if isinstance(error, UnexpectedToken) else set()
    wanted = _wanted(expected)
    if not found:
        return column, f"the line ends too early{wanted}"
    return column, f"{found!r} does not belong here{wanted}"


def _unknown_sign(line: str, column: int) -> str:
    sign = line[column - 1] if column <= len(line) else ""
    if sign == '"':
        return 'the text has no end: a `"` is missing'
    if sign.isalpha():
        return f"{sign!r} is no letter of a name: those have a to z, digits and _"
    return f"{sign!r} is no sign of a program"


def _first_word(line: str, column: int) -> tuple[int, str] | None:
    """Return what is wrong where the word that the line begins with is the mistake."""
    match = _FIRST.match(line)
    if match is None:
        return None
    word, at = match[1], match.start(1) + 1
    rest = line[match.end(1) :].lstrip()
    low = word.lower()
    if low in RESERVED and rest.startswith("=") and not rest.startswith("=="):
        return at, f"`{low}` is a word of the language: give the value another name"
    if rest.startswith(_CHANGES):
        return at, f"a value is given a name so: `{word} = ...`"
    known = low in SPELLINGS or low in SHAPES or low in RESERVED
    if known or column <= at or rest.startswith(("=", ":", "(")):
        return None
    return at, unknown_word(word, (*SPELLINGS, *SHAPES)) or (
        f"there is no word {word!r}; a subprogram takes its values in brackets: `{word}(...)`"
    )


def unknown_word(word: str, known: Iterable[str]) -> str:
    """Return that there is no such word, and which was meant; nothing where nobody can tell."""
    low = word.lower()
    if low in FOREIGN:
        return f"there is no word {word!r}; write {FOREIGN[low]}"
    near = suggestion(low, known)
    return f"there is no word {word!r}{near}" if near else ""


def _wanted(expected: set[str]) -> str:
    if "NUMBER" in expected and "LPAR" in expected:
        return ": a value is missing"
    if "WORD" in expected:
        return ": a number at the beginning of a line is a label, and a word comes after it"
    named = {_EXPECTED.get(each, f"`{each.lower()}`") for each in expected} - {""}
    listed = sorted(named)
    if not listed:
        return ""
    return ": " + " or ".join(listed) + " was expected"
