"""Contact with MKS drives: nothing moves, and what is wrong is named with its drive and remedy."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from amounts import each_value, every_row
from mks_bench import (
    BURSTS,
    HOMES_RPM,
    LATEST,
    MksBench,
    along,
    begun,
    homing_at,
    requests,
    straight,
)

from armdrive.dialects.bus.paths import Course
from armdrive.dialects.mks.compare import parsed_line
from armdrive.dialects.mks.controller import MksController
from armdrive.dialects.mks.drive import START_WINDOW_S, MksDrive
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.mks.stops import ramp_to
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
    MoveBy,
    ReadPosition,
    ReadSettings,
    Registers,
    RequestRejected,
    SwitchOn,
)
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    COUNTS_S_PER_RPM,
    Answered,
    Calibrate,
    Code,
    Enable,
    Home,
    HomingState,
    Mode,
    MoveAbsoluteAxis,
    Outcome,
    ReadStall,
    RunAtSpeed,
    SetStallProtection,
    SilenceWatchdog,
    Status,
    Stop,
    decode_request,
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


def test_frames_that_are_lost_now_and_then_are_asked_for_again():
    bench = MksBench(starts=STARTS)
    count = iter(range(10_000))
    bench.loses = lambda frame, host: next(count) % 7 == 3
    assert bench.do(ReadPosition()) == Registers(Motors(STARTS))


def left_by_an_earlier_program(request_) -> MksBench:
    """A bench whose first drive an earlier program left turning, far from its switch."""
    bench = MksBench()
    bench.node(1).enable()
    bench.node(1).sim.motor.switch.at = 10**9
    bench.node(1).receive(encode(1, request_))
    return bench


EARLIER = [RunAtSpeed(60, 236), Home()]


def test_a_drive_that_an_earlier_program_left_turning_is_waited_for_and_then_stopped():
    bench = left_by_an_earlier_program(RunAtSpeed(60, 236))
    assert isinstance(bench.do(ReadPosition()), Registers)
    assert 10_000 < bench.positions[0] < 40_000  # a second at a turn a second
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


def test_a_reset_stops_a_drive_that_homes():
    bench = MksBench().ready()
    bench.node(1).sim.motor.switch.at = 10**9
    bench.node(1).receive(encode(1, Home()))
    assert bench.do(ClearFault()) == Done()
    assert bench.positions[0] < 40_000
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
    assert isinstance(bench.do(FixSetting(wrong.fix)), Done)
    assert bench.do(ReadSettings()).differences == ()
    bench.ready()


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


def test_nothing_is_said_while_nothing_is_asked():
    bench = MksBench().ready()
    before = len(bench.sent)
    bench.run(5.0)
    assert len(bench.sent) == before


def test_firmware_without_a_watchdog_is_never_asked_for_one():
    bench = MksBench((1, 0, 8)).ready()
    assert not bench.controller.watched
    assert 0x98 not in {frame.data[0] for _, frame in bench.sent}


def test_a_stalled_drive_is_not_switched_on_before_it_is_cleared():
    bench = MksBench()
    bench.node(4).stall()
    words = denied(bench.do(SwitchOn()))
    assert "drive 4 (right wrist) has stalled" in words
    assert "reset" in words
    assert isinstance(bench.do(ClearFault()), Done)
    bench.ready()


def test_switching_off_lets_every_motor_go():
    bench = MksBench().ready()
    assert isinstance(bench.do(DropCurrent()), Done)
    assert not any(node.sim.enabled for node in bench.nodes)
    frames = [decode_request(frame) for _, frame in bench.sent]
    assert Enable(on=False) in frames


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


def test_a_homed_drive_whose_id_another_one_takes_is_not_said_to_have_two_zeros():
    """Mission mks 710000599: the new zero was read from the other drive."""
    bench = MksBench(starts=(20_000, 0, 0, 0, 0, 0)).ready()
    node = bench.node(3).sim

    def takes(frame, host):
        tells = not host and frame.can_id == 3 and frame.data[0] == Code.HOME
        if tells and node.motion.homing is HomingState.DONE:
            bench.device.board.node(0).set_id(3, bench.now_s)
        return False

    bench.loses = takes
    assert "more than one drive answers to the id 3" in denied(bench.do(HomeDevice(((2,),))))
    bench.loses = lambda _frame, _host: False
    bench.device.board.node(0).set_id(1, bench.now_s)
    assert bench.do(ClearFault()) == Done()
    assert bench.do(HomeDevice(((2,),))) == Done()


def test_a_homed_drive_that_falls_silent_is_not_said_to_have_two_zeros():
    """Mission mks 745000275: the reading of before it had homed was taken for a later one."""
    bench = MksBench(starts=(0, 0, 20_000, 0, 0, 0)).ready()
    node = bench.node(3).sim

    def loses(frame, host):
        return host and frame.can_id == 3 and node.motion.homing is HomingState.DONE

    bench.loses = loses
    assert "drive 3 (elbow) does not answer" in denied(bench.do(HomeDevice(((2,),))))
    bench.loses = lambda _frame, _host: False
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


@pytest.mark.parametrize(("for_s", "words"), [(0.7, ""), (9.0, "no drive answered for a while")])
def test_homing_on_a_bus_that_falls_silent_blames_no_drive(for_s, words):
    bench = MksBench().ready()
    bench.begin(HomeDevice(((0, 1),)))
    bench.run(0.05)
    until_s = bench.now_s + for_s
    bench.loses = lambda _frame, _host: bench.now_s < until_s
    reply = bench.finish(30.0)
    assert reply == Done() if not words else words in reply.reason


@pytest.mark.parametrize(
    ("firmware", "rpm", "homing_s", "words"),
    [
        ((1, 0, 4), HOMES_RPM, 1.0, "no switch in time"),
        (LATEST, 3000, 60.0, "no switch within its joints' limits"),
        (LATEST, 5 * HOMES_RPM, 1.0, "no switch within its joints' limits"),
    ],
)
def test_a_search_that_finds_no_switch_is_ended(firmware, rpm, homing_s, words):
    bench = MksBench(firmware, settings={"homing_s": homing_s}).ready()
    drive = bench.node(5).sim
    drive.motor.switch.at = 10**9
    drive.flash.put(homing_at(rpm))
    reply = bench.do(HomeDevice(((4,),)), 100.0)
    assert f"drive 5 (left wrist) found {words}" in denied(reply)
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


@pytest.mark.parametrize(
    ("firmware", "most_s", "remedy"),
    [((1, 0, 4), 9.0, "raise mks.homing_s in the arm file"), (LATEST, 22.0, "")],
)
def test_a_search_that_stands_ends_in_time_and_names_only_a_key_that_helps(
    firmware, most_s, remedy
):
    bench = MksBench(firmware, settings={"homing_s": 2.0}).ready()
    bench.node(5).sim.flash.put(homing_at(10 * HOMES_RPM))
    bench.node(5).block()
    began_s = bench.now_s
    words = denied(bench.do(HomeDevice(((4,),)), 100.0))
    assert bench.now_s - began_s < most_s
    assert "drive 5 (left wrist) found no switch in time, after" in words
    assert remedy in words
    assert ("in the arm file" in words) is bool(remedy)
    bench.check_stands(1.0)


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


# -- A drive that is steered ends where it is sent, and does not run past that to come back --------

CONFIGURED = 252


def course(speed: float) -> Course:
    """A drive at zero that turns so fast."""
    found = Course()
    found.rest_at(0.0, 0.0)
    found.put(0.0, speed, 0.0)
    return found


@every_row("share", [0.05, 0.3, 1.0])
@every_row("speed, left", [(20_000.0, 4000), (20_000.0, -4000), (3000.0, 60)])
def test_a_drive_is_given_a_ramp_by_which_it_can_end(share, speed, left):
    drive = course(math.copysign(speed, left))
    slope = slope_of(ramp_to(drive, left, CONFIGURED, share))
    assert slope <= slope_of(CONFIGURED)
    assert speed**2 / (2.0 * slope) <= max(abs(left), speed**2 / (2.0 * slope_of(CONFIGURED)))


@every_row("share", [0.05, 0.3, 0.8, 1.0])
@every_row("speed, left", [(22_937.0, 266), (41_000.0, 900), (9000.0, 90)])
def test_a_path_can_end_there_though_the_order_is_a_little_late(share, speed, left):
    slope = slope_of(ramp_to(course(speed), left, CONFIGURED, share))
    late = speed * 0.002
    assert speed**2 / (2.0 * slope) <= max(left - late, speed**2 / (2.0 * slope_of(CONFIGURED)))


@every_row("share", [0.05, 0.1, 0.3])
@every_row("ahead_s", [0.0005, 0.001, 0.003])
def test_it_keeps_the_ramp_by_which_it_brakes_though_its_course_is_there_already(share, ahead_s):
    drive = course(0.0)
    drive.order(10_000, 60 * COUNTS_S_PER_RPM, slope_of(235), 0.0)
    drive.advance(0.6)
    drive.order(10_000, 14 * COUNTS_S_PER_RPM, slope_of(246), 0.6)
    now_s = 0.6
    while drive.speed:
        now_s += 0.0005
        drive.advance(now_s)
    slope = slope_of(246)
    speed = slope * ahead_s  # of the shaft itself, which is so much later
    left = speed**2 / (2.0 * slope)
    kept = slope_of(ramp_to(drive, 10_000, CONFIGURED, share, kept=246))
    assert speed**2 / (2.0 * kept) <= left


def test_a_drive_that_stood_starts_with_its_share_of_the_ramp():
    drive = course(0.0)
    drive.order(1000, 14 * COUNTS_S_PER_RPM, slope_of(246), 0.0)
    drive.rest_at(1000, 2.0)
    begins = ramp_to(drive, 5000, CONFIGURED, 0.1)
    assert begins == ramp_to(drive, -5000, CONFIGURED, 0.1)
    assert begins < 246


@pytest.mark.parametrize("ways", [(3000, 100), (3000, 20, 5), (2500, 1200, 300)])
def test_a_motor_that_slows_more_than_the_others_does_not_pass_its_end(ways):
    bench = MksBench().ready()
    moves = [MoveBy(Motors((4000, way, 0, 0, 0, 0)), 40_000.0) for way in ways]
    end, most = sum(ways), 0
    bench.begin(along(moves))
    for _ in range(2000):
        bench.run(0.001)
        most = max(most, bench.positions[1])
        if (reply := bench.reply()) is not None:
            break
    assert isinstance(reply, Done)
    assert most <= end + 2


# -- A drive that rejects orders stops the whole arm soon, since motors can be coupled -------------

TOGETHER = (2000, 0, 0, 2000, 2000, 0)
"""Both wrist motors go alike: the hand pitches, and does not roll."""
STARTED = 1
PERIOD_S = 0.04
SPEED = 20_000.0
WHY = (Code.STALL, Code.ENABLED, Code.MODE)
"""The readings and the setting that tell why a drive takes no orders."""


def apart(bench: MksBench) -> int:
    """Return how far the wrist's motors, which should go alike, are apart."""
    return abs(bench.positions[3] - bench.positions[4])


