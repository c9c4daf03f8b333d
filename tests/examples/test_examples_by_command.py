"""The commands that stand at the top of the examples work as they are copied from there."""

import json
import re
import shlex

import pytest

from armdrive.cli import main
from armdrive.cli.chosen_arm import world_file
from armdrive.sim.world.table import TableBlock

from .on_arms import FOLDER, PUT

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
    assert main([*words, "--check"]) == 0, capsys.readouterr().err
    assert set(blocks()) == {words.split(",")[0] for words in PUT.findall(" ".join(words))}


def test_the_first_command_of_the_tower_builds_it(capsys, monkeypatch):
    monkeypatch.chdir(FOLDER)
    words = command_of("stacking.arm")
    assert main(words) == 0, capsys.readouterr().err
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
