"""The simulated serial CAN adapter: its lines, what it answers, and what it refuses."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_can_wire import frames

from armdrive.sim.serving.servers import Adapter
from firmware_protocol.frames import LONGEST, Frame, SlcanLines, frame_of, line_of

LINES = [
    (Frame(0x7FF, bytes.fromhex("01F601403A")), b"t7FF501F601403A\r"),
    (Frame(0), b"t0000\r"),
    (Frame(1, b"", remote=True), b"r0010\r"),
    (Frame(0x1ABCDEF0, b"\xff", extended=True), b"T1ABCDEF01FF\r"),
    (Frame(5, extended=True, remote=True), b"R000000050\r"),
]


@pytest.mark.parametrize(("frame", "line"), LINES)
def test_frames_are_written_and_read_as_lawicel_does(frame, line):
    assert line_of(frame) == line
    assert frame_of(line.rstrip()) == frame


@given(frames())
def test_what_is_written_is_read(frame):
    assert frame_of(line_of(frame).rstrip()) == frame
    line = line_of(frame).rstrip()
    assert frame_of(line[:1] + line[1:].lower()) == frame
    assert frame_of(line + b"1A2B") == frame


@pytest.mark.parametrize(
    "line",
    [b"", b"t", b"t8000", b"t0019", b"t0012AB", b"t00g0", b"T200000000", b"x0010", b"t00100"],
)
def test_what_is_no_frame_is_none(line):
    assert frame_of(line) is None


@given(st.lists(st.binary(max_size=20)))
def test_garbage_never_raises_neither_in_lines_nor_in_the_adapter(pieces):
    lines, adapter = SlcanLines(), opened()
    for piece in pieces:
        for line in lines.feed(piece):
            frame_of(line)
        adapter.receive(piece)
        adapter.say()


@given(st.lists(frames(), max_size=5), st.integers(1, 9))
def test_lines_are_the_same_in_any_chunks(sent, size):
    text = b"".join(map(line_of, sent))
    lines = SlcanLines()
    chunks = [text[at : at + size] for at in range(0, len(text), size)]
    heard = [frame_of(line) for chunk in chunks for line in lines.feed(chunk)]
    assert heard == sent


def test_noise_without_an_end_is_forgotten_and_the_next_line_is_read():
    lines = SlcanLines()
    for _ in range(10):
        assert lines.feed(b"?" * LONGEST) == []
    assert lines.feed(b"\rt0010\r") == [b"t0010"]


def opened(**settings) -> Adapter:
    adapter = Adapter(**settings)
    adapter.receive(b"S6\rO\r")
    assert adapter.say() == b"\r\r"
    return adapter


ANSWERS = [
    (b"V", b"V1013\r"),
    (b"N", b"NA123\r"),
    (b"F", b"F00\r"),
    (b"", b"\r"),
    (b"t1232AABB", b"z\r"),
    (b"T000001230", b"Z\r"),
    (b"r1230", b"z\r"),
    (b"t1239", b"\a"),
    (b"Z0", b"\r"),
    (b"Z1", b"\a"),
    (b"O", b"\a"),
    (b"S6", b"\a"),
    (b"C", b"\r"),
    (b"Q", b"\a"),
    (b"d1230", b"\a"),
]


@pytest.mark.parametrize(("order", "answer"), ANSWERS, ids=repr)
def test_an_open_adapter_answers(order, answer):
    adapter = opened()
    adapter.receive(order + b"\r")
    assert adapter.say() == answer


CLOSED = [(b"V", b"V1013\r"), (b"C", b"\a"), (b"O", b"\a"), (b"S9", b"\a"), (b"S8", b"\r")]


@pytest.mark.parametrize(("order", "answer"), [*CLOSED, (b"t1230", b"\a"), (b"F", b"\a")])
def test_a_closed_adapter_answers(order, answer):
    adapter = Adapter()
    assert adapter.receive(order + b"\r") == []
    assert adapter.say() == answer


def test_frames_pass_both_ways_once_it_is_open():
    adapter = opened()
    assert adapter.receive(b"t00521122\r") == [Frame(5, b"\x11\x22")]
    adapter.say()
    adapter.show(Frame(6, b"\x33"))
    assert adapter.say() == b"t006133\r"
    adapter.receive(b"C\r")
    adapter.say()
    adapter.show(Frame(6))
    assert adapter.say() == b""


def test_a_listener_hears_and_may_not_send():
    adapter = Adapter()
    adapter.receive(b"S6\rL\r")
    adapter.say()
    assert adapter.receive(b"t0010\r") == []
    assert adapter.say() == b"\a"
    adapter.show(Frame(1))
    assert adapter.say() == b"t0010\r"


@pytest.mark.parametrize("fault", ["bus_off", "alone"])
def test_a_bus_in_trouble_refuses_frames_and_says_so(fault):
    adapter = opened()
    setattr(adapter.faults, fault, True)
    assert adapter.receive(b"t0010\rF\r") == []
    refused, status = adapter.say().split(b"F")
    assert refused == b"\a"
    assert int(status, 16) & 0x20


def test_at_a_wrong_bit_rate_nothing_passes():
    adapter = opened(bus_bitrate=250_000)
    assert adapter.receive(b"t0010\r") == []
    assert adapter.say() == b"\a"
    adapter.show(Frame(1))
    assert adapter.say() == b""


def test_a_mute_adapter_tells_its_version_and_frames_alone():
    adapter = Adapter()
    adapter.faults.mute = True
    assert adapter.receive(b"S6\rO\rt0010\rF\rV\r") == [Frame(1)]
    assert adapter.say() == b"V1013\r"


def test_a_dead_one_says_nothing_at_all():
    adapter = opened()
    adapter.faults.dead = True
    assert adapter.receive(b"V\rt0010\r") == []
    adapter.show(Frame(1))
    assert adapter.say() == b""


def test_closing_and_opening_brings_a_controller_back_to_the_bus():
    adapter = opened()
    adapter.faults.bus_off = True
    adapter.receive(b"C\rO\r")
    adapter.say()
    assert adapter.receive(b"t0010\r") == [Frame(1)]


def test_without_power_it_forgets_that_it_was_open():
    adapter = opened()
    adapter.restart()
    adapter.receive(b"O\r")
    assert adapter.say() == b"\a"
