"""The packing of a program row: the published rule, both ways, with nothing lost."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.teachmover import ProgramRow

WORD = st.integers(0, 65535)
STEPS = st.integers(-32768, 32767)
GOLDEN = (1, 3841, 14436, 28716, 43252, 65280, 65025, 64769)


def by_the_rule(number: int, speed: int, positions: tuple[int, ...]) -> tuple[int, ...]:
    """Compute the words as the rule is written down, byte by byte."""
    low = [position % 65536 % 256 for position in positions]
    high = [position % 65536 // 256 for position in positions]
    return (
        number,
        (255 - speed) * 256 + 1,
        low[1] * 256 + low[0],
        low[3] * 256 + low[2],
        low[5] * 256 + low[4],
        high[1] * 256 + high[0],
        high[3] * 256 + high[2],
        high[5] * 256 + high[4],
    )


def test_the_golden_row():
    row = ProgramRow.move(1, 240, (100, -200, 300, -400, 500, -600))
    assert row.words == GOLDEN
    assert ProgramRow.from_words(GOLDEN) == row


@given(WORD, st.integers(0, 245), st.tuples(*[STEPS] * 6))
def test_rows_are_packed_by_the_rule_and_unpacked_again(number, speed, positions):
    row = ProgramRow.move(number, speed, positions)
    assert row.words == by_the_rule(number, speed, positions)
    assert ProgramRow.from_words(row.words) == row


@given(st.tuples(*[WORD] * 8))
def test_whatever_a_memory_holds_is_written_back_word_for_word(words):
    assert ProgramRow.from_words(words).words == words


@given(st.tuples(*[WORD] * 8))
def test_words_printed_as_signed_numbers_are_the_same_row(words):
    signed = [word - 65536 if word > 32767 else word for word in words]
    assert ProgramRow.from_words(signed) == ProgramRow.from_words(words)


def test_a_row_of_another_kind_keeps_its_kind():
    row = ProgramRow.from_words((3, 15 * 256 + 4, 0, 0, 0, 0, 0, 0))
    assert (row.kind, row.speed) == (4, 240)


@pytest.mark.parametrize(
    "words", [(), GOLDEN[:7], (*GOLDEN, 0), (*GOLDEN[:7], 65536), (-32769, *GOLDEN[1:])]
)
def test_words_that_are_no_row_are_the_other_sides_fault(words):
    with pytest.raises(RemoteProtocolError):
        ProgramRow.from_words(words)
