"""How soon a thread of the desk has its turn: the one that speaks to the arm waits for no picture.

The interpreter lets a thread that computes go on for 5 ms before another one that has been woken
may run. A stop passes through three threads, while the one that paints is hardly ever at rest.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator

TURN_S = 0.0005
"""`benchmarks/desk.py keys` shows what a stop gains by it, `painting` that it costs nothing."""


@contextlib.contextmanager
def short_turns() -> Iterator[None]:
    """Have threads take turns quickly for as long as this lasts, unless they do so already."""
    before_s = sys.getswitchinterval()
    sys.setswitchinterval(min(before_s, TURN_S))
    try:
        yield
    finally:
        sys.setswitchinterval(before_s)
