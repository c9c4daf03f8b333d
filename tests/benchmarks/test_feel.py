"""The benchmarks of feel run on simulated time, with counts too small to measure anything.

What they do in real time over ptys is left out here: those runs last seconds each, and say nothing
on a computer that runs tests. How a stop is recognised on the wire is tested by itself.
"""

import itertools
import json
from random import Random

import feel
import feel_keys
import feel_ways
import releasing
import straightness
import wire_use
from hypothesis import given
from hypothesis import strategies as st


def run(capsys, program, *words):
    """Return the exit code of a benchmark, and its rows by what they say."""
    code = program.main([*words, "--json"])
    _, *rows = map(json.loads, capsys.readouterr().out.splitlines())
    return code, {row["what"]: row for row in rows}


class TestFigures:
    def test_each_value_is_held_against_its_own_bound(self):
        found = [feel.Measured(5.0, 10.0), feel.Measured(3.0, 4.0)]
        figures = feel.Figures("grbl", "a thing", "mm", found)
        assert figures.kept
        assert (figures.bound, figures.nearest) == (4.0, 0.75)
        assert "ABOVE" not in str(figures)
        broken = feel.Figures("grbl", "a thing", "mm", [*found, feel.Measured(4.1, 4.0)])
        assert not broken.kept
        assert "ABOVE ITS BOUND" in str(broken)

    def test_nothing_is_within_a_bound_of_nothing(self):
        assert feel.Figures("grbl", "", "", [feel.Measured(0.0, 0.0)]).kept
        assert not feel.Figures("grbl", "", "", [feel.Measured(1.0, 0.0)]).kept

    def test_a_broken_bound_is_the_exit_code(self, capsys):
        def measure(options, dialect):
            yield feel.Figures(dialect, "it", "ms", [feel.Measured(2.0, bounds[dialect])])

        bounds = {"grbl": 1.0, "robko01": 3.0}
        given = {"measure": measure, "times": 1, "quick_times": 1}
        assert feel.report(["grbl"], "", **given) == 1
        assert feel.report(["robko01"], "", **given) == 0
        assert "2.0 ms" in capsys.readouterr().out


class TestKeyboard:
    @given(st.integers(0, 10_000), st.sampled_from(feel_keys.RATES_HZ), st.booleans())
    def test_events_keep_their_order_and_come_as_late_as_the_link_has_them(self, seed, hz, stalls):
        way = feel_keys.press(Random(seed), hz, stalls=stalls)
        arrivals = way.arrivals_s
        assert list(arrivals) == sorted(arrivals)
        late_s = feel_keys.JITTER_S + stalls * feel_keys.STALL_S
        assert arrivals[-1] < way.lifted_s + late_s + len(arrivals) * feel_keys.TOGETHER_S

    def test_a_link_that_stalls_delivers_in_one_piece(self):
        arrivals = feel_keys.press(Random(1), 33, stalls=True).arrivals_s
        gaps = [after - before for before, after in itertools.pairwise(arrivals)]
        assert max(gaps) > 0.5
        assert sum(gap < 0.001 for gap in gaps) >= 4


def test_lines_are_held_against_what_is_promised(capsys, monkeypatch):
    kinds = {name: feel_ways.KINDS[name] for name in ("short lines, 3 to 20 mm", "arcs")}
    monkeypatch.setattr(straightness, "KINDS", kinds)
    code, rows = run(capsys, straightness, "teachmover", "--times", "1")
    assert code == 0
    assert len(rows) == 4
    assert all(0.0 < row["worst"] < row["bound"] for row in rows.values())


def test_keys_are_let_go_on_links_with_jitter_and_with_a_stall(capsys, monkeypatch):
    monkeypatch.setattr(releasing, "RATES_HZ", (25,))
    code, rows = run(capsys, releasing, "teachmover", "--times", "2")
    assert code == 0
    assert rows["25 Hz, 60 ms of jitter"]["worst"] > 0.0  # in mm, which comes after ms
    assert any("stalls" in what for what in rows)


def test_a_long_path_uses_the_wire(capsys, monkeypatch):
    monkeypatch.setattr(wire_use.QuickBench, "look_s", 0.02)
    code, rows = run(capsys, wire_use, "grbl", "--simulated", "--times", "1")
    assert code == 0
    assert rows["in motion"]["p50"] > 99.0
    assert 0.0 < rows["the wire to the device"]["p50"] < 100.0
