"""CiA 402 drives in motion: targets with every SYNC, bursts by profile position, stops, homing."""

from __future__ import annotations

import itertools
import math

import pytest
from cia402_rig import Rig, moving, steps

from armdrive.dialects.bus.paths import PlannedPath
from armdrive.errors import Refused
from armdrive.tasks import (
    DeviceSettings,
    Done,
    Halted,
    HomeDevice,
    MendSetting,
    MoveAlong,
    MoveBy,
    ReadPosition,
    ReadSettings,
    RequestRejected,
    Timeout,
)
from firmware_protocol.canopen import DriveState, OperationMode, Service
from kinematics import Motors

PERIOD_S = 0.01
LINE = (MoveBy(steps(6000, -3000), 20_000.0), MoveBy(steps(6000, -3000), 20_000.0))


def differences(targets: list[tuple[float, int]]) -> list[int]:
    return [b - a for (_, a), (_, b) in itertools.pairwise(targets)]


# -- the way --------------------------------------------------------------------------------------


def smoothed(way: PlannedPath, time_s: float) -> tuple[int, ...]:
    return tuple(map(round, way.averaged(time_s, 0.03)))


def test_a_straight_way_stays_straight_however_it_is_smoothed():
    way = PlannedPath(Motors((0, 0)))
    for _ in range(3):
        way.append(MoveBy(Motors((900, -300)), 9000.0), 0.0)
    for turn in range(40):
        base, shoulder = smoothed(way, turn * PERIOD_S)
        assert abs(base + 3 * shoulder) <= 2
    assert smoothed(way, 0.4) == (2700, -900)


def test_smoothing_makes_ramps_of_jumps_in_speed():
    way = PlannedPath(Motors((0,)))
    way.append(MoveBy(Motors((1000,)), 10_000.0), 0.0)
    places = [smoothed(way, turn * PERIOD_S)[0] for turn in range(15)]
    speeds = [b - a for a, b in itertools.pairwise(places)]
    changes = [abs(b - a) for a, b in itertools.pairwise((0, *speeds, 0))]
    assert max(changes) <= 35  # of 100 a turn
    assert places[-1] == 1000


# -- cyclic ---------------------------------------------------------------------------------------


def test_targets_come_with_every_sync_never_jump_and_keep_the_motors_in_proportion():
    rig = Rig().ready()
    began_s, before = rig.now_s, rig.positions
    rig.begin(MoveAlong(iter(LINE), 0.3))
    while (reply := rig.reply()) is None:
        rig.run(0.007)
        base, shoulder, *_ = rig.positions - before
        assert abs(base + 2 * shoulder) <= 12
    assert reply == Done()
    assert rig.positions == before + steps(12_000, -6000)
    syncs = [at_s for at_s, _ in rig.frames(Service.SYNC, began_s)]
    gaps = [b - a for a, b in itertools.pairwise(syncs)]
    assert max(gaps) <= PERIOD_S + 1e-6
    check_targets_never_jump(rig, began_s)


def check_targets_never_jump(rig, since_s):
    assert max(map(abs, differences(rig.targets(1, since_s)))) <= 20_000 * PERIOD_S + 1


def test_a_drive_that_stands_while_others_turn_gets_its_target_too():
    rig = Rig({}, hold_after_loss="extrapolate").ready()
    before = rig.positions
    apart = (MoveBy(steps(0, -3000), 20_000.0), MoveBy(steps(6000, 0), 20_000.0))
    assert rig.along(*LINE, *apart, *LINE) == Done()
    assert rig.positions == before + steps(30_000, -15_000)


def be_late(rig):
    """Suspend the program for less than the drives' patience."""
    rig.suspend(0.08)


def mute_one(rig):
    rig.device.board.drives.mute(1, True)
    rig.run(0.1)
    rig.device.board.drives.mute(1, False)


@pytest.mark.parametrize("fail", [be_late, mute_one])
def test_a_motion_slows_down_for_a_moment_of_silence_and_does_not_jump_ahead(fail):
    rig = Rig().ready()
    began_s, before = rig.now_s, rig.positions
    rig.begin(MoveAlong(iter(LINE), 0.3))
    rig.run(0.2)
    fail(rig)
    assert rig.finish() == Done()
    assert rig.positions == before + steps(12_000, -6000)
    check_targets_never_jump(rig, began_s)
    assert rig.controller.underruns


