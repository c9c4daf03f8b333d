"""Each part of the benchmarks runs, with counts too small to measure anything."""

import importlib
import json
import math
from pathlib import Path

import measuring
import programs
import pytest
import recorder
from amounts import THOROUGH

BENCHMARKS = Path(measuring.__file__).parent
PROGRAMS = sorted(
    path.stem for path in BENCHMARKS.glob("*.py") if "\ndef main(argv" in path.read_text("utf-8")
)


@pytest.mark.parametrize("name", PROGRAMS)
def test_every_benchmark_can_be_called(name, capsys):
    if name in {"desk", "desk_ends"}:
        pytest.importorskip("termios", reason="Windows has no pseudo-terminals")
    with pytest.raises(SystemExit, match="0"):
        importlib.import_module(name).main(["--help"])
    assert "usage:" in capsys.readouterr().out


def test_a_page_tells_of_every_benchmark_and_of_no_other():
    page = (BENCHMARKS.parent / "docs/background/measurements.md").read_text("utf-8")
    assert [name for name in PROGRAMS if f"{name}.py" not in page] == []
    named = {word.split("`")[0] for word in page.split("`benchmarks/")[1:] if word[0] != "`"}
    assert {name for name in named if not (BENCHMARKS / name).is_file()} == set()


def test_sections_are_printed_for_people_and_for_programs(capsys):
    rows = (measuring.Row("a thing", 2.0, "ms", 3.0, {"its floor": 4.0}),)
    sections = {"one": lambda: measuring.Section("One", rows, "a note")}
    assert measuring.report([], "", sections) == 0
    assert "p99 3, 4 x its floor" in capsys.readouterr().out
    assert measuring.report(["one", "--json"], "", sections) == 0
    machine, section = map(json.loads, capsys.readouterr().out.splitlines())
    assert "processors" in machine["machine"]
    assert section["section"] == "one"
    assert {"what", "value", "unit", "p99", "times"} == section["rows"][0].keys()


# Each part of the benchmark of programs runs, with counts too small to measure anything.


@pytest.mark.parametrize(
    ("name", "amounts"),
    [("calls", (1, 2)), *([("ways", (1, 2)), ("starting", (1,))] if THOROUGH else [])],
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


# The benchmark of the flight recorder runs, and measures with and without it.


def test_the_cpu_of_a_move_is_measured_for_every_dialect():
    rows = recorder.cpu(rounds=1, dialects=("teachmover", "armdroid")).rows
    assert [row.what.partition(":")[0] for row in rows] == ["teachmover"] * 3 + ["armdroid"] * 3
    assert all("without it" in row.times for row in rows[1::3])


def test_writing_a_ring_is_measured():
    rows = {row.what: row.value for row in recorder.writing(seconds=2.0).rows}
    assert rows["entries in the last five minutes"] > 100
    assert rows["the file"] > 0.0
