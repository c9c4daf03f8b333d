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


def listening() -> Adapter:
    adapter = Adapter()
    adapter.receive(b"S6\rL\r")
    assert adapter.say() == b"\r\r"
    return adapter


def troubled(adapter: Adapter, fault: str) -> Adapter:
    setattr(adapter.faults, fault, True)
    return adapter


def restarted() -> Adapter:
    adapter = opened()
    adapter.restart()
    return adapter


MAKERS = {
    "open": opened,
    "closed": Adapter,
    "listening": listening,
    "at another bit rate than the bus": lambda: opened(bus_bitrate=250_000),
    "bus-off": lambda: troubled(opened(), "bus_off"),
    "alone on its bus": lambda: troubled(opened(), "alone"),
    "mute": lambda: troubled(Adapter(), "mute"),
    "dead": lambda: troubled(opened(), "dead"),
    "back with power": restarted,
}
SAID = [
    ("open", b"V", b"V1013\r"),
    ("open", b"N", b"NA123\r"),
    ("open", b"F", b"F00\r"),
    ("open", b"", b"\r"),
    ("open", b"t1232AABB", b"z\r", Frame(0x123, b"\xaa\xbb")),
    ("open", b"T000001230", b"Z\r", Frame(0x123, extended=True)),
    ("open", b"r1230", b"z\r", Frame(0x123, remote=True)),
    ("open", b"t1239", b"\a"),
    ("open", b"Z0", b"\r"),
    ("open", b"Z1", b"\a"),
    ("open", b"O", b"\a"),
    ("open", b"S6", b"\a"),
    ("open", b"C", b"\r"),
    ("open", b"Q", b"\a"),
    ("open", b"d1230", b"\a"),
    ("closed", b"V", b"V1013\r"),
    ("closed", b"C", b"\a"),
    ("closed", b"O", b"\a"),
    ("closed", b"S9", b"\a"),
    ("closed", b"S8", b"\r"),
    ("closed", b"t1230", b"\a"),
    ("closed", b"F", b"\a"),
    ("listening", b"t0010", b"\a"),
    ("at another bit rate than the bus", b"t0010", b"\a"),
    ("bus-off", b"t0010\rF", b"\aFA0\r"),
    ("bus-off", b"C\rO\rt0010", b"\r\rz\r", Frame(1)),  # opened anew, it is back on the bus
    ("alone on its bus", b"t0010\rF", b"\aF20\r"),
    ("mute", b"S6\rO\rt0010\rF\rV", b"V1013\r", Frame(1)),
    ("dead", b"V\rt0010", b""),
    ("back with power", b"O", b"\a"),  # it has forgotten its bit rate
]


@pytest.mark.parametrize(("which", "lines", "answer", "sent"), [(*row, None)[:4] for row in SAID])
def test_an_adapter_answers_and_sends(which, lines, answer, sent):
    adapter = MAKERS[which]()
    assert adapter.receive(lines + b"\r") == ([] if sent is None else [sent])
    assert adapter.say() == answer


@pytest.mark.parametrize("which", MAKERS)
def test_only_an_adapter_that_is_on_the_bus_shows_its_frames(which):
    adapter = MAKERS[which]()
    adapter.show(Frame(6, b"\x33"))
    on_bus = which in ("open", "listening", "alone on its bus")
    assert adapter.say() == (b"t006133\r" if on_bus else b"")
    adapter.receive(b"C\r")
    adapter.say()
    adapter.show(Frame(6))
    assert adapter.say() == b""
