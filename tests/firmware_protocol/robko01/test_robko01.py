"""Robko 01: frames, and the host's machine."""

import pytest
from amounts import every_row
from cases_robko01 import ANSWERS, EXCHANGES, REQUESTS
from chunks import carried, chunked, events
from hypothesis import assume, given
from hypothesis import strategies as st

from firmware_protocol import robko01
from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError
from firmware_protocol.robko01 import (
    FLUSH,
    Acknowledged,
    Answered,
    Axes,
    Host,
    MoveAbsolute,
    Op,
    Ping,
    Pong,
    Position,
    Positions,
    Stop,
    Stray,
    Unreadable,
)
from firmware_protocol.robko01.frames import (
    FRAME_MAX,
    FrameSplitter,
    Kind,
    SuperFrame,
    frame_bytes,
)
from firmware_protocol.robko01.messages import (
    decode_answer,
    decode_request,
    encode_answer,
    encode_request,
)

# -- Frames ----------------------------------------------------------------------------------------

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
    # C0 = AA ^ 03 ^ 48 = E1; C1 = 01 ^ 01 ^ 69 = 69
    (robko01.Ping(b"Hi"), "AA 01 03 01 48 69 E1 69"),
    # C0 = AA ^ 02 ^ 05 = AD; C1 = 01 ^ 08 = 09
    (robko01.Outputs(5), "AA 01 02 08 05 AD 09"),
    # C0 = AA ^ 19 ^ 01 ^ 64 ^ FE ^ 64 = 4C; C1 = 01 ^ op ^ FF = FE ^ op
    (robko01.MoveRelative(TWO), f"AA 01 19 06 01 00 64 00 FE FF 64 00{REST} 4C F8"),
    (robko01.MoveAbsolute(TWO), f"AA 01 19 07 01 00 64 00 FE FF 64 00{REST} 4C F9"),
    (robko01.MoveSpeed(TWO), f"AA 01 19 0C 01 00 64 00 FE FF 64 00{REST} 4C F2"),
]
# Without a payload C0 is AA ^ 02 ^ status, and C1 is 02 ^ op.
ANSWER_BYTES = [
    (robko01.Acknowledged(robko01.Op.STOP), "AA 02 02 02 01 A9 00"),
    (robko01.Acknowledged(robko01.Op.MOVE_ABSOLUTE, robko01.Status.ERROR), "AA 02 02 07 02 AA 05"),
    (robko01.Acknowledged(robko01.Op.PING, robko01.Status.TIMEOUT), "AA 02 02 01 04 AC 03"),
    (robko01.Acknowledged(robko01.Op.OUTPUTS), "AA 02 02 08 01 A9 0A"),
    # C0 = AA ^ 03 ^ status; C1 = 02 ^ op ^ byte
    (robko01.Busy(robko01.Op.MOVE_ABSOLUTE, 5), "AA 02 03 07 03 05 AA 00"),
    (robko01.OutputsSet(0x0F), "AA 02 03 08 01 0F A8 05"),
    (robko01.InputsRead(0x81), "AA 02 03 09 01 81 A8 8A"),
    (robko01.Moving(0x21), "AA 02 03 0A 01 21 A8 29"),
    (robko01.Pong(), "AA 02 02 01 01 A9 03"),
    # C0 = AA ^ 04 ^ 01 ^ 69 = C6; C1 = 02 ^ 01 ^ 48 = 4B
    (robko01.Pong(b"Hi"), "AA 02 04 01 01 48 69 C6 4B"),
    # C0 = AA ^ 1A ^ 01 ^ 01 = B0; C1 = 02 ^ 0B ^ 2C = 25
    (robko01.Positions(THERE), f"AA 02 1A 0B 01 2C 01{' 00' * 6}{REST} B0 25"),
]


@every_row("request_, data", REQUEST_BYTES)
def test_a_request_is_these_bytes(request_, data):
    assert encode_request(request_).hex(" ").upper() == data
    assert decode_request(SuperFrame(bytes.fromhex(data), 0)) == request_


@every_row("answer, data", ANSWER_BYTES)
def test_an_answer_is_these_bytes(answer, data):
    assert encode_answer(answer).hex(" ").upper() == data
    assert decode_answer(SuperFrame(bytes.fromhex(data), 0)) == answer


