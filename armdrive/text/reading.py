"""Reads files that a person or another program wrote: text, TOML and JSON, within limits.

A command line can name any path: a device that never ends, a pipe without a writer, binary data, or
brackets nested a million deep. For every such file the caller gets one error of its own kind, soon
and without much memory. `parse_toml` and `parse_json` apply the same limits to text from elsewhere.
"""

from __future__ import annotations

import errno
import json
import re
import stat
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from armdrive.errors import ArmError
from armdrive.errors.printable import reason_of


def read_plain(path: Path, most: int) -> bytes:
    """Return the first `most` bytes of a regular file, which a link may lead to.

    Raises `OSError`.
    """
    # before the open: it would wait for the writer of a pipe, and may set off a device
    if not stat.S_ISREG(path.stat().st_mode):
        raise OSError(errno.EINVAL, "it is not a regular file", str(path))
    with path.open("rb") as file:
        return file.read(most)


# Text, TOML and JSON, within limits.

# Bytes. A hundred times the size of an arm file; a larger file is something else.
LARGEST_BYTES = 300_000

# Levels of tables and lists. No file of ours has more than six.
DEEPEST = 40
_TOO_DEEP = f"its tables and lists are nested more than {DEEPEST} deep"

# TOML promises integers of 64 bits and no more.
LARGEST_INTEGER = 2**63 - 1

# Windows' editors begin a file with this byte order mark.
_MARK = "\ufeff"

# A dotted key that nests too many tables. tomllib takes the square of their number in time, and
# more, so such a key is refused before it is parsed.
_DEEP_KEY = re.compile(
    r"""(?m)(?:^|[\[{,])[ \t]*+(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+)"""
    f"{{{DEEPEST}}}"
)

# Makes the error of a caller's kind from its sentence: usually the class itself.
Failure = Callable[[str], ArmError]


def read_bytes(
    path: Path, what: str, failure: Failure, *, most_bytes: int = LARGEST_BYTES
) -> bytes:
    """Return the content of a regular file. `what` names its kind in errors, as "the arm file".

    Raises the error that `failure` makes for anything that is missing, unreadable, not a regular
    file, or larger than `most_bytes`. A pipe or a device is not opened.
    """
    try:
        data = read_plain(path, most_bytes + 1)
    except (OSError, ValueError) as error:  # ValueError: a path with a NUL or a lone surrogate
        raise failure(f"{what} {path} cannot be read: {reason_of(error)}") from None
    if len(data) > most_bytes:
        raise failure(f"{what} {path} is larger than the limit of {most_bytes} bytes")
    return data


def read_text(path: Path, what: str, failure: Failure, *, most_bytes: int = LARGEST_BYTES) -> str:
    """Return the text of a regular file in UTF-8, without a byte order mark.

    Raises as `read_bytes` does, and for bytes that are not UTF-8.
    """
    data = read_bytes(path, what, failure, most_bytes=most_bytes)
    try:
        text = data.decode("utf-8").removeprefix(_MARK)
        return text.replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise failure(f"{what} {path} is not UTF-8 text: byte {error.start} is invalid") from None


def is_there(path: Path) -> bool:
    """Return whether a path leads to anything; a path that no file can have does not."""
    try:
        return path.exists()
    except (OSError, ValueError):  # a name that is too long, or has a NUL in it
        return False


def read_toml(path: Path, what: str, failure: Failure) -> dict[str, Any]:
    """Return a TOML file as its table. Raises as `read_text` and `parse_toml` do."""
    text = read_text(path, what, failure)
    return parse_toml(text, lambda words: failure(f"{what} {path} is not valid TOML: {words}"))


def read_json(
    path: Path, what: str, failure: Failure, *, most_bytes: int = LARGEST_BYTES
) -> object:
    """Return what a JSON file holds. Raises as `read_text` and `parse_json` do."""
    text = read_text(path, what, failure, most_bytes=most_bytes)
    return parse_json(text, lambda words: failure(f"{what} {path} is not valid JSON: {words}"))


def parse_toml(text: str, failure: Failure) -> dict[str, Any]:
    """Return the table of a TOML document within the limits of this module."""
    if _DEEP_KEY.search(text):
        raise failure(_TOO_DEEP)
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # ValueError: TOMLDecodeError among others
        raise failure(_without_newlines(error)) from None
    _require_modest(table, failure)
    return table


def parse_json(text: str, failure: Failure) -> Any:
    """Return the value of a JSON document within the limits of this module, NaN being none."""
    try:
        value = json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise failure(_without_newlines(error)) from None
    _require_modest(value, failure)
    return value


def _require_modest(value: object, failure: Failure) -> None:
    """Refuse integers beyond 64 bits, and deep nesting."""
    waiting = [(value, 0)]
    while waiting:
        found, depth = waiting.pop()
        if isinstance(found, int) and abs(found) > LARGEST_INTEGER:
            raise failure("a whole number does not fit into 64 bits")
        if depth > DEEPEST:
            raise failure(_TOO_DEEP)
        if isinstance(found, dict):
            waiting += [(each, depth + 1) for each in found.values()]
        elif isinstance(found, list):
            waiting += [(each, depth + 1) for each in found]


def _no_constant(word: str) -> NoReturn:
    raise ValueError(f"{word} is not a JSON number")


def _without_newlines(error: Exception) -> str:
    if isinstance(error, RecursionError):
        return _TOO_DEEP
    return " ".join(str(error).split())
