"""The streaming benchmark runs, with counts too small to measure anything."""

from __future__ import annotations

import sys

import grbl_stream
import pytest

needs_pty = pytest.mark.skipif(
    sys.platform == "win32", reason="Windows has no pseudo-terminal that a test could open"
)


def test_the_places_are_one_step_apart_and_stay_in_reach():
    places = grbl_stream.zigzag(2000)
    assert all(abs(b - a) == 1 for a, b in zip([0, *places], places, strict=False))
    assert (min(places), max(places)) == (0, 400)


@needs_pty
def test_a_moving_stream_ends_where_its_lines_lead():
    section = grbl_stream.moving(60)
    assert [row.unit for row in section.rows] == ["lines/s", "%"] * 2
    assert all(row.value > 0.0 for row in section.rows)


@needs_pty
def test_a_refused_line_fails(monkeypatch):
    monkeypatch.setattr(grbl_stream, "segments", lambda count: [grbl_stream.Line("G1X1")] * count)
    with pytest.raises(grbl_stream.Failed, match="22"):
        grbl_stream.checking(3)
