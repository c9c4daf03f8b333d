"""Each part of the benchmark of programs runs, with counts too small to measure anything."""

import math

import programs
import pytest


@pytest.mark.parametrize(
    ("name", "amounts"), [("calls", (1, 2)), ("ways", (1, 2)), ("starting", (1,))]
)
def test_every_row_is_a_figure_beside_a_floor(name, amounts):
    section = programs.SECTIONS[name](*amounts)
    floor, *others = section.rows
    assert not floor.times
    for row in others:
        assert math.isfinite(row.value)
        assert row.value > 0.0
        assert all(times > 0.0 for times in row.times.values())
        assert row.times
