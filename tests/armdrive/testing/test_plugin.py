"""The pytest plugin, and its table."""

import math
import subprocess
import sys

import pytest
from sim_bench import descend, grasp, lift, reach, spread

from armdrive import Arm, NotReferenced, Pose, Stopped
from armdrive.errors import ArmInUse, BadRequest
from armdrive.sim.world import World
from armdrive.sim.world.table import IncidentKind, Stand, Table, TableBlock
from armdrive.status import Trust
from armdrive.testing import ArmWorld

pytest_plugins = ["pytester"]

# -- A world ---------------------------------------------------------------------------------------


def down(x_mm, y_mm, z_mm):
    return Pose.of(x_mm=x_mm, y_mm=y_mm, z_mm=z_mm, pitch_deg=-90)


@pytest.fixture
def world(monkeypatch):
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    with ArmWorld() as world:
        yield world


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
        assert arm.parts.pace.clock is world.clock


def test_a_program_that_means_another_arm_is_told_how_to_mark_its_test(world):
    world.faults.add("drop", 0.0)
    with pytest.raises(BadRequest, match=r"mark it with @pytest.mark.armdrive"):
        Arm.connect("sim:grbl")
    with pytest.raises(BadRequest, match="robko02"):
        Arm.connect("sim:robko02")


def test_the_next_program_finds_the_arm_as_the_last_one_left_it(world):
    with Arm.connect("bench") as arm:
        arm.home()
        arm.move_j(base_deg=30)
    stood = world.joints
    with Arm.connect("bench") as arm:
        assert arm.status.trust is Trust.RESTORED
        with pytest.raises(NotReferenced):
            arm.move_j(base_deg=0)
        with pytest.raises(ArmInUse, match="in use by another connection"):
            Arm.connect("bench")
    with Arm.connect("bench", allow_restored=True) as arm:
        arm.move_j(base_deg=31)
    assert world.joints.deg["base"] == pytest.approx(stood.deg["base"] + 1, abs=0.2)


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


def test_held_and_knocked_over_blocks_are_reported(world):
    world.put("A", 250, 0)
    with Arm.connect() as arm:
        arm.home()
        arm.gripper.open()
        arm.move_to(down(250, 0, 90))
        arm.move_l(down(250, 0, 15))
        arm.gripper.grasp()
        assert (world.held, world.opening_mm) == ("A", 25.0)
        world.put("A", 200, -60)
        assert world.held is None
        assert world.blocks["A"].place == (200.0, -60.0, 0.0)
        world.put("A", 250, 0)
        arm.gripper.open()
        arm.gripper.grasp()
        world.put("B", 250, 60)
        arm.move_l(down(250, 60, 15))
    assert [each.kind for each in world.incidents] == [IncidentKind.KNOCK]
    assert world.take("A").name == "A"
    with pytest.raises(BadRequest, match="there is no block 'A'; there are: B"):
        world.take("A")
    assert world.held is None


def test_a_sensor_and_a_person_come_when_they_are_said_to(world):
    world.after(3.0, lambda: world.set_input(4))
    world.after(6.0, lambda: world.set_input(4, False))
    with Arm.connect() as arm:
        arm.io.wait(high=4, within_s=10)
        assert world.clock.now_s == pytest.approx(3.0, abs=0.3)
        arm.io.wait(low=4, within_s=10)
        assert world.clock.now_s == pytest.approx(6.0, abs=0.3)
        with pytest.raises(BadRequest):
            world.set_input("4")


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


# -- A table ---------------------------------------------------------------------------------------

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


def test_each_arm_sees_a_block_from_its_own_base():
    table = Table()
    quarter = World(stand=Stand(table, x_mm=300.0, y_mm=-250.0, turned_rad=math.pi / 2))
    table.put(TableBlock("A", 250.0, 0.0))
    assert quarter.scene.blocks["A"].place == pytest.approx((250.0, 50.0, 0.0))
    rest = quarter.put(TableBlock("B", 250.0, 50.0, 30.0))
    assert rest.place == pytest.approx((250.0, 50.0, 25.0))
    assert table.blocks["B"].place == pytest.approx((250.0, 0.0, 25.0))


def test_two_arms_share_the_blocks_of_a_table():
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


# -- The plugin ------------------------------------------------------------------------------------


PLUGIN = "armdrive.testing.plugin"
ALONE = [f"-p{PLUGIN}", "-pno:cacheprovider"]


