"""A world for tests: connections lead into it, and what is told of it is physical."""

from __future__ import annotations

import asyncio
import math

import pytest

from armdrive import Arm, ArmInUse, AsyncArm, NoAnswer, NotReferenced, Pose, Stopped, WrongState
from armdrive.errors import ArmFileError, BadRequest
from armdrive.sim.world.table import IncidentKind
from armdrive.status import State, Trust
from armdrive.testing import ArmWorld


def down(x_mm, y_mm, z_mm):
    return Pose.of(x_mm=x_mm, y_mm=y_mm, z_mm=z_mm, pitch_deg=-90)


def carry(arm, start, end):
    """What a person's program does."""
    arm.gripper.open()
    for (x_mm, y_mm), act in ((start, arm.gripper.grasp), (end, arm.gripper.open)):
        arm.move_to(down(x_mm, y_mm, 90))
        arm.move_l(down(x_mm, y_mm, 15))
        act()
        arm.move_l(down(x_mm, y_mm, 90))


@pytest.fixture
def world(monkeypatch):
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    with ArmWorld() as world:
        yield world


def test_a_programs_own_connection_leads_to_the_worlds_arm(world):
    world.put("A", 250, 0)
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        carry(arm, (250, 0), (200, 100))
        assert arm.twin is world.twin
    assert world.blocks["A"].place == pytest.approx((200, 100, 0), abs=1.5)
    assert world.incidents == ()


@pytest.mark.parametrize(
    ("target", "options", "dialect"),
    [
        (None, {}, "teachmover"),
        ("bench", {}, "teachmover"),
        ("sim:grbl", {}, "grbl"),
        ("/dev/ttyUSB0", {"dialect": "robko01"}, "robko01"),
        ("/dev/ttyUSB0", {}, "teachmover"),
        ("COM3", {"dialect": "armdroid", "baud": 9600, "pace": "real"}, "armdroid"),
    ],
)
def test_whatever_a_program_connects_to_it_is_the_worlds_arm(world, target, options, dialect):
    with Arm.connect(target, **options) as arm:
        assert arm.simulated
        assert arm.twin is world.twin
        assert arm.status.dialect == dialect
        assert arm.pace.clock is world.clock


def test_an_arm_file_that_is_there_says_what_the_arm_is(world, tmp_path):
    file = tmp_path / "bench.toml"
    file.write_text('model = "teachmover"\n[connection]\ndialect = "teachmover"\nport = "/dev/x"\n')
    with Arm.connect(str(file)) as arm:
        assert arm.config.name == "sim:bench"
    with pytest.raises(ArmFileError):
        Arm.connect(str(tmp_path / "none.toml"))


def test_a_program_that_means_another_arm_is_told_how_to_mark_its_test(world):
    world.faults.add("drop", 0.0)
    with pytest.raises(BadRequest, match=r"mark it with @pytest.mark.armdrive"):
        Arm.connect("sim:grbl")
    with pytest.raises(BadRequest, match="robko02"):
        Arm.connect("sim:robko02")


def test_the_world_can_be_of_another_arm():
    with ArmWorld("sim:grbl") as world:
        assert world.twin.dialect == "grbl"
        with Arm.connect("bench") as arm:
            assert arm.status.dialect == "grbl"
        with pytest.raises(BadRequest, match="TeachMover"):
            Arm.connect("sim:teachmover")


def test_the_next_program_finds_the_arm_as_the_last_one_left_it(world):
    with Arm.connect("bench") as arm:
        arm.home()
        arm.move_j(base_deg=30)
    stood = world.joints
    with Arm.connect("bench") as arm:
        assert arm.status.trust is Trust.RESTORED
        with pytest.raises(NotReferenced):
            arm.move_j(base_deg=0)
    with Arm.connect("bench", allow_restored=True) as arm:
        arm.move_j(base_deg=31)
    assert world.joints.deg["base"] == pytest.approx(stood.deg["base"] + 1, abs=0.2)


def test_two_programs_cannot_hold_one_arm(world):
    first = Arm.connect("bench")
    with pytest.raises(ArmInUse, match=r"arm_world\.add"):
        Arm.connect("bench")
    first.close()
    Arm.connect("bench").close()