@pytest.mark.parametrize("after_s", [0.2, 0.23, 0.31])
def test_a_wrist_motor_that_rejects_orders_stops_the_other_one_at_once(after_s):
    bench = MksBench().ready()
    bench.at_s[bench.now_s + after_s] = lambda: bench.node(5).set_mode(Mode.PULSE_FOC)
    reply = bench.do(along(straight(10, way=TOGETHER)))
    assert isinstance(reply, RequestRejected)
    assert "drive 5 (left wrist) is in mode 2" in reply.reason
    noticed_s = PERIOD_S + START_WINDOW_S + 0.01
    assert apart(bench) <= SPEED * (noticed_s + bench.controller.ramp_s / 2.0)


def test_a_silent_wrist_motor_stops_the_other_one_once_it_is_mute():
    bench = begun(straight(10, way=TOGETHER), 0.3)
    bench.node(5).sim.port.mute = True
    farthest = 0
    while bench.reply() is None:
        bench.run(0.01)
        farthest = max(farthest, apart(bench))
    assert farthest <= SPEED * PERIOD_S


def test_a_stop_does_not_wait_for_the_answers_of_a_drive_that_rejects_orders():
    """Its answers are lost for a while, and the arm is stopped meanwhile."""
    bench = MksBench().ready()
    bench.loses = lambda frame, host: not host and frame.can_id == 5 and frame.data[0] in WHY
    bench.begin(along(straight(10, way=TOGETHER)))
    bench.run(0.2)
    bench.node(5).set_mode(Mode.PULSE_FOC)
    bench.run(2.0 * PERIOD_S + 2.0 * START_WINDOW_S + 0.01)
    assert requests(bench, ReadStall)
    bench.controller.stop(hard=False)
    bench.run(0.001)
    stopped = {node for _, node, _ in requests(bench, Stop)}
    assert {1, 4} <= stopped


