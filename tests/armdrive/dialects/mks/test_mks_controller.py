"""Contact with MKS drives: nothing moves, and what is wrong is named with its drive and remedy."""

from __future__ import annotations

import re

import pytest
from amounts import each_value, every_row
from mks_bench import (
    HOMES_RPM,
    LATEST,
    MksBench,
    along,
    homing_at,
    straight,
    total,
)

from armdrive.dialects.mks.compare import parsed_line
from armdrive.dialects.mks.controller import MksController
from armdrive.errors import Refused
from armdrive.tasks import (
    AlertKind,
    ClearFault,
    DeviceSettings,
    Done,
    DropCurrent,
    FixSetting,
    Halted,
    HomeDevice,
    ReadPosition,
    ReadSettings,
    Registers,
    RequestRejected,
    SwitchOn,
    Timeout,
)
from firmware_protocol.frames import pack
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    COUNTS_S_PER_RPM,
    Calibrate,
    Code,
    EncoderRead,
    Home,
    HomingState,
    Mode,
    MoveAbsoluteAxis,
    SetStallProtection,
    SilenceWatchdog,
    Stop,
    encode,
    slope_of,
)
from kinematics import Motors

STARTS = (100, -200, 300, 0, 5, -6)
MOVING = {0xF4, 0xF5, 0xF6, 0xFD, 0xFE, 0x91, 0x92, 0x80, 0xF3}


def denied(reply) -> str:
    assert isinstance(reply, RequestRejected), reply
    return reply.reason


def test_contact_tells_the_encoders_and_sends_nothing_that_moves_or_switches():
    bench = MksBench(starts=STARTS)
    assert bench.do(ReadPosition()) == Registers(Motors(STARTS))
    assert bench.do(ReadSettings()) == DeviceSettings(firmware="1.0.9")
    assert not MOVING & {frame.data[0] for _, frame in bench.sent}


@pytest.mark.parametrize(
    ("firmware", "settings", "taken_for", "queued"),
    [
        ((1, 0, 9), {}, "1.0.9", 3),
        ((1, 0, 8), {}, "1.0.8", 3),
        ((1, 0, 6), {}, "1.0.6", 3),
        ((1, 0, 4), {}, "1.0.4", 0),
        ([LATEST] * 2 + [(1, 0, 4)] + [LATEST] * 3, {}, "1.0.4", 0),  # the oldest drive decides
        (LATEST, {"firmware": "1.0.5"}, "1.0.5", 3),  # or the arm file
    ],
)
def test_abilities_are_those_of_the_oldest_firmware(firmware, settings, taken_for, queued):
    bench = MksBench(firmware, settings)
    assert bench.do(ReadSettings()).firmware == taken_for
    assert bench.controller.abilities.queued_segments == queued
    assert bench.controller.abilities.coordinated == bool(queued)


def test_a_drive_too_many_that_has_the_id_of_another_is_named():
    bench, another = MksBench(starts=STARTS), pack(encode(3, EncoderRead(500)))

    def both_answer(frame, host):
        if host and (frame.can_id, frame.data[0]) == (3, Code.ENCODER):
            bench.say(another)
        return False

    bench.loses = both_answer
    assert "more than one drive answers to the id 3" in denied(bench.do(ReadPosition()))


def left_by_an_earlier_program(request_) -> MksBench:
    """A bench whose first drive an earlier program left turning, far from its switch."""
    bench = MksBench()
    bench.node(1).enable()
    bench.node(1).sim.motor.switch.at = 10**9
    bench.node(1).receive(encode(1, request_))
    return bench


EARLIER = [MoveAbsoluteAxis(100 * 0x4000, 60, 236), Home()]


def test_a_drive_that_an_earlier_program_left_turning_is_waited_for_and_then_stopped():
    bench = left_by_an_earlier_program(MoveAbsoluteAxis(100 * 0x4000, 60, 236))
    assert isinstance(bench.do(ReadPosition()), Registers)
    assert 10_000 < bench.positions[0] < 40_000  # a second at a turn a second
    bench.check_stands()


