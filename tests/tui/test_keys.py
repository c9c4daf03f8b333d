"""The key table is complete, free of clashes, and the source of footer and help."""

import pytest

from tui.keys import ALL_JOG_KEYS, JOG_PAIRS, KEYS, footer, help_lines, label
from tui.layout import bindings


def test_no_key_does_two_things():
    keys = [key for binding in bindings() for key in binding.key.split(",")]
    assert len(keys) == len(set(keys))


def test_every_binding_has_an_id_and_a_tooltip_or_is_a_jog_key():
    made = bindings()
    assert len({binding.id for binding in made}) == len(made)
    assert all(binding.tooltip or binding.id.startswith("jog.") for binding in made)


def test_stopping_and_quitting_work_everywhere():
    everywhere = {entry.id for entry in KEYS if entry.everywhere}
    assert everywhere == {"stop", "quit"}
    assert {"space", "escape"} <= set(KEYS[0].keys)


def test_every_axis_of_either_mode_has_a_pair():
    assert {pair.joint for pair in JOG_PAIRS} == {
        "base", "shoulder", "elbow", "wrist_pitch", "wrist_roll", "gripper",
    }  # fmt: skip
    assert {pair.cartesian for pair in JOG_PAIRS} == {"x", "y", "z", "pitch", "roll", "gripper"}


@pytest.mark.parametrize("width", [12, 40, 80, 120, 300])
def test_the_footer_begins_with_the_stop_and_never_runs_over(width):
    line = footer(width)
    assert line.startswith("space STOP")
    assert len(line) <= width


def test_a_wide_footer_and_the_help_name_every_key():
    wide, listed = footer(1000), "\n".join(help_lines())
    for entry in KEYS:
        assert f"{label(entry.keys[0])} {entry.description}" in wide
        assert entry.tooltip in listed
    for key in (k for k in ALL_JOG_KEYS if k not in "uj"):
        assert label(key) in listed
