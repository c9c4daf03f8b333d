"""Run one row of the table of behaviours on one bench, and return the verdict.

`BEHAVIOURS` has all rows in the order of the page, and `BENCHES` all benches.
"""

import os
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from armdrive.registry import DIALECTS

from . import (
    rows_connecting,
    rows_faults,
    rows_gripping,
    rows_homing,
    rows_jogging,
    rows_moving,
    rows_pausing,
    rows_stopping,
)
from .behaviour import Behaviour
from .bench import Bench
from .memory_bench import ThoroughMemoryBench
from .real_time_bench import PtyBench, TcpBench, UdpBench


class Verdict(Enum):
    """The verdict on a row."""

    KEPT = "yes"
    BROKEN = "NO"
    NOT_APPLICABLE = "n/a"


@dataclass(frozen=True, slots=True)
class RowResult:
    """One row on one bench; `words` say why it was not kept."""

    behaviour: str
    dialect: str
    transport: str
    verdict: Verdict
    words: str = ""
    took_s: float = 0.0


def run_row(
    behaviour: Behaviour, dialect: str, transport: str, make: Callable[[str], Bench]
) -> RowResult:
    """Run a row on a new bench; an error goes into the result."""
    began_s = time.monotonic()
    try:
        with make(dialect) as bench:
            why = behaviour.why_not_applicable(bench)
            if not why:
                behaviour.run(bench)
        verdict, words = (Verdict.NOT_APPLICABLE, why) if why else (Verdict.KEPT, "")
    except Exception as error:  # reported with its row, after all rows have run
        verdict, words = Verdict.BROKEN, f"{type(error).__name__}: {error}"
    took_s = time.monotonic() - began_s
    return RowResult(behaviour.name, dialect, transport, verdict, words, took_s)


BEHAVIOURS: tuple[Behaviour, ...] = (
    *rows_connecting.ROWS,
    *rows_homing.ROWS,
    *rows_moving.ROWS,
    *rows_gripping.ROWS,
    *rows_jogging.ROWS,
    *rows_stopping.ROWS,
    *rows_pausing.ROWS,
    *rows_faults.ROWS,
)


BENCHES: Mapping[str, type[Bench]] = MappingProxyType(
    {bench.transport: bench for bench in (ThoroughMemoryBench, PtyBench, TcpBench, UdpBench)}
)


def is_reachable(dialect: str, transport: str) -> bool:
    """Return whether the controller of a dialect can be reached over a transport."""
    return BENCHES[transport].on_bus or not DIALECTS[dialect].can


Task = tuple[str, str, str]
"""A row: behaviour, dialect and transport."""


def run_task(task: Task) -> RowResult:
    """Run one row with a home folder of its own, so that rows share no records."""
    name, dialect, transport = task
    behaviour = next(row for row in BEHAVIOURS if row.name == name)
    with tempfile.TemporaryDirectory(prefix="armdrive-") as home:
        os.environ["ARMDRIVE_HOME"] = home
        os.environ.pop("ARMDRIVE_FORCE_SIM", None)
        return run_row(behaviour, dialect, transport, BENCHES[transport])