def test_a_drive_that_still_brakes_is_waited_for():
    bench = left_by_an_earlier_program(MoveAbsoluteAxis(100 * 0x4000, 60, 236))
    bench.run(0.3)
    bench.node(1).receive(encode(1, Stop(1)))
    assert bench.do(ReadPosition()) == Registers(bench.positions)
    bench.check_stands()


@pytest.mark.parametrize("silent_s", [0.05, 0.3, 0.49])
def test_a_drive_that_an_earlier_program_left_homing_stands_in_the_announced_time(silent_s):
    """Mission mks 710000137: the questions of the next program fed the drive's watchdog."""
    bench = MksBench().ready()
    announced_s = bench.controller.search(HomeDevice(((0,),))).time_s
    bench.node(1).sim.motor.switch.at = 10**9
    bench.begin(HomeDevice(((0,),)))
    bench.run(0.5)
    bench.dead, died_s = True, bench.now_s
    bench.run(silent_s)
    bench.controller = MksController(bench.controller.abilities, bench.config)
    bench.dead = False
    bench.begin(ReadPosition())
    bench.run(announced_s - (bench.now_s - died_s))
    there = bench.positions[0]
    assert isinstance(bench.finish(), Registers)
    bench.run(1.0)
    assert bench.positions[0] == there


@pytest.mark.parametrize("request_", EARLIER)
def test_a_stop_ends_that_wait(request_):
    bench = left_by_an_earlier_program(request_)
    bench.begin(ReadPosition())
    bench.run(0.3)
    bench.controller.stop(hard=False)
    assert isinstance(bench.finish(), Registers)
    assert bench.positions[0] < 10_000
    bench.check_stands()


def test_a_drive_that_does_not_obey_the_stop_is_named():
    bench = left_by_an_earlier_program(Home())
    bench.loses = lambda frame, host: host and frame.data[0] == Code.EMERGENCY_STOP
    words = denied(bench.do(ReadPosition()))
    assert "drive 1 (base)" in words
    assert "did not come to rest after a stop" in words


def test_a_drive_that_calibrates_is_left_alone():
    bench = left_by_an_earlier_program(Calibrate())
    assert "wait until it has finished" in denied(bench.do(ReadPosition()))
    assert bench.node(1).sim.motion.searching


def test_a_wrong_mode_is_a_difference_that_can_be_mended():
    bench = MksBench()
    bench.node(2).set_mode(Mode.PULSE_FOC)
    bench.do(ReadPosition())
    found = bench.do(ReadSettings())
    assert isinstance(found, DeviceSettings)
    (wrong,) = found.differences
    assert wrong.must
    assert "drive 2 (shoulder)" in wrong.setting
    assert wrong.fix == "2: 82 05"
    words = denied(bench.do(SwitchOn()))
    assert "drive 2 (shoulder) is in mode 2" in words
    assert not any(node.sim.enabled for node in bench.nodes)  # else some would hold, others not
    assert isinstance(bench.do(FixSetting(wrong.fix)), Done)
    assert bench.do(ReadSettings()).differences == ()
    bench.ready()
    bench.node(3).set_mode(Mode.PULSE_FOC)
    assert "drive 3 (elbow) is in mode 2" in denied(bench.do(DropCurrent()))


@every_row("line", ["$1=255", "2: f5 00", "2: 8b 00 03", "2: 8a 01", "2: 82 09"])
def test_no_line_moves_a_drive_or_takes_it_elsewhere(line):
    with pytest.raises(Refused):
        parsed_line(line)


def test_switching_on_sets_the_watchdog_and_reads_it_back():
    bench = MksBench(starts=STARTS).ready()
    assert all(node.sim.enabled for node in bench.nodes)
    assert bench.node(1).setting(SilenceWatchdog) == SilenceWatchdog(500)
    assert bench.controller.watched
    assert bench.positions == Motors(STARTS)


