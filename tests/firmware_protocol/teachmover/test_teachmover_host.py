"""The host's machine: what each line of the arm means to it in each of its states."""

import pytest
from chunks import events

from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.teachmover import (
    MAX_ROWS,
    Arm,
    Close,
    Completed,
    Delay,
    Host,
    ProgramRow,
    QDump,
    QWrite,
    Read,
    Registers,
    Reset,
    Run,
    Set,
    Status,
    Step,
    Stray,
    Unreadable,
)
from firmware_protocol.teachmover.messages import encode_reply

STEP = Step(240, (1, 2, 3, 4, 5, 6))
REGISTERS = Registers((1, -2, 3, -4, 5, -6), 7, 65)
ROW = ProgramRow(1, 240, (100, -200, 300, -400, 500, -600))
REGISTER_LINE = encode_reply(REGISTERS)
ROW_LINE = encode_reply(ROW)
EVERY_COMMAND = [
    *(STEP, Read(), Close(), Reset(), Set(), Run(), QDump(), QWrite(ROW), Arm("#"), Delay(1))
]


def asked(command) -> Host:
    host = Host()
    host.send(command)
    return host


@pytest.mark.parametrize("status", [Status.FAILED, Status.STOPPED])
@pytest.mark.parametrize("command", EVERY_COMMAND)
def test_failure_and_the_stop_key_complete_any_command(command, status):
    host = asked(command)
    assert events(host, encode_reply(status)) == [Completed(command, status)]
    assert host.outstanding is None
    assert host.attention == "@"


@pytest.mark.parametrize("command", [c for c in EVERY_COMMAND if not isinstance(c, Read | QDump)])
def test_done_completes_a_command_that_has_nothing_more_to_say(command):
    host = asked(command)
    assert host.outstanding == command
    assert events(host, b"1\r") == [Completed(command, Status.DONE)]
    assert host.outstanding is None


def test_a_read_is_complete_with_its_register_line():
    host = asked(Read())
    assert events(host, b"1\r") == []
    assert host.outstanding == Read()
    assert events(host, REGISTER_LINE) == [Completed(Read(), Status.DONE, REGISTERS)]


@pytest.mark.parametrize("status", [Status.FAILED, Status.STOPPED])
def test_a_register_line_after_a_read_that_is_not_done_is_stray(status):
    found = events(asked(Read()), encode_reply(status) + REGISTER_LINE)
    assert found == [Completed(Read(), status), Stray(REGISTERS)]


def test_a_register_line_without_a_status_is_no_answer():
    host = asked(Read())
    (event,) = events(host, REGISTER_LINE)
    assert event == Unreadable(REGISTER_LINE[:-1], "a status line was awaited after READ")
    assert host.outstanding == Read()


def test_two_status_lines_after_a_read_give_a_late_answer_away():
    host = asked(Read())
    mixed_up, completed = events(host, b"1\r1\r" + REGISTER_LINE)
    assert mixed_up == Unreadable(b"1", "a register line was awaited after READ")
    assert completed == Completed(Read(), Status.DONE, REGISTERS)


def test_nothing_is_sent_while_a_command_is_unanswered():
    host = asked(STEP)
    with pytest.raises(LocalProtocolError, match=r"STEP is unanswered: .* before sending READ"):
        host.send(Read())
    assert events(host, b"1\r") == [Completed(STEP, Status.DONE)]
    assert host.send(Read()) == b"@READ\r"


def test_a_dump_ends_when_its_owner_says_so():
    host = asked(QDump())
    assert not host.dumping
    assert events(host, b"1\r" + ROW_LINE) == []
    assert host.dumping
    host.receive_data(ROW_LINE)
    host.end_dump()
    assert events(host) == [Completed(QDump(), Status.DONE, rows=(ROW, ROW))]
    assert not host.dumping
    assert host.outstanding is None
    assert events(host) == []


def test_a_dump_can_be_empty():
    host = asked(QDump())
    assert events(host, b"1\r") == []
    host.end_dump()
    assert events(host) == [Completed(QDump(), Status.DONE)]


@pytest.mark.parametrize("host", [Host(), asked(QDump()), asked(Read())])
def test_only_a_dump_can_be_ended(host):
    with pytest.raises(LocalProtocolError, match="no dump"):
        host.end_dump()


def test_a_dump_that_breaks_off_in_a_row_says_so():
    host = asked(QDump())
    assert events(host, b"1\r" + ROW_LINE + b"2,3841,1") == []
    host.end_dump()
    cut_off, completed = events(host)
    assert cut_off == Unreadable(b"2,3841,1", "the dump ended in the middle of a line")
    assert completed == Completed(QDump(), Status.DONE, rows=(ROW,))


def test_unreadable_rows_are_told_and_the_dump_goes_on():
    host = asked(QDump())
    garbled = events(host, b"1\r" + ROW_LINE + b"2,38!\r" + REGISTER_LINE + b"0\r" + ROW_LINE)
    assert [type(event) for event in garbled] == [Unreadable] * 3
    host.end_dump()
    assert events(host) == [Completed(QDump(), Status.DONE, rows=(ROW, ROW))]


def test_rows_beyond_any_memory_are_not_kept():
    host = asked(QDump())
    (event,) = events(host, b"1\r" + ROW_LINE * (MAX_ROWS + 1))
    assert isinstance(event, Unreadable)
    host.end_dump()
    (completed,) = events(host)
    assert len(completed.rows) == MAX_ROWS


def test_a_dump_given_up_leaves_no_rows_for_the_next():
    host = asked(QDump())
    assert events(host, b"1\r" + ROW_LINE) == []
    host.end_dump()
    assert host.give_up() == QDump()
    assert events(host) == []
    host.send(QDump())
    assert events(host, b"1\r") == []
    host.end_dump()
    assert events(host) == [Completed(QDump(), Status.DONE, rows=())]


def test_the_attention_character_changes_when_the_arm_has_agreed():
    host = asked(Arm("#"))
    assert host.attention == "@"
    assert events(host, b"1\r") == [Completed(Arm("#"), Status.DONE)]
    assert host.attention == "#"
    assert host.send(Read()) == b"#READ\r"


def test_lines_that_nobody_asked_for_are_stray_when_readable():
    host = Host()
    found = events(host, b"1\r" + REGISTER_LINE + ROW_LINE + b"hello\r")
    assert found[:3] == [Stray(Status.DONE), Stray(REGISTERS), Stray(ROW)]
    assert isinstance(found[3], Unreadable)


def test_a_late_answer_to_a_given_up_command_is_stray():
    host = asked(STEP)
    assert host.give_up() == STEP
    assert host.give_up() is None
    assert events(host, b"1\r") == [Stray(Status.DONE)]


def test_padding_before_a_command_does_not_spoil_its_answer():
    host = Host()
    assert events(host, b"\0\n ") == []
    host.send(STEP)
    assert events(host, b"1\r\n") == [Completed(STEP, Status.DONE)]
    host.send(Read())
    found = events(host, b"1\r\n" + REGISTER_LINE + b"\n")
    assert found == [Completed(Read(), Status.DONE, REGISTERS)]


def test_garbage_is_told_and_reading_goes_on_at_the_next_carriage_return():
    host = asked(STEP)
    garbled, completed = events(host, b"\xff\x80garbage\r1\r")
    assert isinstance(garbled, Unreadable)
    assert garbled.data == b"\xff\x80garbage"
    assert completed == Completed(STEP, Status.DONE)
