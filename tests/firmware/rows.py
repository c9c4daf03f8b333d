"""The rows of the conformance table on one rig, one after the other."""

from __future__ import annotations

from collections.abc import Iterator

from tests.conformance.behaviour import Behaviour
from tests.conformance.behaviours import BEHAVIOURS
from tests.conformance.running import Result, run_row

from .rigs import Rig


def chosen(rig: Rig, pattern: str) -> list[Behaviour]:
    """Return the rows whose name contains the pattern, without those for another transport only."""
    return [
        row
        for row in BEHAVIOURS
        if pattern in row.name and (row.meant_for(rig.transport) or row.meant_for("pty"))
    ]


def run_rows(rig: Rig, pattern: str = "") -> Iterator[Result]:
    """Run rows, each on a fresh bench."""
    for row in chosen(rig, pattern):
        with rig.home():
            yield run_row(row, rig.dialect, rig.transport, lambda _: rig.make())
