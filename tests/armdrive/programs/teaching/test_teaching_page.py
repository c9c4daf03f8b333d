"""The pages about teaching say what is true: their commands run, their program and rows read."""

import re
import shlex

import pytest
from cli_calls import Caller
from pages import page

from armdrive.connect.target import find
from armdrive.dialects.teachmover.pendant import FIRST_LINE, parse_pendant
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point, Step, StepList
from kinematics import Joints

TEACHING = page("teaching")
TEACHMOVER = page("teachmover")
WATCHES = ("armdrive jog", "armdrive teach record", "armdrive run")
"""What needs a second program beside it, or belongs to another page."""


def commands(text):
    lines = re.findall(r"^(armdrive .*)$", text, re.MULTILINE)
    bare = [re.split(r" {2,}", line)[0] for line in lines]
    return [line for line in bare if not line.startswith(WATCHES)]


@pytest.fixture
def stack():
    config = find("sim:teachmover").config
    book = points_of(config.name, config.model.arm)
    book["above"] = Point(Joints.of(0.0, 40.0, -80.0, -40.0, 0.0), 40.0)
    book["pick"] = Point(Joints.of(0.0, 30.0, -85.0, -35.0, 0.0), 12.0)
    steps = [Step("above"), Step(gripper="open"), Step("pick", "line"), Step(wait_s=1.0)]
    book.put_sequence("stack", StepList(tuple(steps * 2)), instead_of=None)
    return book


def test_every_command_of_the_page_runs(capsys, stack, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call = Caller(capsys)
    call("home", code=0)
    told = commands(TEACHING)
    assert len(told) >= 12
    for command in told:
        call(*shlex.split(command)[1:], code=0)
    assert (tmp_path / "stack.arm").is_file()
    assert "unstack" in stack.sequences


def test_the_python_of_the_page_runs():
    code = re.search(r"```python\n(.*?)```", TEACHING, re.DOTALL)[1]
    exec(compile(code, "teaching.md", "exec"), {})
    config = find("sim:teachmover").config
    book = points_of(config.name, config.model.arm)
    assert book["left"].joints["base"] == -book["right"].joints["base"]


def test_the_rows_of_the_page_read():
    shown = re.search(r"```\n(armdrive pendant program 1\n.*?)```", TEACHMOVER, re.DOTALL)[1]
    program = parse_pendant(shown)
    assert [row.number for row in program.rows] == [1, 2, 3]
    assert program.origin is not None


def test_every_pendant_command_of_the_page_is_one(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call = Caller(capsys)
    call("home", code=0)
    told = [line for line in commands(TEACHMOVER) if line.startswith("armdrive pendant ")]
    told = [line for line in told if not line.startswith("armdrive pendant program")]
    assert len(told) == 5
    rows = tmp_path / "rows"
    rows.write_text(f"{FIRST_LINE}\nmove 1 240 0 0 0 0 0 0\n", encoding="utf-8")
    call("pendant", "write", str(rows), "--yes", code=0)
    for command in told:
        words = shlex.split(command)[1:]
        call(*words, *["--yes"] * ("write" in words), code=0)
