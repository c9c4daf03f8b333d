"""What a person is told to type after an interruption: for the same arm, and no faster."""

import argparse
import shlex

import pytest

from armdrive.cli.program.arguments import ARGUMENTS

FAILS = """\
move at(250, 0, 120, -90)
if not input(2)
  move at(900, 0, 120, -90)
end
"""


def told(err, start):
    """Return the words of the command that stands in an answer, read as the command reads them."""
    rest = err[err.index(start) :]
    return shlex.split(rest.splitlines()[0].partition("`")[0])


@pytest.fixture
def failing(call, tmp_path):
    path = tmp_path / "t.arm"
    path.write_text(FAILS, encoding="utf-8")
    call("home", "--sim", "grbl", code=0)
    return str(path)


def test_it_goes_on_as_slowly_and_carefully_as_it_was_begun(call, failing):
    with_care = ("--sim", "grbl", "--speed", "12.5", "--yes", "--input", "1=on")
    words = told(call("run", failing, *with_care, code=3).err, "armdrive run ")
    parser = argparse.ArgumentParser()
    ARGUMENTS["run"].declare(parser)
    options = parser.parse_args(words[2:])
    assert options.resume
    assert (options.sim, options.speed) == ("grbl", 12.5)
    assert (options.step, options.input) == (False, [(1, True)])
    assert not options.yes  # that is said anew, or not


def test_an_arm_is_brought_back_by_a_command_that_names_it(call, failing):
    call("run", failing, "--sim", "grbl", "--yes", "--speed", "50", code=3)
    call("move", "--sim", "grbl", "--z", "80", code=0)
    again = ("run", failing, "--sim", "grbl", "--yes", "--speed", "50", "--resume")
    words = told(call(*again, code=3).err, "armdrive move ")
    assert words[:6] == ["armdrive", "move", "--sim", "grbl", "--speed", "0.5"]
    call(*words[1:], code=0)
    assert "out of reach" in call(*again, code=3).err  # it stands there: line 3 is tried again
