"""Typed numbers: plain and whole ones, and speeds as a fraction or a percentage of the limits."""

import pytest

from armdrive.errors import BadRequest
from armdrive.text.numbers import number, parse_speed, whole


@pytest.mark.parametrize(
    ("text", "fraction"),
    [("0.5", 0.5), ("50%", 0.5), (" 50 % ", 0.5), ("1", 1.0), ("100%", 1.0), (".25", 0.25),
     ("1e-1", 0.1), ("0.5%", 0.005), ("+0.5", 0.5)],
)  # fmt: skip
def test_a_speed_is_a_fraction_or_a_percentage(text: str, fraction: float) -> None:
    assert parse_speed(text) == pytest.approx(fraction)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("50", "a speed is a fraction of the limits, not 50: write 0.5 or 50%"),
        ("1.01", "a speed is a fraction of the limits, not 1.01: write 0.0101 or 1.01%"),
        ("101", "a speed is at most 100% of the limits, not 101: write 0.5 or 50%"),
        ("150%", "a speed is at most 100% of the limits, not 150%: write 0.5 or 50%"),
        ("1e999", "a speed is at most 100% of the limits, not inf: write 0.5 or 50%"),
        ("0", "a speed is above 0, not 0: write 0.5 or 50%"),
        ("-0.5", "a speed is above 0, not -0.5: write 0.5 or 50%"),
        ("-10%", "a speed is above 0, not -10%: write 0.5 or 50%"),
        ("fast", "'fast' is not a speed: write 0.5 or 50%"),
        ("", "'' is not a speed: write 0.5 or 50%"),
        ("nan", "'nan' is not a speed: write 0.5 or 50%"),
        ("0_5", "'0_5' is not a speed: write 0.5 or 50%"),
        ("٥", "'٥' is not a speed: write 0.5 or 50%"),
        ("50%%", "'50%%' is not a speed: write 0.5 or 50%"),
    ],
)
def test_any_other_text_is_refused_with_both_spellings(text: str, words: str) -> None:
    with pytest.raises(BadRequest) as caught:
        parse_speed(text)
    assert str(caught.value) == words


@pytest.mark.parametrize(
    ("text", "value"), [("5", 5), ("-0.25", -0.25), ("1e3", 1000), (" 7 ", 7), ("+2", 2)]
)
def test_a_plain_number_is_read(text: str, value: float) -> None:
    assert number(text) == value


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x", "'x' is not a number"),
        ("", "'' is not a number"),
        ("1_5", "'1_5' is not a number"),
        ("٥", "'٥' is not a number"),
        ("nan", "'nan' is not a finite number"),
        ("1e999", "'1e999' is not a finite number"),
    ],
)
def test_what_is_no_plain_number_is_refused(text: str, words: str) -> None:
    with pytest.raises(BadRequest) as caught:
        number(text)
    assert str(caught.value) == words


def test_a_whole_number_has_digits_alone() -> None:
    assert [whole(text) for text in ("0", "12", "-3", "+4")] == [0, 12, -3, 4]
    for text in ("1.0", "1e3", "", "x", "1_5", "٥", "9" * 6000):
        with pytest.raises(BadRequest, match="is not a"):
            whole(text)
