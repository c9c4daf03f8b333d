"""Contact with MKS drives: nothing moves, and what is wrong is named with its drive and remedy."""

from __future__ import annotations

import pytest
from mks_bench import HOMES_RPM, LATEST, MksBench, homing_at

from armdrive.dialects.mks.compare import parsed_line
from armdrive.errors import Refused
from armdrive.tasks import (
    ClearFault,
    DeviceSettings,
    Done,
    DropCurrent,
    HomeDevice,
    MendSetting,
    ReadPosition,
    ReadSettings,
    Registers,
    RequestRejected,
    SwitchOn,
)
from firmware_protocol.mks import (
    Calibrate,
    Code,
    Enable,
    Home,
    Mode,
    RunAtSpeed,
    SilenceWatchdog,
    decode_request,
    encode,
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
    assert isinstance(bench.do(ReadSettings()), DeviceSettings)
    assert not MOVING & {frame.data[0] for _, frame in bench.sent}
    assert bench.controller.firmware == "1.0.9"


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
    bench.do(ReadPosition())
    assert bench.controller.firmware == taken_for
    assert bench.controller.abilities.queued_segments == queued
    assert bench.controller.abilities.coordinated == bool(queued)


def test_frames_that_are_lost_now_and_then_are_asked_for_again():
    bench = MksBench(starts=STARTS)
    count = iter(range(10_000))
    bench.loses = lambda frame, host: next(count) % 7 == 3
    assert bench.do(ReadPosition()) == Registers(Motors(STARTS))


def test_a_drive_that_an_earlier_program_left_running_is_waited_for_and_then_stopped():
    bench = MksBench()
    bench.node(1).enable()
    bench.node(1).receive(encode(1, RunAtSpeed(60, 236)))
    assert isinstance(bench.do(ReadPosition()), Registers)
    assert 10_000 < bench.positions[0] < 40_000  # a second at a turn a second
    bench.check_stands()


@pytest.mark.parametrize("request_", [Home(), Calibrate()])
def test_a_drive_that_homes_or_calibrates_is_left_alone(request_):
    bench = MksBench()
    bench.node(1).enable()
    bench.node(1).receive(encode(1, request_))
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
    assert wrong.mend == "2: 82 05"
    words = denied(bench.do(SwitchOn()))
    assert "drive 2 (shoulder) is in mode 2" in words
    assert isinstance(bench.do(MendSetting(wrong.mend)), Done)
    assert bench.do(ReadSettings()).differences == ()
    bench.ready()


@pytest.mark.parametrize("line", ["$1=255", "2: f5 00", "2: 8b 00 03", "2: 8a 01", "2: 82 09"])
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


def test_homing_goes_group_by_group_and_sets_no_zero():
    bench = MksBench(starts=STARTS).ready()
    assert isinstance(bench.do(HomeDevice(((2,), (0, 1)))), Done)
    homed = [frame.can_id for _, frame in bench.sent if frame.data[0] == Code.HOME]
    assert homed == [3, 1, 2]
    assert Code.ZERO not in {frame.data[0] for _, frame in bench.sent}
    assert bench.positions == Motors((0, 0, 0, *STARTS[3:]))


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
    ("rpm", "homing_s", "words"),
    [(HOMES_RPM, 1.0, "no switch in time"), (3000, 60.0, "no switch within its joints' limits")],
)
def test_a_search_that_finds_no_switch_is_ended(rpm, homing_s, words):
    bench = MksBench(settings={"homing_s": homing_s}).ready()
    drive = bench.node(5).sim
    drive.motor.switch.at = 10**9
    drive.flash.put(homing_at(rpm))
    assert f"drive 5 (left wrist) found {words}" in denied(bench.do(HomeDevice(((4,),))))
    bench.check_stands(1.0)
