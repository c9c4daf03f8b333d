"""How far a run has come: by its rehearsal, and found again where it went another way."""

import pytest

from armdrive.programs.problems import SourceMark
from armdrive.programs.progress import FOR_EVER, UNKNOWN, RunProgress, Took, nearest


def took(*pairs):
    return [Took(SourceMark(line), "Go", time_s) for line, time_s in pairs]


ONCE = took((1, 10.0), (2, 20.0), (3, 10.0), (2, 20.0), (4, 40.0))


def test_a_run_that_goes_as_rehearsed():
    progress = RunProgress([ONCE])
    assert progress.total_s == 100
    assert progress.estimate(0.0) is UNKNOWN
    seen = []
    for line in (1, 2, 3, 2, 4):
        progress.begins(SourceMark(line))
        seen.append((progress.estimate(0.0).percent, progress.estimate(5.0).left_s))
    assert seen == [(0, 95), (10, 85), (30, 65), (40, 55), (60, 35)]
    assert progress.estimate(1000.0).percent == 100
    assert progress.estimate(1000.0).left_s == 0


def test_a_slowed_run_has_more_time_left():
    progress = RunProgress([ONCE])
    progress.begins(SourceMark(1))
    assert progress.estimate(0.0, 0.5).left_s == 200
    assert progress.estimate(4.0, 0.5).percent == 2


def test_a_branch_that_was_not_rehearsed_is_left_for_the_next_line_that_was():
    progress = RunProgress([ONCE])
    progress.begins(SourceMark(1))
    progress.begins(SourceMark(9))
    assert progress.estimate(0.0) is UNKNOWN
    progress.begins(SourceMark(3))
    assert progress.estimate(0.0).percent == 30


def test_a_line_that_is_carried_out_more_often_than_rehearsed_is_found_before():
    progress = RunProgress([took((1, 10.0), (2, 10.0), (3, 10.0))])
    for line in (1, 2, 3):
        progress.begins(SourceMark(line))
    progress.begins(SourceMark(2))
    assert progress.estimate(0.0).percent == pytest.approx(100 / 3)


def test_loops_are_counted_and_the_last_rehearsed_stands_for_the_rest():
    progress = RunProgress([took((1, 40.0)), took((1, 20.0))], repeated=4)
    assert progress.total_s == 100
    for loop, percent in ((1, 0), (2, 40), (3, 60), (4, 80)):
        progress.begins(SourceMark(1), loop)
        assert progress.estimate(0.0).percent == percent


def test_without_an_end_it_is_the_loop_that_counts():
    progress = RunProgress([took((1, 40.0)), took((1, 20.0))], repeated=FOR_EVER)
    assert progress.total_s is None
    progress.begins(SourceMark(1), 700)
    assert progress.estimate(5.0).percent == 25
    assert progress.estimate(5.0).left_s == 15


def test_nothing_is_known_without_a_rehearsal():
    progress = RunProgress(())
    progress.begins(SourceMark(1))
    assert progress.estimate(3.0) is UNKNOWN
    assert progress.total_s is None
    nothing_takes_time = RunProgress([took((1, 0.0))])
    nothing_takes_time.begins(SourceMark(1))
    assert nothing_takes_time.estimate(3.0).percent == 0


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