@pytest.mark.parametrize(
    ("lost", "turns"),
    [
        pytest.param(lambda frame, _: frame.can_id == 0x201, 5, id="one drive's targets"),
        pytest.param(lambda frame, _: frame.can_id == 0x80, 7, id="every SYNC"),
    ],
)
@pytest.mark.parametrize("lasts_s", [0.03, 0.08, 0.15])
def test_a_drive_that_misses_its_targets_is_sent_no_farther_and_makes_up_for_few(
    lost, turns, lasts_s
):
    rig = Rig().ready()
    before = rig.positions
    rig.begin(MoveAlong(iter(LINE * 2), 0.3))
    rig.run(0.2)
    rig.loses = lost
    rig.at_s[rig.now_s + lasts_s] = lambda: setattr(rig, "loses", lambda *_: False)
    there, ways = rig.positions, []
    for _ in range(60):
        rig.run(PERIOD_S)
        ways.append((rig.positions - there).largest)
        there = rig.positions
    assert max(ways) <= turns * 20_000 * PERIOD_S + 1
    assert all(sum(ways[i : i + 20]) <= 1.2 * 20_000 * 20 * PERIOD_S for i in range(40))
    assert rig.finish() == Done()
    assert rig.positions == before + steps(24_000, -12_000)


@pytest.mark.parametrize("fault", ["alone", "mute"])
@pytest.mark.parametrize("lasts_s", [0.04, 0.12, 0.15, 0.25])
def test_drives_that_were_cut_off_for_a_moment_do_not_jump_far(fault, lasts_s):
    """At most over what they were told, and did not hear, until that was noticed."""
    rig = Rig().ready()
    rig.begin(MoveAlong(iter(LINE * 4), 1.0))
    rig.run(0.233)
    there, ways = rig.positions, []
    rig.twin.faults.add(fault)
    rig.at_s[rig.now_s + lasts_s] = rig.twin.faults.end
    for _ in range(60):
        rig.run(PERIOD_S)
        ways.append((rig.positions - there).largest)
        there = rig.positions
    assert max(ways) <= 20_000 * PERIOD_S * (5 if fault == "alone" else 1.5)
    if lasts_s > 0.12:
        assert isinstance(rig.reply(), RequestRejected | Timeout)
        assert sum(ways[12:]) == 0


@pytest.mark.parametrize(
    ("strategy", "hard"), [("cyclic", False), ("cyclic", True), ("profile", False)]
)
def test_a_stop_is_a_quick_stop_that_keeps_the_current_and_the_drives_obey_again(strategy, hard):
    rig = moving(steps(20_000, -10_000), 0.4, {"strategy": strategy})
    rig.stop(hard=hard)
    asked_s, there, reply = rig.now_s, rig.positions[0], None
    while reply is None:
        rig.run(0.002)
        assert all(node.motor.holding for node in rig.device.board.nodes)
        reply = rig.reply()
    assert reply == Halted()
    stopping = rig.controller.stopping(0.3)
    assert rig.now_s - asked_s <= stopping.asked_s
    assert rig.positions[0] - there <= 20_000 * stopping.asked_motion_s
    assert 0x0002 in rig.words(1)
    assert rig.states() == {DriveState.ENABLED}
    held = rig.positions
    rig.check_stands(1.0)
    assert (rig.along(*LINE[:1]) if strategy == "cyclic" else rig.do(LINE[0])) == Done()
    assert rig.positions == held + LINE[0].steps


def test_a_released_jog_slows_down_on_its_path():
    rig = Rig().ready()
    before, released = rig.positions, [False]
    rig.begin(MoveAlong(iter(LINE * 4), 1.0, released=lambda: released[0]))
    rig.run(0.5)
    released[0] = True
    there = rig.positions[0]
    assert rig.finish() == Halted()
    base, shoulder, *_ = rig.positions - before
    assert abs(base + 2 * shoulder) <= 2
    assert rig.positions[0] - there <= 20_000 * 0.2
    assert 0x0002 not in rig.words(1)


def test_what_is_held_back_is_driven_to_its_end_and_no_more_is_drawn():
    rig, held, drawn = Rig().ready(), [False], []

    def segments():
        for each in LINE * 4:
            drawn.append(each)
            yield each

    rig.begin(MoveAlong(segments(), 1.0, held_back=lambda: held[0]))
    rig.run(0.4)
    held[0] = True
    before = len(drawn)
    assert rig.finish() == Done()
    assert len(drawn) == before < 8
    assert rig.positions[0] == 6000 * before