def test_an_unchanged_order_is_repeated():
    bench = MksBench().ready()
    at_60_rpm = Motors(4 * count for count in (8192, 0, 0, 8192, 8192, 0))
    bench.do(along([MoveBy(at_60_rpm, 16_384.0)]))
    at_s = [at_s for at_s, *_ in requests(bench, MoveAbsoluteAxis, node=5)]
    assert max(b - a for a, b in pairwise(at_s)) <= 2.0 * PERIOD_S + 1e-3
    assert at_s[-1] - at_s[0] > 1.5


def test_a_burst_ends_soon_if_a_drive_rejects_its_order():
    bench = MksBench(settings=BURSTS, firmware=(1, 0, 6)).ready()
    ways = Motors(8 * way for way in TOGETHER)
    bench.at_s[bench.now_s + 0.2] = lambda: bench.node(5).set_mode(Mode.PULSE_FOC)
    reply = bench.do(MoveBy(ways, SPEED))
    assert isinstance(reply, RequestRejected)
    assert "drive 5 (left wrist) is in mode 2" in reply.reason
    assert apart(bench) <= SPEED * 0.12


@pytest.mark.parametrize("lost", [0, 1, 2])
def test_a_started_report_may_be_lost(lost):
    bench = MksBench().ready()
    count = [0]

    def loses(frame, host):
        data = frame.data
        began = not host and data[0] == Code.ABSOLUTE_AXIS and data[1] == STARTED
        count[0] += began
        return began and count[0] % 3 == lost

    bench.loses = loses
    assert isinstance(bench.do(along(straight())), Done)
    assert count[0] > 30
    assert not bench.alerts()


