"""TeachMover messages and their lines."""

import contextlib
from typing import get_args

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import teachmover
from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError
from firmware_protocol.teachmover import (
    Arm,
    Close,
    Delay,
    Key,
    ProgramRow,
    QWrite,
    Registers,
    Set,
    Step,
)
from firmware_protocol.teachmover.messages import (
    decode_command,
    decode_reply,
    encode_command,
    encode_reply,
)

ZERO = (0,) * 6

REFUSED = [
    (lambda: Step(246, ZERO), "speed", 246, "0 to 245"),
    (lambda: Step(-1, ZERO), "speed", -1, "0 to 245"),
    (lambda: Step(True, ZERO), "speed", True, "0 to 245"),
    (lambda: Step(2.0, ZERO), "speed", 2.0, "whole number"),
    (lambda: Step("9", ZERO), "speed", "9", "whole number"),
    (lambda: Step(0, (0,) * 5), "steps", (0,) * 5, "6 counts"),
    (lambda: Step(0, None), "steps", None, "6 counts"),
    (lambda: Step(0, "123456"), "steps", "123456", "6 counts"),
    (lambda: Step(0, (0, 0, 32768, 0, 0, 0)), "steps[2]", 32768, "-32768 to 32767"),
    (lambda: Step(0, (0, 0, 0, 0, 0, -32769)), "steps[5]", -32769, "-32768 to 32767"),
    (lambda: Step(0, (0.5, 0, 0, 0, 0, 0)), "steps[0]", 0.5, "whole number"),
    (lambda: Step(0, ZERO, 256), "output", 256, "0 to 255"),
    (lambda: Step(0, ZERO, -1), "output", -1, "0 to 255"),
    (lambda: Close(246), "speed", 246, "0 to 245"),
    (lambda: Set(-1), "speed", -1, "0 to 245"),
    (lambda: Delay(-1), "count", -1, "0 to 65535"),
    (lambda: QWrite((1, 2, 3)), "row", (1, 2, 3), "ProgramRow"),
    (lambda: Registers((0,) * 7), "positions", (0,) * 7, "6 counts"),
    (lambda: Registers(ZERO, 256), "key", 256, "0 to 255"),
    (lambda: Registers(ZERO, Key.NONE, 256), "inputs", 256, "0 to 255"),
    (lambda: ProgramRow(-1, 0, ZERO), "number", -1, "0 to 65535"),
    (lambda: ProgramRow(1, 256, ZERO), "speed", 256, "0 to 255"),
    (lambda: ProgramRow(1, 0, ZERO, 256), "kind", 256, "0 to 255"),
    (lambda: ProgramRow.move(1, 246, ZERO), "speed", 246, "0 to 245"),
    (lambda: ProgramRow(1, 0, (0, 0, 0, 40000, 0, 0)), "positions[3]", 40000, "to 32767"),
    *(
        (lambda bad=bad: Arm(bad), "attention", bad, "no letter, digit, comma or minus")
        for bad in ("", "a", "Z", "7", ",", "-", " ", "\r", "\x7f", "é", "@@", None, 64)
    ),
]


@every_row("build, field, value, allowed", REFUSED)
def test_what_does_not_fit_is_refused_by_name_value_and_range(build, field, value, allowed):
    with pytest.raises(BadField) as caught:
        build()
    error = caught.value
    assert isinstance(error, LocalProtocolError)
    assert (error.field, error.value) == (field, value)
    assert allowed in error.allowed
    assert str(error) == f"{field} must be {error.allowed}, not {value!r}"


def test_the_extremes_are_admitted():
    assert Step(245, (-32768, 32767, 0, 0, 0, 0), 255).arguments == (
        *(245, -32768, 32767, 0, 0, 0, 0),
        255,
    )
    assert Delay(65535).arguments == (65535,)
    assert [Arm(sign).attention for sign in "@!#~/"] == list("@!#~/")


