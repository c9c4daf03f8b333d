"""Each part of the benchmarks runs, with counts too small to measure anything."""

import inspect
import json
import math
import sys
from collections import Counter

import grbl_stream
import killing
import measuring
import programs
import pytest
import recorder
import simulated_time
import solving
import starting
import walking_arm

from kinematics import preset
from kinematics.five_axis import closed_form

needs_pty = pytest.mark.skipif(
    sys.platform == "win32", reason="Windows has no pseudo-terminal that a test could open"
)


def rows_of(section: measuring.Section) -> dict[str, measuring.Row]:
    """Return the rows by name, each seen to hold a number that means something."""
    for row in section.rows:
        assert math.isfinite(row.value)
        assert row.value > 0.0
        assert row.p99 is None or row.p99 >= row.value > 0.0
        assert row.unit
        assert row.what in str(row)
    return {row.what: row for row in section.rows}


class CountingMath:
    """The math module, with a count of the calls that a floor has to make as well."""

    def __init__(self) -> None:
        self.calls: Counter[str] = Counter()

    def __getattr__(self, name: str) -> object:
        found = getattr(math, name)
        if not inspect.isbuiltin(found):
            return found

        def counted(*values: float) -> float:
            self.calls[name] += 1
            return found(*values)

        return counted


@pytest.mark.parametrize("direction", ["forward", "inverse"])
def test_a_floor_calls_math_no_more_and_not_much_less_than_the_solution(monkeypatch, direction):
    counting = CountingMath()
    (angles,) = solving.postures(1)
    lengths = preset(solving.MODEL).arm.lengths
    goal = closed_form.forward(angles, lengths)
    monkeypatch.setattr(closed_form, "math", counting)
    if direction == "forward":
        closed_form.forward(angles, lengths)
        solved = Counter(counting.calls)
    else:
        assert len(closed_form.inverse(goal, lengths, solving.START)) == 4
        solved = Counter(counting.calls)
    counting.calls.clear()
    for name in ("sin", "cos", "acos", "atan2", "hypot", "sqrt"):
        monkeypatch.setattr(solving, name, getattr(counting, name))
    floor = solving.forward_floor if direction == "forward" else solving.inverse_floor
    floor(goal)
    assert counting.calls <= solved
    assert counting.calls.total() >= 0.7 * solved.total()


def test_one_pose():
    rows = rows_of(solving.solving(poses=5, rounds=2))
    assert sum("FK" in name for name in rows) == 2
    assert sum("IK" in name for name in rows) == 3
    assert all(row.times for name, row in rows.items() if "floor" not in name)


@needs_pty
def test_the_wire():
    import wire

    rows = rows_of(wire.wire(rounds=2))
    read = rows["READ through the driver"]
    assert read.times["the floor"] > 0.9
    assert rows["floor: 22 bytes at 9600 baud"].value == pytest.approx(22 * 10 / 9.6)


def test_simulated_time():
    rows = rows_of(simulated_time.simulated_time(rounds=1, moves=2))
    assert all(row.value > 1.0 for row in rows.values())


def test_starting():
    rows = rows_of(starting.starting(rounds=1))
    assert rows["armdrive --help"].times["a bare interpreter"] > 0.0


@needs_pty
def test_killing():
    rows = rows_of(killing.killing(kills=1))
    assert rows["announced: status.silent_time_s"].value < 1000.0


def test_the_whole_prints_lines_for_people_and_for_programs(capsys, monkeypatch):
    monkeypatch.setattr(
        walking_arm, "SECTIONS", {"solving": lambda: solving.solving(poses=2, rounds=1)}
    )
    assert walking_arm.main([]) == 0
    assert "IK, value types (ik)" in capsys.readouterr().out
    assert walking_arm.main(["solving", "--json"]) == 0
    machine, section = map(json.loads, capsys.readouterr().out.splitlines())
    assert "processors" in machine["machine"]
    assert section["section"] == "solving"
    assert {"what", "value", "unit", "p99", "times"} == section["rows"][0].keys()


def test_an_unknown_section_is_a_usage_error(capsys):
    with pytest.raises(SystemExit):
        walking_arm.main(["sloving"])
    assert "no section is called sloving" in capsys.readouterr().err


def test_a_run_keeps_to_a_home_of_its_own(monkeypatch):
    from armdrive.storage import files as places

    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    before = places.states()
    with measuring.own_home() as home:
        assert home in places.states().parents
    assert places.states() == before


def test_cases_take_turns():
    called: list[str] = []
    taken = measuring.interleaved(
        {name: lambda name=name: called.append(name) for name in "ab"}, rounds=3
    )
    assert "".join(called) == "ab" * 4  # one round warms up
    assert [len(seconds) for seconds in taken.values()] == [3, 3]


def test_one_in_a_hundred_is_the_99th_percentile():
    assert measuring.p99([float(value) for value in range(100)]) == 99.0
    assert measuring.p99([float(value) for value in range(1000)]) == 990.0
    assert measuring.p99([3.0, 1.0]) == 3.0


# The streaming benchmark runs, with counts too small to measure anything.


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


# Each part of the benchmark of programs runs, with counts too small to measure anything.


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


# The benchmark of the flight recorder runs, and measures with and without it.


def test_the_cpu_of_a_move_is_measured_for_every_dialect():
    rows = recorder.cpu(rounds=1, dialects=("teachmover", "armdroid")).rows
    assert [row.what.partition(":")[0] for row in rows] == ["teachmover"] * 3 + ["armdroid"] * 3
    assert all("without it" in row.times for row in rows[1::3])


def test_writing_a_ring_is_measured():
    rows = {row.what: row.value for row in recorder.writing(seconds=2.0).rows}
    assert rows["entries in the last five minutes"] > 100
    assert rows["the file"] > 0.0
