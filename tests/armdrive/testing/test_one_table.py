"""Several arms over one table: the blocks are the same, and one hand takes over from another."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sim_bench import descend, grasp, lift, reach, spread

from armdrive.connect.target import simulated_config
from armdrive.errors import BadRequest
from armdrive.registry import simulate
from armdrive.sim.world import World
from armdrive.sim.world.table import IncidentKind, Stand, Table, TableBlock

TALL = TableBlock("A", 250.0, 0.0, 0.0, width_mm=30.0, height_mm=60.0)
"""Halfway between two bases that are 500 mm apart and look at one another."""


def facing():
    """Return a table, and two arms at it that look at one another over 500 mm."""
    table = Table()
    near, far = Stand(table), Stand(table, x_mm=500.0, turned_rad=math.pi)
    return table, World(stand=near), World(stand=far)


def held(*, by_both=False):
    """Return the table and its two arms; the near one holds the tall block, or both do."""
    table, near, far = facing()
    table.put(TALL)
    around(near, 20.0)
    grasp(near)
    if by_both:
        around(far, 45.0)
        grasp(far)
    return table, near, far


def around(world, z_mm):
    """Bring a tip into the tall block from above, with open fingers."""
    reach(world, 250.0, 0.0, 120.0)
    spread(world, 60.0)
    descend(world, 250.0, 0.0, z_mm)


@given(
    st.floats(-900, 900), st.floats(-900, 900), st.floats(-math.pi, math.pi),
    st.tuples(st.floats(-500, 500), st.floats(-500, 500), st.floats(0, 300)),
)  # fmt: skip
def test_from_the_base_to_the_table_and_back_is_where_it_was(x_mm, y_mm, turned_rad, point):
    stand = Stand(x_mm=x_mm, y_mm=y_mm, turned_rad=turned_rad)
    assert stand.from_base(stand.on_table(point)) == pytest.approx(point, abs=1e-9)
    assert math.dist(stand.on_table(point), stand.on_table((0.0, 0.0, point[2]))) == pytest.approx(
        math.hypot(*point[:2]), abs=1e-9
    )


def test_an_arm_that_is_not_turned_sees_the_tables_own_coordinates_exactly():
    table = Table()
    table.put(TALL)
    assert World(stand=Stand(table)).scene.blocks["A"] == TALL


def test_each_arm_sees_a_block_from_its_own_base():
    table = Table()
    quarter = World(stand=Stand(table, x_mm=300.0, y_mm=-250.0, turned_rad=math.pi / 2))
    table.put(TableBlock("A", 250.0, 0.0))
    assert quarter.scene.blocks["A"].place == pytest.approx((250.0, 50.0, 0.0))
    rest = quarter.put(TableBlock("B", 250.0, 50.0, 30.0))
    assert rest.place == pytest.approx((250.0, 50.0, 25.0))
    assert table.blocks["B"].place == pytest.approx((250.0, 0.0, 25.0))


def test_what_one_arm_moves_the_other_finds_moved():
    _, near, far = held()
    lift(near, 100.0)
    assert near.scene.held == "A"
    assert far.scene.held is None
    seen, mine = far.scene.blocks["A"], near.scene.blocks["A"]
    assert seen.z_mm == mine.z_mm > 50.0
    assert seen.x_mm == pytest.approx(500.0 - mine.x_mm)


def test_a_block_is_handed_over_and_stays_where_it_was():
    table, near, far = held(by_both=True)
    assert (near.scene.carried, far.scene.carried) == (("A",), ())
    assert far.grip_force_n > 0.0
    assert far.opening_mm == pytest.approx(30.0)
    before = table.blocks["A"].place
    spread(near, 60.0)
    assert (near.scene.carried, far.scene.carried) == ((), ("A",))
    lift(near, 120.0)
    assert table.blocks["A"].place == before
    lift(far, 60.0)
    assert table.blocks["A"].z_mm == pytest.approx(before[2] + 60.0, abs=2.0)
    assert near.incidents + far.incidents == []


def test_the_second_to_let_go_first_changes_nothing():
    table, near, far = held(by_both=True)
    spread(far, 60.0)
    assert (near.scene.held, far.scene.held) == ("A", None)
    lift(near, 40.0)
    assert table.blocks["A"].z_mm == pytest.approx(40.0, abs=2.0)


def test_the_first_pulls_a_block_out_of_fingers_that_hold_still_and_says_so():
    _, near, far = held(by_both=True)
    lift(near, 100.0)
    assert (near.scene.held, far.scene.held) == ("A", None)
    (incident,) = near.incidents
    assert incident.kind is IncidentKind.KNOCK
    assert "another arm's fingers" in incident.sentence


def test_the_second_goes_away_and_leaves_the_block_with_the_first():
    table, near, far = held(by_both=True)
    lift(far, 100.0)
    assert (near.scene.held, far.scene.held) == ("A", None)
    assert table.blocks["A"].place == pytest.approx(TALL.place, abs=1.0)


def test_both_let_go_and_it_falls():
    table, near, _far = held()
    lift(near, 50.0)
    assert table.blocks["A"].z_mm > 40.0
    spread(near, 60.0)
    assert table.blocks["A"].z_mm == 0.0


def test_what_stands_on_a_block_goes_over_with_it():
    table, near, far = facing()
    table.put(TALL)
    table.put(TableBlock("B", 250.0, 0.0, 60.0, width_mm=20.0, height_mm=20.0))
    around(near, 20.0)
    grasp(near)
    around(far, 45.0)
    grasp(far)
    assert near.scene.carried == ("A", "B")
    spread(near, 60.0)
    assert far.scene.carried == ("A", "B")
    far.give_way((0, 40, 0, 0, 0, 0))
    low, high = table.blocks["A"], table.blocks["B"]
    assert high.z_mm - low.z_mm == pytest.approx(60.0, abs=0.1)
    assert low.place != TALL.place


def test_a_block_in_the_fingers_of_one_is_not_pushed_by_the_other_but_that_is_told():
    table, near, far = held()
    lift(near, 60.0)
    place = table.blocks["A"].place
    reach(far, 250.0, 60.0, 90.0)
    spread(far, 0.0)
    reach(far, 250.0, 0.0, 90.0)
    assert table.blocks["A"].place == place
    assert [each.kind for each in far.incidents] == [IncidentKind.KNOCK]


def test_a_block_that_is_taken_away_is_gone_out_of_all_fingers():
    table, near, far = held(by_both=True)
    assert table.take("A") == TALL.at(TALL.place)
    assert (near.scene.held, far.scene.held) == (None, None)
    assert (near.scene.contact_mm, far.scene.contact_mm) == (0.0, 0.0)
    assert table.take("A") is None


def test_a_saved_world_is_put_on_no_other_table():
    config = simulated_config("teachmover")
    saved = simulate(config).save()
    with pytest.raises(BadRequest, match="table of its own"):
        simulate(config, saved, stand=Stand())
