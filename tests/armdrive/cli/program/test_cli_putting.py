"""`armdrive run --put`: blocks on the table of a simulated arm before its program begins."""

import json

import pytest
from cli_calls import Caller

from armdrive.cli.chosen_arm import world_file
from armdrive.errors import BadRequest
from armdrive.sim.world.table import block_of

CARRY = """
open 40
move at(250, 60, 70, -90)
move_line at(250, 60, 12, -90)
open_now 28
move_line at(250, 60, 70, -90)
move_line at(250, 0, 70, -90)
move_line at(250, 0, 12, -90)
open_now 40
ready
"""
TWICE = """
from armdrive import Arm
for _ in range(2):
    with Arm.connect() as arm:
        arm.twin.world.take("A")
"""


@pytest.fixture
def call(capsys):
    return Caller(capsys)


def blocks(name="sim:teachmover"):
    saved = json.loads(world_file(name).read_text(encoding="utf-8"))
    return {each["name"]: each for each in saved["world"]["blocks"]}


def write(tmp_path, text, name="carry.arm"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_the_program_finds_the_blocks_that_were_put_there(call, tmp_path):
    program = write(tmp_path, f"home\n{CARRY}")
    call("run", program, "--put", "A,250,60,30", "--put", "B,180,-60", code=0)
    found = blocks()
    assert found["A"]["y_mm"] == pytest.approx(0.0, abs=1.0)
    assert found["A"]["height_mm"] == 30.0
    assert (found["B"]["width_mm"], found["B"]["z_mm"]) == (25.0, 0.0)


def test_a_block_stands_on_the_one_before(call, tmp_path):
    program = write(tmp_path, "home\n")
    call("run", program, "--put", "A,250,60,30,20", "--put", "B,250,60", code=0)
    assert blocks()["B"]["z_mm"] == 20.0


def test_a_script_that_connects_twice_finds_them_once(call, tmp_path):
    call("run", write(tmp_path, TWICE, "twice.py"), "--put", "A,250,60", code=0)
    assert blocks() == {}


def test_a_real_arm_has_no_table_to_put_them_on(call, tmp_path):
    program = write(tmp_path, "home\n")
    words = ("--port", "/dev/no-such-port", "--dialect", "teachmover")
    refused = call("run", program, *words, "--put", "A,250,60", code=2)
    assert "simulated" in refused.err
    assert "by hand" in refused.err


@pytest.mark.parametrize("words", ["A", "A,1", "A,1,2,3,4,5", "A,one,2", "A B,1,2", "A,1,2,-3"])
def test_what_is_no_block_is_refused_with_its_form(words):
    with pytest.raises(BadRequest):
        block_of(words.split(","))


def test_the_command_says_what_is_wrong_with_a_block(call, tmp_path):
    refused = call("run", write(tmp_path, "home\n"), "--put", "A,one,2", code=2)
    assert "'one' is no number" in refused.err
    assert "NAME,X,Y[,WIDTH[,HEIGHT]]" in refused.err
