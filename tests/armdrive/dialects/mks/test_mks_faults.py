"""What goes wrong in a motion of MKS drives: which faults end it, and which delays do not.

A fault ends it with all drives at rest, an error that names the drive, and no order that a drive
with a new zero could obey. A delay of the bus or of this program ends none.
"""

from __future__ import annotations

import re
from functools import partial

import pytest
from amounts import each_value, every_row
from driver_bench import ANSWERS, BOTH, ORDERS
from mks_bench import (
    AHEAD_S,
    BURSTS,
    FAR_FROM_ZERO,
    MksBench,
    along,
    begun,
    check_blamed,
    check_done,
    check_halted,
    requests,
    restart,
    segments,
    send_late,
    straight,
    total,
)

from armdrive.tasks import (
    AlertKind,
    Done,
    MoveAlong,
    MoveBy,
    ProtocolWarning,
    ReadPosition,
    Registers,
    RequestRejected,
    Timeout,
)
from firmware_protocol.frames import pack
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    LATEST,
    Code,
    EncoderRead,
    Mode,
    MoveAbsoluteAxis,
    Outcome,
    Stop,
    encode,
)
from kinematics import Motors

NEAR_ZERO = (-2000, 0, 0, 0, 0, 0)
BURST = MoveBy(Motors((30_000, -9000, 0, 0, 0, 0)), 30_000.0)
held, suspended = MksBench.delay_frames, MksBench.suspend
HELD_UP = [partial(held, sides=sides) for sides in (BOTH, ORDERS, ANSWERS)]


# -- delays are nobody's fault ---------------------------------------------------------------------


@each_value(
    "late, for_s, after_s, starts",
    [*HELD_UP, send_late, suspended],
    [0.12, 0.9, 0.3],
    [0.01, 0.42, 0.9],
    [FAR_FROM_ZERO, NEAR_ZERO],
)
def test_a_delay_of_the_bus_or_the_program_ends_no_motion(late, for_s, after_s, starts):
    slow = straight(20, (2500, 400, 0, 0, 0, 0))
    bench = begun(slow, 0.0, starts=starts)
    start = bench.positions
    bench.run(after_s)
    late(bench, for_s)
    check_done(bench)
    assert (bench.positions - start - total(slow)).largest <= 8


@each_value("late, for_s", [*HELD_UP, suspended], [0.2, 0.9])
def test_a_late_bus_or_program_ends_no_burst(for_s, late):
    bench = MksBench(starts=FAR_FROM_ZERO, settings=BURSTS).ready()
    bench.begin(BURST)
    bench.run(0.2)
    late(bench, for_s)
    check_done(bench)


@each_value("settings, watchdog_s, way", [{}, BURSTS], [0.0, 0.5], [9000, 60_000])
def test_a_program_that_is_suspended_at_the_end_ends_no_motion(way, watchdog_s, settings):
    bench = MksBench(starts=FAR_FROM_ZERO, settings={**settings, "watchdog_s": watchdog_s}).ready()
    move = MoveBy(Motors((way, -3000, 0, 0, 0, 0)), 30_000.0)
    bench.begin(move if settings else along([move]))
    bench.run(0.2)
    bench.suspend(6.0)
    check_done(bench)


@pytest.mark.parametrize("late_s", [0.02, 0.09, 0.2])
@pytest.mark.parametrize("sides", [ORDERS, ANSWERS])
def test_a_link_that_becomes_slow_in_motion_ends_none(late_s, sides):
    bench = begun(straight(10), 0.3, starts=NEAR_ZERO)
    bench.waits_s = lambda _frame, host: late_s * (host in sides)
    check_done(bench)


@each_value("seed, starts", [0, 1, 2], [(-9000, 60_000, 20_000, 0, 0, 0), FAR_FROM_ZERO])
def test_single_lost_frames_end_no_motion_and_lose_no_steps(seed, starts):
    bench, moves = MksBench(starts=starts).ready(), straight(10, (3000, 1500, -700, 0, 0, 0))
    lost = iter(range(seed, 10_000))
    bench.loses = lambda _frame, _host: next(lost) % 13 == 0
    bench.begin(along(moves))
    check_done(bench)
    assert (bench.positions - Motors(starts) - total(moves)).largest <= 8


