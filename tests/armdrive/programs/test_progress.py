"""How far a run has come: by its rehearsal, and found again where it went another way."""

import pytest

from armdrive.programs.problems import SourceMark
from armdrive.programs.progress import FOR_EVER, UNKNOWN, RunProgress, Took, nearest


def took(*pairs):
    return [Took(SourceMark(line), "Go", time_s) for line, time_s in pairs]


ONCE = took((1, 10.0), (2, 20.0), (3, 10.0), (2, 20.0), (4, 40.0))


LOOPS = [took((1, 40.0)), took((1, 20.0))]
RUNS = {
    # what was rehearsed, how often it is repeated, and lines (and loops) that begin with their
    # percent, and the seconds left 5 s later
    "as rehearsed": (
        [ONCE], 1, [(1, 1, 0, 95), (2, 1, 10, 85), (3, 1, 30, 65), (2, 1, 40, 55), (4, 1, 60, 35)]),
    "a branch that was not rehearsed": (
        [ONCE], 1, [(1, 1, 0, 95), (9, 1, None, None), (3, 1, 30, 65)]),
    "a line more often than rehearsed": (
        [took((1, 30.0), (2, 30.0), (3, 40.0))], 1,
        [(1, 1, 0, 95), (2, 1, 30, 65), (3, 1, 60, 35), (2, 1, 30, 65)]),
    "the last rehearsed loop stands for the rest": (
        LOOPS, 4, [(1, 1, 0, 95), (1, 2, 40, 55), (1, 3, 60, 35), (1, 4, 80, 15)]),
    "without an end it is the loop that counts": (LOOPS, FOR_EVER, [(1, 700, 0, 15)]),
    "nothing is known without a rehearsal": ((), 1, [(1, 1, None, None)]),
    "nothing takes time": ([took((1, 0.0))], 1, [(1, 1, 0, 0)]),
}  # fmt: skip


@pytest.mark.parametrize("name", RUNS)
def test_how_far_a_run_has_come(name):
    rehearsed, repeated, lines = RUNS[name]
    progress = RunProgress(rehearsed, repeated=repeated)
    assert progress.estimate(0.0) is UNKNOWN
    for line, loop, percent, left_s in lines:
        progress.begins(SourceMark(line), loop)
        found = progress.estimate(0.0).percent, progress.estimate(5.0).left_s
        assert found == pytest.approx((percent, left_s))


def test_the_whole_time_is_known_unless_there_is_no_end():
    assert RunProgress([ONCE]).total_s == 100
    assert RunProgress(LOOPS, repeated=4).total_s == 100
    assert RunProgress(LOOPS, repeated=FOR_EVER).total_s is None
    assert RunProgress(()).total_s is None


def test_a_slowed_run_has_more_time_left_and_none_has_less_than_none():
    progress = RunProgress([ONCE])
    progress.begins(SourceMark(1))
    assert progress.estimate(0.0, 0.5).left_s == 200
    assert progress.estimate(4.0, 0.5).percent == 2
    progress.begins(SourceMark(4))
    assert (progress.estimate(1000.0).percent, progress.estimate(1000.0).left_s) == (100, 0)


@pytest.mark.parametrize(
    ("lines", "line", "expected", "index"),
    [
        ((1, 2, 1, 2), 1, 1, 2),
        ((1, 2, 1, 2), 1, 3, 2),
        ((1, 2), 1, 9, 0),
        ((1, 2), 3, 0, None),
        ((), 3, 0, None),
    ],
)
def test_a_place_is_looked_for_ahead_and_then_behind(lines, line, expected, index):
    assert nearest([SourceMark(each) for each in lines], SourceMark(line), expected) == index
