"""Programs of the TeachMover's pendant, and their files."""

import re
from collections.abc import Iterator
from dataclasses import replace

import pytest
from amounts import every_row
from faults import Rule, garbled, instead, lost, ready_arm
from hypothesis import example, given
from hypothesis import strategies as st

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import find
from armdrive.dialects.teachmover.pendant import (
    FORMAT_LINE,
    PendantProgram,
)
from armdrive.errors import (
    BadRequest,
    LinkLost,
    PendantFileError,
    ProgramHalfWritten,
    Refused,
    Stopped,
)
from armdrive.registry import DIALECTS
from armdrive.status import State
from firmware_protocol.teachmover import ProgramRow
from kinematics import Joints

COUNTS = st.integers(-(1 << 15), (1 << 15) - 1)
ROWS = st.builds(
    ProgramRow,
    st.integers(0, 65535),
    st.integers(0, 255),
    st.tuples(*[COUNTS] * 6),
    st.integers(0, 255),
)
PROGRAMS = st.lists(ROWS, max_size=12, unique_by=lambda row: row.number).map(
    lambda rows: PendantProgram(tuple(sorted(rows, key=lambda row: row.number)))
)


def program(*numbers: int) -> PendantProgram:
    """Return a program whose rows have these numbers, each with another target."""
    rows = (ProgramRow.move(n, 200, (100 * n, -7 * n, n, 0, -n, 50)) for n in numbers)
    return PendantProgram(tuple(rows))


@pytest.fixture
def arm() -> Iterator[Arm]:
    with ready_arm() as arm:
        yield arm


def memory(arm: Arm) -> dict[int, ProgramRow]:
    return dict(arm.twin.board.memory.rows)


@given(PROGRAMS)
def test_a_written_program_is_read_back_unchanged_and_nothing_moves(rows):
    with Arm.connect("sim:teachmover") as arm:
        before = arm.twin.world.motors
        assert arm.controller.write_program(rows) == len(rows.rows)
        assert arm.controller.read_program().words == rows.words
        assert arm.twin.world.motors == before
        assert arm.status.state is State.STANDBY


def test_rows_that_are_there_already_are_not_written_again(arm):
    arm.controller.write_program(program(1, 2, 3))
    changed = PendantProgram((*program(1, 2).rows, ProgramRow.move(3, 90, (0,) * 6)))
    arm.twin.link.sent.clear()
    assert arm.controller.write_program(changed) == 1
    assert len(arm.twin.link.named(b"@QWRITE")) == 1


@pytest.mark.parametrize(
    "dialect", [name for name, row in DIALECTS.items() if name != "teachmover"]
)
def test_a_controller_without_a_program_says_so_before_a_byte(dialect):
    with Arm.connect(f"sim:{dialect}") as arm:
        sent = arm.parts.engine.requests_sent
        with pytest.raises(Refused, match="keeps no program"):
            arm.controller.read_program()
        with pytest.raises(Refused, match="keeps no program"):
            arm.controller.write_program(program(1))
        assert arm.parts.engine.requests_sent == sent


def test_a_full_memory_says_which_rows_are_in_it():
    with Arm.connect("sim:teachmover") as arm, pytest.raises(ProgramHalfWritten) as caught:
        arm.controller.write_program(program(*range(1, 53)))
    assert "only 50 of 52 rows were written: write again" in str(caught.value)


def test_rows_of_other_numbers_are_not_left_to_run_with_the_new_ones_unless_said():
    with Arm.connect("sim:teachmover") as arm:
        arm.controller.write_program(program(1, 2, 3, 4))
        before = memory(arm)
        with pytest.raises(Refused, match="also has rows 3 to 4"):
            arm.controller.write_program(program(1, 2))
        assert memory(arm) == before
        arm.controller.write_program(program(1, 2), leave_others=True)
        assert list(memory(arm)) == [1, 2, 3, 4]


def test_a_digit_that_was_turned_in_a_dump_is_noticed(arm):
    rows = program(1, 2, 3)
    arm.controller.write_program(rows)
    arm.twin.link.back.append(Rule(b"2,", garbled(-3, ord("7")), times=1))
    assert arm.controller.read_program().words == rows.words
    assert not arm.twin.link.back[0].applies(b"2,")  # the damage has been done, once


