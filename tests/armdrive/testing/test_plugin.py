"""The pytest plugin, tried by tests that run tests: each fixture, mark and option."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

pytest_plugins = ["pytester"]

PLUGIN = "armdrive.testing.plugin"
ALONE = [f"-p{PLUGIN}", "-pno:cacheprovider"]
SCRIPT = """
    from armdrive import Arm, Pose

    def down(x_mm, y_mm, z_mm):
        return Pose.of(x_mm=x_mm, y_mm=y_mm, z_mm=z_mm, pitch_deg=-90)

    def main():
        with Arm.connect("bench") as arm:
            arm.home()
            arm.gripper.open()
            arm.move_to(down(250, 0, 90))
            arm.move_l(down(250, 0, 15))
            width_mm = arm.gripper.grasp()
            arm.move_to(down(200, 100, 90))
            arm.move_l(down(200, 100, 15))
            arm.gripper.open()
            arm.move_l(down(200, 100, 90))
        return width_mm
"""


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


def test_a_persons_script_that_connects_by_itself_is_tested_without_its_arm(pytester, passes):
    pytester.makepyfile(pick=SCRIPT)
    passes(
        """
        import pytest
        import pick

        def test_it(arm_world):
            arm_world.put("A", 250, 0)
            assert pick.main() == pytest.approx(25, abs=0.3)
            assert arm_world.blocks["A"].place == pytest.approx((200, 100, 0), abs=1.5)
            assert arm_world.incidents == ()
            assert arm_world.held is None
            assert arm_world.pose.z_mm == pytest.approx(90, abs=1)
        """
    )


def test_sim_arm_is_enabled_and_referenced_in_the_same_world(passes):
    passes(
        """
        from armdrive import State, Trust

        def test_it(sim_arm, arm_world):
            assert sim_arm.status.state is State.STANDBY
            assert sim_arm.status.trust is Trust.REFERENCED
            assert sim_arm.twin is arm_world.twin
            sim_arm.move_j(base_deg=10)
            assert abs(arm_world.joints.deg["base"] - 10) < 0.2
        """
    )


def test_faults_can_be_had_and_each_test_begins_anew(passes):
    passes(
        """
        import pytest
        from armdrive import LinkLost

        def test_a_pulled_cable(sim_arm, arm_world):
            arm_world.faults.add("unplug", after_s=0.5)
            with pytest.raises(LinkLost):
                sim_arm.move_j(base_deg=60)

        def test_the_next_one_has_its_cable(sim_arm, arm_world):
            sim_arm.move_j(base_deg=60)
            assert arm_world.faults.active == ()
        """,
        passed=2,
    )


def test_no_real_port_can_be_opened_and_what_is_remembered_goes_into_the_tests_folder(passes):
    passes(
        """
        import os
        import pytest
        from armdrive import PortUnavailable
        from armdrive.connect.parts import connect_real
        from armdrive.connect.target import simulated_config
        from armdrive.storage.files import states

        def test_within(arm_world, tmp_path):
            assert os.environ["ARMDRIVE_FORCE_SIM"] == "1"
            assert states().is_relative_to(tmp_path)
            with pytest.raises(PortUnavailable):
                connect_real(simulated_config("teachmover"))

        def test_without():
            assert "ARMDRIVE_FORCE_SIM" not in os.environ
        """,
        passed=2,
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


def test_an_option_says_it_for_the_tests_that_do_not(passes):
    passes(MARKED.format("robko01"), "--armdrive-dialect=robko01", passed=2)


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


@pytest.mark.parametrize(
    "mark", ['"grbl"', 'dialekt="grbl"', 'dialect="grbl", file="a.toml"', ""], ids=str
)
def test_a_mark_that_says_nothing_right_is_an_error_that_shows_how(mark, passes):
    ended = passes(
        f"""
        import pytest

        @pytest.mark.armdrive({mark})
        def test_it(arm_world):
            pass
        """,
        passed=0,
        errors=1,
    )
    ended.stdout.re_match_lines([".*(armdrive\\(dialect=|not both)"])


def test_an_unknown_arm_is_one_sentence_even_for_a_test_that_never_connects(passes):
    source = """
        import pytest

        @pytest.mark.armdrive(dialect="gerbil")
        def test_marked(arm_world):
            pass

        @pytest.mark.armdrive(file="none.toml")
        def test_filed(arm_world):
            pass

        def test_unmarked(arm_world):
            pass
    """
    ended = passes(source, "--armdrive-dialect=robko", passed=0, errors=3)
    ended.stdout.re_match_lines([".*gerbil.*grbl", ".*none.toml", ".*robko.*robko01"])


def test_a_coroutine_may_use_them_too(passes):
    passes(
        """
        import asyncio
        from armdrive import AsyncArm

        async def program():
            async with AsyncArm.connect("bench") as arm:
                await arm.home()
                await arm.move_j(base_deg=20)

        def test_it(arm_world):
            asyncio.run(program())
            assert abs(arm_world.joints.deg["base"] - 20) < 0.2
        """
    )


def test_the_plugin_is_registered_under_its_modules_name_and_so_never_twice():
    project = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text())
    (entry,) = project["project"]["entry-points"]["pytest11"].items()
    assert entry == (PLUGIN, PLUGIN)
    assert hasattr(EntryPoint(*entry, "pytest11").load(), "arm_world")


def test_loading_it_imports_nothing_heavy():
    program = f"import sys, pytest, {PLUGIN}; print(*sys.modules)"
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    ours = {name for name in ended.stdout.split() if name.split(".")[0] in OWN}
    assert ours == {"armdrive", "armdrive.testing", PLUGIN}
    assert not set(ended.stdout.split()) & {"numpy", "serial", "can", "textual", "asyncio"}


OWN = ("armdrive", "kinematics", "firmware_protocol", "tui")