def test_a_stop_during_frames_that_are_lost_still_stops():
    rig = Rig().ready()
    rig.begin(MoveAlong(iter(LINE * 4), 1.0))
    rig.run(0.5)
    there = rig.positions[0]
    rig.device.board.drives.mute(4, True)  # another one is not heard at all
    rig.stop()
    reply = rig.finish()
    assert isinstance(reply, RequestRejected | Halted)
    rig.run(0.5)
    assert rig.positions[0] - there <= 20_000 * 0.2


# -- profile position -----------------------------------------------------------------------------


@pytest.mark.parametrize("options", [{"csp": False}, {}])
def test_bursts_by_profile_position_begin_and_arrive_together(options):
    settings = {} if options else {"strategy": "profile"}
    rig = Rig(settings, **options).ready()
    assert rig.controller.abilities.queued_segments == 0
    before = rig.positions
    rig.begin(MoveBy(steps(6000, -3000), 20_000.0))
    while rig.reply() is None:
        rig.run(0.007)
        base, shoulder, *_ = rig.positions - before
        assert abs(base + 2 * shoulder) <= 4
    assert (rig.positions - before)[:2] == (6000, -3000)
    assert {node.states.mode for node in rig.device.board.nodes} == {OperationMode.PROFILE_POSITION}


def test_a_burst_lasts_as_long_as_announced():
    rig = Rig({"strategy": "profile"}).ready()
    rig.do(ReadPosition())
    began_s = rig.now_s
    assert rig.do(MoveBy(steps(6000), 20_000.0)) == Done()
    assert rig.now_s - began_s <= rig.controller.duration_s(6000, 20_000.0) + 0.15


# -- homing and settings --------------------------------------------------------------------------


def test_homing_by_a_method_of_the_arm_file_counts_from_the_home():
    rig = Rig({"homing_methods": (37,) * 6}).ready()
    rig.along(*LINE)
    there = rig.device.world.motors
    assert rig.do(HomeDevice(((0, 1), (2,)))) == Done()
    assert rig.device.world.motors == there
    assert rig.do(ReadPosition()).positions[:3] == (0, 0, 0)
    assert rig.states() == {DriveState.ENABLED}
    assert rig.along(*LINE) == Done()
    assert rig.do(ReadPosition()).positions[:2] == (12_000, -6000)


def test_a_homing_that_fails_is_reported():
    rig = Rig({"homing_methods": (1,) * 6}).ready()
    reply = rig.do(HomeDevice(((0,),)))
    assert isinstance(reply, RequestRejected)
    assert "drive 1 (base)" in reply.reason


def test_settings_that_differ_are_reported_with_the_line_that_mends_them():
    rig = Rig({"encoder_increments": 4096})
    told = rig.do(ReadSettings())
    assert isinstance(told, DeviceSettings)
    first = next(each for each in told.differences if "608F:01" in each.setting)
    assert (first.found, first.expected, first.must) == ("10000", "4096", True)
    assert first.mend == "1: 608F:01 u32 4096"
    told = Rig({"encoder_increments": 10_000}).do(ReadSettings())
    assert told.differences == ()


@pytest.mark.parametrize(
    "line",
    [
        "nonsense",
        "1: 6040:00 u16 15",
        "1: 60B0:00 i32 999",
        "1: 60FF:00 i32 999",
        "1: 1016:01 u32 0",
        "9: 607E:00 u8 0",
    ],
)
def test_a_line_that_would_move_or_unguard_a_drive_is_refused(line):
    rig = Rig()
    rig.do(ReadPosition())
    with pytest.raises(Refused):
        rig.do(MendSetting(line))


def test_a_program_that_falls_silent_stops_the_arm_within_the_announced_time():
    rig = Rig({}, hold_after_loss="extrapolate").ready()
    rig.begin(MoveAlong(iter(LINE * 4), 5.0))
    rig.run(0.5)
    rig.dead = True
    there, bound = rig.positions[0], rig.controller.stopping(0.3)
    rig.run(bound.silent_s)
    held = rig.positions
    assert held[0] - there <= 20_000 * bound.silent_motion_s
    rig.run(1.0)
    assert rig.positions == held
    assert math.isfinite(bound.silent_s)
