"""The benchmark of the flight recorder runs, and measures with and without it."""

from __future__ import annotations

import recorder


def test_the_cpu_of_a_move_is_measured_for_every_dialect():
    rows = recorder.cpu(rounds=1, dialects=("teachmover", "armdroid")).rows
    assert [row.what.partition(":")[0] for row in rows] == ["teachmover"] * 3 + ["armdroid"] * 3
    assert all("without it" in row.times for row in rows[1::3])


def test_writing_a_ring_is_measured():
    rows = {row.what: row.value for row in recorder.writing(seconds=2.0).rows}
    assert rows["entries in the last five minutes"] > 100
    assert rows["the file"] > 0.0