def test_a_row_that_was_lost_on_the_wire_is_written_again(arm):
    arm.twin.link.to.append(Rule(b"@QWRITE 2,", lost, times=1))
    arm.controller.write_program(program(1, 2, 3))
    assert list(memory(arm)) == [1, 2, 3]


def test_a_row_that_came_otherwise_into_the_arm_is_named(arm):
    other = ProgramRow.move(2, 10, (0,) * 6)
    line = b"@QWRITE " + b",".join(b"%d" % word for word in other.words) + b"\r"
    arm.twin.link.to.append(Rule(b"@QWRITE 2,", instead(line), times=1))
    with pytest.raises(ProgramHalfWritten, match=r"differs from what was written: row 2\."):
        arm.controller.write_program(program(1, 2, 3))


def test_a_cable_pulled_in_the_middle_of_writing_names_the_rows():
    arm = ready_arm()
    link = arm.twin.link
    link.on_write = lambda data: link.cut() if data.startswith(b"@QWRITE 3,") else None
    with pytest.raises(ProgramHalfWritten) as caught, arm:
        arm.controller.write_program(program(1, 2, 3, 4, 5))
    assert "only 2 of 5 rows were written: write again" in str(caught.value)
    assert isinstance(caught.value.__cause__, LinkLost)


def test_a_stop_ends_writing_between_two_rows(arm):
    arm.twin.link.on_write = lambda data: (
        arm.request_stop() if data.startswith(b"@QWRITE 2,") else None
    )
    with pytest.raises(Stopped, match="only 2 of 4 rows"):
        arm.controller.write_program(program(1, 2, 3, 4))
    assert list(memory(arm)) == [1, 2]


def test_rows_read_under_another_reference_are_refused_until_they_are_shifted():
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        arm.controller.write_program(program(1, 2))
        read = arm.controller.read_program()
        arm.move_j(base_deg=20.0)
        arm.disable()  # @RESET: from now on, the registers count from here
        arm.enable()
        arm.reference.declare(arm.twin.world.joints)
        sent = arm.parts.engine.requests_sent
        with pytest.raises(Refused, match="count from elsewhere"):
            arm.controller.write_program(read)
        assert arm.parts.engine.requests_sent == sent
        now = arm.controller.read_program().origin
        shifted = read.moved_to(now)
        arm.controller.write_program(shifted)
        for old, new in zip(read.rows, shifted.rows, strict=True):
            old_place = [a + b for a, b in zip(old.positions, read.origin, strict=True)]
            assert [a + b for a, b in zip(new.positions, now, strict=True)] == old_place
        arm.controller.write_program(read.without_origin())
        assert arm.controller.read_program().words == read.words


ZERO, FIVES = (0,) * 6, (5,) * 6
ODD = ProgramRow(1, 200, (1, 2, 3, 4, 5, 6), kind=4)


@pytest.mark.parametrize(
    ("row", "origin", "to", "words"),
    [
        (ODD, ZERO, FIVES, "unknown kind"),
        (ProgramRow.move(1, 200, (-32768,) * 6), ZERO, FIVES, "row 1 cannot be shifted"),
        (ProgramRow.move(1, 200, ZERO), None, FIVES, "the program's origin is unknown"),
        (ProgramRow.move(1, 200, ZERO), ZERO, None, "home it first"),
    ],
)
def test_a_row_that_may_lead_elsewhere_is_not_shifted(row, origin, to, words):
    with pytest.raises(Refused, match=words):
        PendantProgram((row,), origin).moved_to(to)


def test_a_row_of_an_unknown_kind_is_kept():
    odd = PendantProgram((ODD,), ZERO)
    assert odd.moved_to(ZERO) is odd


def test_the_dump_of_a_slow_wire_is_waited_for():
    config = find("sim:teachmover").config
    slow = replace(config, connection=replace(config.connection, baud=300))
    with Arm(connect_simulated(slow)) as arm:
        arm.controller.write_program(program(1, 2, 3, 4, 5))
        assert len(arm.controller.read_program().rows) == 5


# -- Files -----------------------------------------------------------------------------------------

CONFIG = find("sim:teachmover").config


def written(program):
    return program.text(CONFIG, "2026-11-22 10:30")


