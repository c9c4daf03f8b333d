"""A busy computer: what drives have answered in time and was read late is heard all the same."""

from __future__ import annotations

import mks_bench
import pytest
from mks_bench import BURSTS, MksBench, along, begun, blamed, ends_well, straight, suspend

from armdrive.dialects.bus.ledger import LATE_REPLY_MAX_S, LateReplies
from armdrive.tasks import Done, MoveBy, ProtocolWarning, ReadPosition, Registers, SwitchOn
from firmware_protocol.frames import pack
from firmware_protocol.mks import (
    Code,
    EncoderRead,
    Outcome,
    ReadEncoder,
    Status,
)
from firmware_protocol.mks.answers import encode
from kinematics import Motors

STARTS = (0, 100, -200, 4000, 5, 16384)


@pytest.mark.parametrize("every_s", [0.04, 0.06, 0.2])
@pytest.mark.parametrize("request_", [ReadPosition(), SwitchOn()])
def test_a_program_that_is_always_late_hears_all_drives(every_s, request_):
    bench = MksBench(starts=STARTS)
    bench.begin(request_)
    for _ in range(40):
        suspend(bench, every_s)
        if (reply := bench.reply()) is not None:
            break
    assert str(reply) in ("done", str(Registers(Motors(STARTS))))


@pytest.mark.parametrize("late_s", [0.06, 0.12, 0.3])
def test_late_answers_are_not_taken_for_those_of_a_second_drive(late_s):
    bench = MksBench(starts=STARTS)
    answer = bench._answer

    def later(said):
        if said:
            bench.at_s[bench.now_s + late_s + 1e-6 * len(bench.at_s)] = lambda: answer(said)

    bench._answer = later
    bench.begin(ReadPosition())
    bench.run(1.5)
    bench._answer = answer
    assert bench.finish() == Registers(Motors(STARTS))


def send_late(bench, for_s):
    """Have the thread stand still as it writes: what it says comes late, and so does it itself."""
    said = len(bench.sent)
    while len(bench.sent) == said:
        bench._step(bench.now_s + 1.0)
    bench.to[:] = [(at_s + for_s, data) for at_s, data in bench.to]
    suspend(bench, for_s)


@pytest.mark.parametrize("for_s", [0.1, 0.2, 0.3, 0.45])
@pytest.mark.parametrize("after_s", [0.0, 0.01, 0.3, 0.31, 0.42])
def test_a_thread_that_stands_still_as_it_writes_blames_no_drive(after_s, for_s):
    way = (6000, -3000, 1500, 0, 700, 20)
    bench = begun(straight(20, way), after_s)
    send_late(bench, for_s)
    ends_well(bench)
    assert (bench.positions - Motors(50_000 + 20 * each for each in way)).largest <= 8


def test_a_drive_that_is_blocked_is_called_so_after_a_late_wake_as_well():
    bench = begun(straight(20), 0.3)
    bench.node(3).block(bench.now_s)
    send_late(bench, 0.3)
    blamed(bench, "drive 3 (elbow)")
    assert bench.now_s < 2.0


@pytest.mark.parametrize("settings", [{}, BURSTS])
@pytest.mark.parametrize("watchdog_s", [0.0, 0.5])
@pytest.mark.parametrize("way", [9000, 60_000])
def test_a_thread_that_stands_still_at_the_end_blames_no_drive(way, watchdog_s, settings):
    bench = MksBench(starts=(50_000,) * 6, settings={**settings, "watchdog_s": watchdog_s}).ready()
    move = MoveBy(Motors((way, -3000, 0, 0, 0, 0)), 30_000.0)
    bench.begin(move if settings else along([move]))
    bench.run(0.2)
    suspend(bench, 6.0)
    ends_well(bench)


def test_a_late_answer_to_setting_the_watchdog_is_not_its_value():
    bench = MksBench()
    bench.do(ReadPosition())
    hear, told = bench.node(3).hear, []

    def late(asked, now_s):
        if asked.can_id == 3 and asked.data[0] == Code.READ_SETTING and not told:
            told.append(pack(encode(3, Status(Code.WATCHDOG, Outcome.DONE))))
            return [told[0], *hear(asked, now_s)]
        return hear(asked, now_s)

    bench.node(3).hear = late
    assert isinstance(bench.do(SwitchOn()), Done)
    assert told
    assert bench.controller.watched


def test_an_answer_more_now_and_then_is_no_second_drive():
    bench = MksBench(starts=STARTS)
    bench.back.append((0.0001, pack(encode(2, EncoderRead(100)))))
    assert bench.do(ReadPosition()) == Registers(Motors(STARTS))
    assert ReadEncoder().code is Code.ENCODER


# -- what is no oddity, and what is one ------------------------------------------------------------

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