def test_the_tables_leave_no_operation_out():
    assert {request.op for request, _ in REQUEST_BYTES} == set(robko01.Op)


@every_row(
    "kind, op, rest, reason",
    [
        (Kind.REQUEST, 0, b"", "no operation has the number 0"),
        (Kind.REQUEST, 17, b"", "no operation has the number 17"),
        (Kind.REQUEST, 2, b"x", "STOP of length 1 where none belong"),
        (Kind.REQUEST, 7, b"x" * 23, "MOVE_ABSOLUTE of length 23 where 24 belong"),
        (Kind.REQUEST, 8, b"", "OUTPUTS of length 0 where one belongs"),
        (Kind.ANSWER, 2, b"\x01", "an answer, where requests belong"),
    ],
)
def test_a_frame_that_is_no_request_says_why(kind, op, rest, reason):
    with pytest.raises(RemoteProtocolError, match=reason):
        decode_request(SuperFrame(frame_bytes(kind, op, rest), 0))


@every_row(
    "kind, op, rest, reason",
    [
        (Kind.REQUEST, 2, b"", "a request, where answers belong"),
        (Kind.ANSWER, 99, b"\x01", "no operation has the number 99"),
        (Kind.ANSWER, 2, b"\x05", "no status has the number 5"),
        (Kind.ANSWER, 2, b"\x01x", "STOP of length 1 where none belong"),
        (Kind.ANSWER, 9, b"\x01", "INPUTS of length 0 where one belongs"),
        (Kind.ANSWER, 11, b"\x01" + bytes(22), "POSITION of length 22 where 24 belong"),
        (Kind.ANSWER, 7, b"\x03xy", "MOVE_ABSOLUTE of length 2 where one belongs"),
    ],
)
def test_a_frame_that_is_no_answer_says_why(kind, op, rest, reason):
    with pytest.raises(RemoteProtocolError, match=reason):
        decode_answer(SuperFrame(frame_bytes(kind, op, rest), 0))


