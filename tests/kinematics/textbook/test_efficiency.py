"""Counting numbers count what runs, and the counts say which way of computing is worth it."""

import math

import pytest
from amounts import every_row
from chain_cases import gap
from hypothesis import given
from hypothesis import strategies as st

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink
from kinematics.five_axis import closed_form
from kinematics.five_axis.closed_form import forward_frame
from kinematics.textbook.efficiency import (
    Ledger,
    Tally,
    efficiency,
    forward_ways,
    on_any_numbers,
    plain,
    recursion,
)
from kinematics.textbook.systems import SYSTEMS

ARM = SYSTEMS["minimover5"].arm
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


def test_a_counting_number_is_never_taken_for_a_float():
    number = Ledger().number(0.5)
    with pytest.raises(TypeError):
        math.sin(number)
    with pytest.raises(TypeError):
        float(number)


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 5))
def test_the_code_that_counts_is_the_code_that_runs(angles):
    ledger = Ledger()
    counted = on_any_numbers(forward_frame)
    assert counted.__code__ is forward_frame.__code__
    found = counted(ledger.numbers(angles), ARM.lengths)
    expected = forward_frame(angles, ARM.lengths)
    assert [[plain(entry) for entry in row] for row in found] == [list(row) for row in expected]


def test_helpers_called_by_name_are_counted_too():
    ledger = Ledger()
    goal = ledger.numbers((200.0, 100.0, 150.0, -1.0, 0.0))
    found = on_any_numbers(closed_form.inverse)(goal, ARM.lengths, (0.0,) * 5)
    assert len(found) == 4
    assert ledger.tally().arcs == 4  # base, direction, lift, and the bend in elbow_triangle


def test_the_minimover_s_counts():
    forward = by_name(efficiency(SYSTEMS["minimover5"]).forward)
    assert forward["closed form"] == Tally(22, 11, sines=10)
    assert forward["recursion"] == Tally(150, 90, sines=10)
    assert forward["affine products"] == Tally(174, 108, sines=10)
    assert forward["full products"] == Tally(286, 192, sines=10)
    assert forward["straight line"].multiplications < forward["recursion"].multiplications / 4


@every_row("name", sorted(SYSTEMS))
def test_every_system_s_ways_are_counted(name):
    found = efficiency(SYSTEMS[name])
    forward = by_name(found.forward)
    straight, full = forward["straight line"], forward["full products"]
    links = len(SYSTEMS[name].chain())
    assert full == Tally(6 * links + 64 * (links - 1), 48 * (links - 1), sines=full.sines)
    assert straight.multiplications < full.multiplications
    branches = set(SYSTEMS[name].signs)
    counted = {way.name for way in found.inverse} - {"all branches together"}
    assert counted == (set() if name in FREE_OF_ARITHMETIC else branches)


@pytest.mark.parametrize("name", ["minimover5", "alpha2-lecture", "puma"])
def test_branches_together_cost_less_than_one_by_one(name):
    inverse = by_name(efficiency(SYSTEMS[name]).inverse)
    together = inverse.pop("all branches together")
    assert len(inverse) == len(SYSTEMS[name].signs)
    assert together.trigonometric < sum(one.trigonometric for one in inverse.values())
    assert together.multiplications < sum(one.multiplications for one in inverse.values())


link_rows = st.builds(
    DHLink,
    st.floats(-3.0, 3.0),
    st.floats(-100.0, 100.0),
    st.floats(-100.0, 100.0),
    st.floats(-3.0, 3.0),
)


@given(st.lists(link_rows, min_size=1, max_size=6), st.sampled_from(Convention), st.data())
def test_the_recursion_is_the_product_of_the_matrices(links, convention, data):
    chain = Chain(tuple(links), convention)
    values = data.draw(st.tuples(*[st.floats(-3.0, 3.0)] * len(links)))
    table = tuple(link.parameters(value) for link, value in zip(links, values, strict=True))
    assert gap(recursion(table, convention), chain.fk(values)) < 1e-9


def test_a_table_of_one_s_own_is_counted_as_well():
    chain = Chain((DHLink(a_mm=100.0), DHLink(a_mm=50.0)), Convention.CRAIG)
    ways = by_name(forward_ways(chain, (0.1, 0.2)))
    assert ways["recursion"].sines == 4
    assert ways["straight line"].multiplications < ways["affine products"].multiplications
    assert str(ways["recursion"]) == "60 multiplications, 36 additions, 4 sines"
