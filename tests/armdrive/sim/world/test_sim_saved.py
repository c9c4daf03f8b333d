"""A simulated arm outlives its process, and refuses what it has not saved itself."""

from __future__ import annotations

import json

import pytest
from sim_bench import Bench, descend, grasp, lift

from armdrive.errors import StateFileError
from armdrive.sim.device import SimDevice
from armdrive.sim.simulated_arm import recalled
from armdrive.sim.teachmover import TeachMoverBoard
from armdrive.sim.world import World
from armdrive.sim.world.saved import world_from_json, world_to_json
from armdrive.sim.world.table import TableBlock
from firmware_protocol.teachmover import Key, ProgramRow, QWrite, Step


def lived_in():
    """A world with a block in the air, one on the table, and an incident."""
    world = World(blocks=[TableBlock("A", 250, 40, 0, 30, 30), TableBlock("B", 200, -100)])
    descend(world, 250, 40, 15, opening=50)
    grasp(world)
    lift(world, 60)
    world.drive((0, 0, 0, 0, 0, -1000), time_s=4.5)
    return world


def test_a_world_comes_back_as_it_was():
    world = lived_in()
    again = world_from_json(json.loads(json.dumps(world_to_json(world))))
    assert again.motors == world.motors
    assert again.scene.blocks == world.scene.blocks
    assert again.scene.held == "A"
    assert again.incidents == world.incidents
    assert again.grip_force_n == world.grip_force_n
    assert world_to_json(again) == world_to_json(world)


def test_a_block_held_when_saved_is_still_carried():
    again = world_from_json(world_to_json(lived_in()))
    before = again.scene.blocks["A"].place
    again.drive((100, 0, 0, 0, 0, 0))
    assert again.scene.blocks["A"].place != before
    assert again.scene.blocks["A"].z_mm == pytest.approx(before[2])


def test_a_device_comes_back_with_what_it_knew():
    bench = Bench(TeachMoverBoard(lived_in()))
    bench.ask(QWrite(ProgramRow.move(3, 200, (1, -2, 3, -4, 5, -6))))
    bench.ask(Step(240, (12, 0, 0, 0, 0, 0), 9))
    bench.board.press(Key.FREE)
    bench.device.set_input(5, True)
    saved = json.loads(json.dumps(bench.device.to_json()))
    again = recalled(saved, TeachMoverBoard)
    assert again.registers == (12, 0, 0, 0, 0, 0)
    known = again.board
    assert (known.key, known.outputs, known.shared.inputs_set) == (Key.FREE, 9, 32)
    assert known.memory.rows == bench.board.memory.rows
    assert again.to_json() == saved


def _changed(path, value):
    data = SimDevice(TeachMoverBoard(lived_in())).to_json()
    *way, last = path
    table = data
    for key in way:
        table = table[key]
    table[last] = value
    return data


@pytest.mark.parametrize(
    ("path", "value", "named"),
    [
        (["world", "format"], 2, "format"),
        (["world", "arm"], "robko01", "robko01"),
        (["world", "arm"], 3, "arm"),
        (["world", "motors"], [0, 0, 0], "motors"),
        (["world", "motors"], [0, 0, 0, 0, 0, 1.5], "motors"),
        (["world", "motors"], [0, 0, 0, 0, 0, 10**9], "motors"),
        (["world", "motors"], [True] * 6, "motors"),
        (["world", "energised"], 1, "energised"),
        (["world", "held"], "C", "C"),
        (["world", "held"], 5, "held"),
        (["world", "blocks"], {}, "blocks"),
        (["world", "blocks", 0], "A", "block"),
        (["world", "blocks", 0, "x_mm"], float("nan"), "x_mm"),
        (["world", "blocks", 0, "x_mm"], "1", "x_mm"),
        (["world", "blocks", 0, "width_mm"], -1, "wider"),
        (["world", "blocks", 0, "name"], "B", "same name"),
        (["world", "blocks", 0, "colour"], "red", "colour"),
        (["world", "incidents", 0, "kind"], "fire", "fire"),
        (["registers"], [0, 0, 0, 0, 0, 40000], "registers"),
        (["key"], 15, "key"),
        (["memory"], [[1, 2]], "words"),
        (["memory"], [[70000] * 8], "words"),
        (["extra"], 1, "extra"),
    ],
)
def test_what_no_arm_has_saved_is_refused_by_name(path, value, named):
    with pytest.raises(StateFileError, match=named):
        recalled(_changed(path, value), TeachMoverBoard)


@pytest.mark.parametrize("data", [None, [], "world", {}, {"format": 1}])
def test_what_is_no_world_at_all_is_refused(data):
    with pytest.raises(StateFileError, match="--fresh"):
        world_from_json(data)
