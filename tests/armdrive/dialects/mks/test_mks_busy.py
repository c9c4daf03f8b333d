"""A busy computer: replies that came in time and are read late still count."""

from __future__ import annotations

import random
from functools import partial

import pytest
from amounts import amount, each_value
from driver_bench import ANSWERS, BOTH, ORDERS
from mks_bench import (
    BURSTS,
    FAR_FROM_ZERO,
    MksBench,
    along,
    begun,
    check_blamed,
    check_done,
    segments,
    send_late,
    straight,
    total,
)

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


@each_value("every_s, request_", [0.04, 0.06, 0.2], [ReadPosition(), SwitchOn()])
def test_a_program_that_is_always_late_reads_all_replies(every_s, request_):
    bench = MksBench(starts=STARTS)
    bench.begin(request_)
    for _ in range(40):
        bench.suspend(every_s)
        bench.run(1e-6)
        if (reply := bench.reply()) is not None:
            break
    assert str(reply) in ("done", str(Registers(Motors(STARTS))))


@pytest.mark.parametrize("late_s", [0.06, 0.12, 0.3])
def test_late_answers_are_not_taken_for_those_of_a_second_drive(late_s):
    bench = MksBench(starts=STARTS)
    bench.waits_s = lambda _frame, host: 0.0 if host else late_s
    bench.begin(ReadPosition())
    bench.run(1.5)
    bench.waits_s = lambda _frame, _host: 0.0
    assert bench.finish() == Registers(Motors(STARTS))


# -- nobody is to blame --------------------------------------------------------------------------

NEAR_ZERO = (-2000, 0, 0, 0, 0, 0)
FAST, CREEPING = (9000, -3000, 0, 0, 0, 0), (300, -100, 0, 0, 0, 0)
CORNER = segments(*([(6000, 3000, 0, 0, 0, 0)] * 8 + [(-6000, 3000, 0, 0, 0, 0)] * 8))
held, suspended = MksBench.delay_frames, MksBench.suspend
HOLD_UPS = [partial(held, sides=sides) for sides in (BOTH, ORDERS, ANSWERS)]
BURST = MoveBy(Motors((30_000, -9000, 0, 0, 0, 0)), 30_000.0)


def comes_through(moves, late, for_s, after_s, **begins):
    """Have something be late in a motion, which ends well and where it should."""
    bench = begun(moves, 0.0, **begins)
    start = bench.positions
    bench.run(after_s)
    late(bench, for_s)
    check_done(bench)
    assert (bench.positions - start - total(moves)).largest <= 8


@each_value(
    "late, for_s, after_s",
    [*HOLD_UPS, send_late, suspended],
    [0.12, 0.45],
    [0.01, 0.42, 0.9],
)
def test_a_short_outage_of_bus_or_program_blames_no_drive(late, for_s, after_s):
    comes_through(straight(10), late, for_s, after_s)


LATE = [
    *((straight(10), late, 0.9, after_s, {}) for late in HOLD_UPS for after_s in (0.01, 0.9)),
    *((CORNER, suspended, for_s, 0.5, {}) for for_s in (0.2, 0.5, 0.6)),
    *((straight(20, (2500, 400, 0, 0, 0, 0)), suspended, for_s, 0.12, {"starts": NEAR_ZERO})
      for for_s in (0.1, 0.15, 0.3)),
    # it is late before its slow end, with so little sent ahead that it stands meanwhile
    *((segments(*([FAST] * 6 + [CREEPING] * tail)), partial(held, sides=sides), 0.05, after_s,
       {"ahead_s": 0.06, "segment_s": 0.02})
      for tail, after_s in ((0, 0.48), (1, 0.52), (6, 0.5))
      for sides in (BOTH, ORDERS)),
]  # fmt: skip


@pytest.mark.parametrize(("moves", "late", "for_s", "after_s", "begins"), LATE[:: amount(2, 1)])
def test_a_short_outage_in_other_motions_blames_no_drive(moves, late, for_s, after_s, begins):
    comes_through(moves, late, for_s, after_s, **begins)


@each_value("late, for_s", HOLD_UPS, [0.2, 0.9])
def test_a_burst_is_waited_for(for_s, late):
    bench = MksBench(starts=FAR_FROM_ZERO, settings=BURSTS).ready()
    bench.begin(BURST)
    bench.run(0.2)
    late(bench, for_s)
    check_done(bench)


@each_value("settings, watchdog_s, way", [{}, BURSTS], [0.0, 0.5], [9000, 60_000])
def test_a_program_that_is_suspended_at_the_end_blames_no_drive(way, watchdog_s, settings):
    bench = MksBench(starts=FAR_FROM_ZERO, settings={**settings, "watchdog_s": watchdog_s}).ready()
    move = MoveBy(Motors((way, -3000, 0, 0, 0, 0)), 30_000.0)
    bench.begin(move if settings else along([move]))
    bench.run(0.2)
    bench.suspend(6.0)
    check_done(bench)


SPEEDS = (9000, -6000, 3000, -1000, 300, 0)


def there_and_back(_):
    way = (9000, -4500, 700, 0, 0, 0)
    return [way] * 12 + [tuple(-each for each in way)] * 12


