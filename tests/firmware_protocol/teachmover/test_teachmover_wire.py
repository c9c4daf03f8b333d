"""The bytes of every TeachMover command and reply, both ways, and what is read with patience."""

from typing import get_args

import pytest
from hypothesis import given
from teachmover_strategies import COMMANDS, REPLIES

from firmware_protocol import teachmover
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.teachmover.messages import (
    decode_command,
    decode_reply,
    encode_command,
    encode_reply,
)

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


@pytest.mark.parametrize(("command", "line"), COMMAND_BYTES)
def test_the_bytes_of_every_command_both_ways(command, line):
    assert encode_command(command, "@") == line
    assert decode_command(line[1:-1]) == command
    assert encode_command(command, "!") == b"!" + line[1:]


def test_the_table_of_bytes_has_every_command():
    assert {type(command) for command, _ in COMMAND_BYTES} == set(get_args(teachmover.Command))


@pytest.mark.parametrize(("reply", "line"), REPLY_BYTES)
def test_the_bytes_of_every_reply_both_ways(reply, line):
    assert encode_reply(reply) == line
    decoded = decode_reply(line[:-1])
    assert decoded == reply
    assert type(decoded) is type(reply)


@pytest.mark.parametrize(("body", "command"), TOLERATED_COMMANDS)
def test_what_public_programs_send_is_understood(body, command):
    assert decode_command(body) == command


@pytest.mark.parametrize("body", MALFORMED_COMMANDS)
def test_what_is_no_command_is_the_other_sides_fault(body):
    with pytest.raises(RemoteProtocolError):
        decode_command(body)


@pytest.mark.parametrize(("line", "reply"), TOLERATED_REPLIES)
def test_padding_that_cannot_change_a_meaning_is_read_over(line, reply):
    assert decode_reply(line) == reply


@pytest.mark.parametrize("line", GARBLED_REPLIES)
def test_a_doubtful_reply_is_the_other_sides_fault(line):
    with pytest.raises(RemoteProtocolError):
        decode_reply(line)


def test_a_field_out_of_range_is_named_with_its_command():
    with pytest.raises(RemoteProtocolError, match=r"STEP: speed must be .* 0 to 245, not 250"):
        decode_command(b"STEP 250,0,0,0,0,0,0")


@given(COMMANDS)
def test_every_command_is_read_back_as_it_was(command):
    assert decode_command(encode_command(command, "@")[1:-1]) == command


@given(REPLIES)
def test_every_reply_is_read_back_as_it_was(reply):
    assert decode_reply(encode_reply(reply)[:-1]) == reply
