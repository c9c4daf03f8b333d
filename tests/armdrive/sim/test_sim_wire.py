"""Bytes arrive on a simulated line no sooner and no later than its baud rate says."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armdrive.sim.wire import PacedDevice, PacedWire

BYTE_S = 10 / 9600


def test_the_last_bit_of_a_line_arrives_ten_bits_a_byte_later():
    wire = PacedWire(9600)
    wire.push(b"@READ\r", 1.0)
    assert wire.next_s() == pytest.approx(1.0 + 6 * BYTE_S, abs=1e-12)
    assert wire.pull(1.0 + 6 * BYTE_S - 1e-5) == b"@READ"
    assert wire.pull(1.0 + 6 * BYTE_S) == b"\r"
    assert math.isinf(wire.next_s())


def test_at_the_very_moment_it_names_everything_is_there():
    for start in (0.0, 0.1, 1e5 + 1 / 3):
        wire = PacedWire(9600)
        wire.push(bytes(37), start)
        assert len(wire.pull(wire.next_s())) == 37


def test_a_second_line_waits_for_the_first():
    wire = PacedWire(9600)
    wire.push(b"ab", 0.0)
    wire.push(b"cd", BYTE_S)
    assert wire.pull(2 * BYTE_S) == b"ab"
    assert wire.next_s() == pytest.approx(4 * BYTE_S, abs=1e-12)


def test_a_pause_holds_for_the_bytes_pushed_with_it():
    wire = PacedWire(9600)
    wire.push(b"a", 0.0)
    wire.push(b"bc", 0.0, 0.01)
    assert wire.pull(BYTE_S) == b"a"
    wire.pull(2 * BYTE_S + 0.01)
    assert wire.next_s() == pytest.approx(3 * BYTE_S + 0.02, abs=1e-12)


def test_what_is_cleared_never_arrives():
    wire = PacedWire(9600)
    wire.push(b"lost", 0.0)
    wire.clear()
    assert wire.pull(1.0) == b""
    wire.push(b"x", 0.0)
    assert wire.pull(BYTE_S) == b"x"


@given(
    lines=st.lists(st.tuples(st.binary(max_size=20), st.floats(0, 0.02)), max_size=8),
    looks=st.lists(st.floats(0, 0.01), max_size=30),
)
def test_nothing_is_lost_reordered_or_early_however_often_one_looks(lines, looks):
    wire, now, sent = PacedWire(9600), 0.0, b""
    for data, pause in lines:
        now += pause
        wire.push(data, now)
        sent += data
    got, at = b"", 0.0
    for pause in looks:
        at += pause
        got += wire.pull(at)
        assert len(got) <= at / BYTE_S + 1e-2
    got += wire.pull(now + len(sent) * BYTE_S + 1e-9)
    assert got == sent


class Echo:
    """A device that repeats a line, a tenth of a second after it has heard its end."""

    byte_gap_s = 0.0

    def __init__(self):
        self.due = []
        self.heard = b""

    def receive(self, data, now_s):
        self.heard += data
        if data.endswith(b"\r"):
            self.due.append((now_s + 0.1, self.heard))
            self.heard = b""

    def transmit(self, now_s):
        said = b"".join(data for at, data in self.due if at <= now_s)
        self.due = [(at, data) for at, data in self.due if at > now_s]
        return said

    def next_s(self):
        return min((at for at, _ in self.due), default=math.inf)


def test_an_answer_is_as_late_as_it_should_be_whoever_looks_when():
    seldom, often = PacedDevice(Echo(), 9600), PacedDevice(Echo(), 9600)
    for line in (seldom, often):
        line.send(b"hell\r", 0.0)
    due = 10 * BYTE_S + 0.1
    assert seldom.receive(due - 1e-5) == b"hell"
    assert seldom.receive(due) == b"\r"
    seen = {}
    for tick in range(200):
        for byte in often.receive(tick / 1000):
            seen[byte] = tick / 1000
    assert due <= seen[ord("\r")] <= due + 0.001


def test_an_unplugged_cable_loses_both_directions():
    line = PacedDevice(Echo(), 9600)
    line.send(b"a\r", 0.0)
    line.advance(0.01)
    line.unplug()
    line.send(b"b\r", 0.02)
    line.replug(0.3)
    assert line.receive(1.0) == b""
    line.send(b"c\r", 1.0)
    assert line.receive(2.0) == b"c\r"