def row_to(number, joints, opening_mm, speed=240):
    steps = CONFIG.model.transmission.to_motors(joints, opening_mm)
    return ProgramRow.move(number, speed, tuple(steps))


@example(PendantProgram((ProgramRow.move(10_000, 240, (0,) * 6),)), None)
@given(PROGRAMS, st.none() | st.tuples(*[st.integers(-32768, 32767)] * 6))
def test_a_written_file_reads_back_the_same(program, origin):
    program = PendantProgram(program.rows, origin)
    assert PendantProgram.parse(written(program)) == program


def test_rows_stand_below_their_motors():
    rows = (ProgramRow.move(1, 240, (100, -200, 300, -400, 500, -600)), ProgramRow(2, 250, ZERO))
    lines = written(PendantProgram(rows)).splitlines()
    assert lines[0] == FORMAT_LINE
    assert lines[-2] == (
        "move    1   240"
        + "".join(f"{n:>12}" for n in (100, -200, 300, -400, 500, -600))
        + "   # 470 steps/s"
    )
    assert lines[-1].startswith("raw     2 ")
    assert lines[-1].endswith("   # not a known move")
    assert len(lines[-3]) == lines[-2].index(" # 470") - 2
    assert "origin 0 0 0 0 0 0" in written(PendantProgram(rows, ZERO)).splitlines()


@every_row(
    "line, words",
    [
        ("move 1 240 1 2 3 4 5", "line 2: `move` needs 8 numbers, not 7"),
        ("move 1 246 1 2 3 4 5 6", "line 2: .*246"),
        ("move 1 240 1 2 3 4 5 40000", "line 2: .*40000"),
        ("move 1 240 1 2 3 4 5 six", "line 2: 'six' is not a whole number"),
        ("jump 1 240 1 2 3 4 5 6", "line 2: a row begins with `move` or `raw`, not 'jump'"),
        ("raw 1 70000 1 2 3 4 5 6", "line 2: 70000"),
        ("origin 1 2 3", "line 2: `origin` needs 6 numbers"),
        ("origin 0 0 0 0 0 0\norigin 1 2 3 4 5 6", "line 3: `origin` needs 8"),
    ],
)
def test_a_line_that_is_none_is_named(line, words):
    with pytest.raises(PendantFileError, match=words):
        PendantProgram.parse(f"{FORMAT_LINE}\n{line}\n")


@every_row("text", ["", "move 1 240 1 2 3 4 5 6", "armdrive pendant program 2"])
def test_a_file_without_its_first_line_is_no_program(text):
    with pytest.raises(PendantFileError, match="the first line must be"):
        PendantProgram.parse(text)


@given(st.text(alphabet="mover awign0123456789- #\n", max_size=80))
def test_whatever_stands_in_a_file_is_a_program_or_a_sentence(text):
    try:
        read = PendantProgram.parse(f"{FORMAT_LINE}\n{text}")
    except PendantFileError:
        return  # the only error that may be raised
    assert PendantProgram.parse(written(read)) == read


def test_a_row_that_is_there_twice_can_be_kept_but_not_used():
    row = "move 1 240 1 2 3 4 5 6\n"
    program = PendantProgram.parse(
        f"{FORMAT_LINE}\norigin 0 0 0 0 0 131072\n{row}{row.replace('6', '7')}"
    )
    assert PendantProgram.parse(written(program)) == program
    with pytest.raises(BadRequest, match="row 1 is there twice"):
        program.require_fitting(64)


def test_more_rows_than_the_memory_holds_are_refused_before_the_first():
    with pytest.raises(BadRequest, match="65 rows are more than"):
        program(*range(65)).require_fitting(64)


def test_a_row_says_its_speed_posture_and_fingers_where_the_origin_is_known():
    row = row_to(1, Joints.of(10.0, 40.0, -80.0, -40.0, 0.0), 30.0)
    words = PendantProgram((row,), ZERO).meaning(CONFIG, row)
    assert re.fullmatch(r"470 steps/s; base 10\.\d°, shoulder .*; fingers \d+\.\d mm", words)
    assert PendantProgram((row,)).meaning(CONFIG, row) == "470 steps/s"
    odd = ProgramRow(1, 240, ZERO, kind=9)
    assert PendantProgram((odd,), ZERO).meaning(CONFIG, odd) == "not a known move"