def test_registers_hold_the_last_key_and_the_inputs_in_one_number():
    registers = Registers.from_numbers((1, -2, 3, -4, 5, -6, 7 * 256 + 65))
    assert registers == Registers((1, -2, 3, -4, 5, -6), Key.STOP, 65)
    assert registers.key is Key.STOP
    assert registers.numbers == (1, -2, 3, -4, 5, -6, 1857)


def test_a_key_without_a_name_stays_a_number():
    for key in range(256):
        registers = Registers.from_numbers((*ZERO, key * 256))
        assert registers.key == key
        assert isinstance(registers.key, Key) == (key <= 14)
        assert Registers.from_numbers(registers.numbers) == registers


@every_row(
    "numbers",
    [ZERO, (*ZERO, 0, 0), (*ZERO, -1), (*ZERO, 65536), (32768, 0, 0, 0, 0, 0, 0)],
)
def test_numbers_that_are_no_registers_are_the_other_sides_fault(numbers):
    with pytest.raises(RemoteProtocolError):
        Registers.from_numbers(numbers)


def test_the_keys_are_the_pendants():
    names = "NONE TRAIN PAUSE GRIP OUT FREE MOVE STOP STEP POINT JUMP CLEAR ZERO SPEED RUN"
    assert [key.name for key in Key] == names.split()
    assert [int(key) for key in Key] == list(range(15))


# -- rows of a program ----------------------------------------------------------------------------

WORD = st.integers(0, 65535)
STEPS = st.integers(-32768, 32767)
GOLDEN = (1, 3841, 14436, 28716, 43252, 65280, 65025, 64769)


