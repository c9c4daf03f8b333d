"""Answers that come late are no oddity; answers that nobody asked for are one."""

from __future__ import annotations

import mks_bench
import pytest
from mks_bench import BURSTS, MksBench, along, straight, suspend

from armdrive.dialects.bus.ledger import LATE_REPLY_MAX_S, LateReplies
from armdrive.tasks import Done, MoveBy, ProtocolWarning, ReadPosition
from firmware_protocol.frames import pack
from firmware_protocol.mks import Code, EncoderRead, Outcome
from firmware_protocol.mks.answers import encode
from kinematics import Motors

WAY = (3000, -1500, 700, 0, 300, 20)


def oddities(bench):
    return [event.text for event in bench.heard if isinstance(event, ProtocolWarning)]


def test_one_late_answer_is_expected_for_each_question_that_was_given_up():
    owed = LateReplies()
    owed.give_up(2, 0x31, 1.0)
    assert not owed.takes(3, 0x31, 1.1)
    assert not owed.takes(2, 0xF1, 1.1)
    assert owed.takes(2, 0x31, 1.1)
    assert not owed.takes(2, 0x31, 1.1)


def test_nothing_is_late_for_ever():
    owed = LateReplies()
    owed.give_up(2, 0x31, 1.0)
    assert not owed.takes(2, 0x31, 1.1 + LATE_REPLY_MAX_S)


@pytest.mark.parametrize("settings", [{}, BURSTS])
@pytest.mark.parametrize("wire_s", [0.002, 0.005, 0.008])
def test_a_slow_wire_is_no_oddity(wire_s, settings, monkeypatch):
    monkeypatch.setattr(mks_bench, "WIRE_S", wire_s)
    bench = MksBench(starts=(50_000,) * 6, settings=settings).ready()
    bench.heard.clear()
    burst = MoveBy(Motors([20 * each for each in WAY]), 30_000.0)
    assert isinstance(bench.do(burst if settings else along(straight(20, WAY))), Done)
    assert not oddities(bench)


@pytest.mark.parametrize("every_s", [0.07, 0.15])
def test_a_program_that_is_late_now_and_then_finds_no_oddity(every_s):
    bench = MksBench(starts=(50_000,) * 6).ready()
    bench.heard.clear()
    bench.begin(along(straight(20, WAY)))
    for _ in range(8):
        bench.run(0.15)
        suspend(bench, every_s)
    assert isinstance(bench.finish(), Done)
    assert not oddities(bench)


def test_an_answer_that_nobody_asked_for_is_told():
    bench = MksBench().ready()
    bench.heard.clear()
    bench.back += [(bench.now_s, pack(encode(2, EncoderRead(0)))) for _ in range(2)]
    bench.do(ReadPosition())
    assert any("drive 2 answered twice" in text for text in oddities(bench))


def test_one_failure_beside_a_new_target_is_the_old_one_and_stops_no_steering():
    bench = MksBench(starts=(50_000,) * 6).ready()
    bench.heard.clear()
    began_s = bench.now_s
    bench.begin(along(straight(10, WAY)))
    bench.run(0.3)
    node = bench.node(2)
    bench._answer([node.sim.device.tell(node.sim.motion.under_way, Outcome.FAILED)])
    assert isinstance(bench.finish(), Done)
    assert not oddities(bench)
    asked_s = [at_s for at_s, frame in bench.sent if frame.data[0] == Code.STALL]
    assert max(asked_s) < began_s  # it was no reason to ask whether the drive has stalled
