"""How long bursts are: as usual on a usual wire, longer on a slow one, never beyond patience."""

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from armdrive.abilities import (
    HEADROOM,
    PATIENCE_S,
    SEGMENTS_AHEAD,
    Traffic,
    budget,
    segment_s,
)
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import parse_arm

BAUDS = st.sampled_from([300, 1200, 2400, 4800, 9600, 19_200, 57_600, 115_200, 1_000_000])
TRAFFIC = st.builds(Traffic, st.integers(5, 80), st.integers(1, 80))


@given(TRAFFIC, BAUDS, BAUDS, st.floats(0.05, 1.0), st.integers(0, 16))
def test_no_wire_makes_bursts_shorter_than_usual_or_longer_than_patience(
    traffic, baud, usual, usual_s, queued
):
    found = budget(
        traffic, baud, usual_baud=usual, jog_burst_s=usual_s, planned_burst_s=usual_s, queued=queued
    )
    for burst_s in (found.jog_burst_s, found.planned_burst_s):
        assert usual_s <= burst_s <= max(usual_s, PATIENCE_S)


@given(TRAFFIC, BAUDS)
def test_a_slow_wire_keeps_its_share_of_motion_until_patience_ends(traffic, baud):
    found = budget(traffic, baud, usual_baud=9600, jog_burst_s=0.05, planned_burst_s=0.05, queued=0)
    if found.planned_burst_s < PATIENCE_S:
        assert found.planned_burst_s / traffic.exchange_s(baud) >= (
            0.05 / traffic.exchange_s(9600) - 1e-9
        )


@given(TRAFFIC, BAUDS)
def test_a_queue_never_runs_empty_where_patience_allows(traffic, baud):
    found = budget(
        traffic, baud, usual_baud=115_200, jog_burst_s=0.05, planned_burst_s=0.05, queued=15
    )
    if found.jog_burst_s < PATIENCE_S:
        assert segment_s(found.jog_burst_s) >= HEADROOM * traffic.line_s(baud) - 1e-12


@every_row("row", DIALECTS.values(), ids=lambda row: row.name)
def test_every_dialect_keeps_its_own_lengths_on_its_own_wire(row):
    config = parse_arm({"model": row.preset, "connection": {"dialect": row.name}}, name="x")
    assert config.motion.jog_burst_s == row.abilities.jog_burst_s
    assert config.motion.planned_burst_s == row.abilities.planned_burst_s


def test_an_old_cable_gets_longer_bursts_and_the_file_has_the_last_word():
    connection = {"dialect": "teachmover", "baud": 4800}
    slow = parse_arm({"model": "teachmover", "connection": connection}, name="x")
    assert slow.motion.planned_burst_s == pytest.approx(0.30)
    own = {"model": "teachmover", "connection": connection, "motion": {"planned_burst_s": 0.1}}
    assert parse_arm(own, name="x").motion.planned_burst_s == 0.1
    assert SEGMENTS_AHEAD * segment_s(0.3) == pytest.approx(0.3)