def by_the_rule(number: int, speed: int, positions: tuple[int, ...]) -> tuple[int, ...]:
    """Compute the words as the rule is written down, byte by byte."""
    low = [position % 65536 % 256 for position in positions]
    high = [position % 65536 // 256 for position in positions]
    return (
        number,
        (255 - speed) * 256 + 1,
        low[1] * 256 + low[0],
        low[3] * 256 + low[2],
        low[5] * 256 + low[4],
        high[1] * 256 + high[0],
        high[3] * 256 + high[2],
        high[5] * 256 + high[4],
    )


def test_the_golden_row():
    row = ProgramRow.move(1, 240, (100, -200, 300, -400, 500, -600))
    assert row.words == GOLDEN
    assert ProgramRow.from_words(GOLDEN) == row


@given(WORD, st.integers(0, 245), st.tuples(*[STEPS] * 6))
def test_rows_are_packed_by_the_rule_and_unpacked_again(number, speed, positions):
    row = ProgramRow.move(number, speed, positions)
    assert row.words == by_the_rule(number, speed, positions)
    assert ProgramRow.from_words(row.words) == row


@given(st.tuples(*[WORD] * 8))
def test_whatever_a_memory_holds_is_written_back_word_for_word(words):
    assert ProgramRow.from_words(words).words == words


@given(st.tuples(*[WORD] * 8))
def test_words_printed_as_signed_numbers_are_the_same_row(words):
    signed = [word - 65536 if word > 32767 else word for word in words]
    assert ProgramRow.from_words(signed) == ProgramRow.from_words(words)


def test_a_row_of_another_kind_keeps_its_kind():
    row = ProgramRow.from_words((3, 15 * 256 + 4, 0, 0, 0, 0, 0, 0))
    assert (row.kind, row.speed) == (4, 240)


@every_row("words", [(), GOLDEN[:7], (*GOLDEN, 0), (*GOLDEN[:7], 65536), (-32769, *GOLDEN[1:])])
def test_words_that_are_no_row_are_the_other_sides_fault(words):
    with pytest.raises(RemoteProtocolError):
        ProgramRow.from_words(words)


# -- Lines -----------------------------------------------------------------------------------------

GOLDEN_ROW = teachmover.ProgramRow(1, 240, (100, -200, 300, -400, 500, -600))
MOVE = teachmover.Step(240, (1, -2, 3, -4, 5, -6))

COMMAND_BYTES = [
    (MOVE, b"@STEP 240,1,-2,3,-4,5,-6\r"),
    (teachmover.Step(0, (0, 0, 0, 0, 0, -32768), 31), b"@STEP 0,0,0,0,0,0,-32768,31\r"),
    (teachmover.Step(9, (0, 0, 0, 0, 0, 0), 0), b"@STEP 9,0,0,0,0,0,0,0\r"),
    (teachmover.Read(), b"@READ\r"),
    (teachmover.Close(), b"@CLOSE\r"),
    (teachmover.Close(235), b"@CLOSE 235\r"),
    (teachmover.Reset(), b"@RESET\r"),
    (teachmover.Set(), b"@SET\r"),
    (teachmover.Set(0), b"@SET 0\r"),
    (teachmover.Run(), b"@RUN\r"),
    (teachmover.QDump(), b"@QDUMP\r"),
    (teachmover.QWrite(GOLDEN_ROW), b"@QWRITE 1,3841,14436,28716,43252,65280,65025,64769\r"),
    (teachmover.Arm("#"), b"@ARM #\r"),
    (teachmover.Delay(12), b"@DELAY 12\r"),
]

REPLY_BYTES = [
    (teachmover.Status.FAILED, b"0\r"),
    (teachmover.Status.DONE, b"1\r"),
    (teachmover.Status.STOPPED, b"2\r"),
    (teachmover.Registers((0, 0, 0, 0, 0, 0)), b"0,0,0,0,0,0,0\r"),
    (
        teachmover.Registers((1, -2, 3, -4, 5, -6), teachmover.Key.STOP, 65),
        b"1,-2,3,-4,5,-6,1857\r",
    ),
    (GOLDEN_ROW, b"1,3841,14436,28716,43252,65280,65025,64769\r"),
]

TOLERATED_COMMANDS = [
    (b"STEP 240, 1, -2, 3, -4, 5, -6", MOVE),
    (b"STEP 240 , 1 ,-2,  3,-4,5,-6,", MOVE),
    (b"STEP240,1,-2,3,-4,5,-6", MOVE),
    (b"STE 240,1,-2,3,-4,5,-6", MOVE),
    (b"STEP 240,001,-2,3,-4,5,-6 \n", MOVE),
    (b"STEP 9,-0,0,0,0,0,0", teachmover.Step(9, (0, 0, 0, 0, 0, 0))),
    (b"READ, ", teachmover.Read()),
    (b"READ ", teachmover.Read()),
    (b"RESET, 0", teachmover.Reset()),
    (b"CLOSE, 0", teachmover.Close()),
    (b"CLO 235", teachmover.Close(235)),
    (b"CLO ", teachmover.Close()),
    (b"SET235,", teachmover.Set(235)),
    (b"QDUM", teachmover.QDump()),
    (b"ARM #,", teachmover.Arm("#")),
    (b"ARM!", teachmover.Arm("!")),
]

MALFORMED_COMMANDS = [
    b"",
    b" READ",
    b"read",
    b"Read",
    b"RE",
    b"READY",
    b"READ 1",
    b"READ,,1",
    b"HOME",
    b"STEP",
    b"STEP 240",
    b"STEP 240,1,2,3,4,5",
    b"STEP 240,1,2,3,4,5,6,7,8",
    b"STEP 240,1,,3,4,5,6",
    b"STEP 240,1 2,3,4,5,6",
    b"STEP 240,1.0,2,3,4,5,6",
    b"STEP 240,+1,2,3,4,5,6",
    b"STEP 240,0x1,2,3,4,5,6",
    b"STEP 240,1_0,2,3,4,5,6",
    b"STEP 240,--1,2,3,4,5,6",
    b"STEP 240,1,2,3,4,5,6,,",
    b"STEP 246,1,2,3,4,5,6",
    b"STEP -1,1,2,3,4,5,6",
    b"STEP 240,40000,2,3,4,5,6",
    b"STEP 240,100000,2,3,4,5,6",
    b"STEP 240,000001,2,3,4,5,6",
    b"STEP 240,1,2,3,4,5,6,256",
    b"STEP 240,\xd9\xa1,2,3,4,5,6",
    b"CLOSE 300",
    b"CLOSE 1,1",
    b"QWRITE 1,2,3,4,5,6,7",
    b"QWRITE 1,2,3,4,5,6,7,65536",
    b"ARM",
    b"ARM A",
    b"ARM ##",
    b"ARM ,",
    b"ARM #,#",
    b"ARM \xff",
    b"DELAY",
    b"DELAY -1",
    b"DELAY 1,2",
]

TOLERATED_REPLIES = [
    (b"\n1", teachmover.Status.DONE),
    (b"\0\0 1 ", teachmover.Status.DONE),
    (b"2,", teachmover.Status.STOPPED),
    (
        b"\n 1, -2 ,3,-4,5,-6,  1857,",
        teachmover.Registers((1, -2, 3, -4, 5, -6), teachmover.Key.STOP, 65),
    ),
    (b"1 3841 14436 28716 43252 65280 65025 64769", GOLDEN_ROW),
    (b"1, 3841, 14436, 28716, 43252, 65280, 65025, 64769,", GOLDEN_ROW),
    (b"1,3841,14436,28716,-22284,-256,-511,-767", GOLDEN_ROW),
]

GARBLED_REPLIES = [
    b"",
    b",",
    b"3",
    b"-1",
    b"01",
    b"11",
    b"x",
    b"1 1",
    b"1,2",
    b"\x001,2,3,4,5,6,7",  # the NUL could have been a minus sign
    b"\xad1,2,3,4,5,6,7",  # a minus sign with its top bit set
    b"1,2,3,4,5,6,-7",
    b"1,2,3,4,5,,7",
    b"1 2 3 4 5 6 7",
    b"1 2,3,4,5,6,7,8",
    b"1,2,3,4,5,6 7,8",
    b"000001,2,3,4,5,6,7",
    b"32768,2,3,4,5,6,7",
    b"1,2,3,4,5,6,65536",
    b"1,2,3,4,5,6,7,8,9",
    b"1,2,3,4,5,6,7,99999",
    b"1,2,3,4,5,6,7,,",
    b"@READ",
]


@every_row("command, line", COMMAND_BYTES)
def test_the_bytes_of_every_command_both_ways(command, line):
    assert encode_command(command, "@") == line
    assert decode_command(line[1:-1]) == command
    assert encode_command(command, "!") == b"!" + line[1:]


def test_the_table_of_bytes_has_every_command():
    assert {type(command) for command, _ in COMMAND_BYTES} == set(get_args(teachmover.Command))


@every_row("reply, line", REPLY_BYTES)
def test_the_bytes_of_every_reply_both_ways(reply, line):
    assert encode_reply(reply) == line
    decoded = decode_reply(line[:-1])
    assert decoded == reply
    assert type(decoded) is type(reply)


@every_row("body, command", TOLERATED_COMMANDS)
def test_what_public_programs_send_is_understood(body, command):
    assert decode_command(body) == command


@every_row("body", MALFORMED_COMMANDS)
def test_what_is_no_command_is_the_other_sides_fault(body):
    with pytest.raises(RemoteProtocolError):
        decode_command(body)


@given(st.binary(max_size=40) | st.binary(max_size=20).map(lambda rest: b"STEP " + rest))
def test_any_bytes_are_a_command_and_a_reply_or_the_other_sides_fault(body):
    for decode in (decode_command, decode_reply):
        with contextlib.suppress(RemoteProtocolError):
            decode(body)


@every_row("line, reply", TOLERATED_REPLIES)
def test_padding_that_cannot_change_a_meaning_is_read_over(line, reply):
    assert decode_reply(line) == reply


@every_row("line", GARBLED_REPLIES)
def test_a_doubtful_reply_is_the_other_sides_fault(line):
    with pytest.raises(RemoteProtocolError):
        decode_reply(line)


def test_a_field_out_of_range_is_named_with_its_command():
    with pytest.raises(RemoteProtocolError, match=r"STEP: speed must be .* 0 to 245, not 250"):
        decode_command(b"STEP 250,0,0,0,0,0,0")
