"""The physical world of a simulated arm, and the world as it is saved."""

import json
from dataclasses import replace

import pytest
from amounts import every_row
from hypothesis import given, settings
from hypothesis import strategies as st
from sim_bench import TeachMoverBench, descend, grasp, lift, reach, spread

from armdrive.errors import BadRequest, StateFileError
from armdrive.sim.device import SimDevice
from armdrive.sim.simulated_arm import recalled
from armdrive.sim.teachmover import TeachMoverBoard
from armdrive.sim.world import World
from armdrive.sim.world.body import MOST_FORCE_N, OPENING_STOP_MM, ArmBody
from armdrive.sim.world.saved import world_from_json, world_to_json
from armdrive.sim.world.table import IncidentKind, TableBlock
from firmware_protocol.teachmover import Key, ProgramRow, QWrite, Step
from kinematics.presets import preset

BODY = World().body
BLOCK = TableBlock("A", 250, 40, 0, width_mm=30, height_mm=30)


def kinds(world):
    return [incident.kind for incident in world.incidents]


def holding(*others, x_mm=250, y_mm=40, z_mm=15, lifted_mm=0):
    """Return a world whose fingers came down around the block, closed, and perhaps lifted it."""
    world = World(blocks=[BLOCK, *others])
    descend(world, x_mm, y_mm, z_mm, opening=50)
    grasp(world)
    if lifted_mm:
        lift(world, lifted_mm)
    return world


def block(world, name="A"):
    return world.scene.blocks[name]


class TestMotorsAndStops:
    def test_the_reference_posture_is_the_published_step_counts(self):
        world = World(motors=(0, -508, 1163, 384, 384, 1163))
        assert world.tip == pytest.approx((127.0, 0.0, 0.0), abs=0.3)
        assert world.opening_mm == 0.0
        assert world.incidents == []

    def test_a_joint_at_its_stop_loses_steps_once_reported(self):
        world = World()
        start = world.motors
        world.drive((3000, 0, 0, 0, 0, 0))
        assert world.joints.deg["base"] == pytest.approx(93.0, abs=0.06)
        assert world.motors[0] < start[0] + 3000
        world.drive((10, 0, 0, 0, 0, 0))
        assert kinds(world) == [IncidentKind.STOP]
        world.drive((-100, 0, 0, 0, 0, 0))
        assert world.joints.deg["base"] == pytest.approx(93.0 - 100 / 19.644, abs=0.1)

    @given(st.tuples(*[st.integers(-4000, 4000)] * 6))
    def test_no_motion_leads_beyond_a_mechanical_stop(self, steps):
        world = World()
        world.drive(steps)
        for angle, stop in zip(world.joints, world.body.stops, strict=True):
            assert stop.low_rad - 0.02 <= angle <= stop.high_rad + 0.02
        assert 0.0 <= world.opening_mm <= OPENING_STOP_MM + 1e-9
        assert world.grip_force_n <= MOST_FORCE_N + 1e-9

    def test_driving_into_the_table_is_an_incident(self):
        world = World()
        reach(world, 250, 0, 5)
        assert world.incidents == []
        reach(world, 250, 0, -4)
        assert kinds(world) == [IncidentKind.TABLE]

    def test_a_preset_without_known_steps_cannot_be_simulated(self):
        with pytest.raises(BadRequest, match="Alpha II"):
            ArmBody.of_preset(preset("alpha2"))


class TestSag:
    def test_without_current_the_arm_comes_down_and_keeps_base_and_roll(self):
        world = World()
        before = world.joints
        height = world.tip[2]
        world.cut_current()
        assert not world.energised
        assert height - world.tip[2] > 10
        assert world.joints["base"] == pytest.approx(before["base"])
        assert world.joints["wrist_roll"] == pytest.approx(before["wrist_roll"], abs=0.005)
        rest = world.motors
        world.cut_current()
        assert world.motors == rest  # it sags once

    def test_the_table_ends_the_fall(self):
        world = World()
        reach(world, 250, 0, 8)
        world.cut_current()
        assert -0.5 < world.tip[2] < 1.0
        assert world.incidents == []

    def test_an_arm_that_rests_on_the_table_does_not_move(self):
        world = World(motors=(0, -508, 1163, 384, 384, 1163))
        before = world.motors
        world.cut_current()
        assert world.motors == before

    def test_a_held_block_is_dropped(self):
        world = holding(lifted_mm=60)
        assert world.scene.held == "A"
        world.cut_current()
        assert world.scene.held is None
        assert block(world).z_mm == 0.0


