"""The board's machine alone, and both machines wired to each other, whatever the wire does."""

import random

import pytest
from chunks import carried, events
from grbl_strategies import COMMANDS
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import grbl
from firmware_protocol.errors import LocalProtocolError

X1 = grbl.Line("G90G1X1F100")
TEXT = X1.text
NOISE = st.binary(min_size=1, max_size=300)


def lines(found) -> list:
    return [event for event in found if isinstance(event, grbl.LineReceived)]


def test_realtime_commands_come_out_of_the_middle_of_a_line_at_once():
    device = grbl.Device(grbl.MEGA_5X)
    device.receive_data(b"$X\nG90G1?X1")
    assert events(device) == [
        grbl.LineReceived("$X", grbl.Unlock()),
        grbl.RealtimeReceived(grbl.Realtime.STATUS),
    ]
    device.receive_data(b"!F\x18100\n")
    found = events(device)
    assert [event.command for event in found[:2]] == [
        grbl.Realtime.FEED_HOLD,
        grbl.Realtime.SOFT_RESET,
    ]
    assert found[2] == grbl.LineReceived(TEXT, grbl.parse_line(TEXT, grbl.MEGA_5X))


def test_a_stream_is_parted_into_realtime_commands_and_the_rest():
    commands = (grbl.Realtime.STATUS, grbl.Realtime.JOG_CANCEL, grbl.Realtime.FEED_PLUS_10)
    assert grbl.split_realtime(b"G1?X\x85\xff1\x91\n") == (commands, b"G1X1\n")
    assert grbl.split_realtime(b"\x19\x80G\n") == ((), b"\x19G\n")
    both = (grbl.Realtime.STOP, grbl.Realtime.STATUS_ALIAS)
    assert grbl.split_realtime(b"\x19\x80G\n", grblhal=True) == (both, b"G\n")


@pytest.mark.parametrize("command", grbl.Realtime)
def test_every_realtime_command_arrives_where_the_firmware_has_it(command):
    for dialect in (grbl.MEGA_5X, grbl.GRBLHAL):
        device = grbl.Device(dialect)
        device.receive_data(grbl.Host().send_realtime(command))
        known = dialect is grbl.GRBLHAL or command not in grbl.GRBLHAL_ONLY
        assert events(device) == ([grbl.RealtimeReceived(command)] if known else [])


def test_each_line_is_answered_once():
    device = grbl.Device(grbl.MEGA_5X)
    with pytest.raises(LocalProtocolError, match="no line is unanswered"):
        device.send(grbl.Ok())
    device.receive_data(b"\nG5\n?")
    assert lines(events(device))[0] == grbl.LineReceived("", grbl.Empty())
    assert device.unanswered == 2
    assert device.send(grbl.Ok()) == b"ok\r\n"
    assert device.send(grbl.Feedback("Pgm End")) == b"[MSG:Pgm End]\r\n"
    assert device.send(grbl.Error(20)) == b"error:20\r\n"
    with pytest.raises(LocalProtocolError):
        device.send(grbl.Error(20))


def test_after_a_banner_nothing_is_owed_and_discarded_bytes_are_gone():
    device = grbl.Device(grbl.MEGA_5X)
    device.receive_data(b"G0\nG1\nG")
    device.next_event()
    device.discard()
    assert (device.unanswered, device.buffered, events(device)) == (0, 0, [])
    device.receive_data(b"$X\n")
    device.next_event()
    assert device.send(grbl.Banner()) == b"\r\nGrbl 1.1h ['$' for help]\r\n"
    assert device.unanswered == 0


def test_a_line_that_is_too_long_is_refused_with_error_11():
    device = grbl.Device(grbl.MEGA_5X)
    for _ in range(1000):
        device.receive_data(b"X" * 100)
        assert device.buffered <= 79
    device.receive_data(b"\n" + TEXT.encode() + b"\n")
    first, second = events(device)
    assert (first.content.code, second.text) == (11, TEXT)


def test_a_flood_that_nobody_fetches_is_bounded_and_told():
    device = grbl.Device(grbl.MEGA_5X)
    for _ in range(2000):
        device.receive_data(b"G0\n?")
    assert device.buffered <= 512 * 80
    found = events(device)
    assert len(found) <= 1024
    assert [
        event.content.reason for event in lines(found) if isinstance(event.content, grbl.Rejected)
    ] == ["256 lines were waiting: from here on they are lost"]


@given(st.lists(st.tuples(COMMANDS, st.booleans()), max_size=6), st.data())
def test_every_script_arrives_whole_at_both_ends(script, data):
    host, device = grbl.Host(grbl.MEGA_5X), grbl.Device(grbl.MEGA_5X)
    for command, taken in script:
        (line,) = carried(data.draw, host.send(command), device)
        assert (line.text, line.content) == (
            command.text,
            grbl.parse_line(command.text, grbl.MEGA_5X),
        )
        (event,) = carried(data.draw, device.send(grbl.Ok() if taken else grbl.Error(9)), host)
        assert isinstance(event, grbl.Acknowledged if taken else grbl.Refused)
        assert event.command == command
    assert (host.outstanding_lines, device.unanswered) == ((), 0)


@given(st.lists(COMMANDS, max_size=12), st.integers(0, 1000))
def test_lines_that_are_streamed_never_overfill_the_ring_and_keep_their_order(script, seed):
    host, device, rng = grbl.Host(grbl.MEGA_5X), grbl.Device(grbl.MEGA_5X), random.Random(seed)
    in_ring, answered = 0, []
    waiting = list(script)
    while len(answered) < len(script):
        if waiting and host.room_for(waiting[0]) and rng.random() < 0.8:
            sent = host.send(waiting.pop(0))
            in_ring += len(sent)
            assert in_ring == host.outstanding_bytes < 255
            device.receive_data(sent)
        elif (line := device.next_event()) is not None:
            in_ring -= len(line.text) + 1
            host.receive_data(device.send(grbl.Ok()))
            answered += events(host)
        elif waiting:
            assert host.room_for(waiting[0])
    assert [event.command for event in answered] == script


def _all_of(stream: bytes) -> list:
    device = grbl.Device(grbl.GRBLHAL)
    device.receive_data(stream)
    return events(device)


@given(NOISE, st.data())
def test_after_noise_both_ends_understand_at_the_next_line_end(noise, data):
    host, device = grbl.Host(grbl.MEGA_5X), grbl.Device(grbl.MEGA_5X)
    carried(data.draw, noise + b"\n", device)
    (line,) = carried(data.draw, host.send(X1), device)
    assert line.text == TEXT
    assert all(
        isinstance(event, grbl.Unreadable | grbl.Acknowledged | grbl.Stray)
        for event in carried(
            data.draw, b"\xff" + noise.replace(b"\n", b"").replace(b"\r", b""), host
        )
    )
    found = carried(data.draw, b"\nok\r\n", host)
    assert grbl.Acknowledged(X1) in found
