"""Turns of an angle and ranges of a joint; numbers and lines as text."""

import math

import pytest
from amounts import every_row
from hypothesis import example, given
from hypothesis import strategies as st

from kinematics.limits import LIMIT_TOLERANCE_RAD, all_fitted, turn_into
from kinematics.text import folded, plain, rounded

angles = st.floats(-50.0, 50.0)


@given(angles, angles, st.floats(0.0, 12.0), angles)
@example(0.0, -6.0, 12.0, 3.0)  # the seed is almost half a circle away, and so is no turn
def test_a_turn_is_the_best_of_all_turns(angle, low, width, seed):
    high = low + width
    found = turn_into(angle, low, high, seed)
    assert abs(math.remainder(found - angle, math.tau)) <= 2 * LIMIT_TOLERANCE_RAD
    turns = [angle + count * math.tau for count in range(-40, 41)]
    inside = [turn for turn in turns if low <= turn <= high]
    if inside:
        nearest = min(abs(turn - seed) for turn in inside)
        assert low <= found <= high
        assert abs(found - seed) <= nearest + 2 * LIMIT_TOLERANCE_RAD
    else:
        least = min(max(low - turn, turn - high) for turn in turns)
        assert max(low - found, found - high) <= least + 1e-9


@every_row("angle", [-1.0, 2.0])
def test_an_angle_without_a_turn_in_the_range_fits_nowhere(angle):
    assert all_fitted((angle,), ((0.0, 1.0),), (0.0,)) is None
    assert all_fitted((angle + math.tau,), ((0.0, 1.0),), (0.0,)) is None


@every_row(
    "low, high, found",
    [
        (-math.inf, math.inf, 6.0 + math.tau),
        (-math.inf, 1.0, 6.0 - math.tau),
        (7.0, math.inf, 6.0 + math.tau),
        (14.0, math.inf, 6.0 + 2 * math.tau),
        (-math.inf, -20.0, 6.0 - 5 * math.tau),
    ],
)
def test_a_joint_with_one_limit_or_none_takes_a_turn_within_it(low, high, found):
    assert turn_into(6.0, low, high, 12.0) == pytest.approx(found)


# Counts and numbers in words, and lines folded to a width.


@every_row(
    "value, digits, fixed, short",
    [
        (-0.0001, 2, "0.00", "0"),
        (12.5, 2, "12.50", "12.5"),
        (-1.005, 1, "-1.0", "-1"),
        (100.0, 0, "100", "100"),
    ],
)
def test_a_number_has_no_minus_before_zero(value, digits, fixed, short):
    assert rounded(value, digits) == fixed
    assert plain(value, digits) == short


LINES = st.text(alphabet="ab- ", max_size=120)
WIDTHS = st.integers(1, 60)


@given(LINES, WIDTHS)
def test_a_line_is_broken_at_spaces_and_a_word_only_if_it_is_longer_than_a_row(line, width):
    rows = folded(line, width)
    assert all(len(row) <= width for row in rows)
    words = line.split()
    assert "".join("".join(row.split()) for row in rows) == "".join(words)
    if len(line) <= width:
        assert rows == [line]
    elif all(len(word) <= width // 4 for word in words):
        assert [word for row in rows for word in row.split()] == words


@every_row(
    "line, width, rows",
    [
        ("  an example of a line", 14, ["  an example", "    of a line"]),
        ("  cause   the cable is loose", 20, ["  cause   the cable", "          is loose"]),
        ("a  b  the last of the columns", 16, ["a  b  the last", "      of the", "      columns"]),
        ("a column too far to the   right", 28, ["a column too far to the", "  right"]),
        ("  path   /a/path/that/is/long", 20, ["  path", "/a/path/that/is/long"]),
    ],
)
def test_further_rows_begin_below_the_last_column(line, width, rows):
    assert folded(line, width) == rows