class TestFingers:
    def test_the_switch_trips_when_the_fingers_press_on_each_other(self):
        world = World()
        spread(world, 20.0)
        assert not world.grip_switch
        grasp(world)
        assert world.grip_switch
        assert world.opening_mm == 0.0
        assert world.grip_force_n == pytest.approx(4.448 / 2, abs=0.15)

    @settings(max_examples=25)
    @given(st.floats(5, 70))
    def test_fingers_measure_what_is_between_them(self, width):
        world = World(blocks=[TableBlock("A", 250, 40, 0, width, 30)])
        descend(world, 250, 40, 15, opening=76)
        grasp(world)
        assert world.scene.held == "A"
        assert world.opening_mm == pytest.approx(width)
        assert world.grip_switch
        assert world.incidents == []

    def test_every_32_half_steps_add_a_pound(self):
        world = holding()
        before = world.grip_force_n
        world.drive((0, 0, 0, 0, 0, -32))
        assert world.grip_force_n - before == pytest.approx(4.448)

    def test_too_much_force_loses_steps(self):
        world = World()
        spread(world, 5.0)
        world.drive((0, 0, 0, 0, 0, -1000))
        assert world.grip_force_n == pytest.approx(35.0, abs=0.15)
        assert kinds(world) == [IncidentKind.STOP]


class TestBlocks:
    def test_a_held_block_goes_where_the_tip_goes_and_stays_where_it_is_put(self):
        world = holding(lifted_mm=80, x_mm=251, y_mm=39)
        reach(world, 200, -120, 95)
        x, y, z = world.tip
        assert block(world).place == pytest.approx((x - 1, y + 1, z - 15), abs=0.7)
        for z in (75, 55, 35, 15):
            reach(world, 200, -120, z)
        spread(world, 50)
        lift(world, 80)
        reach(world, 250, 40, 95)
        assert block(world).place == pytest.approx((199, -119, 0), abs=0.8)
        assert world.incidents == []

    def test_blocks_can_be_stacked_and_stand(self):
        world = holding(TableBlock("B", 200, -100, 0, 40, 25), lifted_mm=100)
        descend(world, 200, -100, 25 + 15)
        spread(world, 50)
        lift(world, 100)
        assert block(world).place == pytest.approx((200, -100, 25), abs=0.8)
        assert block(world, "B").place == (200, -100, 0)
        assert world.incidents == []
        grasp(world)
        assert world.opening_mm == 0.0

    def test_a_block_on_a_carried_one_comes_along(self):
        world = holding(TableBlock("B", 250, 40, 30, 20, 20), lifted_mm=60)
        assert block(world, "B").z_mm == pytest.approx(block(world).top_mm)
        spread(world, 50)
        assert block(world, "B").z_mm == 30.0

    def test_a_block_falls_on_what_is_below_it_and_on_nothing_else(self):
        beside, within = TableBlock("B", 150, 40, 90), TableBlock("C", 255, 45, 0, 10, 10)
        above = TableBlock("D", 255, 35, 200)
        world = World(blocks=[BLOCK, beside, within, above])
        assert [each.z_mm for each in world.scene.blocks.values()] == [0.0, 0.0, 0.0, 30.0]
        assert BLOCK.entry((150, 40, 60), (150, 40, 0)) is None
        assert BLOCK.entry((250, 40, 60), (250, 40, 0)) == 0.5

    def test_closed_fingers_push_a_block_ahead_of_them(self):
        world = World(blocks=[BLOCK])
        grasp(world)
        descend(world, 250, -40, 15)
        for y in range(-30, 60, 10):
            reach(world, 250, y, 15)
        assert kinds(world) == [IncidentKind.KNOCK]
        assert "A" in world.incidents[0].sentence
        assert block(world).y_mm == pytest.approx(50 + 14, abs=2.5)
        assert block(world).x_mm == pytest.approx(250, abs=3)
        for y in (0, 40, 60):
            reach(world, 250, y, 15)
        assert kinds(world) == [IncidentKind.KNOCK] * 2

    def test_fingers_not_open_enough_come_down_on_a_block(self):
        world = World(blocks=[BLOCK])
        descend(world, 250, 40, 15, opening=20)
        assert kinds(world) == [IncidentKind.KNOCK]
        grasp(world)
        assert world.scene.held is None

    def test_a_carried_block_knocks_what_it_runs_into(self):
        world = holding(TableBlock("B", 250, -60, 0, 30, 60), lifted_mm=20)
        for y in range(30, -60, -10):
            reach(world, 250, y, 35)
        assert kinds(world) == [IncidentKind.KNOCK]
        assert world.incidents[0].what == "B"
        assert block(world, "B").y_mm < -70
        for y in (-30, -60, -70):
            reach(world, 250, y, 35)
        assert kinds(world) == [IncidentKind.KNOCK] * 2

    def test_a_held_block_pressed_into_the_table_is_an_incident(self):
        world = holding(z_mm=25)
        for z_mm in (20, 18):
            reach(world, 250, 40, z_mm)
        assert kinds(world) == [IncidentKind.TABLE]
        spread(world, 50)
        assert block(world).z_mm == 0.0

    def test_a_block_in_the_fingers_can_be_taken_away(self):
        world = holding(TableBlock("B", 200, -100))
        world.take("B")
        assert world.scene.held == "A"
        assert world.take("A").name == "A"
        assert world.scene.held is None
        with pytest.raises(BadRequest, match="there is no block 'A'"):
            world.take("A")

    @pytest.mark.parametrize(
        "sizes",
        [
            ("", 1, 1),
            ("a b", 1, 1),
            ("A", float("nan"), 0),
            ("A", "1", 2),
            ("A", 1, 2, 0, -3),
            ("A", 1, 2, 0, 1, 0),
            ("A", True, 2),
        ],
    )
    def test_impossible_blocks_are_refused(self, sizes):
        with pytest.raises(BadRequest):
            TableBlock(*sizes)


