"""Every example runs as it stands, and by the command at its top; so does the design's own."""

import io
import json
import os
import re
import runpy
import shlex
import subprocess
import sys
import tomllib
import warnings

import pytest
from amounts import THOROUGH
from waiting import LONG_S

from armdrive.cli import main
from armdrive.cli.chosen_arm import world_file
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import parse_arm
from armdrive.sim.world.table import TableBlock
from kinematics.geometry import Tool

from . import worlds
from .examples_table import EXAMPLES
from .on_arms import FOLDER, PUT, run_example

SCRIPTS = sorted(path for path in FOLDER.glob("*.py") if THOROUGH or path.name not in EXAMPLES)
"""Every day those that no other test runs."""


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_an_example_runs_unattended(path, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    monkeypatch.setattr(sys, "argv", [str(path)])
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    with warnings.catch_warnings(action="error"):
        runpy.run_path(str(path), run_name="__main__")
    said = capfd.readouterr()
    assert said.err == ""
    assert said.out


def test_an_example_is_a_program_of_its_own(tmp_path):
    path = FOLDER / "first_steps.py"
    ended = subprocess.run(
        [sys.executable, "-W", "error", str(path)],
        env={**os.environ, "ARMDRIVE_FORCE_SIM": "1"},
        cwd=tmp_path,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=LONG_S,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stderr == ""
    assert ended.stdout


def test_the_example_of_the_documentation_word_for_word(capsys):
    from armdrive import Arm, Pose

    # fmt: off
    # ruff: noqa: E501, T201 - the lines are the documentation's, as it prints them
    with Arm.connect("sim:teachmover") as arm:      # or an arm file's name, or a port with a dialect
        arm.home()                                   # the simulated arm has a simulated operator
        arm.move_j(shoulder_deg=40, elbow_deg=-60, speed=0.5)             # joints not named stay
        arm.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90))   # joint motion to a Cartesian goal
        arm.move_l(Pose.of(x_mm=250, y_mm=80, z_mm=120, pitch_deg=-90))   # straight line
        width_mm = arm.gripper.grasp()
        print(arm.status, arm.joints, arm.pose)
        # fmt: on
        tip = arm.twin.world.pose

    assert width_mm == pytest.approx(0.0, abs=0.1)
    assert (tip.x_mm, tip.y_mm, tip.z_mm) == pytest.approx((250, 80, 120), abs=0.5)
    assert "SIMULATED" in capsys.readouterr().out


# The commands that stand at the top of the examples.

PROGRAMS = sorted(path.name for path in FOLDER.glob("*.arm"))
ARM = "sim:teachmover"
FIRST_COMMAND = re.compile(r"^#? *(armdrive run \S.*?)(?:  +.*)?$", re.MULTILINE)


def command_of(file):
    """Return the words of the first command that an example tells of."""
    found = FIRST_COMMAND.search((FOLDER / file).read_text(encoding="utf-8"))
    assert found is not None
    return shlex.split(found[1])[1:]


def blocks():
    saved = json.loads(world_file(ARM).read_text(encoding="utf-8"))["world"]["blocks"]
    return {each["name"]: TableBlock(**each) for each in saved}


@pytest.mark.parametrize("file", PROGRAMS)
def test_the_first_command_of_a_program_rehearses_it_with_its_blocks(file, capsys, monkeypatch):
    monkeypatch.chdir(FOLDER)
    words = command_of(file)
    assert words[:2] == ["run", file]
    built = file == "stacking.arm"  # this one is run as well, the others only rehearsed
    assert main(words if built else [*words, "--check"]) == 0, capsys.readouterr().err
    assert set(blocks()) == {words.split(",")[0] for words in PUT.findall(" ".join(words))}
    if built:
        assert sorted(block.z_mm for block in blocks().values()) == [0.0, 25.0, 50.0, 75.0]


@pytest.mark.parametrize("file", ["circle.py", "lettering.py"])
def test_the_first_command_of_a_drawing_rehearses_it(file, capsys, monkeypatch):
    monkeypatch.chdir(FOLDER)
    words = command_of(file)
    named = words.index("--arm")
    del words[named : named + 2]
    assert "--check" in words
    assert main(words) == 0, capsys.readouterr().err
    assert "move_" in capsys.readouterr().out


# Every example on the arm of every dialect: the physical world at its end, and no incident.
#
# Every day some dialects run a shorter form of an example, with fewer blocks or letters; with
# THOROUGH=1 all run the whole.


CASES = [
    pytest.param(example, form, dialect, id=f"{example.file}-{dialect}")
    for example in EXAMPLES.values()
    for dialect in DIALECTS
    if not example.against(dialect) and (form := example.form(dialect, whole=THOROUGH)) is not None
]


@pytest.mark.parametrize(("example", "form", "dialect"), CASES)
def test_an_example_leaves_the_world_as_it_says(example, form, dialect):
    ran = run_example(example, form, dialect)
    assert worlds.incidents(ran) == []
    assert example.wrong(ran, form.size) == []


def test_a_pen_that_the_arm_file_knows_of_draws_the_same_circle():
    """The tool's point is what goes round, 40 mm beyond the finger tips and beside them."""
    config = config_with_tool(Tool(along_mm=40.0, up_mm=6.0))
    example = EXAMPLES["circle.py"]
    ran = run_example(example, example.whole, config)
    assert ran.watch.world.body.arm.tool
    assert worlds.incidents(ran) == []
    assert example.wrong(ran, example.whole.size) == []


def config_with_tool(tool):
    text = f'model = "teachmover"\n[tool]\nalong_mm = {tool.along_mm}\nup_mm = {tool.up_mm}\n'
    return parse_arm(tomllib.loads(text), name="bench", folder=FOLDER)
