"""Numbers as people write them, and TOML that reads back the same."""

import math
import tomllib

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from armdrive.config.write import shortest
from armdrive.dialog import WrongAnswer
from armdrive.errors import BadRequest
from armdrive.setup.draft import ratio
from armdrive.text.numbers import number, parse_speed
from armdrive.text.toml import TomlEntry, TomlSection, document


@every_row(
    "line, turns",
    [("20:1", 20), ("60/16", 3.75), ("5", 5), ("60/16 * 4:1", 15), ("1:2", 0.5), ("2.5 : 1", 2.5)],
)
def test_a_gear_is_read_as_people_write_it(line, turns):
    assert ratio(line).turns == pytest.approx(turns)


@every_row("line", ["", "x", "20:", "60//16", "0:1", "-3", "a:b", "1:0", "inf", "1e9", "20:1 * "])
def test_a_wrong_gear_is_refused_with_an_example(line):
    with pytest.raises(WrongAnswer, match="like 20:1"):
        ratio(line)


VALUES = st.recursive(
    st.text(st.characters(exclude_categories=["Cs"]))
    | st.booleans()
    | st.integers(-(10**9), 10**9)
    | st.floats(allow_nan=False, allow_infinity=False),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.text(st.characters(exclude_categories=["Cs"])), inner, max_size=3)
    ),
    max_leaves=6,
)


@given(st.text(st.characters(exclude_categories=["Cs"])), VALUES)
def test_written_text_reads_back_the_same(key, value):
    text = document([TomlSection("", (TomlEntry(key, value, "a comment"),))])
    assert tomllib.loads(text) == {key: value}


@given(st.floats(-1000.0, 1000.0))
def test_the_shortest_number_means_the_same_to_the_last_bit(degrees):
    angle_rad = math.radians(degrees)
    short = shortest(math.degrees(angle_rad), math.radians, angle_rad)
    assert math.radians(short) == angle_rad


# -- typed numbers --------------------------------------------------------------------------------


@every_row(
    "text, fraction",
    [("0.5", 0.5), ("50%", 0.5), (" 50 % ", 0.5), ("1", 1.0), ("100%", 1.0), (".25", 0.25),
     ("1e-1", 0.1), ("0.5%", 0.005), ("+0.5", 0.5)],
)  # fmt: skip
def test_a_speed_is_a_fraction_or_a_percentage(text: str, fraction: float) -> None:
    assert parse_speed(text) == pytest.approx(fraction)


@every_row(
    "text, words",
    [
        ("50", "a speed is a fraction of the limits, not 50: write 0.5 or 50%"),
        ("1.01", "a speed is a fraction of the limits, not 1.01: write 0.0101 or 1.01%"),
        ("101", "a speed is at most 100% of the limits, not 101: write 0.5 or 50%"),
        ("150%", "a speed is at most 100% of the limits, not 150%: write 0.5 or 50%"),
        ("1e999", "'1e999' is not a speed: write 0.5 or 50%"),
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


@every_row("text, value", [("5", 5), ("-0.25", -0.25), ("1e3", 1000), (" 7 ", 7), ("+2", 2)])
def test_a_plain_number_is_read(text: str, value: float) -> None:
    assert number(text) == value