def test_a_failed_report_is_a_rejection_unless_an_order_starts_next_to_it():
    drive = MksDrive(1, "base", MksSettings())
    failed, started = (
        Answered(1, Status(Code.ABSOLUTE_AXIS, each)) for each in (Outcome.FAILED, Outcome.STARTED)
    )
    for at_s in (1.0, 1.0 + START_WINDOW_S):
        drive.note(failed, at_s)
        drive.note(started, at_s)
        drive.note(failed, at_s + START_WINDOW_S)
        assert math.isinf(drive.rejected_s)
    drive.note(failed, 2.0)
    drive.note(failed, 2.001)
    assert drive.rejected_s == pytest.approx(2.0 + START_WINDOW_S)


@pytest.mark.parametrize("count", [0, 5, 6])
def test_a_drive_that_rejects_its_order_is_asked_why_and_gets_it_again(count):
    """Drive 5 stands during the first segments; some of its first orders come with a poll."""
    bench = MksBench().ready()
    first, then = Motors((2000, 0, 0, 2000, 0, 0)), Motors(TOGETHER)
    bench.node(5).set_mode(Mode.PULSE_FOC)
    began_s = bench.now_s
    bench.begin(along([MoveBy(way, SPEED) for way in (*[first] * count, *[then] * 20)]))
    bench.run(1.0)
    sent = [frame.data for at_s, frame in bench.sent if frame.can_id == 5 and at_s >= began_s]
    asked = next(index for index, data in enumerate(sent) if data[0] == Code.STALL)
    order = next(data for data in sent if data[0] == Code.ABSOLUTE_AXIS)
    assert sent[:asked].count(order) == 1
    assert order in sent[asked:]