class TestFingersOfAServo:
    """Fingers that no motor of the transmission moves."""

    @pytest.fixture
    def world(self):
        body = ArmBody.of_preset(preset("teachmover"))
        motors = tuple(
            replace(motor, sees=motor.sees[:5]) for motor in body.transmission.motors[:5]
        )
        body = replace(body, transmission=replace(body.transmission, motors=motors))
        return World(body, blocks=[BLOCK])

    def test_they_close_on_a_block_carry_it_and_let_it_go(self, world):
        world.move_fingers(50)
        descend(world, 250, 40, 15)
        world.move_fingers(0)
        assert (world.opening_mm, world.scene.held) == (30.0, "A")
        lift(world, 60)
        assert block(world).z_mm == pytest.approx(60, abs=2)
        world.move_fingers(50)
        assert (world.scene.held, block(world).z_mm) == (None, 0.0)

    def test_they_stay_where_they_were_when_the_world_is_saved(self, world):
        world.move_fingers(12.5)
        again = world_from_json(world_to_json(world), world.body)
        assert (again.opening_mm, again.motors) == (12.5, world.motors)


# -- Saved worlds ----------------------------------------------------------------------------------


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
    again = world_from_json(json.loads(json.dumps(world_to_json(world))), world.body)
    assert again.motors == world.motors
    assert again.scene.blocks == world.scene.blocks
    assert again.scene.held == "A"
    assert again.incidents == world.incidents
    assert again.grip_force_n == world.grip_force_n
    assert world_to_json(again) == world_to_json(world)


def test_a_block_held_when_saved_is_still_carried():
    again = world_from_json(world_to_json(lived_in()), BODY)
    before = again.scene.blocks["A"].place
    again.drive((100, 0, 0, 0, 0, 0))
    assert again.incidents == lived_in().incidents
    assert again.scene.blocks["A"].place != before
    assert again.scene.blocks["A"].z_mm == pytest.approx(before[2])


def test_a_device_comes_back_with_what_it_knew():
    bench = TeachMoverBench(TeachMoverBoard(lived_in()))
    bench.ask(QWrite(ProgramRow.move(3, 200, (1, -2, 3, -4, 5, -6))))
    bench.ask(Step(240, (12, 0, 0, 0, 0, 0), 9))
    bench.board.press(Key.FREE)
    bench.device.set_input(5, True)
    saved = json.loads(json.dumps(bench.device.to_json()))
    again = recalled(saved, TeachMoverBoard, BODY)
    assert again.registers == (12, 0, 0, 0, 0, 0)
    known = again.board
    assert (known.key, known.outputs, known.inputs_set) == (Key.FREE, 9, 32)
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


@every_row(
    "path, value, named",
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
def test_a_world_that_no_arm_saved_is_refused_by_name(path, value, named):
    with pytest.raises(StateFileError, match=named):
        recalled(_changed(path, value), TeachMoverBoard, BODY)


@every_row(
    "way, key",
    [((), "powered"), ((), "memory"), (("world",), "held"), (("world", "blocks", 0), "z_mm")],
)
def test_missing_entries_of_a_saved_arm_are_named(way, key):
    data = SimDevice(TeachMoverBoard(lived_in())).to_json()
    table = data
    for each in way:
        table = table[each]
    del table[key]
    with pytest.raises(StateFileError, match=f"missing {key}; .*--fresh"):
        recalled(data, TeachMoverBoard, BODY)


@every_row("data", [None, [], "world", {}, {"format": 1}])
def test_a_file_that_is_no_world_is_refused(data):
    with pytest.raises(StateFileError, match="--fresh"):
        world_from_json(data, BODY)
