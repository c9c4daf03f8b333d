"""Numbers as people type and read them: plain ones, whole ones, and speeds."""

from __future__ import annotations

import math
import re

from armdrive.errors import BadRequest


def number(word: str) -> float:
    """Return a finite number; digits are 0 to 9, with nothing between. Raises `BadRequest`."""
    try:
        value = float(word)
    except ValueError:
        raise BadRequest(f"{word!r} is not a number") from None
    if not word.isascii() or "_" in word:  # Python would take both: `1_5` for 15
        raise BadRequest(f"{word!r} is not a number")
    if not math.isfinite(value):
        raise BadRequest(f"{word!r} is not a finite number")
    return value


# Whole numbers have 64 bits wherever they go: into a file, a socket or a system call.
_WHOLE = r"\s*[+-]?[0-9]{1,18}\s*"


def whole(word: str, least: int | None = None) -> int:
    """Return a whole number, of at least `least` where that is given. Raises `BadRequest`."""
    if not re.fullmatch(_WHOLE, word) or (least is not None and int(word) < least):
        wanted = "" if least is None else f" from {least} on"
        raise BadRequest(f"{word!r} is not a whole number{wanted}")
    return int(word)


# A speed is a fraction of the arm's limits, written as `0.5` or `50%`.


def parse_speed(text: str) -> float:
    """Return the fraction that a text means: above 0 and up to 1.

    Raises `BadRequest`. A bare number above 1 is refused, because readers disagree whether 50 means
    50 % or fifty times the limits.
    """
    word = text.strip()
    percent = word.endswith("%")
    try:
        value = number(word.removesuffix("%").strip())
    except BadRequest:
        raise BadRequest(f"{text!r} is not a speed: {_how()}") from None
    fraction = value / 100.0 if percent else value
    if not 0.0 < fraction <= 1.0:
        raise BadRequest(speed_refusal(value, percent=percent))
    return fraction


def speed_refusal(value: float, *, percent: bool = False) -> str:
    """Return the sentence that refuses a number as a speed and shows how to write one."""
    shown = f"{value:g}%" if percent else f"{value:g}"
    if value <= 0.0:
        return f"a speed is above 0, not {shown}: {_how()}"
    if percent or value > 100.0:
        return f"a speed is at most 100% of the limits, not {shown}: {_how()}"
    return f"a speed is a fraction of the limits, not {shown}: {_how(value)}"


def _how(percent: float = 50.0) -> str:
    return f"write {percent / 100.0:g} or {percent:g}%"
