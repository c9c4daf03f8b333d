"""What a simulated drive does by its firmware: one row an ability, on both sides of its version."""

import pytest
from amounts import every_row
from mks_sim import DONE, FAILED, STARTED, STORED, TURN, Bench
from mks_sim import outcomes as said

from firmware_protocol import mks
from firmware_protocol.mks.values import Bitrate

ASKED_FOR = {
    mks.Ability.ZERO: mks.SetZero(),
    mks.Ability.EMERGENCY_STOP: mks.EmergencyStop(),
    mks.Ability.CHOICE_OF_COMPLETION: mks.SetReplies(mks.ReplyMode.IMMEDIATE),
    mks.Ability.READ_SETTINGS: mks.ReadSetting(mks.Code.MODE),
    mks.Ability.RAW_ENCODER: mks.ReadRawEncoder(),
    mks.Ability.SYNCHRONOUS_START: mks.ArmSynchronous(True),
    mks.Ability.VERSION: mks.ReadVersion(),
    mks.Ability.SILENCE_WATCHDOG: mks.SilenceWatchdog(100),
}
"""What a drive answers if it is able to, and else not at all."""


def text(version: tuple[int, int, int]) -> str:
    return ".".join(map(str, version))


def rpm(point, now_s):
    return point.rate(now_s) * 60 / TURN


def before(version: tuple[int, int, int]) -> str:
    return text((version[0], version[1], version[2] - 1))


@every_row("ability", ASKED_FOR, ids=lambda each: each.name.lower())
def test_a_drive_answers_what_its_firmware_has_and_ignores_the_rest(ability):
    since = ability.since
    for firmware, answered in ((before(since), False), (text(since), True)):
        bench = Bench(firmware=firmware)
        assert bool(bench.ask(1, ASKED_FOR[ability], 0.1)) is answered


class TestRetargeting:
    @pytest.mark.parametrize(
        ("superseded", "heard"),
        [
            ("first", [FAILED, STARTED]),
            ("last", [STARTED, FAILED]),
            ("never", [STARTED]),
        ],
    )
    def test_from_1_0_5_a_new_target_replaces_the_old_one_without_a_jerk(self, superseded, heard):
        bench = Bench(firmware="1.0.5", superseded=superseded)
        bench.ask(1, mks.MoveAbsoluteAxis(9 * TURN, 60, 240), 1.0)
        before_rpm = rpm(bench.board.nodes[0].motor.point, bench.now_s)
        assert said(bench.ask(1, mks.MoveAbsoluteAxis(2 * TURN, 60, 240))) == heard
        assert rpm(bench.board.nodes[0].motor.point, bench.now_s) == pytest.approx(before_rpm)
        assert said(bench.run(3.0)) == [DONE]
        assert bench.counts(1) == 2 * TURN

    def test_before_it_is_refused_and_the_old_one_goes_on(self):
        bench = Bench(firmware="1.0.4")
        bench.ask(1, mks.MoveAbsoluteAxis(TURN, 60, 0), 0.2)
        (refused,) = bench.ask(1, mks.MoveAbsoluteAxis(0, 60, 0))
        assert said([refused]) == [FAILED]
        bench.run(1.5)
        assert bench.counts(1) == TURN


class TestStoring:
    def test_armed_it_stores_a_motion_and_disarmed_it_forgets_it(self):
        bench = Bench(firmware="1.0.8")
        bench.ask(1, mks.ArmSynchronous(True))
        assert said(bench.ask(1, mks.MoveAbsoluteAxis(TURN, 60, 0), 1.0)) == [STORED]
        assert bench.counts(1) == 0
        bench.ask(1, mks.ArmSynchronous(False))
        assert said(bench.ask(1, mks.MoveAbsoluteAxis(10, 60, 0))) == [STARTED, DONE]

    def test_a_stop_is_not_stored(self):
        bench = Bench()
        bench.ask(1, mks.ArmSynchronous(True))
        bench.ask(1, mks.MoveAbsoluteAxis(TURN, 60, 0))
        assert said(bench.ask(1, mks.Stop(0))) == [STARTED, DONE]
        assert bench.counts(1) == 0


