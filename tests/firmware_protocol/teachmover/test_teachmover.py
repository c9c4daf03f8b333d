"""The TeachMover's codec: messages, their lines, and the host's machine."""

import pytest
from amounts import every_row
from cases_teachmover import COMMANDS, REGISTERS, ROWS, STATUSES
from chunks import carried, events
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import teachmover
from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError
from firmware_protocol.teachmover import (
    Close,
    Completed,
    Host,
    Key,
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
from firmware_protocol.teachmover.messages import (
    decode_command,
    decode_reply,
    encode_command,
    encode_reply,
)

# -- Messages --------------------------------------------------------------------------------------

ZERO = (0,) * 6

REFUSED = [
    (lambda: Step(246, ZERO), "speed", 246, "0 to 245"),
    (lambda: Step(0, (0,) * 5), "steps", (0,) * 5, "6 counts"),
    (lambda: Step(0, (0, 0, 32768, 0, 0, 0)), "steps[2]", 32768, "-32768 to 32767"),
    (lambda: Step(0, ZERO, 256), "output", 256, "0 to 255"),
    (lambda: Close(246), "speed", 246, "0 to 245"),
    (lambda: Set(-1), "speed", -1, "0 to 245"),
    (lambda: QWrite((1, 2, 3)), "row", (1, 2, 3), "ProgramRow"),
    (lambda: Registers((0,) * 7), "positions", (0,) * 7, "6 counts"),
    (lambda: Registers(ZERO, 256), "key", 256, "0 to 255"),
    (lambda: Registers(ZERO, Key.NONE, 256), "inputs", 256, "0 to 255"),
    (lambda: ProgramRow(-1, 0, ZERO), "number", -1, "0 to 65535"),
    (lambda: ProgramRow(1, 256, ZERO), "speed", 256, "0 to 255"),
    (lambda: ProgramRow(1, 0, ZERO, 256), "kind", 256, "0 to 255"),
    (lambda: ProgramRow.move(1, 246, ZERO), "speed", 246, "0 to 245"),
    (lambda: ProgramRow(1, 0, (0, 0, 0, 40000, 0, 0)), "positions[3]", 40000, "to 32767"),
]


@every_row("build, field, value, allowed", REFUSED)
def test_what_does_not_fit_is_refused_by_name_value_and_range(build, field, value, allowed):
    with pytest.raises(BadField) as caught:
        build()
    assert (caught.value.field, caught.value.value) == (field, value)
    assert allowed in caught.value.allowed


def test_registers_hold_the_last_key_and_the_inputs_in_one_number():
    registers = Registers.from_numbers((1, -2, 3, -4, 5, -6, 7 * 256 + 65))
    assert registers == Registers((1, -2, 3, -4, 5, -6), Key.STOP, 65)
    assert registers.numbers == (1, -2, 3, -4, 5, -6, 1857)
    for key in range(256):  # one without a name stays a number
        registers = Registers.from_numbers((*ZERO, key * 256))
        assert (registers.key, isinstance(registers.key, Key)) == (key, key <= 14)


# -- rows of a program ----------------------------------------------------------------------------

WORD = st.integers(0, 65535)
GOLDEN = (1, 3841, 14436, 28716, 43252, 65280, 65025, 64769)
ROW_1 = ProgramRow(1, 240, (100, -200, 300, -400, 500, -600))


def test_the_golden_row():
    assert ProgramRow.move(1, 240, ROW_1.positions).words == GOLDEN
    assert ProgramRow.from_words(GOLDEN) == ROW_1
    other = ProgramRow.from_words((3, 15 * 256 + 4, 0, 0, 0, 0, 0, 0))
    assert (other.kind, other.speed) == (4, 240)


@given(st.tuples(*[WORD] * 8))
def test_whatever_a_memory_holds_is_written_back_word_for_word(words):
    row = ProgramRow.from_words(words)
    assert row.words == words
    signed = [word - 65536 if word > 32767 else word for word in words]
    assert ProgramRow.from_words(signed) == row


# -- Lines -----------------------------------------------------------------------------------------

MOVE = Step(240, (1, -2, 3, -4, 5, -6))

COMMAND_BYTES = [
    (MOVE, b"@STEP 240,1,-2,3,-4,5,-6\r"),
    (Step(0, (0, 0, 0, 0, 0, -32768), 31), b"@STEP 0,0,0,0,0,0,-32768,31\r"),
    (Step(9, ZERO, 0), b"@STEP 9,0,0,0,0,0,0,0\r"),
    (Read(), b"@READ\r"),
    (Close(), b"@CLOSE\r"),
    (Close(235), b"@CLOSE 235\r"),
    (Reset(), b"@RESET\r"),
    (Set(), b"@SET\r"),
    (Set(0), b"@SET 0\r"),
    (Run(), b"@RUN\r"),
    (QDump(), b"@QDUMP\r"),
    (QWrite(ROW_1), b"@QWRITE 1,3841,14436,28716,43252,65280,65025,64769\r"),
    (
        QWrite(ProgramRow(65535, 0, (-1,) * 6, 255)),
        b"@QWRITE" + b" 65535" + b",65535" * 7 + b"\r",
    ),
]

REPLY_BYTES = [
    (Status.FAILED, b"0\r"),
    (Status.DONE, b"1\r"),
    (Status.STOPPED, b"2\r"),
    (Registers(ZERO), b"0,0,0,0,0,0,0\r"),
    (Registers((1, -2, 3, -4, 5, -6), Key.STOP, 65), b"1,-2,3,-4,5,-6,1857\r"),
    (ROW_1, b"1,3841,14436,28716,43252,65280,65025,64769\r"),
]

TOLERATED_COMMANDS = [
    (b"STEP 240, 1, -2, 3, -4, 5, -6", MOVE),
    (b"STEP 240 , 1 ,-2,  3,-4,5,-6,", MOVE),
    (b"STEP240,1,-2,3,-4,5,-6", MOVE),
    (b"STE 240,001,-2,3,-4,5,-6 \n", MOVE),
    (b"READ, ", Read()),
    (b"READ ", Read()),
    (b"RESET, 0", Reset()),
    (b"CLOSE, 0", Close()),
    (b"CLO 235", Close(235)),
    (b"SET235,", Set(235)),
    (b"QDUM", QDump()),
]

MALFORMED_COMMANDS = [
    *(b"", b" READ", b"read", b"RE", b"READY", b"READ 1", b"READ,,1", b"HOME", b"STEP"),
    *(b"STEP 240,1,2,3,4,5", b"STEP 240,1,2,3,4,5,6,7,8", b"STEP 240,1,,3,4,5,6"),
    *(b"STEP 240,1 2,3,4,5,6", b"STEP 240,1.0,2,3,4,5,6", b"STEP 240,+1,2,3,4,5,6"),
    *(b"STEP 240,1,2,3,4,5,6,,", b"STEP 246,1,2,3,4,5,6", b"STEP 240,40000,2,3,4,5,6"),
    *(b"STEP 240,000001,2,3,4,5,6", b"STEP 240,1,2,3,4,5,6,256", b"STEP 240,\xd9\xa1,2,3,4,5,6"),
    *(b"CLOSE 300", b"CLOSE 1,1", b"QWRITE 1,2,3,4,5,6,7", b"QWRITE 1,2,3,4,5,6,7,65536"),
]

TOLERATED_REPLIES = [
    (b"\n1", Status.DONE),
    (b"\0\0 1 ", Status.DONE),
    (b"2,", Status.STOPPED),
    (b"\n 1, -2 ,3,-4,5,-6,  1857,", Registers((1, -2, 3, -4, 5, -6), Key.STOP, 65)),
    (b"1 3841 14436 28716 43252 65280 65025 64769", ROW_1),
    (b"1, 3841, 14436, 28716, 43252, 65280, 65025, 64769,", ROW_1),
    (b"1,3841,14436,28716,-22284,-256,-511,-767", ROW_1),
]

GARBLED_REPLIES = [
    *(b"", b",", b"3", b"-1", b"01", b"11", b"x", b"1 1", b"1,2", b"@READ"),
    b"\x001,2,3,4,5,6,7",  # the NUL could have been a minus sign
    b"\xad1,2,3,4,5,6,7",  # a minus sign with its top bit set
    *(b"1,2,3,4,5,6,-7", b"1,2,3,4,5,,7", b"1 2 3 4 5 6 7", b"1 2,3,4,5,6,7,8"),
    *(b"000001,2,3,4,5,6,7", b"32768,2,3,4,5,6,7", b"1,2,3,4,5,6,65536", b"1,2,3,4,5,6,7,8,9"),
    *(b"1,2,3,4,5,6,7,99999", b"1,2,3,4,5,6,7,,", b"-32769,3841,14436,28716,0,0,0,0"),
]


@every_row("command, line", COMMAND_BYTES)
def test_the_bytes_of_every_command_both_ways(command, line):
    assert encode_command(command) == line
    assert decode_command(line[1:-1]) == command


@every_row("reply, line", REPLY_BYTES)
def test_the_bytes_of_every_reply_both_ways(reply, line):
    assert encode_reply(reply) == line
    decoded = decode_reply(line[:-1])
    assert (decoded, type(decoded)) == (reply, type(reply))


@every_row("body, command", TOLERATED_COMMANDS)
def test_what_public_programs_send_is_understood(body, command):
    assert decode_command(body) == command


@every_row("line, reply", TOLERATED_REPLIES)
def test_padding_that_cannot_change_a_meaning_is_read_over(line, reply):
    assert decode_reply(line) == reply


@every_row(
    "decode, body",
    [
        *((decode_command, body) for body in MALFORMED_COMMANDS),
        *((decode_reply, body) for body in GARBLED_REPLIES),
    ],
)
def test_a_doubtful_line_is_the_other_sides_fault(decode, body):
    with pytest.raises(RemoteProtocolError):
        decode(body)


def test_a_field_out_of_range_is_named_with_its_command():
    with pytest.raises(RemoteProtocolError, match=r"STEP: speed must be .* 0 to 245, not 250"):
        decode_command(b"STEP 250,0,0,0,0,0,0")


# -- The host --------------------------------------------------------------------------------------

SOME_REGISTERS = Registers((1, -2, 3, -4, 5, -6), 7, 65)
REGISTER_LINE = encode_reply(SOME_REGISTERS)
ROW_LINE = encode_reply(ROW_1)


def asked(command) -> Host:
    host = Host()
    host.send(command)
    return host


@pytest.mark.parametrize("status", [Status.FAILED, Status.STOPPED])
def test_a_register_line_after_a_read_that_is_not_done_is_stray(status):
    found = events(asked(Read()), encode_reply(status) + REGISTER_LINE)
    assert found == [Completed(Read(), status), Stray(SOME_REGISTERS)]


def test_a_register_line_without_a_status_is_no_answer():
    host = asked(Read())
    (event,) = events(host, REGISTER_LINE)
    assert event == Unreadable(REGISTER_LINE[:-1], "a status line was awaited after READ")
    assert host.outstanding == Read()


def test_nothing_is_sent_while_a_command_is_unanswered():
    host = asked(MOVE)
    with pytest.raises(LocalProtocolError, match=r"STEP is unanswered: .* before sending READ"):
        host.send(Read())
    host.give_up()
    assert events(host, b"1\r") == [Stray(Status.DONE)]
    assert host.send(Read()) == b"@READ\r"


@pytest.mark.parametrize("host", [Host(), asked(QDump()), asked(Read())])
def test_only_a_dump_can_be_ended(host):
    with pytest.raises(LocalProtocolError, match="no dump"):
        host.end_dump()


def test_a_dump_that_breaks_off_in_a_row_says_so():
    host = asked(QDump())
    assert events(host, b"1\r" + ROW_LINE + b"2,3841,1") == []
    assert host.dumping
    cut_off, completed = host.end_dump()
    assert cut_off == Unreadable(b"2,3841,1", "the dump ended in the middle of a line")
    assert completed == Completed(QDump(), Status.DONE, rows=(ROW_1,))
    assert not host.dumping


def test_unreadable_rows_are_told_and_the_dump_goes_on():
    host = asked(QDump())
    garbled = events(host, b"1\r" + ROW_LINE + b"2,38!\r" + REGISTER_LINE + b"0\r" + ROW_LINE)
    assert [type(event) for event in garbled] == [Unreadable] * 3
    assert host.end_dump() == [Completed(QDump(), Status.DONE, rows=(ROW_1, ROW_1))]


@st.composite
def exchanges(draw: st.DrawFn) -> tuple[teachmover.Command, list[teachmover.Reply]]:
    """Draw a command and the replies of its whole answer."""
    command, status = draw(COMMANDS), draw(STATUSES)
    if status is Status.DONE and isinstance(command, Read):
        return command, [status, draw(REGISTERS)]
    if status is Status.DONE and isinstance(command, QDump):
        return command, [status, *draw(st.lists(ROWS, max_size=4))]
    return command, [status]


@given(st.lists(exchanges(), max_size=5), st.data())
def test_every_script_arrives_whole(script, data):
    host = Host()
    for command, (status, *rest) in script:
        assert decode_command(host.send(command)[1:-1]) == command
        answer = b"".join(map(encode_reply, (status, *rest)))
        found = carried(data.draw, answer, host)
        if host.dumping:
            found += host.end_dump()
        if isinstance(command, Read) and rest:
            assert found == [Completed(command, status, registers=rest[0])]
        else:
            assert found == [Completed(command, status, rows=tuple(rest))]
        assert host.outstanding is None
