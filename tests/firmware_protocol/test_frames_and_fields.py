"""CAN frames, lines of text, and the fields of messages."""

from dataclasses import FrozenInstanceError
from enum import IntEnum

import pytest
from amounts import every_row
from chunks import chunked, events
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import armdroid, grbl, teachmover
from firmware_protocol.errors import BadField
from firmware_protocol.events import Stray, Unreadable
from firmware_protocol.fields import (
    BYTE,
    an_instance,
    boolean,
    each,
    message,
    numbered,
    optional,
    row_of,
    whole_from,
)
from firmware_protocol.frames import RECORD_MAX, Frame, Unpacker, pack
from firmware_protocol.lines import LineSplitter

# -- CAN frames ------------------------------------------------------------------------------------

DATA = st.binary(max_size=8)
FRAMES = st.one_of(
    st.tuples(st.integers(0, 0x7FF), DATA),
    st.tuples(st.integers(0, 0x1FFFFFFF), DATA, st.just(True)),
    st.tuples(st.integers(0, 0x7FF), st.just(b""), st.just(False), st.just(True)),
).map(lambda fields: Frame(*fields))


@every_row(
    "frame, text",
    [
        (Frame(0x123, b"\x01\xf6"), "123#01F6"),
        (Frame(1), "001#"),
        (Frame(1, b"", extended=True), "00000001#"),
        (Frame(0x1FFFFFFF, bytes(8), extended=True), "1FFFFFFF#0000000000000000"),
        (Frame(0x7FF, remote=True), "7FF#R"),
    ],
)
def test_a_frame_is_written_as_candump_does(frame, text):
    assert str(frame) == text
    assert Frame.parse(text) == frame


@pytest.mark.parametrize(
    ("text", "frame"),
    [("12a#0b.0c", Frame(0x12A, b"\x0b\x0c")), ("123#R8", Frame(0x123, remote=True))],
)
def test_what_people_type_is_read_too(text, frame):
    assert Frame.parse(text) == frame


@every_row(
    "text", ["", "123", "12#00", "1234#00", "800#", "123#0", "123##1", "123#" + "00" * 9, "123#R9"]
)
def test_what_is_no_frame_cannot_be_read(text):
    with pytest.raises(BadField):
        Frame.parse(text)


@every_row(
    "build, field",
    [
        (lambda: Frame(0x800), "can_id"),
        (lambda: Frame(-1), "can_id"),
        (lambda: Frame(True), "can_id"),
        (lambda: Frame(0x20000000, extended=True), "can_id"),
        (lambda: Frame(1, bytes(9)), "data"),
        (lambda: Frame(1, bytearray(1)), "data"),
        (lambda: Frame(1, b"x", remote=True), "data"),
        (lambda: Frame(1, extended=1), "extended"),
        (lambda: Frame(1, remote=None), "remote"),
    ],
)
def test_what_is_no_frame_cannot_be_built(build, field):
    with pytest.raises(BadField, match=f"^{field} must be"):
        build()


def test_a_record_is_these_bytes():
    # the CRC-16 of C5 02 01 23 01 F6, from FFFF by the polynomial 1021, worked out bit by bit
    data = bytes.fromhex("C5 02 01 23 01 F6")
    crc = 0xFFFF
    for byte in data:
        for bit in range(8):
            top = crc >> 15 ^ byte >> (7 - bit) & 1
            crc = crc << 1 & 0xFFFF ^ (0x1021 if top else 0)
    assert pack(Frame(0x123, b"\x01\xf6")) == data + crc.to_bytes(2, "big")


@given(FRAMES)
def test_every_frame_is_read_back_from_its_text_and_from_its_record(frame):
    assert Frame.parse(str(frame)) == frame
    assert len(pack(frame)) <= RECORD_MAX
    assert Unpacker().feed(pack(frame)) == [frame]


@given(st.binary(max_size=100), FRAMES, st.data())
def test_after_any_garbage_a_frame_is_found_once_a_silence_follows(garbage, frame, data):
    unpacker = Unpacker()
    found = []
    for chunk in data.draw(chunked(garbage + pack(frame))):
        found += unpacker.feed(chunk)
    found += unpacker.silence()
    assert found[-1] == frame
    assert unpacker.silence() == []


