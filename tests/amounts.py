"""How much is tried: a sample every day, all of it with THOROUGH=1 in the environment."""

from __future__ import annotations

import os

THOROUGH = os.environ.get("THOROUGH", "0") not in ("", "0")


def amount(everyday: int, thorough: int) -> int:
    """Return one of two numbers of rounds, examples or frames."""
    return thorough if THOROUGH else everyday
