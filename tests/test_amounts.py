"""A table in one test fails for every row that a test of its own would fail for, and names it."""

import pytest
from amounts import every_row


def even(number):
    assert number % 2 == 0
    if number == 6:
        pytest.fail("six")


def test_every_failing_row_is_named_and_all_others_pass():
    every_row("number", (2, 4))(even)()
    with pytest.raises(BaseExceptionGroup, match="3 of 5 rows") as failed:
        every_row("number", iter((1, 2, 3, 4, 6)))(even)()
    notes = [failure.__notes__ for failure in failed.value.exceptions]
    assert notes == [["in the row 1"], ["in the row 3"], ["in the row 6"]]


def test_fixtures_and_further_tables_reach_the_test():
    seen = []

    @every_row("one, two", [(1, 2), (3, 4)], ids=["low", "high"])
    @every_row("three", "ab")
    def kept(keep, one, two, three):
        keep((one, two, three))

    kept(keep=seen.append)
    assert seen == [(1, 2, "a"), (1, 2, "b"), (3, 4, "a"), (3, 4, "b")]