@every_row(
    "build, field",
    [
        (lambda: robko01.Ping(b"x" * 27), "payload"),
        (lambda: robko01.Ping("text"), "payload"),
        (lambda: robko01.Outputs(256), "value"),
        (lambda: robko01.Outputs(True), "value"),
        (lambda: robko01.MoveAbsolute((0,) * 12), "axes"),
        (lambda: robko01.Positions(None), "axes"),
        (lambda: robko01.Axes((0,) * 5), "positions_steps"),
        (lambda: robko01.Axes((0, 0, 32768, 0, 0, 0)), r"positions_steps\[2\]"),
        (lambda: robko01.Axes((0,) * 6, (0, 1.0, 0, 0, 0, 0)), r"speeds_steps_s\[1\]"),
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


# -- Machines --------------------------------------------------------------------------------------

STOPPED = encode_answer(Acknowledged(Op.STOP))
HERE = Positions(Axes((1, 2, 3, 4, 5, 6)))
SWALLOWING = bytes.fromhex("AA 02 1C")
"""The header of the longest answer, which never comes."""


def split(*chunks: bytes, silence=False) -> list[SuperFrame | Unreadable]:
    """Return the frames in bytes, and the runs of bytes between them."""
    splitter = FrameSplitter()
    for chunk in chunks:
        splitter.feed(chunk)
    if silence:
        splitter.silence()
    return list(iter(splitter.next_frame, None))


def asked(request) -> Host:
    host = Host()
    host.send(request)
    return host


def test_nothing_is_sent_while_a_request_is_unanswered():
    host = asked(Position())
    with pytest.raises(LocalProtocolError, match=r"POSITION is unanswered: .* before sending STOP"):
        host.send(Stop())
    host.forget()
    assert host.send(Stop())


def test_the_late_answer_to_a_forgotten_request_is_stray():
    host = asked(Stop())
    host.forget()
    host.send(Position())
    assert events(host, STOPPED + encode_answer(HERE)) == [
        Stray(Acknowledged(Op.STOP)),
        Answered(Position(), HERE),
    ]


def test_a_ping_knows_its_own_answer():
    host = asked(Ping(b"one"))
    host.forget()
    host.send(Ping(b"two"))
    late, right = events(host, encode_answer(Pong(b"one")) + encode_answer(Pong(b"two")))
    assert late == Stray(Pong(b"one"))
    assert right == Answered(Ping(b"two"), Pong(b"two"))


@every_row("cut", range(len(STOPPED) + 1))
def test_a_frame_that_began_before_the_request_is_not_its_answer(cut):
    host = asked(Stop())
    host.receive_data(STOPPED[:cut])
    host.forget()
    host.send(Stop())
    host.receive_data(STOPPED[cut:])
    first = Answered if cut == 0 else Stray
    assert [type(event) for event in events(host)] == [first]


def test_bytes_that_are_no_answer_are_told_and_change_nothing():
    host = asked(Stop())
    spoilt = STOPPED[:-1] + b"\x7f"
    echo = encode_request(Stop())
    found = events(host, b"noise" + spoilt + echo + STOPPED)
    assert found == [
        Unreadable(b"noise" + spoilt, "the check bytes should be a9 00"),
        Unreadable(echo, "a request, where answers belong"),
        Answered(Stop(), Acknowledged(Op.STOP)),
    ]


def test_an_answer_behind_a_spoilt_length_is_heard_after_a_silence():
    host = asked(Stop())
    assert events(host, SWALLOWING + STOPPED) == []
    host.silence()
    assert events(host) == [
        Unreadable(SWALLOWING, "the frame was not finished"),
        Answered(Stop(), Acknowledged(Op.STOP)),
    ]
    host.silence()
    assert events(host) == []


@every_row("cut", range(1, 30))
def test_padding_ends_a_frame_that_was_cut_off(cut):
    cut_off = encode_request(MoveAbsolute(Axes((1,) * 6)))[:cut]
    *garbled, last = split(cut_off + FLUSH + encode_request(Stop()))
    assert last.raw == encode_request(Stop())
    assert all(isinstance(entry, Unreadable) for entry in garbled)


@given(
    st.lists(st.sampled_from([0, 0, 0, 1, 125, -125, 240, 700]), min_size=6, max_size=6),
    st.lists(st.sampled_from([0, 63, 700]), min_size=6, max_size=6),
    st.integers(1, 6),
    st.randoms(use_true_random=False),
)
def test_a_motion_that_lost_zeros_is_never_made_whole_by_what_is_sent_behind_it(
    steps, speeds, count, draw
):
    whole = encode_request(MoveAbsolute(Axes(tuple(steps), tuple(speeds))))
    zeros = [index for index, byte in enumerate(whole) if byte == 0 and index > 2]
    assume(len(zeros) >= 2 * count)
    gone = set(draw.sample(zeros, 2 * count))
    left = bytes(byte for index, byte in enumerate(whole) if index not in gone)
    found = split(left + FLUSH)
    assert not any(isinstance(each, SuperFrame) and each.op == Op.MOVE_ABSOLUTE for each in found)


def test_what_ends_a_frame_begins_none():
    assert 0xAA not in FLUSH
    assert len(FLUSH) == FRAME_MAX


# -- Any bytes, in any chunks ----------------------------------------------------------------------

FRAMES = st.one_of(REQUESTS.map(encode_request), ANSWERS.map(encode_answer))
PIECES = st.lists(
    st.one_of(
        FRAMES,
        st.binary(max_size=40),
        st.tuples(FRAMES, st.integers(0, 33)).map(lambda cut: cut[0][: cut[1]]),
        st.sampled_from([b"\xaa", b"\xaa\x01", b"\xaa\x02\x1c", b"\xaa\x01\x1b\x06"]),
    ),
    max_size=8,
)


@given(st.lists(EXCHANGES, max_size=5), st.data())
def test_every_script_arrives_whole(script, data):
    host = Host()
    for request, answer in script:
        (frame,) = split(*data.draw(chunked(host.send(request))))
        assert decode_request(frame) == request
        answered = encode_answer(answer)
        assert carried(data.draw, answered, host) == [Answered(request, answer)]
        assert host.outstanding is None


@given(PIECES)
def test_every_byte_is_told_once_and_in_order(pieces):
    stream = b"".join(pieces)
    found = split(stream, silence=True)
    raw = [entry.raw if isinstance(entry, SuperFrame) else entry.data for entry in found]
    assert b"".join(raw) == stream
    at = 0
    for entry, data in zip(found, raw, strict=True):
        assert not isinstance(entry, SuperFrame) or entry.start == at
        at += len(data)
