"""Which known word a misspelt one is meant for: what errors suggest.

Most programs misspell nothing, so that the library which compares words is loaded when one does.
"""

from __future__ import annotations

from collections.abc import Iterable


def nearest_word(word: str, known: Iterable[str], *, likeness: float = 0.6) -> str | None:
    """Return the known word most like this one, None where none is like it.

    `likeness` is how like it has to be: 0 to 1, as of difflib's ratio.
    """
    from difflib import get_close_matches

    near = get_close_matches(word, list(known), n=1, cutoff=likeness)
    return near[0] if near else None


def did_you_mean(
    word: str, known: Iterable[str], otherwise: str = "", *, likeness: float = 0.6
) -> str:
    """Return the question whether another word was meant; `otherwise` where none is like it."""
    near = nearest_word(word, known, likeness=likeness)
    return otherwise if near is None else f"did you mean {near!r}?"


def suggestion(word: str, known: Iterable[str]) -> str:
    """Return that question as the end of a sentence; nothing where no word is like it."""
    asked = did_you_mean(word, known)
    return f"; {asked}" if asked else ""
