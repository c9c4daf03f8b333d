"""Counting numbers count what runs, and the counts say which way of computing is worth it."""

import math

from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from kinematics.textbook.efficiency import (
    Ledger,
    Tally,
    efficiency,
    plain,
)
from kinematics.textbook.systems import SYSTEMS

FREE_OF_ARITHMETIC = {"cartesian", "two-link-5"}
"""Their joints are their coordinates."""

floats = st.floats(-100.0, 100.0)


def by_name(ways):
    return {way.name: way.tally for way in ways}


@given(floats, floats)
def test_counting_numbers_compute_what_floats_do(a, b):
    ledger = Ledger()
    x, y = ledger.numbers((a, b))
    found = (2.0 * x + y * y - 1.0, 3.0 - x, -y, abs(x), y.atan2(x), x.atan2_of(b), x.sin())
    assert [plain(one) for one in found] == [
        2.0 * a + b * b - 1.0,
        3.0 - a,
        -b,
        abs(a),
        math.atan2(b, a),
        math.atan2(b, a),
        math.sin(a),
    ]
    assert ledger.tally() == Tally(multiplications=2, additions=3, sines=1, arcs=2)
    assert (x < y, x <= b, x == a, bool(x)) == (a < b, a <= b, True, bool(a))


def test_the_minimover_s_counts():
    forward = by_name(efficiency(SYSTEMS["minimover5"]).forward)
    assert forward["straight line"] == Tally(23, 12, sines=10)
    assert forward["affine products"] == Tally(174, 108, sines=10)
    assert forward["full products"] == Tally(286, 192, sines=10)


@every_row("name", sorted(SYSTEMS))
def test_every_system_s_ways_are_counted(name):
    found = efficiency(SYSTEMS[name])
    forward = by_name(found.forward)
    straight, full = forward["straight line"], forward["full products"]
    links = len(SYSTEMS[name].chain())
    assert full == Tally(6 * links + 64 * (links - 1), 48 * (links - 1), sines=full.sines)
    assert straight.multiplications < full.multiplications
    branches = set(SYSTEMS[name].signs)
    counted = {way.name for way in found.inverse}
    assert counted == (set() if name in FREE_OF_ARITHMETIC else branches)
