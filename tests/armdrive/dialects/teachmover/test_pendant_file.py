"""A pendant's program as text: every row comes back unchanged, with its meaning beside it."""

import re

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from pendant_programs import PROGRAMS

from armdrive.connect.target import find
from armdrive.dialects.teachmover.pendant import (
    FIRST_LINE,
    PendantProgram,
    meaning,
    parse_pendant,
    taught_by,
    text_of,
)
from armdrive.errors import BadRequest, PendantFileError, Refused
from armdrive.storage.points import Taught
from firmware_protocol.teachmover import ProgramRow
from kinematics import Joints

CONFIG = find("sim:teachmover").config
ZERO = (0,) * 6


def written(program):
    return text_of(CONFIG, program, "2026-11-22 10:30")


def row_to(number, joints, opening_mm, speed=240):
    steps = CONFIG.model.transmission.to_motors(joints, opening_mm)
    return ProgramRow.move(number, speed, tuple(steps))


@example(PendantProgram((ProgramRow.move(10_000, 240, (0,) * 6),)), None)
@given(PROGRAMS, st.none() | st.tuples(*[st.integers(-32768, 32767)] * 6))
def test_what_is_written_reads_as_the_same_words(program, origin):
    program = PendantProgram(program.rows, origin)
    assert parse_pendant(written(program)) == program


def test_rows_stand_below_their_motors():
    rows = (ProgramRow.move(1, 240, (100, -200, 300, -400, 500, -600)), ProgramRow(2, 250, ZERO))
    lines = written(PendantProgram(rows)).splitlines()
    assert lines[0] == FIRST_LINE
    assert lines[-2] == (
        "move    1   240"
        + "".join(f"{n:>12}" for n in (100, -200, 300, -400, 500, -600))
        + "   # 470 steps/s"
    )
    assert lines[-1].startswith("raw     2 ")
    assert lines[-1].endswith("   # not a known move")
    assert len(lines[-3]) == lines[-2].index(" # 470") - 2
    assert "origin 0 0 0 0 0 0" in written(PendantProgram(rows, ZERO)).splitlines()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("move 1 240 1 2 3 4 5", "line 2: `move` needs 8 numbers, not 7"),
        ("move 1 246 1 2 3 4 5 6", "line 2: .*246"),
        ("move 1 240 1 2 3 4 5 40000", "line 2: .*40000"),
        ("move 1 240 1 2 3 4 5 six", "line 2: 'six' is not a whole number"),
        ("jump 1 240 1 2 3 4 5 6", "line 2: a row begins with `move` or `raw`, not 'jump'"),
        ("raw 1 70000 1 2 3 4 5 6", "line 2: 70000"),
        ("origin 1 2 3", "line 2: `origin` needs 6 numbers"),
    ],
)
def test_a_line_that_is_none_is_named(line, words):
    with pytest.raises(PendantFileError, match=words):
        parse_pendant(f"{FIRST_LINE}\n{line}\n")


@given(st.text(alphabet="mover awign0123456789- #\n", max_size=80))
def test_whatever_stands_in_a_file_is_a_program_or_a_sentence(text):
    try:
        read = parse_pendant(f"{FIRST_LINE}\n{text}")
    except PendantFileError:
        return  # the only error that may be raised
    assert parse_pendant(written(read)) == read


def test_what_is_no_program_at_all_is_refused():
    with pytest.raises(PendantFileError, match="first line must be"):
        parse_pendant("[points.pick]\n")


def test_a_row_that_is_there_twice_can_be_kept_but_not_used():
    row = "move 1 240 1 2 3 4 5 6\n"
    program = parse_pendant(f"{FIRST_LINE}\norigin 0 0 0 0 0 131072\n{row}{row.replace('6', '7')}")
    assert parse_pendant(written(program)) == program
    with pytest.raises(BadRequest, match="row 1 is there twice"):
        taught_by(CONFIG, program, "stack")
    with pytest.raises(BadRequest, match="row 1 is there twice"):
        program.require_fitting(64)


def test_a_row_says_its_speed_posture_and_fingers_where_the_origin_is_known():
    row = row_to(1, Joints.of(10.0, 40.0, -80.0, -40.0, 0.0), 30.0)
    words = meaning(CONFIG, PendantProgram((row,), ZERO), row)
    assert re.fullmatch(r"470 steps/s; base 10\.\d°, shoulder .*; fingers \d+\.\d mm", words)
    assert meaning(CONFIG, PendantProgram((row,)), row) == "470 steps/s"
    odd = ProgramRow(1, 240, ZERO, kind=9)
    assert meaning(CONFIG, PendantProgram((odd,), ZERO), odd) == "not a known move"


def test_rows_become_points_and_steps_of_the_fingers():
    up, down = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0), Joints.of(0.0, 30.0, -85.0, -35.0, 0.0)
    rows = (
        row_to(1, up, 40.0),
        row_to(2, down, 40.0, 140),
        row_to(3, down, 10.0),
        row_to(4, up, 10.0),
    )
    points, steps = taught_by(CONFIG, PendantProgram(rows, ZERO), "stack")
    assert list(points) == ["stack-1", "stack-2", "stack-4"]
    assert [str(step) for step in steps.steps] == [
        "to stack-1",
        "gripper 40 mm",
        "to stack-2 at 32%",
        "gripper 10 mm",
        "to stack-4",
    ]
    assert points["stack-1"].joints.deg["shoulder"] == pytest.approx(40.0, abs=0.1)
    Taught(points, {"stack": steps})  # raises an error if a step's point does not exist


def test_rows_that_nobody_understands_become_no_points():
    with pytest.raises(Refused, match="the program's origin is unknown"):
        taught_by(CONFIG, PendantProgram(()), "stack")
    with pytest.raises(Refused, match="has no rows"):
        taught_by(CONFIG, PendantProgram((), ZERO), "stack")
    odd = PendantProgram((ProgramRow(7, 240, ZERO, kind=9),), ZERO)
    with pytest.raises(Refused, match="row 7 is of an unknown kind"):
        taught_by(CONFIG, odd, "stack")
