"""The key table is complete, free of clashes, and the source of bindings, footer and help."""

import pytest

from tui.keys.keyboard import DEFAULT_KEYS, KEYS_OFFERED, bindings, label
from tui.keys.table import JOG_PAIRS, SCREENS, TABLE
from tui.widgets import KeyLine

PLACES = sorted({row.place for row in TABLE})


@pytest.mark.parametrize("place", PLACES)
def test_no_key_does_two_things_at_one_place(place):
    # what counts in dialogs need not differ from the screens': nothing goes through a dialog
    places = (place, "") if place in {entry.id for entry in SCREENS} else (place,)
    keys = [key for binding in bindings(*places) for key in binding.key.split(",")]
    assert len(keys) == len(set(keys))


def test_nothing_anywhere_takes_a_key_that_works_everywhere():
    everywhere = {key for row in TABLE if row.everywhere for key in row.keys}
    assert not everywhere & {key for row in TABLE if not row.everywhere for key in row.keys}


def test_every_row_becomes_one_binding_that_says_what_it_does():
    made = bindings(*PLACES)
    assert sorted(binding.id for binding in made) == sorted(row.id for row in TABLE)
    assert len({row.id for row in TABLE}) == len(TABLE)
    assert all(binding.tooltip for binding in made)


def test_stopping_and_quitting_work_everywhere():
    everywhere = {row.id for row in TABLE if row.everywhere}
    assert everywhere == {"stop", "quit"}
    assert {"space", "escape"} <= set(DEFAULT_KEYS.of("stop"))


def test_every_axis_of_either_mode_has_a_pair():
    assert {pair.joint for pair in JOG_PAIRS} == {
        "base", "shoulder", "elbow", "wrist_pitch", "wrist_roll", "gripper",
    }  # fmt: skip
    assert {pair.cartesian for pair in JOG_PAIRS} == {"x", "y", "z", "pitch", "roll", "gripper"}


@pytest.mark.parametrize("place", [entry.id for entry in SCREENS])
@pytest.mark.parametrize("width", [12, 40, 80, 120, 300])
async def test_the_line_of_keys_begins_with_the_stop_and_never_runs_over(place, width):
    rows = DEFAULT_KEYS.next_keys(place)
    assert len(rows) <= KEYS_OFFERED
    line = KeyLine(id="keys")
    line.show_keys(rows, width)
    assert line.shown.startswith("space STOP")
    assert len(line.shown.rstrip()) <= width


@pytest.mark.parametrize("place", [entry.id for entry in SCREENS])
def test_the_help_begins_with_jogging_and_names_every_key(place):
    listed = "\n".join(DEFAULT_KEYS.help(place, JOG_PAIRS))
    assert listed.startswith("Move the arm, on the jog screen (f2)")
    for row in TABLE:
        if row.place in (place, "") and row.description:
            assert row.tooltip in listed


def test_what_leads_out_of_a_state_stands_right_behind_the_stop():
    ids = [row.id for row in DEFAULT_KEYS.next_keys("log", first=("reset",))]
    assert ids[:2] == ["stop", "reset"]
    assert ids[-3:] == ["help", "palette", "quit"]


def test_the_help_of_the_jog_screen_names_the_jog_keys():
    listed = "\n".join(DEFAULT_KEYS.help("jog", JOG_PAIRS))
    for key in (key for pair in JOG_PAIRS for key in (pair.plus, pair.minus)):
        assert label(key) in listed