def test_a_stalled_drive_is_not_switched_on_before_it_is_cleared():
    bench = MksBench()
    bench.node(4).stall()
    words = denied(bench.do(SwitchOn()))
    assert "drive 4 (right wrist) has stalled" in words
    assert "reset" in words
    assert isinstance(bench.do(ClearFault()), Done)
    bench.ready()


def test_a_drive_that_stays_without_current_is_named():
    bench = MksBench()
    bench.node(4).sim.set_enabled = lambda *_: None
    assert "drive 4 (right wrist) does not switch its motor on" in denied(bench.do(SwitchOn()))


def test_an_encoder_that_trembles_is_no_motion():
    bench = MksBench(starts=STARTS).ready()
    for node, slip in zip(bench.nodes, (3, -8, 0, 9, 1, 1), strict=True):
        node.load(slip)
    told = bench.do(ReadPosition())
    assert told == Registers(Motors((*STARTS[:3], 9, *STARTS[4:])))


def test_a_drive_is_where_it_was_left_if_it_is_found_within_reach_of_that():
    bench = MksBench(starts=STARTS)
    registers = bench.do(ReadPosition()).positions
    left = Motors([103, -200, 292, 9, 5, -6])
    assert bench.controller.unwrap(registers, left) == Motors([103, -200, 292, 0, 5, -6])
    bench.ready()
    assert bench.do(ReadPosition()).positions == Motors([103, -200, 292, 0, 5, -6])


@pytest.mark.parametrize(
    "settings", [{}, {"watchdog_s": 0.04, "poll_s": 0.02}], ids=["as shipped", "shortest watchdog"]
)
def test_homing_goes_group_by_group_and_sets_no_zero(settings):
    bench = MksBench(settings=settings, starts=STARTS).ready()
    assert isinstance(bench.do(HomeDevice(((2,), (0, 1)))), Done)
    homed = [frame.can_id for _, frame in bench.sent if frame.data[0] == Code.HOME]
    assert homed == [3, 1, 2]
    assert Code.ZERO not in {frame.data[0] for _, frame in bench.sent}
    assert bench.positions == Motors((0, 0, 0, *STARTS[3:]))
    assert bench.do(along(straight(3))) == Done()
    assert bench.positions == total(straight(3)) + Motors((0, 0, 0, *STARTS[3:]))


@pytest.mark.parametrize(
    ("takes", "words"),
    [
        # mission mks 710000599: the new zero was read from the other drive
        (True, "more than one drive answers to the id 3"),
        # mission mks 745000275: the reading of before it had homed was taken for a later one
        (False, "drive 3 (elbow) does not answer"),
    ],
    ids=["another takes its id", "it falls silent"],
)
def test_a_homed_drive_that_is_not_read_itself_is_not_said_to_have_two_zeros(takes, words):
    bench = MksBench(starts=(20_000, 0, 20_000, 0, 0, 0)).ready()
    node, other = bench.node(3).sim, bench.device.board.node(0)

    def once_homed(frame, host):
        if frame.can_id != 3 or node.motion.homing is not HomingState.DONE:
            return False
        if takes and not host and frame.data[0] == Code.HOME:
            other.set_id(3, bench.now_s)
        return host and not takes

    bench.loses = once_homed
    assert words in denied(bench.do(HomeDevice(((2,),))))
    bench.loses = lambda _frame, _host: False
    other.set_id(1, bench.now_s)
    assert bench.do(ClearFault()) == Done()
    bench.ready()
    assert bench.do(HomeDevice(((2,),))) == Done()