@pytest.mark.parametrize("superseded", ["first", "last", "never"])
def test_the_failure_of_a_replaced_order_is_none_of_the_new_one(superseded):
    bench = begun(straight(10), 0.1)
    for node in bench.nodes:
        object.__setattr__(node.sim.quirks, "superseded", superseded)
    bench.run(0.2)
    node = bench.node(2)
    bench.say(pack(node.sim.device.tell(node.sim.motion.under_way, Outcome.FAILED)))
    check_done(bench)
    assert not [event for event in bench.heard if isinstance(event, ProtocolWarning)]


@each_value("every_s, moves", [0.07, 0.15], [False, True])
def test_a_program_that_is_always_late_reads_all_replies(every_s, moves):
    bench = MksBench().ready()
    bench.begin(along(straight(6)) if moves else ReadPosition())
    for _ in range(100):
        bench.suspend(every_s)
        bench.run(1e-6)
        if (reply := bench.reply()) is not None:
            break
    assert isinstance(reply, Done | Registers)
    assert not bench.alerts()


def test_one_odd_reading_that_comes_twice_is_no_proof():
    bench = begun(straight(10), 0.3)
    odd = pack(encode(1, EncoderRead(COUNTS_PER_TURN)))
    bench.say(odd, odd)
    check_done(bench)


# -- silence ---------------------------------------------------------------------------------------


@each_value("sides, settings", [BOTH, ORDERS, ANSWERS], [{}, BURSTS])
def test_a_long_outage_ends_the_motion_and_blames_no_drive(sides, settings):
    bench = MksBench(starts=NEAR_ZERO, settings=settings).ready()
    bench.begin(BURST if settings else along(straight(30)))
    bench.run(0.2)
    bench.delay_frames(1.6, sides)
    reply = bench.finish()
    assert isinstance(reply, Timeout | RequestRejected)
    assert isinstance(reply, Timeout) or (reply.silent and reply.reason.startswith("the drives"))
    assert not bench.alerts()
    bench.run(1.0)
    bench.check_stands()


def test_no_drive_gets_a_target_while_one_owes_replies():
    """So the others are soon where the silent one stands, at its last target."""
    bench = begun(straight(30), 0.5)
    bench.node(1).mute = True
    began_s = bench.now_s
    bench.finish()
    assert not requests(bench, MoveAbsoluteAxis, since_s=began_s + 0.16)
    ahead = (bench.positions[1] - 50_000) / -3000 - (bench.positions[0] - 50_000) / 6000
    assert abs(ahead) * 0.1 < 0.25


@pytest.mark.parametrize(
    ("mute", "words"),
    [(True, r"drive 1 \(base\) does not answer"), (False, "drive 1 .*did not answer for a while")],
)
def test_a_drive_that_falls_silent_is_named(mute, words):
    bench = begun(straight(30, (300, -100, 0, 0, 0, 0)), 0.3, starts=NEAR_ZERO)
    bench.node(1).mute = True
    if not mute:
        bench.at_s[bench.now_s + 1.05] = lambda: setattr(bench.node(1), "mute", False)
    reply = bench.finish()
    assert isinstance(reply, RequestRejected)
    assert reply.silent
    assert re.search(words, reply.reason)


def test_a_silent_bus_is_silence_before_in_and_after_a_motion():
    bench = MksBench().ready()
    assert isinstance(bench.do(along(straight(4))), Done)
    targets = " ".join(map(str, bench.positions))
    bench.run(1.0)
    bench.loses, began_s = lambda *_: True, bench.now_s
    assert bench.do(ReadPosition()).to == f"F5 to {targets}"
    assert isinstance(bench.do(along(straight(4))), Timeout)
    assert not requests(bench, MoveAbsoluteAxis, since_s=began_s)
    bench = begun(straight(40), 0.3)
    bench.loses = lambda *_: True
    assert isinstance(bench.finish(), Timeout)


def test_a_bus_that_is_silent_as_a_pause_begins_ends_the_motion():
    bench, paused = MksBench(starts=FAR_FROM_ZERO).ready(), []
    bench.begin(MoveAlong(iter(straight(30)), AHEAD_S, held_back=lambda: bool(paused)))
    bench.run(0.4)
    paused.append(True)
    bench.delay_frames(0.8, ANSWERS)
    bench.run(0.75)
    orders = [at_s for at_s, *_ in requests(bench, MoveAbsoluteAxis)]
    assert max(orders) < bench.now_s - 0.6
    assert isinstance(bench.finish(), RequestRejected)


