"""Counts and numbers in words, and lines folded to a width."""

from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from kinematics.text import counted, folded, plain, rounded


@every_row(
    "count, words, said",
    [
        (0, ("act",), "0 acts"),
        (1, ("act",), "1 act"),
        (2, ("act",), "2 acts"),
        (-1, ("count",), "-1 counts"),
        (1, ("axis", "axes"), "1 axis"),
        (3, ("axis", "axes"), "3 axes"),
        (1, ("row is", "rows are"), "1 row is"),
        (0, ("row is", "rows are"), "0 rows are"),
    ],
)
def test_a_count_and_its_noun_agree(count, words, said):
    assert counted(count, *words) == said


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
        ("a plain line", 20, ["a plain line"]),
        ("a well-known word", 12, ["a well-known", "  word"]),
        ("  an example of a line", 14, ["  an example", "    of a line"]),
        ("  cause   the cable is loose", 20, ["  cause   the cable", "          is loose"]),
        ("a  b  the last of the columns", 16, ["a  b  the last", "      of the", "      columns"]),
        ("a column too far to the   right", 28, ["a column too far to the", "  right"]),
        ("  path   /a/path/that/is/long", 20, ["  path", "/a/path/that/is/long"]),
        ("abcdefgh", 3, ["abc", "def", "gh"]),
    ],
)
def test_further_rows_begin_below_the_last_column(line, width, rows):
    assert folded(line, width) == rows
