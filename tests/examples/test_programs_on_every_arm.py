"""Every example on the arm of every dialect: the physical world at its end, and no incident.

Every day some dialects run a shorter form of an example, with fewer blocks or letters; with
THOROUGH=1 all run the whole.
"""

import tomllib

import pytest
from amounts import THOROUGH
from pages import page_path

from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import parse_arm
from kinematics.five_axis.tool_arm import ToolArm
from kinematics.geometry import Tool

from . import worlds
from .examples_table import EXAMPLES
from .on_arms import FOLDER, run_example
from .page import COMMAND, amounts, cell, told

PAGE = page_path("examples")
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
    if form is example.whole:
        shown = told(PAGE.read_text(encoding="utf-8"), example.file, dialect)
        found = cell(example, form, ran)
        assert amounts(shown) == pytest.approx(amounts(found), rel=0.1, abs=0.2), COMMAND


def test_the_table_has_every_program_file():
    assert {path.name for path in FOLDER.glob("*.arm")} <= set(EXAMPLES)


def test_a_pen_that_the_arm_file_knows_of_draws_the_same_circle():
    """The tool's point is what goes round, 40 mm beyond the finger tips and beside them."""
    config = config_with_tool(Tool(along_mm=40.0, up_mm=6.0))
    example = EXAMPLES["circle.py"]
    ran = run_example(example, example.whole, config)
    assert isinstance(ran.watch.world.body.arm, ToolArm)
    assert worlds.incidents(ran) == []
    assert example.wrong(ran, example.whole.size) == []


def config_with_tool(tool):
    text = f'model = "teachmover"\n[tool]\nalong_mm = {tool.along_mm}\nup_mm = {tool.up_mm}\n'
    return parse_arm(tomllib.loads(text), name="bench", folder=FOLDER)
