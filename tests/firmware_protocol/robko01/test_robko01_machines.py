"""The host's and the device's machine: one request, one answer, and what does not belong."""

import pytest
from chunks import events
from hypothesis import assume, given
from hypothesis import strategies as st

from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.robko01 import (
    FLUSH,
    Acknowledged,
    Answered,
    Axes,
    Device,
    Host,
    MoveRelative,
    Op,
    Ping,
    Pong,
    Position,
    Positions,
    SavePosition,
    Status,
    Stop,
    Stray,
    Unreadable,
)
from firmware_protocol.robko01.frames import FRAME_MAX
from firmware_protocol.robko01.messages import encode_answer, encode_request

STOPPED = encode_answer(Acknowledged(Op.STOP))
HERE = Positions(Axes((1, 2, 3, 4, 5, 6)))
SWALLOWING = bytes.fromhex("AA 02 1C")
"""The header of the longest answer, which never comes."""


def asked(request) -> Host:
    host = Host()
    host.send(request)
    return host


def test_an_answer_completes_the_request():
    host = asked(Stop())
    assert host.outstanding == Stop()
    assert events(host, STOPPED) == [Answered(Stop(), Acknowledged(Op.STOP))]
    assert host.outstanding is None


def test_nothing_is_sent_while_a_request_is_unanswered():
    host = asked(Position())
    with pytest.raises(LocalProtocolError, match=r"POSITION is unanswered: .* before sending STOP"):
        host.send(Stop())
    assert host.forget() == Position()
    assert host.forget() is None
    assert host.send(Stop())


def test_an_answer_to_another_operation_is_stray():
    host = asked(Position())
    assert events(host, STOPPED) == [Stray(Acknowledged(Op.STOP))]
    assert host.outstanding == Position()


def test_an_answer_that_nobody_awaits_is_stray():
    assert events(Host(), STOPPED) == [Stray(Acknowledged(Op.STOP))]


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


def test_a_ping_can_be_refused():
    refused = Acknowledged(Op.PING, Status.ERROR)
    assert events(asked(Ping(b"x")), encode_answer(refused)) == [Answered(Ping(b"x"), refused)]


@pytest.mark.parametrize("cut", range(len(STOPPED) + 1))
def test_a_frame_that_began_before_the_request_is_not_its_answer(cut):
    host = asked(Stop())
    host.receive_data(STOPPED[:cut])
    host.forget()
    host.send(Stop())
    host.receive_data(STOPPED[cut:])
    first = Answered if cut == 0 else Stray
    assert [type(event) for event in events(host)] == [first]


def test_a_discarded_beginning_spoils_nothing():
    host = asked(Stop())
    host.receive_data(STOPPED + STOPPED[:4])
    host.discard()
    assert host.buffered == 0
    assert host.outstanding == Stop()
    assert events(host, STOPPED) == [Answered(Stop(), Acknowledged(Op.STOP))]


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


def test_an_answer_behind_a_spoilt_length_is_heard_when_enough_has_followed():
    host = asked(Stop())
    assert events(host, SWALLOWING + STOPPED + bytes(22)) == []
    assert [type(event) for event in events(host, b"\0")] == [Unreadable, Answered]


def test_requests_come_one_at_a_time_and_the_next_waits_for_the_answer():
    device = Device()
    assert events(device, encode_request(Position()) + encode_request(Stop())) == [Position()]
    assert device.unanswered == Position()
    with pytest.raises(LocalProtocolError, match="POSITION is unanswered, so an answer to STOP"):
        device.send(Acknowledged(Op.STOP))
    assert device.send(HERE) == encode_answer(HERE)
    assert events(device) == [Stop()]
    assert device.send(Acknowledged(Op.STOP, Status.ERROR))
    with pytest.raises(LocalProtocolError, match="nothing is owed"):
        device.send(Acknowledged(Op.STOP))


def test_a_device_can_keep_its_answer_back():
    device = Device()
    assert events(device, encode_request(SavePosition())) == [SavePosition()]
    assert device.forget() == SavePosition()
    assert device.forget() is None
    assert events(device, encode_request(Stop())) == [Stop()]


def test_what_is_no_request_gets_no_answer():
    device = Device()
    data = encode_request(MoveRelative(Axes((1,) * 6)))
    spoilt = data[:10] + b"\x55" + data[11:]
    found = events(device, spoilt + STOPPED + encode_request(Stop()))
    assert [type(event) for event in found] == [Unreadable, Unreadable, Stop]
    assert found[0].data == spoilt
    assert found[1] == Unreadable(STOPPED, "an answer, where requests belong")


def test_after_a_loss_of_power_a_device_has_heard_nothing():
    device = Device()
    device.receive_data(encode_request(Stop()) * 2)
    device.discard()
    assert device.buffered == 0
    assert device.next_event() is None


@pytest.mark.parametrize("cut", range(1, 30))
def test_padding_frees_a_device_from_a_frame_that_was_cut_off(cut):
    device = Device()
    device.receive_data(encode_request(MoveRelative(Axes((1,) * 6)))[:cut])
    found = events(device, FLUSH + encode_request(Stop()))
    assert found[-1] == Stop()
    assert all(isinstance(event, Unreadable) for event in found[:-1])


def test_both_ends_can_count_the_check_bytes_into_the_length():
    host, device = Host(counts_check=True), Device(counts_check=True)
    longest = Ping(bytes(range(26)))
    assert events(device, host.send(longest)) == [longest]
    assert events(host, device.send(Pong(longest.payload))) == [
        Answered(longest, Pong(longest.payload))
    ]
    assert [type(event) for event in events(Device(), host.send(Ping(b"much the same")))] == []


@given(
    st.lists(st.sampled_from([0, 0, 0, 1, 125, -125, 240, 700]), min_size=6, max_size=6),
    st.lists(st.sampled_from([0, 63, 700]), min_size=6, max_size=6),
    st.integers(1, 6),
    st.randoms(use_true_random=False),
)
def test_a_motion_that_lost_zeros_is_never_made_whole_by_what_is_sent_behind_it(
    steps, speeds, count, draw
):
    whole = encode_request(MoveRelative(Axes(tuple(steps), tuple(speeds))))
    zeros = [index for index, byte in enumerate(whole) if byte == 0 and index > 2]
    assume(len(zeros) >= 2 * count)
    gone = set(draw.sample(zeros, 2 * count))
    left = bytes(byte for index, byte in enumerate(whole) if index not in gone)
    found = events(Device(), left + FLUSH)
    assert not any(isinstance(event, MoveRelative) for event in found)


def test_what_ends_a_frame_begins_none():
    assert 0xAA not in FLUSH
    assert len(FLUSH) == FRAME_MAX