@pytest.fixture
def passes(pytester, monkeypatch):
    """Run a file of tests within this process; `words` are pytest's own."""
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # some plugins bear no session inside

    def run(source, *words, passed=1, failed=0, errors=0):
        pytester.makepyfile(source)
        ended = pytester.runpytest_inprocess(*ALONE, *words)
        ended.assert_outcomes(passed=passed, failed=failed, errors=errors)
        return ended

    return run


def test_every_test_begins_anew_without_a_real_port_in_a_folder_of_its_own(passes):
    """The page about testing scripts has a test of a person's own, with faults and marks."""
    passes(
        """
        import asyncio
        import os
        import pytest
        from armdrive import AsyncArm, PortUnavailable, State, Trust
        from armdrive.connect.parts import connect_real
        from armdrive.connect.target import simulated_config
        from armdrive.storage.files import states

        def test_referenced(sim_arm, arm_world):
            assert sim_arm.status.state is State.STANDBY
            assert sim_arm.status.trust is Trust.REFERENCED
            assert sim_arm.twin is arm_world.twin
            sim_arm.move_j(base_deg=10)
            assert abs(arm_world.joints.deg["base"] - 10) < 0.2
            arm_world.faults.add("unplug")

        def test_anew(arm_world, tmp_path):
            assert arm_world.faults.active == ()
            assert os.environ["ARMDRIVE_FORCE_SIM"] == "1"
            assert states().is_relative_to(tmp_path)
            with pytest.raises(PortUnavailable):
                connect_real(simulated_config("teachmover"))

        def test_without():
            assert "ARMDRIVE_FORCE_SIM" not in os.environ

        async def program():
            async with AsyncArm.connect("bench") as arm:
                await arm.home()
                await arm.move_j(base_deg=20)

        def test_a_coroutine(arm_world):
            asyncio.run(program())
            assert abs(arm_world.joints.deg["base"] - 20) < 0.2
        """,
        passed=4,
    )


MARKED = """
    import pytest

    @pytest.mark.armdrive(dialect="grbl")
    def test_marked(arm_world):
        assert arm_world.twin.dialect == "grbl"

    def test_unmarked(arm_world):
        assert arm_world.twin.dialect == "{}"
"""


def test_a_mark_says_what_the_arm_of_a_test_is(passes):
    passes(MARKED.format("teachmover"), "--strict-markers", passed=2)


ARM_FILE = """
title = "The arm in room 3"
model = "teachmover"
[connection]
dialect = "teachmover"
port = "/dev/ttyUSB0"
"""
FILED = """
    import pytest
    from armdrive import Arm

    @pytest.mark.armdrive(file="arms/bench.toml")
    def test_marked(arm_world):
        with Arm.connect("bench") as arm:
            assert arm.status.title == "The arm in room 3"
            assert arm.simulated
"""


def test_an_arm_file_of_the_project_is_the_arm_also_where_nobody_has_installed_it(pytester, passes):
    folder = pytester.mkdir("arms")
    (folder / "bench.toml").write_text(ARM_FILE)
    passes(FILED)
    source = FILED.replace('@pytest.mark.armdrive(file="arms/bench.toml")', "")
    passes(source, "--armdrive-file", "arms/bench.toml")


def test_an_unknown_arm_is_one_sentence_even_for_a_test_that_never_connects(passes):
    source = """
        import pytest

        @pytest.mark.armdrive(dialect="gerbil")
        def test_marked(arm_world):
            pass

        @pytest.mark.armdrive(file="none.toml")
        def test_filed(arm_world):
            pass

        @pytest.mark.armdrive("grbl")
        def test_without_a_word(arm_world):
            pass

        @pytest.mark.armdrive(dialect="grbl", file="none.toml")
        def test_both(arm_world):
            pass

        @pytest.mark.armdrive(dialekt="grbl")
        def test_misspelt(arm_world):
            pass

        def test_unmarked(arm_world):
            pass
    """
    ended = passes(source, "--armdrive-dialect=robko", passed=0, errors=6)
    unclear = [".*choose the simulated arm by its dialect or by a file"] * 3
    ended.stdout.re_match_lines([".*gerbil.*grbl", ".*none.toml", *unclear, ".*robko.*robko01"])


def test_loading_it_imports_nothing_heavy():
    program = f"import sys, pytest, {PLUGIN}; print(*sys.modules)"
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    ours = {name for name in ended.stdout.split() if name.split(".")[0] in OWN}
    assert ours == {"armdrive", "armdrive.testing", PLUGIN}
    assert not set(ended.stdout.split()) & {"numpy", "serial", "can", "textual", "asyncio"}


OWN = ("armdrive", "kinematics", "firmware_protocol", "tui")
