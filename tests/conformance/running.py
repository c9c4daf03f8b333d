"""Run one row of the table on one bench, and say what came of it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from .behaviour import Behaviour
from .bench import Bench


class Verdict(Enum):
    """What came of a row."""

    KEPT = "yes"
    BROKEN = "NO"
    NOT_APPLICABLE = "n/a"


@dataclass(frozen=True, slots=True)
class Result:
    """One row on one bench; `words` say why where it is not kept."""

    behaviour: str
    dialect: str
    transport: str
    verdict: Verdict
    words: str = ""
    took_s: float = 0.0


def run_row(
    behaviour: Behaviour, dialect: str, transport: str, make: Callable[[str], Bench]
) -> Result:
    """Run a row on a fresh bench. Whatever it raises is told in the result."""
    began_s = time.monotonic()
    try:
        with make(dialect) as bench:
            why = behaviour.lacking(bench)
            if not why:
                behaviour.run(bench)
        verdict, words = (Verdict.NOT_APPLICABLE, why) if why else (Verdict.KEPT, "")
    except Exception as error:  # told with its row, beside all the others
        verdict, words = Verdict.BROKEN, f"{type(error).__name__}: {error}"
    took_s = time.monotonic() - began_s
    return Result(behaviour.name, dialect, transport, verdict, words, took_s)