# -- restarts: a drive counts from zero again ------------------------------------------------------


def moving(start, speed, after_s, **settings):
    way = (speed, -speed // 2, 700, 0, 0, 0)
    return begun(
        segments(*[way] * 12), after_s, starts=(start, 50_000, 50_000, 0, 0, 0), **settings
    )


@each_value(
    "start_speed, after_s, dead_s",
    [(9000, 9000), (-3000, 9000), (0, 3000), (20_000, 3000), (20_000, -3000), (60_000, 300)],
    [0.21, 0.47],
    [0.0, 0.05, 0.1],
)
def test_a_drive_that_restarts_far_from_zero_is_found_before_it_goes_far(
    start_speed, after_s, dead_s
):
    start, speed = start_speed
    bench = moving(start, speed, after_s)
    stood, back_s = bench.node(1).count, bench.now_s + dead_s
    shaft = restart(bench, 1, dead_s=dead_s)
    reply = bench.finish()
    assert isinstance(reply, RequestRejected)
    assert "reset" in reply.reason
    bench.run(1.0)
    assert abs(shaft() - stood) <= abs(speed) * 10 * (dead_s + 0.3)
    (stopped_s, *_), *_ = requests(bench, Stop, since_s=back_s)
    assert dead_s or stopped_s <= back_s + 0.16  # a poll, and a second look at once
    assert not requests(bench, MoveAbsoluteAxis, since_s=back_s + 0.15, node=2)


@each_value(
    "start, dead_s, settings, stop_s",
    [-2000, 0, 900],
    [0.15, 0.3],
    [BURSTS, {}],
    [None, 0.0, 0.02],
)
def test_a_restart_near_zero_is_found_by_the_missing_replies(start, dead_s, settings, stop_s):
    bench = MksBench(starts=(start, 0, 0, 0, 0, 0), settings=settings).ready()
    move = MoveBy(Motors((15_000, -9000, 0, 0, 0, 0)), 15_000.0)
    bench.begin(move if settings else along(segments(*[(900, -300, 0, 0, 0, 0)] * 12)))
    bench.run(0.11)
    restart(bench, 1, dead_s=dead_s)
    back_s = bench.now_s + dead_s
    if stop_s is not None:
        bench.run(stop_s)
        bench.controller.stop(hard=False)
    reply = bench.finish()
    assert isinstance(reply, RequestRejected) or bench.alerts()
    orders = requests(bench, MoveAbsoluteAxis, node=1, since_s=back_s)
    assert not [order for _, _, order in orders if order.speed_rpm > 1 and stop_s is None]


@every_row("start, after_s, settings, keeps_angle", [
    (40_000, 0.47, {}, True),
    (9000, 0.02, BURSTS, False),
    (-20_000, 0.2, BURSTS, False),
    (1024, 0.5, BURSTS, False),
])  # fmt: skip
def test_a_count_that_leaps_is_found_in_any_motion(start, after_s, settings, keeps_angle):
    bench = MksBench(starts=(start, 50_000, 0, 0, 0, 0), settings=settings).ready()
    bench.begin(BURST if settings else along(segments(*[(3000, -900, 0, 0, 0, 0)] * 12)))
    bench.run(after_s)
    restart(bench, 1, keeps_angle=keeps_angle)
    check_blamed(bench)


@each_value("after_s, all_of_them, dead_s", [0.0, 0.02, 0.06], [False, True], [0.05, 0.0])
def test_a_restart_while_the_drives_brake_is_found(after_s, all_of_them, dead_s):
    bench = moving(9000, 9000, 0.5)
    bench.controller.stop(hard=False)
    bench._send()
    bench.run(after_s)
    for number in range(1, 7 if all_of_them else 2):
        restart(bench, number, dead_s=dead_s)
    reply = bench.finish()
    assert bench.alerts() or isinstance(reply, RequestRejected)


def test_a_standing_drive_that_restarts_in_a_motion_of_others_is_found():
    bench = begun(straight(12, (3000, 0, 0, 0, 0, 0)), 0.3, starts=(0, 0, 30_000, 0, 0, 0))
    restart(bench, 3)
    check_blamed(bench, "drive 3 (elbow)", AlertKind.RESTARTED)


@pytest.mark.parametrize("dead_s", [0.15, 0.3])
@pytest.mark.parametrize("start", [50_000, -2000, 0])
def test_a_supply_of_all_drives_that_fails_for_a_moment_is_found(start, dead_s):
    bench = begun(straight(30), 0.5, starts=(start,) * 6)
    for number in range(1, 7):
        restart(bench, number, dead_s=dead_s)
    reply = bench.finish()
    assert isinstance(reply, RequestRejected | Timeout)
    bench.run(1.0)
    bench.check_stands()


# -- blocked, pushed, weak -------------------------------------------------------------------------


@each_value("counts_s, poll_s, after_s", [9000, 30_000, 90_000], [0.02, 0.1, 0.2], [0.2, 0.53])
def test_a_blocked_shaft_is_reported_within_the_documented_time(counts_s, poll_s, after_s):
    way = (counts_s // 10, -counts_s // 30, 0, 0, 0, 0)
    bench = begun(straight(30, way), after_s, poll_s=poll_s)
    bench.node(1).block()
    blocked_s = bench.now_s
    check_blamed(bench, kind=AlertKind.OFF_PATH)
    (stopped_s, *_), *_ = requests(bench, Stop, since_s=blocked_s)
    following_s = bench.controller.settings.following_error_counts / counts_s
    assert stopped_s - blocked_s <= following_s + 0.1 + 2.0 * poll_s + 0.05


def test_a_shaft_that_is_blocked_in_a_short_motion_is_found_at_its_end():
    bench = begun(straight(8, (100, -30, 0, 0, 0, 0)))
    bench.node(1).block()
    check_blamed(bench, kind=AlertKind.OFF_PATH)


def pushed(bench):
    bench.node(1).load(6000)


def weak(bench, share=0.5):
    """Have a motor turn at a share of what its drive is told."""
    flash = bench.node(1).sim.flash
    rpm_of = flash.rpm_of
    flash.rpm_of = lambda rpm: rpm_of(rpm) * share


def reach_a_switch(bench):
    """Have the first drive run into its limit switch, and say so."""
    sim = bench.node(1).sim
    asked = sim.motion.under_way
    sim.motion.halt(bench.now_s)
    bench.say(pack(sim.device.tell(asked, Outcome.LIMIT_STOP)))


FAULTS = {
    "is blocked": (lambda bench: bench.node(3).block(), AlertKind.OFF_PATH, r"drive 3 \(elbow\)"),
    "is pushed": (pushed, AlertKind.OFF_PATH, r"drive 1 \(base\)"),
    "is weak": (weak, AlertKind.OFF_PATH, r"drive 1 \(base\)"),
    "stalls": (lambda bench: bench.node(2).stall(), AlertKind.SWITCHED_OFF,
               r"drive 2 \(shoulder\) has stalled"),
    "is reset": (lambda bench: bench.node(1).reset(), AlertKind.RESTARTED, r"drive 1 \(base\)"),
    "is switched off": (lambda bench: bench.node(5).enable(False), AlertKind.SWITCHED_OFF,
                        r"drive 5 \(left wrist\) has switched its motor off"),
    "is in another mode": (lambda bench: bench.node(5).set_mode(Mode.PULSE_FOC),
                           AlertKind.OFF_PATH, r"drive 5 \(left wrist\) is in mode 2"),
    "reaches a limit switch": (reach_a_switch, AlertKind.ALARM_LOST,
                               r"drive 1 \(base\) has run into a limit switch"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "settings"), [*((name, {}) for name in FAULTS), ("reaches a limit switch", BURSTS)]
)
def test_a_drive_that_fails_ends_the_motion_of_all_and_is_named(name, settings):
    fails, kind, words = FAULTS[name]
    bench = MksBench(starts=FAR_FROM_ZERO, settings=settings).ready()
    bench.begin(BURST if settings else along(straight(40)))
    bench.run(0.4)
    fails(bench)
    began_s = bench.now_s
    alert = check_blamed(bench, "drive", kind)
    assert re.search(words, alert.text)
    assert bench.now_s < began_s + 2.0
    assert settings == {} or not requests(bench, MoveAbsoluteAxis, node=1, since_s=began_s)
    bench.check_stands()
    bench.do(ReadPosition())
    assert len(bench.alerts()) == 1  # all are taken to be where they stand


@pytest.mark.parametrize("after_s", [0.2, 0.23, 0.31])
def test_a_wrist_motor_that_rejects_orders_stops_the_other_one_at_once(after_s):
    bench = begun(straight(12, (0, 0, 0, 2000, -2000, 0)), after_s)
    bench.node(4).set_mode(Mode.PULSE_FOC)
    stood = bench.positions
    check_blamed(bench, "drive 4 (right wrist)")
    assert abs(bench.positions[4] - stood[4]) <= 20_000 * 0.2


def test_a_drive_that_goes_on_after_the_stop_is_named():
    bench = begun(straight(30), 0.3)
    bench.node(2).receive(encode(2, MoveAbsoluteAxis(5_000_000, 600, 236)))
    deaf_to = (Code.ABSOLUTE_AXIS, Code.EMERGENCY_STOP)
    bench.loses = lambda frame, host: host and frame.can_id == 2 and frame.data[0] in deaf_to
    assert bench.finish().reason == "drive 2 (shoulder) did not come to rest after a stop"


def test_a_drive_that_says_nothing_when_it_rejects_a_burst_is_found():
    bench = MksBench(starts=FAR_FROM_ZERO, settings=BURSTS).ready()
    object.__setattr__(bench.node(1).sim.quirks, "says_refused", False)
    bench.node(1).set_mode(Mode.PULSE_FOC)
    bench.begin(BURST)
    check_blamed(bench)


def lose_reports(bench):
    """Lose every third report of a drive that it has started."""
    count = iter(range(1000))
    bench.loses = lambda frame, host: (
        not host and frame.data[0] == Code.ABSOLUTE_AXIS and next(count) % 3 == 0
    )


def lose_orders(bench):
    """Lose the orders of one drive for a moment."""
    until_s = bench.now_s + 0.1
    bench.loses = lambda frame, host: (
        host and frame.can_id == 1 and frame.data[0] == 0xF5 and bench.now_s < until_s
    )


def be_slow(bench):
    """Have a motor turn a little slower than its drive is told."""
    weak(bench, 0.92)


@pytest.mark.parametrize(
    ("happens", "settings", "count"),
    [
        (lose_reports, {}, 20),
        (lose_orders, {}, 20),
        (be_slow, {}, 40),
        (None, {"acceleration": 200}, 20),
    ],
)
def test_drives_that_can_make_up_for_it_are_not_blamed(happens, settings, count):
    bench = begun(straight(count, (2000, -2000, 0, 0, 0, 0)), 0.4, **settings)
    if happens is not None:
        happens(bench)
    check_done(bench)
    assert bench.positions[:2] == (50_000 + 2000 * count, 50_000 - 2000 * count)


# -- at rest ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("start", [20_000, -20_000])
def test_a_drive_that_restarts_at_rest_is_found_at_the_next_look(start):
    bench = MksBench(starts=(start, 0, 0, 0, 0, 0)).ready()
    restart(bench, 1)
    bench.do(ReadPosition())
    assert [alert.kind for alert in bench.alerts()] == [AlertKind.RESTARTED]


def test_a_drive_that_is_turned_at_rest_is_found_and_taken_from_there():
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    bench.node(2).load(COUNTS_PER_TURN)
    there = Registers(Motors((50_000, 50_000 + COUNTS_PER_TURN, *[50_000] * 4)))
    assert bench.do(ReadPosition()) == there
    assert [alert.kind for alert in bench.alerts()] == [AlertKind.OFF_PATH]
    bench.do(ReadPosition())
    assert len(bench.alerts()) == 1
    check_halted(begun(straight(10), 0.2))


# -- answers that no question explains -------------------------------------------------------------


@pytest.mark.parametrize("late_s", [0.06, 0.12, 0.3])
def test_late_answers_are_not_taken_for_those_of_a_second_drive(late_s):
    bench = MksBench(LATEST)
    bench.waits_s = lambda _frame, host: 0.0 if host else late_s
    bench.begin(ReadPosition())
    bench.run(1.5)
    bench.waits_s = lambda _frame, _host: 0.0
    assert isinstance(bench.finish(), Registers)
