"""Numbers as people write them, and TOML that reads back the same."""

from __future__ import annotations

import math
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armdrive.config.write import shortest
from armdrive.dialog.conversation import WrongAnswer
from armdrive.setup.draft import flattened, ratio
from armdrive.text.toml import TomlEntry, TomlSection, document


@pytest.mark.parametrize(
    ("line", "turns"),
    [("20:1", 20), ("60/16", 3.75), ("5", 5), ("60/16 * 4:1", 15), ("1:2", 0.5), ("2.5 : 1", 2.5)],
)
def test_a_gear_is_read_as_people_write_it(line, turns):
    assert ratio(line).turns == pytest.approx(turns)


@pytest.mark.parametrize(
    "line", ["", "x", "20:", "60//16", "0:1", "-3", "a:b", "1:0", "inf", "1e9", "20:1 * "]
)
def test_what_is_no_gear_is_refused_with_how_to_write_one(line):
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
def test_what_is_written_reads_back_the_same(key, value):
    text = document([TomlSection("", (TomlEntry(key, value, "a comment"),))])
    assert tomllib.loads(text) == {key: value}


@given(st.integers(-360, 360))
def test_whole_degrees_are_written_whole(degrees):
    angle_rad = math.radians(degrees)
    assert shortest(math.degrees(angle_rad), math.radians, angle_rad) == degrees


@given(st.floats(-1000.0, 1000.0))
def test_the_shortest_number_means_the_same_to_the_last_bit(degrees):
    angle_rad = math.radians(degrees)
    short = shortest(math.degrees(angle_rad), math.radians, angle_rad)
    assert math.radians(short) == angle_rad


def test_answers_of_a_file_are_as_one_would_type_them():
    table = {"name": "a", "gear": {"right wrist": 5.5}, "homing": True, "park": [1, 2], "g": []}
    table["homing groups"] = [[3], [1, 2]]
    assert flattened(table) == {
        "name": "a",
        "gear.right wrist": "5.5",
        "homing": "yes",
        "park": "1, 2",
        "g": "none",
        "homing groups": "3; 1, 2",
    }
