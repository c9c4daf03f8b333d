"""TeachMover machines: the host's, the device's, and the two back to back."""

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
from firmware_protocol.teachmover.messages import encode_reply

# -- The device ------------------------------------------------------------------------------------


ROW_1 = teachmover.ProgramRow(1, 240, (100, -200, 300, -400, 500, -600))
SOME_REGISTERS = teachmover.Registers((1, -2, 3, -4, 5, -6), 7, 65)


def device_with(*lines: bytes, **settings) -> teachmover.Device:
    device = teachmover.Device(**settings)
    device.receive_data(b"".join(line + b"\r" for line in lines))
    return device


def test_commands_come_one_at_a_time_and_the_next_waits_for_the_answer():
    device = device_with(b"@CLOSE", b"@RUN")
    assert device.next_event() == teachmover.Close()
    assert device.unanswered == teachmover.Close()
    assert device.next_event() is None
    assert device.send(teachmover.Status.DONE) == b"1\r"
    assert device.unanswered is None
    assert device.next_event() == teachmover.Run()


@pytest.mark.parametrize("status", teachmover.Status)
def test_a_status_answers_a_command(status):
    device = device_with(b"@STEP 240,1,2,3,4,5,6")
    assert device.next_event() == teachmover.Step(240, (1, 2, 3, 4, 5, 6))
    assert device.send(status) == b"%d\r" % status
    with pytest.raises(LocalProtocolError, match="nothing is owed"):
        device.send(status)


def test_a_read_is_answered_with_a_status_and_then_the_registers():
    device = device_with(b"@READ", b"@READ")
    assert device.next_event() == teachmover.Read()
    with pytest.raises(LocalProtocolError, match="a Status is owed, so a Registers"):
        device.send(SOME_REGISTERS)
    assert device.send(teachmover.Status.DONE) == b"1\r"
    assert device.next_event() is None
    with pytest.raises(LocalProtocolError, match="a Registers is owed, so a Status"):
        device.send(teachmover.Status.DONE)
    assert device.send(SOME_REGISTERS) == b"1,-2,3,-4,5,-6,1857\r"
    assert device.next_event() == teachmover.Read()


@every_row("status", [teachmover.Status.FAILED, teachmover.Status.STOPPED])
@every_row("line", [b"@READ", b"@QDUMP"])
def test_nothing_follows_a_status_other_than_done(line, status):
    device = device_with(line)
    device.next_event()
    device.send(status)
    for reply in (SOME_REGISTERS, ROW_1):
        with pytest.raises(LocalProtocolError):
            device.send(reply)


def test_a_dump_is_answered_with_a_status_and_rows_until_the_next_command():
    device = device_with(b"@QDUMP", b"@RUN")
    assert device.next_event() == teachmover.QDump()
    assert device.send(teachmover.Status.DONE) == b"1\r"
    for _ in range(3):
        assert device.send(ROW_1) == b"1,3841,14436,28716,43252,65280,65025,64769\r"
    assert device.next_event() == teachmover.Run()
    with pytest.raises(LocalProtocolError):
        device.send(ROW_1)


def test_the_attention_character_changes_with_the_answer_and_for_what_waits_behind():
    device = device_with(b"@ARM #", b"@READ", b"#RUN")
    assert device.next_event() == teachmover.Arm("#")
    assert device.attention == "@"
    device.send(teachmover.Status.DONE)
    assert device.attention == "#"
    assert device.next_event() == teachmover.Ignored(b"@READ")
    assert device.next_event() == teachmover.Run()


@pytest.mark.parametrize("status", [teachmover.Status.FAILED, teachmover.Status.STOPPED])
def test_the_attention_character_stays_when_the_answer_is_not_done(status):
    device = device_with(b"@ARM #", b"@RUN")
    device.next_event()
    device.send(status)
    assert device.attention == "@"
    assert device.next_event() == teachmover.Run()


def test_a_malformed_line_says_why_and_is_answered():
    device = device_with(b"@STEP 240,1", b"@RUN")
    event = device.next_event()
    assert event == teachmover.Unreadable(
        b"@STEP 240,1", "numbers after the name: 2 where 7 or 8 belong"
    )
    assert device.unanswered == event
    assert device.send(teachmover.Status.FAILED) == b"0\r"
    assert device.next_event() == teachmover.Run()