def test_a_stop_that_a_homing_drive_did_not_receive_is_repeated():
    bench = MksBench().ready()
    bench.node(1).sim.motor.switch.at = 10**9
    bench.begin(HomeDevice(((0,),)))
    bench.run(0.5)
    lost = []

    def loses(frame, host):
        stop = host and frame.data[0] == Code.EMERGENCY_STOP and not lost
        lost.extend([frame] * stop)
        return stop

    bench.loses, there = loses, bench.positions[0]
    bench.controller.stop(hard=False)
    assert bench.finish() == Halted(kept=False)
    assert lost
    assert bench.positions[0] - there < 0.1 * COUNTS_PER_TURN  # at a turn a second
    bench.check_stands()


def test_a_shaft_that_is_blocked_as_its_homing_is_stopped_does_not_spring():
    bench = MksBench().ready()
    bench.node(1).sim.motor.switch.at = 10**9
    bench.begin(HomeDevice(((0,),)))
    bench.run(0.5)
    bench.node(1).block()
    bench.run(0.1)
    bench.controller.stop(hard=False)
    assert bench.finish() == Halted(kept=False)
    bench.node(1).free()
    bench.check_stands()


def test_a_drive_that_refuses_to_home_is_named():
    bench = MksBench().ready()
    bench.node(3).set_mode(Mode.PULSE_FOC)
    assert "drive 3 (elbow) refused to home" in denied(bench.do(HomeDevice(((2,),))))


def longest_braking_s(rpm):
    """Return how long a drive brakes from a speed on the gentlest ramp that it knows."""
    return rpm * COUNTS_S_PER_RPM / slope_of(1)


@pytest.mark.parametrize(
    ("firmware", "rpms", "most_s"),
    [
        ((1, 0, 4), (60, 60), 60.0),  # tells no speed: `homing_s`
        ((1, 0, 8), (60, 60), 75.0),  # OVERTRAVEL times the wrist's range, at a turn a second
        ((1, 0, 8), (60, 120), 75.0),
        ((1, 0, 8), (120, 120), 37.5),
    ],
)
def test_without_a_watchdog_homing_is_bounded_by_the_drives_speeds_once_they_are_read(
    firmware, rpms, most_s
):
    bench, request_ = MksBench(firmware), HomeDevice(((3, 4),))
    for motor, rpm in zip((4, 5), rpms, strict=True):
        bench.node(motor).sim.flash.put(homing_at(rpm))
    assert bench.controller.search(request_).time_s == pytest.approx(60.0, abs=0.3)
    bench.do(ReadPosition())
    time_s = bench.controller.search(request_).time_s
    assert most_s - 0.3 <= time_s <= most_s + longest_braking_s(max(rpms)) + 0.3


@each_value("rpm, acceleration, died_s", [60, 600], [0, 252, 255], [0.051, 0.075, 0.09])
def test_drives_stand_in_the_announced_time_after_the_host_dies_while_they_home(
    rpm, acceleration, died_s
):
    bench = MksBench(settings={"acceleration": acceleration})
    bench.node(1).sim.flash.put(homing_at(rpm))
    bench.node(1).sim.motor.switch.at = 10**9
    bench.ready()
    search = bench.controller.search(HomeDevice(((0,),)))
    bench.begin(HomeDevice(((0,),)))
    bench.run(1.0 + died_s)
    bench.dead, there = True, bench.positions[0]
    bench.run(search.time_s)
    stood = bench.positions[0]
    assert stood - there <= search.most_steps
    bench.run(1.0)
    assert bench.positions[0] == stood


def test_the_next_program_knows_the_watchdog_before_it_switches_anything_on():
    bench = MksBench().ready()
    bench.do(DropCurrent())
    again = MksController(bench.controller.abilities, bench.config)
    bench.controller = again
    assert not again.watched
    bench.do(ReadPosition())
    assert again.watched
    assert again.search(HomeDevice(((0,),))).time_s < 1.0 + longest_braking_s(HOMES_RPM)


