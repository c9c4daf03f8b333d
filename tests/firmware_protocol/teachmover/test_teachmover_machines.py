"""The machine of a TeachMover's host."""

import pytest
from amounts import every_row
from cases_teachmover import COMMANDS, REGISTERS, ROWS, STATUSES
from chunks import carried, events
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import teachmover
from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.teachmover import (
    MAX_ROWS,
    Arm,
    Close,
    Completed,
    Delay,
    Host,
    QDump,
    QWrite,
    Read,
    Reset,
    Run,
    Set,
    Status,
    Step,
    Stray,
    Unreadable,
)
from firmware_protocol.teachmover.messages import decode_command, encode_reply

ROW_1 = teachmover.ProgramRow(1, 240, (100, -200, 300, -400, 500, -600))
SOME_REGISTERS = teachmover.Registers((1, -2, 3, -4, 5, -6), 7, 65)


STEP = Step(240, (1, 2, 3, 4, 5, 6))


REGISTER_LINE = encode_reply(SOME_REGISTERS)
ROW_LINE = encode_reply(ROW_1)
EVERY_COMMAND = [
    *(STEP, Read(), Close(), Reset(), Set(), Run(), QDump(), QWrite(ROW_1), Arm("#"), Delay(1))
]


def asked(command) -> Host:
    host = Host()
    host.send(command)
    return host


@every_row("status", [Status.FAILED, Status.STOPPED])
@every_row("command", EVERY_COMMAND)
def test_failure_and_the_stop_key_complete_any_command(command, status):
    host = asked(command)
    assert events(host, encode_reply(status)) == [Completed(command, status)]
    assert host.outstanding is None


@every_row("command", [c for c in EVERY_COMMAND if not isinstance(c, Read | QDump)])
def test_done_completes_a_command_that_has_nothing_more_to_say(command):
    host = asked(command)
    assert host.outstanding == command
    assert events(host, b"1\r") == [Completed(command, Status.DONE)]
    assert host.outstanding is None


def test_a_read_is_complete_with_its_register_line():
    host = asked(Read())
    assert events(host, b"1\r") == []
    assert host.outstanding == Read()
    assert events(host, REGISTER_LINE) == [Completed(Read(), Status.DONE, SOME_REGISTERS)]


@pytest.mark.parametrize("status", [Status.FAILED, Status.STOPPED])
def test_a_register_line_after_a_read_that_is_not_done_is_stray(status):
    found = events(asked(Read()), encode_reply(status) + REGISTER_LINE)
    assert found == [Completed(Read(), status), Stray(SOME_REGISTERS)]


def test_a_register_line_without_a_status_is_no_answer():
    host = asked(Read())
    (event,) = events(host, REGISTER_LINE)
    assert event == Unreadable(REGISTER_LINE[:-1], "a status line was awaited after READ")
    assert host.outstanding == Read()


def test_two_status_lines_after_a_read_give_a_late_answer_away():
    host = asked(Read())
    mixed_up, completed = events(host, b"1\r1\r" + REGISTER_LINE)
    assert mixed_up == Unreadable(b"1", "a register line was awaited after READ")
    assert completed == Completed(Read(), Status.DONE, SOME_REGISTERS)


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
    assert events(host) == [Completed(QDump(), Status.DONE, rows=(ROW_1, ROW_1))]
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
    assert completed == Completed(QDump(), Status.DONE, rows=(ROW_1,))


def test_unreadable_rows_are_told_and_the_dump_goes_on():
    host = asked(QDump())
    garbled = events(host, b"1\r" + ROW_LINE + b"2,38!\r" + REGISTER_LINE + b"0\r" + ROW_LINE)
    assert [type(event) for event in garbled] == [Unreadable] * 3
    host.end_dump()
    assert events(host) == [Completed(QDump(), Status.DONE, rows=(ROW_1, ROW_1))]


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


def test_lines_that_nobody_asked_for_are_stray_when_readable():
    host = Host()
    found = events(host, b"1\r" + REGISTER_LINE + ROW_LINE + b"hello\r")
    assert found[:3] == [Stray(Status.DONE), Stray(SOME_REGISTERS), Stray(ROW_1)]
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
    assert found == [Completed(Read(), Status.DONE, SOME_REGISTERS)]


def test_garbage_is_told_and_reading_goes_on_at_the_next_carriage_return():
    host = asked(STEP)
    garbled, completed = events(host, b"\xff\x80garbage\r1\r")
    assert isinstance(garbled, Unreadable)
    assert garbled.data == b"\xff\x80garbage"
    assert completed == Completed(STEP, Status.DONE)


# -- Any exchange, in any chunks -------------------------------------------------------------------

NOISE_BYTES = st.binary(min_size=1, max_size=400).filter(lambda b: b"\r" not in b)
DUMPS = st.lists(ROWS, max_size=4)


@st.composite
def exchanges(draw: st.DrawFn) -> tuple[teachmover.Command, list[teachmover.Reply]]:
    """Draw a command of a host, which never sends `Arm`, and the replies of its whole answer."""
    command = draw(COMMANDS.filter(lambda each: not isinstance(each, Arm)))
    status = draw(STATUSES)
    if status is teachmover.Status.DONE and isinstance(command, teachmover.Read):
        return command, [status, draw(REGISTERS)]
    if status is teachmover.Status.DONE and isinstance(command, teachmover.QDump):
        return command, [status, *draw(DUMPS)]
    return command, [status]


def expected(command: teachmover.Command, replies: list[teachmover.Reply]) -> teachmover.Completed:
    status, *rest = replies
    if isinstance(command, teachmover.Read) and rest:
        return teachmover.Completed(command, status, registers=rest[0])
    return teachmover.Completed(command, status, rows=tuple(rest))


def whole_answer(draw, host: Host, answer: bytes) -> list:
    """Carry an answer to a host, and return its events; a dump is ended."""
    found = carried(draw, answer, host)
    if host.dumping:
        host.end_dump()
        found += events(host)
    return found


@given(st.lists(exchanges(), max_size=5), st.data())
def test_every_script_arrives_whole(script, data):
    host = Host()
    for command, replies in script:
        assert decode_command(host.send(command)[1:-1]) == command
        answer = b"".join(map(encode_reply, replies))
        assert whole_answer(data.draw, host, answer) == [expected(command, replies)]
        assert host.outstanding is None


@given(NOISE_BYTES, exchanges(), st.data())
def test_after_noise_a_host_understands_again_at_the_next_carriage_return(noise, exchange, data):
    host, (command, replies) = Host(), exchange
    carried(data.draw, noise + b"\r", host)
    host.send(command)
    answer = b"".join(map(encode_reply, replies))
    assert whole_answer(data.draw, host, answer) == [expected(command, replies)]


@given(exchanges(), st.binary(min_size=1, max_size=40), st.data())
def test_garbage_lines_before_an_answer_do_not_change_it(exchange, garbage, data):
    command, replies = exchange
    host = asked(command)
    told = b"?" + garbage.replace(b"\r", b"?") + b"\r"
    answer = b"".join(map(encode_reply, replies))
    found = whole_answer(data.draw, host, told + answer)
    assert [type(event) for event in found] == [Unreadable, Completed]
    assert found[1] == expected(command, replies)


def test_the_longest_line_of_the_dialect_passes():
    longest = QWrite(teachmover.ProgramRow(65535, 0, (-1,) * 6, 255))
    line = Host().send(longest)
    assert line == b"@QWRITE" + b" 65535" + b",65535" * 7 + b"\r"
    assert decode_command(line[1:-1]) == longest