class TestWatchdog:
    def test_it_stops_a_drive_in_its_time_when_nothing_comes(self):
        bench = Bench()
        bench.ask(1, mks.SilenceWatchdog(200))
        bench.send(1, mks.MoveAbsoluteAxis(5 * TURN, 60, 250))
        bench.run(0.0)
        bench.run(0.2)
        node = bench.board.nodes[0]
        assert rpm(node.motor.point, bench.now_s) == pytest.approx(60.0)
        bench.run(0.001 + 60 * 6 * 50e-6)  # the frame's time, and the ramp
        there = bench.world.motors
        assert rpm(node.motor.point, bench.now_s) == 0.0
        bench.run(1.0)
        assert bench.world.motors == there
        assert node.motion.watchdog_stops == 1
        assert said(bench.ask(1, mks.MoveAbsoluteAxis(0, 60, 240), 0.1)) == [STARTED]

    @pytest.mark.parametrize(("node", "fed"), [(1, True), (2, False)])
    def test_only_frames_to_a_drive_itself_feed_it(self, node, fed):
        bench = Bench()
        bench.ask(1, mks.SilenceWatchdog(200))
        bench.send(1, mks.MoveAbsoluteAxis(50 * TURN, 60, 250))
        for _ in range(10):
            bench.ask(node, mks.ReadEncoder(), 0.15)
        assert (bench.board.nodes[0].motion.watchdog_stops == 0) is fed


class TestTalking:
    @pytest.mark.parametrize(
        ("mode", "heard"),
        [
            (mks.ReplyMode.FULL, [STARTED, DONE]),
            (mks.ReplyMode.IMMEDIATE, [STARTED]),
            (mks.ReplyMode.NONE, []),
        ],
    )
    def test_what_it_says_of_a_motion_is_a_setting(self, mode, heard):
        bench = Bench()
        bench.ask(1, mks.SetReplies(mode))
        assert said(bench.ask(1, mks.MoveAbsoluteAxis(TURN, 600, 0), 1.0)) == heard
        assert bench.counts(1) == TURN

    def test_an_id_is_changed_and_outlives_the_power(self):
        bench = Bench()
        bench.ask(6, mks.SetId(9))
        bench.host = mks.Host((*range(1, 7), 9))
        bench.ids = (*bench.ids, 9)
        bench.device.power_off()
        bench.device.power_on()
        assert bench.counts(9) == 0
        assert bench.ask(6, mks.ReadEncoder()) == []

    def test_at_another_speed_than_the_buss_it_hears_nothing(self):
        bench = Bench()
        bench.ask(1, mks.SetBitrate(Bitrate.K250))
        assert bench.ask(1, mks.ReadEncoder(), 0.1) == []
        assert bench.counts(2) == 0

    def test_before_1_0_7_homing_by_command_is_not_told(self):
        assert Bench(firmware="1.0.6").ask(1, mks.ReadHoming())[0].answer.by_command is None
        assert Bench().ask(1, mks.ReadHoming())[0].answer.by_command is not None

    def test_before_1_0_8_a_motion_is_done_whether_the_shaft_came_along_or_not(self):
        bench = Bench(firmware="1.0.7")
        bench.ask(1, mks.SetStallProtection(False))
        bench.world.stalled.add(0)
        assert said(bench.ask(1, mks.MoveAbsoluteAxis(TURN, 60, 0), 2.0)) == [STARTED, DONE]
        assert bench.counts(1) == 0


class TestAsShipped:
    def test_every_drive_is_id_1_and_waits_for_pulses(self):
        bench = Bench(factory=True)
        assert {node.device.node for node in bench.board.nodes} == {1}
        assert said(bench.ask(1, mks.MoveAbsoluteAxis(10, 60, 0))) == [FAILED] * 6
        assert bench.ask(2, mks.ReadEncoder(), 0.1) == []
