"""Makes text from files, devices and the command line safe to print.

A terminal acts on control characters. A title in an arm file, a device's banner or a file name
could move the cursor, change colors, rename the window or reverse the order of the letters. So all
text that a person sees passes through here, and a character that is not printable becomes an
escape.
"""

from __future__ import annotations

import os
import shlex

# Characters. A longer line of a message quotes its input at length, and loses its middle.
LONGEST_LINE = 2_000

ELLIPSIS = " ... "
_KEPT_AT_END = 400  # an error says what to do at its end


def printable(text: str) -> str:
    r"""Return text as one printable line: `\x1b` for escape, `\n` for a line break, and so on.

    Control characters (C0, DEL, C1), format characters such as bidirectional overrides, lone
    surrogates, private and unassigned characters and every space but the usual one are escaped.
    Applying this twice changes nothing.
    """
    return text if text.isprintable() else "".join(map(_shown, text))


def printable_lines(text: str) -> str:
    """Return text with its line breaks kept and every line printable."""
    return "\n".join(map(printable, text.split("\n")))


def as_message(text: str) -> str:
    """Return a message with printable lines of bounded length.

    A message may quote a wrong value, which may have thousands of digits.
    """
    return "\n".join(shortened(printable(line)) for line in text.split("\n"))


def shortened(line: str, most: int = LONGEST_LINE) -> str:
    """Return a line of at most `most` characters (100 or more), without its middle if it is longer.

    The end stays, because that is where a message says what to do.
    """
    if len(line) <= most:
        return line
    end = min(_KEPT_AT_END, most // 2)
    return f"{line[: most - end - len(ELLIPSIS)]}{ELLIPSIS}{line[-end:]}"


def reason_of(error: object) -> str:
    """Return why something failed, in the system's words where it has some, without its number."""
    return str(getattr(error, "strerror", None) or error)


def in_words(error: OSError) -> OSError:
    """Return an error of the operating system as a sentence with its file."""
    if error.filename is None or not error.strerror:
        return error
    file = os.fsdecode(error.filename)
    return OSError(
        f"{file} cannot be used ({error.strerror}): free some space, make its folder writable, or "
        "set ARMDRIVE_HOME to a writable folder"
    )


def command_line(*words: object) -> str:
    """Return an armdrive command that a person may copy; names are quoted as a shell needs it."""
    texts = ["armdrive", *map(str, words)]
    return shlex.join(texts) if os.name == "posix" else " ".join(texts)


def encodable(text: str, encoding: str | None) -> str:
    """Return text that a stream of this encoding can write, with escapes for the rest."""
    known = encoding or "utf-8"
    return text.encode(known, "backslashreplace").decode(known)


def _shown(character: str) -> str:
    if character.isprintable():
        return character
    return character.encode("unicode_escape").decode("ascii")