@pytest.mark.parametrize(("for_s", "words"), [(0.7, ""), (9.0, "silent")])
def test_homing_on_a_bus_that_falls_silent_blames_no_drive(for_s, words):
    bench = MksBench().ready()
    bench.begin(HomeDevice(((0, 1),)))
    bench.run(0.05)
    until_s = bench.now_s + for_s
    bench.loses = lambda _frame, _host: bench.now_s < until_s
    reply = bench.finish(30.0)
    assert reply == Done() if not words else isinstance(reply, Timeout)


NO_SWITCH = "found no switch within its joints' limits"
LATE, REMEDY = "found no switch in time, after", "raise mks.homing_s in the arm file"


@pytest.mark.parametrize(
    ("firmware", "rpm", "homing_s", "blocked", "most_s", "words"),
    [
        ((1, 0, 4), HOMES_RPM, 1.0, False, 9.0, f"{LATE}.*{REMEDY}"),
        (LATEST, 3000, 60.0, False, 100.0, NO_SWITCH),
        (LATEST, 5 * HOMES_RPM, 1.0, False, 100.0, NO_SWITCH),
        ((1, 0, 4), 10 * HOMES_RPM, 2.0, True, 9.0, f"{LATE}.*{REMEDY}"),
        (LATEST, 10 * HOMES_RPM, 2.0, True, 22.0, rf"{LATE} \d+ s$"),  # the key would not help
    ],
)
def test_a_search_that_finds_no_switch_is_ended(firmware, rpm, homing_s, blocked, most_s, words):
    bench = MksBench(firmware, settings={"homing_s": homing_s}).ready()
    bench.node(5).sim.motor.switch.at = 10**9
    bench.node(5).sim.flash.put(homing_at(rpm))
    if blocked:
        bench.node(5).block()
    began_s = bench.now_s
    reply = bench.do(HomeDevice(((4,),)), 100.0)
    assert re.search(rf"drive 5 \(left wrist\) {words}", denied(reply))
    assert bench.now_s - began_s < most_s
    bench.check_stands(1.0)


def test_a_drive_that_stalls_as_it_homes_is_said_to_have_released_its_shaft():
    bench = MksBench().ready()
    bench.node(5).sim.flash.put(SetStallProtection(on=True))
    bench.begin(HomeDevice(((3, 4),)))
    bench.run(0.2)
    bench.node(5).block()
    words = denied(bench.finish())
    assert "drive 5 (left wrist) did not find its switch or stop" in words
    assert "drive 5 (left wrist) has stalled" in words
    assert "direction" in words
    (alert,) = bench.alerts()
    assert alert.kind is AlertKind.SWITCHED_OFF
    bench.check_stands(1.0)


def test_a_slow_drive_has_the_time_that_its_homing_speed_gives_for_its_range():
    bench = MksBench(settings={"homing_s": 1.0}).ready()
    drive, range_counts = bench.node(5).sim, bench.config.motor_ranges[4]
    drive.motor.switch.at = round(range_counts / 4)
    began_s = bench.now_s
    assert bench.do(HomeDevice(((4,),)), 100.0) == Done()
    assert bench.now_s - began_s > 15.0


def test_homing_lasts_as_long_as_all_groups_and_a_silent_host_as_the_longest():
    bench = MksBench((1, 0, 8))
    for node, rpm in zip(bench.nodes, (60, 60, 60, 60, 60, 120), strict=True):
        node.sim.flash.put(homing_at(rpm))
    bench.do(ReadPosition())
    wrist, other, both, each = (
        bench.controller.search(HomeDevice(groups))
        for groups in (((4,),), ((5,),), ((4, 5),), ((4,), (5,)))
    )
    assert wrist.lasts.s > other.lasts.s
    assert both.lasts == wrist.lasts
    assert each.lasts.s == wrist.lasts.s + other.lasts.s
    assert each.time_s == both.time_s
    brakes_s = longest_braking_s(120) - longest_braking_s(60)  # the fastest of them decides
    assert both.time_s == pytest.approx(wrist.time_s + brakes_s)
