"""CAN frames: what can be built, how they are written, and how records carry them."""

from binascii import crc_hqx

import pytest
from chunks import chunked
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.errors import BadField
from firmware_protocol.frames import RECORD_MAX, Frame, Unpacker, pack

DATA = st.binary(max_size=8)
FRAMES = st.one_of(
    st.tuples(st.integers(0, 0x7FF), DATA),
    st.tuples(st.integers(0, 0x1FFFFFFF), DATA, st.just(True)),
    st.tuples(st.integers(0, 0x7FF), st.just(b""), st.just(False), st.just(True)),
).map(lambda fields: Frame(*fields))


@pytest.mark.parametrize(
    ("frame", "text"),
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


@pytest.mark.parametrize(
    "text", ["", "123", "12#00", "1234#00", "800#", "123#0", "123##1", "123#" + "00" * 9, "123#R9"]
)
def test_what_is_no_frame_cannot_be_read(text):
    with pytest.raises(BadField):
        Frame.parse(text)


@pytest.mark.parametrize(
    ("build", "field"),
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


@given(st.lists(FRAMES, max_size=6), st.data())
def test_the_chunks_make_no_difference(frames, data):
    unpacker = Unpacker()
    found = []
    for chunk in data.draw(chunked(b"".join(map(pack, frames)))):
        found += unpacker.feed(chunk)
    assert found == frames
    assert (unpacker.buffered, unpacker.skipped) == (0, 0)


@given(st.binary(max_size=100), FRAMES, st.data())
def test_after_any_garbage_a_frame_is_found_once_a_silence_follows(garbage, frame, data):
    unpacker = Unpacker()
    found = []
    for chunk in data.draw(chunked(garbage + pack(frame))):
        found += unpacker.feed(chunk)
        assert unpacker.buffered < RECORD_MAX
    found += unpacker.silence()
    assert found[-1] == frame
    assert unpacker.buffered == 0


@given(st.binary(max_size=100), FRAMES)
def test_after_any_garbage_a_frame_is_found_once_a_longest_record_has_followed(garbage, frame):
    assert frame in Unpacker().feed(garbage + pack(frame) + bytes(RECORD_MAX))


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
    assert unpacker.skipped == len(pack(frames[spoilt]))


def test_a_record_of_an_id_that_no_frame_has_is_skipped():
    body = bytes.fromhex("C5 00 08 00")
    bad = body + crc_hqx(body, 0xFFFF).to_bytes(2, "big")
    unpacker = Unpacker()
    assert unpacker.feed(bad + pack(Frame(1))) == [Frame(1)]
    assert unpacker.skipped == len(bad)