def test_arms_are_placed_by_the_names_that_the_program_uses(world):
    world.add("left", "sim:teachmover")
    world.add("right", "sim:grbl", x_mm=500, turned_deg=180)
    with Arm.connect("left") as left, Arm.connect("right") as right:
        assert (left.status.dialect, right.status.dialect) == ("teachmover", "grbl")
        assert list(world.arms) == ["left", "right"]
        with pytest.raises(BadRequest, match="left, right"):
            Arm.connect("middle")
    with pytest.raises(BadRequest, match="already"):
        world.add("left")


def test_what_is_told_is_physical_whatever_the_controller_believes(world):
    world.put("A", 250, 0)
    with Arm.connect() as arm:
        arm.home()
        world.faults.add("stall", 1)
        arm.move_j(base_deg=40)
        assert arm.joints.deg["base"] == pytest.approx(40, abs=0.2)
        assert world.joints.deg["base"] == pytest.approx(0, abs=0.2)
        assert world.pose.y_mm == pytest.approx(0, abs=1)
        world.faults.end()


def test_what_is_held_and_what_is_knocked_over(world):
    world.put("A", 250, 0)
    with Arm.connect() as arm:
        arm.home()
        arm.gripper.open()
        arm.move_to(down(250, 0, 90))
        arm.move_l(down(250, 0, 15))
        arm.gripper.grasp()
        assert (world.held, world.opening_mm) == ("A", 25.0)
        world.put("B", 250, 60)
        arm.move_l(down(250, 60, 15))
    assert [each.kind for each in world.incidents] == [IncidentKind.KNOCK]
    assert world.take("A").name == "A"
    assert world.held is None


def test_a_sensor_and_a_person_come_when_they_are_said_to(world):
    world.after(3.0, lambda: world.set_input(4))
    world.after(6.0, lambda: world.set_input(4, False))
    with Arm.connect() as arm:
        arm.wait_inputs(high=4, within_s=10)
        assert world.clock.now_s == pytest.approx(3.0, abs=0.3)
        arm.wait_inputs(low=4, within_s=10)
        assert world.clock.now_s == pytest.approx(6.0, abs=0.3)
        with pytest.raises(BadRequest):
            world.set_input("4")


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda world: world.put(5, 250, 0), "name must be text, not 5"),
        (lambda world: world.put("A", "left", 0), "x_mm must be a finite number, not 'left'"),
        (lambda world: world.add("right", x_mm=math.inf), "x_mm must be a finite number, not inf"),
        (lambda world: world.after("soon", print), "by_s must be a finite number, not 'soon'"),
        (lambda world: world.after(1, None), "action must be a function, not None"),
        (lambda world: world.set_input(1), "no input 1 for a sensor; inputs are counted from 1"),
        (lambda world: world.set_input(8 + 1), "TeachMover has no input 9 for a sensor"),
        (lambda world: world.add("right", ""), "the name of the arm is empty"),
        (lambda world: Arm.connect(""), "the name of the arm is empty"),
    ],
)
def test_a_call_of_the_world_that_cannot_be_is_refused(world, call, said):
    with pytest.raises(BadRequest, match=said):
        call(world)
    assert world.blocks == {}


def test_an_async_program_leads_there_too(world):
    world.add("left")
    world.add("right", x_mm=500, turned_deg=180)

    async def program():
        async with AsyncArm.connect("left") as left, AsyncArm.connect("right") as right:
            await asyncio.gather(left.home(), right.home())
            began_s = world.clock.now_s
            await asyncio.gather(left.move_j(base_deg=50), right.move_j(base_deg=50))
            return world.clock.now_s - began_s

    assert asyncio.run(program()) < 5.0
    for twin in world.arms.values():
        assert twin.world.joints.deg["base"] == pytest.approx(50, abs=0.2)


def test_the_end_closes_what_is_open_and_later_connections_lead_elsewhere():
    with ArmWorld() as world:
        arm = Arm.connect()
        arm.home()
        handle = arm.move_j(base_deg=60, wait=False)
    assert arm.closed
    with pytest.raises(Stopped):
        handle.wait()
    with Arm.connect() as other:
        assert other.twin is not world.twin


def test_a_with_block_whose_arm_cannot_be_switched_on_leaves_no_connection_open():
    with ArmWorld("sim:robko01") as world:
        arm = Arm.connect("sim:robko01")
        world.faults.add("mute")
        with pytest.raises(NoAnswer), arm:
            raise AssertionError("the motors are not on")
        assert arm.closed
        with pytest.raises(WrongState, match="closed for good"), arm:
            raise AssertionError("the arm is not connected")
        world.faults.end("mute")
        with Arm.connect("sim:robko01") as again:
            assert again.status.state is State.STANDBY
