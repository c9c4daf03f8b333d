"""Pendant programs for tests: random ones and plain ones."""

from __future__ import annotations

from hypothesis import strategies as st

from armdrive.dialects.teachmover.pendant import PendantProgram
from firmware_protocol.teachmover import ProgramRow

COUNTS = st.integers(-(1 << 15), (1 << 15) - 1)
ROWS = st.builds(
    ProgramRow,
    st.integers(0, 65535),
    st.integers(0, 255),
    st.tuples(*[COUNTS] * 6),
    st.integers(0, 255),
)
PROGRAMS = st.lists(ROWS, max_size=12, unique_by=lambda row: row.number).map(
    lambda rows: PendantProgram(tuple(sorted(rows, key=lambda row: row.number)))
)


def program(*numbers: int) -> PendantProgram:
    """Return a program whose rows have these numbers, each with another target."""
    rows = (ProgramRow.move(n, 200, (100 * n, -7 * n, n, 0, -n, 50)) for n in numbers)
    return PendantProgram(tuple(rows))