@given(st.lists(FRAMES, min_size=1, max_size=4), st.integers(0))
def test_a_wrong_bit_costs_its_frame_alone(frames, bit):
    stream = bytearray(b"".join(map(pack, frames)))
    at = bit % (8 * len(stream))
    stream[at // 8] ^= 1 << at % 8
    unpacker = Unpacker()
    found = unpacker.feed(bytes(stream)) + unpacker.silence()
    ends, spoilt = 0, 0
    for index, frame in enumerate(frames):
        if ends <= at // 8:
            spoilt = index
        ends += len(pack(frame))
    assert found == frames[:spoilt] + frames[spoilt + 1 :]


# -- Lines -----------------------------------------------------------------------------------------


def drained(splitter: LineSplitter) -> list[bytes | Unreadable]:
    found = []
    while (line := splitter.next_line()) is not None:
        found.append(line)
    return found


def test_a_line_appears_when_its_terminator_does():
    splitter = LineSplitter(b"\r")
    splitter.feed(b"one")
    assert splitter.next_line() is None
    assert splitter.partial == b"one"
    splitter.feed(b"\rtw")
    assert drained(splitter) == [b"one"]
    assert splitter.partial == b"tw"


def test_any_byte_of_the_set_ends_a_line_and_empty_lines_are_skipped():
    splitter = LineSplitter(b"\r\n")
    splitter.feed(b"a\r\nb\n\n\rc\r")
    assert drained(splitter) == [b"a", b"b", b"c"]


def test_a_line_of_the_greatest_length_passes_and_one_byte_more_does_not():
    splitter = LineSplitter(b"\r", max_length=5)
    splitter.feed(b"12345\r123456\rok\r")
    assert drained(splitter) == [
        b"12345",
        Unreadable(b"12345", "a line of more than 5 bytes"),
        b"ok",
    ]


def test_discarding_makes_the_next_byte_begin_a_line():
    splitter = LineSplitter(b"\r", max_length=8)
    for junk in (b"waiting\rpart", b"far too long for a line"):
        splitter.feed(junk)
        splitter.discard()
        assert (splitter.partial, drained(splitter)) == (b"", [])
        splitter.feed(b"new\r")
        assert drained(splitter) == [b"new"]


# -- the hosts that read lines --------------------------------------------------------------------

CLOSE, OFFSETS, QUERY = (
    teachmover.Close(),
    armdroid.ReportOffsets(),
    grbl.SystemCommand.QUERY_SETTINGS,
)
REPORTED = armdroid.OffsetsReported((1, -2, 3, -4, 5, -6))
DONE = teachmover.Status.DONE
every_host = pytest.mark.parametrize(
    ("make", "command", "line", "answered", "stray"),
    [
        (teachmover.Host, CLOSE, b"1\r", teachmover.Completed(CLOSE, DONE), DONE),
        (
            armdroid.Host,
            OFFSETS,
            b"offsets = 1,-2,3,-4,5,-6\r\n",
            armdroid.Completed(OFFSETS, REPORTED),
            REPORTED,
        ),
        (grbl.Host, QUERY, b"ok\r\n", grbl.Acknowledged(QUERY), grbl.Ok()),
    ],
    ids=["teachmover", "armdroid", "grbl"],
)
"""Each with a command, the line that answers it, and what the host says of the line both ways."""


@every_host
def test_a_line_that_came_or_began_before_a_command_is_never_its_answer(
    make, command, line, answered, stray
):
    for cut in range(1, len(line) + 1):
        host = make()
        host.receive_data(line[:cut])
        host.send(command)
        (early,) = events(host, line[cut:])
        if early != Stray(stray):
            assert early == Unreadable(
                line.rstrip(b"\r\n"), "the line began before the command was sent"
            )
        assert cut < len(line) or early == Stray(stray)
        assert events(host, line) == [answered]


@every_host
def test_an_endless_line_is_told_once_and_spoils_no_answer(make, command, line, answered, stray):
    host, found = make(), []
    host.send(command)
    for _ in range(300):
        found += events(host, b"<" * 100)
    assert [type(event) for event in found] == [Unreadable]
    assert events(host, line[-1:] + line) == [answered]


@every_host
def test_discarded_bytes_and_events_are_gone_and_the_command_stays(
    make, command, line, answered, stray
):
    host = make()
    host.receive_data(line * 2 + line[:1])
    host.send(command)
    host.discard()
    assert events(host, line) == [answered]


# -- Fields ----------------------------------------------------------------------------------------


class Colour(IntEnum):
    RED = 1
    BLUE = 2


PAIR = row_of(whole_from(-3, 3), 2, "two numbers")


@message(colour=numbered(Colour), pair=PAIR)
class Message:
    colour: Colour
    pair: tuple[int, ...] = (0, 0)

    def __post_init__(self) -> None:
        if self.colour is Colour.RED and any(self.pair):
            raise BadField("pair", self.pair, "zeros where it is red")


@every_row(
    "rule, given, kept",
    [
        (BYTE, 255, 255),
        (boolean, False, False),
        (numbered(Colour), 2, Colour.BLUE),
        (an_instance(str, "text"), "a", "a"),
        (optional(BYTE), None, None),
        (optional(BYTE), 7, 7),
        (each(BYTE), [], ()),
        (each(BYTE), [1, 2], (1, 2)),
        (PAIR, [3, -3], (3, -3)),
        (row_of(BYTE, range(1, 3), "one or two"), (9,), (9,)),
    ],
)
def test_a_rule_keeps_what_fits(rule, given, kept):
    found = rule("field", given)
    assert found == kept
    assert type(found) is type(kept)


@every_row(
    "rule, given, field, allowed",
    [
        (BYTE, 256, "field", "a whole number from 0 to 255"),
        (BYTE, True, "field", "a whole number from 0 to 255"),
        (boolean, 1, "field", "True or False"),
        (numbered(Colour), 3, "field", "a whole number from 1 to 2"),
        (an_instance(str, "text"), b"a", "field", "text"),
        (optional(BYTE), -1, "field", "a whole number from 0 to 255"),
        (each(BYTE), [1, "2"], "field", "a whole number from 0 to 255"),
        (PAIR, (1, 2, 3), "field", "two numbers"),
        (PAIR, 12, "field", "two numbers"),
        (PAIR, (1, 4), "field[1]", "a whole number from -3 to 3"),
        (row_of(BYTE, range(1, 3), "one or two"), (), "field", "one or two"),
    ],
)
def test_a_rule_refuses_what_does_not_fit_and_names_it(rule, given, field, allowed):
    with pytest.raises(BadField) as refused:
        rule("field", given)
    assert (refused.value.field, refused.value.allowed) == (field, allowed)


def test_a_message_keeps_what_its_rules_return_and_is_frozen():
    message = Message(2, [1, 2])
    assert message == Message(Colour.BLUE, (1, 2))
    assert message.colour is Colour.BLUE
    with pytest.raises(FrozenInstanceError):
        message.colour = Colour.RED
