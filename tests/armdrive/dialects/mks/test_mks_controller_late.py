"""A busy computer: what drives have answered in time and was read late is heard all the same."""

from __future__ import annotations

import pytest
from mks_bench import BURSTS, MksBench, along, begun, blamed, ends_well, straight, suspend

from armdrive.tasks import Done, MoveBy, ReadPosition, Registers, SwitchOn
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


def test_a_program_that_stood_still_blames_no_drive_in_motion():
    bench = MksBench().ready()
    bench.begin(along(straight(30)))
    bench.run(0.3)
    suspend(bench, 0.6)
    ends_well(bench)


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


def test_two_drives_of_one_id_are_told_from_one_that_is_late():
    bench = MksBench()
    bench.nodes.append(MksBench(starts=(7000,) * 6).node(2))
    assert "id 2:" in str(bench.do(ReadPosition()))


def test_an_answer_more_now_and_then_is_no_second_drive():
    bench = MksBench(starts=STARTS)
    bench.back.append((0.0001, pack(encode(2, EncoderRead(100)))))
    assert bench.do(ReadPosition()) == Registers(Motors(STARTS))
    assert ReadEncoder().code is Code.ENCODER