def of_many_speeds(dice):
    speeds = [dice.choice((1.0, 0.1, -1.0, -0.3)) for _ in range(5)]
    return [(round(6000 * s), round(-3000 * s), 700, 0, 0, 0) for s in speeds for _ in range(5)]


def of_all_motors(dice):
    ways = [tuple(dice.choice(SPEEDS) for _ in range(6)) for _ in range(3)]
    return [way for way in ways for _ in range(6)]


RANDOM = [
    (there_and_back, (0.0, 0.4), (0.0, 0.3), [*HOLD_UPS, suspended]),
    (of_many_speeds, (0.0, 0.3), (0.0, 0.2), [*HOLD_UPS, suspended]),
    (of_all_motors, (0.005, 0.06), (0.005, 0.08), [suspended]),
]


@pytest.mark.parametrize("seed", range(amount(2, 20)))
@pytest.mark.parametrize(("ways", "well_s", "late_s", "lates"), RANDOM)
def test_repeated_delays_make_no_drive_seem_elsewhere(seed, ways, well_s, late_s, lates):
    dice = random.Random(seed)
    bench = begun(segments(*ways(dice)))
    while bench.controller.busy and bench.now_s < 60.0:
        bench.run(dice.uniform(*well_s))
        dice.choice(lates)(bench, dice.uniform(*late_s))
    check_done(bench)


def test_a_blocked_drive_is_found_although_the_program_was_late():
    bench = begun(straight(20), 0.3)
    bench.node(3).block()
    send_late(bench, 0.3)
    check_blamed(bench, "drive 3 (elbow)")
    assert bench.now_s < 2.0


def test_a_late_answer_to_setting_the_watchdog_is_not_its_value():
    bench = MksBench()
    bench.do(ReadPosition())
    late = []

    def loses(frame, host):
        if host and frame.can_id == 3 and frame.data[0] == Code.READ_SETTING and not late:
            late.append(pack(encode(3, Status(Code.WATCHDOG, Outcome.DONE))))
            bench.say(*late)
        return False

    bench.loses = loses
    assert isinstance(bench.do(SwitchOn()), Done)
    assert late
    assert bench.controller.watched


def test_an_occasional_surplus_answer_is_no_second_drive():
    bench = MksBench(starts=STARTS)
    bench.say(pack(encode(2, EncoderRead(100))))
    assert bench.do(ReadPosition()) == Registers(Motors(STARTS))
    assert ReadEncoder().code is Code.ENCODER


# -- what is no oddity, and what is one ------------------------------------------------------------

WAY = (3000, -1500, 700, 0, 300, 20)


def oddities(bench):
    return [event.text for event in bench.heard if isinstance(event, ProtocolWarning)]


@each_value("settings, wire_s", [{}, BURSTS], [0.002, 0.008])
def test_a_slow_wire_causes_no_warning(wire_s, settings):
    bench = MksBench(starts=FAR_FROM_ZERO, settings=settings).ready()
    bench.heard.clear()
    bench.waits_s = lambda frame, host: wire_s * (frame.can_id if host else 1)
    moves = straight(10, WAY)
    assert isinstance(bench.do(MoveBy(total(moves), 30_000.0) if settings else along(moves)), Done)
    assert not oddities(bench)


@pytest.mark.parametrize("every_s", [0.07, 0.15])
def test_a_program_that_is_sometimes_late_causes_no_warning(every_s):
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    bench.heard.clear()
    bench.begin(along(straight(12, WAY)))
    for _ in range(4):
        bench.run(0.15)
        bench.suspend(every_s)
    assert isinstance(bench.finish(), Done)
    assert not oddities(bench)


def test_an_unexpected_answer_causes_a_warning():
    bench = MksBench().ready()
    bench.heard.clear()
    bench.say(*[pack(encode(2, EncoderRead(0)))] * 2)
    bench.do(ReadPosition())
    assert any("drive 2 answered twice" in text for text in oddities(bench))


def test_a_failed_report_next_to_a_new_target_belongs_to_the_old_one():
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    bench.heard.clear()
    began_s = bench.now_s
    bench.begin(along(straight(10, WAY)))
    bench.run(0.3)
    node = bench.node(2)
    bench.say(pack(node.sim.device.tell(node.sim.motion.under_way, Outcome.FAILED)))
    assert isinstance(bench.finish(), Done)
    assert not oddities(bench)
    asked_s = [at_s for at_s, frame in bench.sent if frame.data[0] == Code.STALL]
    assert max(asked_s) < began_s  # it was no reason to ask whether the drive has stalled


@pytest.mark.parametrize(
    ("late_s", "sides"), [(0.02, ANSWERS), (0.025, ANSWERS), (0.04, BOTH), (0.08, ANSWERS)]
)
def test_an_outage_ends_also_if_every_reply_is_late_afterwards(late_s, sides):
    moves = [MoveBy(Motors(WAY), 3000.0)] * 2
    bench = begun(moves, 0.5)
    bench.delay_frames(0.4)
    bench.run(0.4)
    bench.waits_s = lambda _frame, host: late_s if host in sides else 0.0
    assert bench.finish() == Done()
    assert bench.positions - Motors(FAR_FROM_ZERO) == total(moves)
    assert not bench.alerts()
