"""How a running program's place and its times are written for people."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

_SAID = re.compile(r"""(?:"[^"]*"|'[^']*'|[^"'#])*(?=#)""")
"""What stands in a line before its comment; nothing where there is none."""


def place_words(view: Mapping[str, Any]) -> str:
    """Return where a program is, as a line for people."""
    percent, left_s = view["percent"], view["left_s"]
    share = "    " if percent is None else f"{percent:3.0f}%"
    left = "" if left_s is None else f"  {duration(left_s)} left"
    several = view["loops"] != 1
    loop = f"loop {view['loop']}  " if several else ""
    return f"{share}  {loop}{line_words(view['line'], view['text'] or view['act'])}{left}"


def line_words(line: int | None, text: str) -> str:
    """Return a line of a program with its number, where anybody knows that, and no comment."""
    said = _SAID.match(text)
    text = said.group().rstrip() if said else text
    return f"line {line}: {text}" if line else text


def duration(time_s: float) -> str:
    """Return a time for people: seconds, or minutes and seconds, or hours and minutes."""
    if time_s < 60.0:
        return f"{time_s:.1f} s" if time_s < 10.0 else f"{time_s:.0f} s"
    minutes, seconds = divmod(round(time_s), 60)
    if minutes < 60:
        return f"{minutes} min {seconds} s"
    return f"{minutes // 60} h {minutes % 60} min"