def test_a_line_without_the_attention_character_gets_no_answer():
    device = device_with(b"READ", b"x@READ", b"#READ", b"@RUN")
    assert [device.next_event() for _ in range(4)] == [
        *(teachmover.Ignored(b"READ"), teachmover.Ignored(b"x@READ"), teachmover.Ignored(b"#READ")),
        teachmover.Run(),
    ]


def test_padding_before_the_attention_character_means_nothing():
    device = device_with(b"\0\0\n @RUN", b"\n", b"\0", b"")
    assert device.next_event() == teachmover.Run()
    device.send(teachmover.Status.DONE)
    assert device.next_event() is None


@pytest.mark.parametrize(
    ("start", "kind"), [(b"@STEP ", teachmover.Unreadable), (b"noise", teachmover.Ignored)]
)
def test_an_endless_line_is_told_once_and_takes_no_memory(start, kind):
    device = teachmover.Device()
    device.receive_data(start)
    for _ in range(500):
        device.receive_data(b"1," * 50)
    event = device.next_event()
    assert isinstance(event, kind)
    assert event.data.startswith(start)
    device.forget()
    device.receive_data(b"\r@RUN\r")
    assert device.next_event() == teachmover.Run()


def test_the_beginning_of_an_over_long_line_is_no_command():
    device = device_with(b"@RUN" + b" " * 300)
    assert isinstance(device.next_event(), teachmover.Unreadable)


def test_after_a_loss_of_power_nothing_is_owed():
    device = device_with(b"@READ", b"@RUN")
    device.next_event()
    device.send(teachmover.Status.DONE)
    assert device.forget() == teachmover.Read()
    assert device.forget() is None
    device.discard()
    assert device.next_event() is None


# -- The host --------------------------------------------------------------------------------------

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


# -- Back to back ----------------------------------------------------------------------------------

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


@given(st.lists(exchanges(), max_size=5), st.data())
def test_every_script_arrives_whole_at_both_ends(script, data):
    host, device = teachmover.Host(), teachmover.Device()
    for command, replies in script:
        assert carried(data.draw, host.send(command), device) == [command]
        answer = b"".join(device.send(reply) for reply in replies)
        found = carried(data.draw, answer, host)
        if isinstance(command, teachmover.QDump) and replies[0] is teachmover.Status.DONE:
            assert found == []
            host.end_dump()
            found = events(host)
        assert found == [expected(command, replies)]
        assert (host.outstanding, device.unanswered) == (None, None)


@given(NOISE_BYTES, exchanges(), st.data())
def test_after_noise_both_ends_agree_again_at_the_next_carriage_return(noise, exchange, data):
    host, device = teachmover.Host(), teachmover.Device()
    for event in carried(data.draw, noise + b"\r", device):
        if isinstance(event, teachmover.Unreadable):
            device.send(teachmover.Status.FAILED)
        elif device.unanswered is not None or event == teachmover.QDump():
            device.forget()  # the noise happened to be a command
    carried(data.draw, noise + b"\r", host)
    command, replies = exchange
    assert carried(data.draw, host.send(command), device) == [command]
    found = carried(data.draw, b"".join(device.send(reply) for reply in replies), host)
    if isinstance(command, teachmover.QDump) and replies[0] is teachmover.Status.DONE:
        host.end_dump()
        found = events(host)
    assert found == [expected(command, replies)]


@given(exchanges(), st.binary(min_size=1, max_size=40), st.data())
def test_garbage_lines_before_an_answer_do_not_change_it(exchange, garbage, data):
    command, replies = exchange
    host, device = teachmover.Host(), teachmover.Device()
    device.receive_data(host.send(command))
    assert device.next_event() == command
    answer = b"".join(device.send(reply) for reply in replies)
    told = b"?" + garbage.replace(b"\r", b"?") + b"\r"
    found = carried(data.draw, told + answer, host)
    if isinstance(command, teachmover.QDump) and replies[0] is teachmover.Status.DONE:
        host.end_dump()
        found += events(host)
    assert [type(event) for event in found] == [teachmover.Unreadable, teachmover.Completed]
    assert found[1] == expected(command, replies)


def test_the_longest_line_of_the_dialect_passes():
    longest = teachmover.QWrite(teachmover.ProgramRow(65535, 0, (-1,) * 6, 255))
    host, device = teachmover.Host(), teachmover.Device()
    line = host.send(longest)
    assert line == b"@QWRITE" + b" 65535" + b",65535" * 7 + b"\r"
    device.receive_data(line)
    assert device.next_event() == longest
