"""SUPER frames byte by byte, check bytes worked out by hand, and what cannot be built."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from robko01_strategies import ANSWERS, REQUESTS

from firmware_protocol import robko01
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.robko01.frames import Frame, Kind, check_bytes, frame_bytes
from firmware_protocol.robko01.messages import (
    decode_answer,
    decode_request,
    encode_answer,
    encode_request,
)

TWO = robko01.Axes((1, -2, 0, 0, 0, 0), (100, 100, 0, 0, 0, 0))
THERE = robko01.Axes((300, 0, 0, 0, 0, 0))
REST = " 00" * 16

# Without a payload C0 is AA ^ 01 = AB, and C1 is 01 ^ op.
REQUEST_BYTES = [
    (robko01.Ping(), "AA 01 01 01 AB 00"),
    (robko01.Stop(), "AA 01 01 02 AB 03"),
    (robko01.Disable(), "AA 01 01 03 AB 02"),
    (robko01.Enable(), "AA 01 01 04 AB 05"),
    (robko01.Clear(), "AA 01 01 05 AB 04"),
    (robko01.Inputs(), "AA 01 01 09 AB 08"),
    (robko01.IsMoving(), "AA 01 01 0A AB 0B"),
    (robko01.Position(), "AA 01 01 0B AB 0A"),
    (robko01.GetRobotId(), "AA 01 01 0E AB 0F"),
    (robko01.SavePosition(), "AA 01 01 0F AB 0E"),
    (robko01.LoadPosition(), "AA 01 01 10 AB 11"),
    # C0 = AA ^ 03 ^ 48 = E1; C1 = 01 ^ 01 ^ 69 = 69
    (robko01.Ping(b"Hi"), "AA 01 03 01 48 69 E1 69"),
    # C0 = AA ^ 02 ^ 05 = AD; C1 = 01 ^ 08 = 09
    (robko01.Outputs(5), "AA 01 02 08 05 AD 09"),
    # C0 = AA ^ 02 ^ 07 = AF; C1 = 01 ^ 0D = 0C
    (robko01.SetRobotId(b"\x07"), "AA 01 02 0D 07 AF 0C"),
    # C0 = AA ^ 19 ^ 01 ^ 64 ^ FE ^ 64 = 4C; C1 = 01 ^ op ^ FF = FE ^ op
    (robko01.MoveRelative(TWO), f"AA 01 19 06 01 00 64 00 FE FF 64 00{REST} 4C F8"),
    (robko01.MoveAbsolute(TWO), f"AA 01 19 07 01 00 64 00 FE FF 64 00{REST} 4C F9"),
    (robko01.MoveSpeed(TWO), f"AA 01 19 0C 01 00 64 00 FE FF 64 00{REST} 4C F2"),
]
# Without a payload C0 is AA ^ 02 ^ status, and C1 is 02 ^ op.
ANSWER_BYTES = [
    (robko01.Acknowledged(robko01.Op.STOP), "AA 02 02 02 01 A9 00"),
    (robko01.Acknowledged(robko01.Op.MOVE_RELATIVE, robko01.Status.ERROR), "AA 02 02 06 02 AA 04"),
    (robko01.Acknowledged(robko01.Op.PING, robko01.Status.TIMEOUT), "AA 02 02 01 04 AC 03"),
    (robko01.Acknowledged(robko01.Op.OUTPUTS), "AA 02 02 08 01 A9 0A"),
    # C0 = AA ^ 03 ^ status; C1 = 02 ^ op ^ byte
    (robko01.Busy(robko01.Op.MOVE_RELATIVE, 5), "AA 02 03 06 03 05 AA 01"),
    (robko01.OutputsSet(0x0F), "AA 02 03 08 01 0F A8 05"),
    (robko01.InputsRead(0x81), "AA 02 03 09 01 81 A8 8A"),
    (robko01.Moving(0x21), "AA 02 03 0A 01 21 A8 29"),
    (robko01.RobotId(robko01.Op.SET_ROBOT_ID, b"\x07"), "AA 02 03 0D 01 07 A8 08"),
    (robko01.RobotId(robko01.Op.GET_ROBOT_ID), "AA 02 02 0E 01 A9 0C"),
    (robko01.Pong(), "AA 02 02 01 01 A9 03"),
    # C0 = AA ^ 04 ^ 01 ^ 69 = C6; C1 = 02 ^ 01 ^ 48 = 4B
    (robko01.Pong(b"Hi"), "AA 02 04 01 01 48 69 C6 4B"),
    # C0 = AA ^ 1A ^ 01 ^ 01 = B0; C1 = 02 ^ 0B ^ 2C = 25
    (robko01.Positions(THERE), f"AA 02 1A 0B 01 2C 01{' 00' * 6}{REST} B0 25"),
]


@pytest.mark.parametrize(("request_", "data"), REQUEST_BYTES)
def test_a_request_is_these_bytes(request_, data):
    assert encode_request(request_).hex(" ").upper() == data
    assert decode_request(Frame(bytes.fromhex(data), 0)) == request_


@pytest.mark.parametrize(("answer", "data"), ANSWER_BYTES)
def test_an_answer_is_these_bytes(answer, data):
    assert encode_answer(answer).hex(" ").upper() == data
    assert decode_answer(Frame(bytes.fromhex(data), 0)) == answer


def test_the_tables_leave_no_operation_out():
    assert {request.op for request, _ in REQUEST_BYTES} == set(robko01.Op)


def test_a_firmware_that_counts_the_check_bytes_has_longer_lengths():
    # C0 = AA ^ 03 = A9; C1 = 01 ^ 02 = 03; and C0 = AA ^ 04 ^ 01 = AF; C1 = 02 ^ 02 = 00
    assert encode_request(robko01.Stop(), counts_check=True).hex() == "aa010302a903"
    assert (
        encode_answer(robko01.Acknowledged(robko01.Op.STOP), counts_check=True).hex()
        == "aa02040201af00"
    )


@given(REQUESTS)
def test_what_a_host_sends_can_be_read(request_):
    data = encode_request(request_)
    assert len(data) <= robko01.FRAME_MAX - 1
    assert decode_request(Frame(data, 0)) == request_


@given(ANSWERS)
def test_what_a_device_sends_can_be_read(answer):
    data = encode_answer(answer)
    assert len(data) <= robko01.FRAME_MAX
    assert decode_answer(Frame(data, 0)) == answer


@given(st.binary(min_size=4, max_size=31), st.integers(0, 40 * 8))
def test_one_wrong_bit_never_passes(data, bit):
    whole = bytearray(data + check_bytes(data))
    at = bit % (len(whole) * 8)
    whole[at // 8] ^= 1 << at % 8
    assert check_bytes(whole[:-2]) != whole[-2:]


@given(st.sampled_from(Kind), st.integers(0, 255), st.binary(min_size=1, max_size=26))
def test_any_frame_has_a_meaning_or_a_typed_reason(kind, op, rest):
    frame = Frame(frame_bytes(kind, op, rest), 0)
    decode, encode = {
        Kind.REQUEST: (decode_request, encode_request),
        Kind.ANSWER: (decode_answer, encode_answer),
    }[kind]
    with contextlib.suppress(RemoteProtocolError):
        assert encode(decode(frame)) == frame.raw


@pytest.mark.parametrize(
    ("kind", "op", "rest", "reason"),
    [
        (Kind.REQUEST, 0, b"", "no operation has the number 0"),
        (Kind.REQUEST, 17, b"", "no operation has the number 17"),
        (Kind.REQUEST, 2, b"x", "STOP of length 1 where none belong"),
        (Kind.REQUEST, 6, b"x" * 23, "MOVE_RELATIVE of length 23 where 24 belong"),
        (Kind.REQUEST, 8, b"", "OUTPUTS of length 0 where one belongs"),
        (Kind.ANSWER, 2, b"\x01", "an answer, where requests belong"),
    ],
)
def test_a_frame_that_is_no_request_says_why(kind, op, rest, reason):
    with pytest.raises(RemoteProtocolError, match=reason):
        decode_request(Frame(frame_bytes(kind, op, rest), 0))


@pytest.mark.parametrize(
    ("kind", "op", "rest", "reason"),
    [
        (Kind.REQUEST, 2, b"", "a request, where answers belong"),
        (Kind.ANSWER, 99, b"\x01", "no operation has the number 99"),
        (Kind.ANSWER, 2, b"\x05", "no status has the number 5"),
        (Kind.ANSWER, 2, b"\x01x", "STOP of length 1 where none belong"),
        (Kind.ANSWER, 9, b"\x01", "INPUTS of length 0 where one belongs"),
        (Kind.ANSWER, 11, b"\x01" + bytes(22), "POSITION of length 22 where 24 belong"),
        (Kind.ANSWER, 6, b"\x03xy", "MOVE_RELATIVE of length 2 where one belongs"),
    ],
)
def test_a_frame_that_is_no_answer_says_why(kind, op, rest, reason):
    with pytest.raises(RemoteProtocolError, match=reason):
        decode_answer(Frame(frame_bytes(kind, op, rest), 0))


@pytest.mark.parametrize(
    ("build", "field"),
    [
        (lambda: robko01.Ping(b"x" * 27), "payload"),
        (lambda: robko01.Ping("text"), "payload"),
        (lambda: robko01.Outputs(256), "value"),
        (lambda: robko01.Outputs(True), "value"),
        (lambda: robko01.MoveRelative((0,) * 12), "axes"),
        (lambda: robko01.Positions(None), "axes"),
        (lambda: robko01.Axes((0,) * 5), "positions_steps"),
        (lambda: robko01.Axes((0, 0, 32768, 0, 0, 0)), r"positions_steps\[2\]"),
        (lambda: robko01.Axes((0,) * 6, (0, 1.0, 0, 0, 0, 0)), r"speeds_steps_s\[1\]"),
        (lambda: robko01.SetRobotId(b"x" * 27), "payload"),
        (lambda: robko01.RobotId(robko01.Op.PING), "op"),
        (lambda: robko01.Busy(17, 0), "op"),
        (lambda: robko01.Busy(robko01.Op.STOP, 256), "moving"),
        (lambda: robko01.Acknowledged(robko01.Op.STOP, 5), "status"),
        (lambda: robko01.Acknowledged(robko01.Op.POSITION), "status"),
        (lambda: robko01.Pong(b"x" * 27), "payload"),
    ],
)
def test_what_the_protocol_cannot_carry_cannot_be_built(build, field):
    with pytest.raises(BadField, match=f"^{field} must be"):
        build()


def test_the_moving_mask_names_its_axes():
    assert robko01.Moving(0b100101).axes == (0, 2, 5)


@given(st.integers(-(10**9), 10**9))
def test_a_position_is_wrapped_to_16_bits(position):
    assert -32768 <= robko01.wrap(position) <= 32767
    assert (robko01.wrap(position) - position) % 65536 == 0
