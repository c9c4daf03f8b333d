"""Simulated MKS drives: orders, settings, faults."""

import json
import math

import pytest
from bus_sim import IDS
from mks_sim import DONE, FAILED, LIMIT_STOP, STARTED, TURN, Bench, arm_config
from mks_sim import outcomes as said

from armdrive.config.sections import HomingSettings
from armdrive.errors import BadRequest
from firmware_protocol import mks
from kinematics import Joints

LATE_S = 0.002
"""What the bus and a drive take to say something."""
CARRIED_OUT, GIVEN_UP = [STARTED, DONE], [STARTED, FAILED]


@pytest.fixture
def bench():
    return Bench()


class TestMoving:
    def test_an_absolute_motion_turns_the_shaft_and_the_arm(self, bench):
        before = bench.world.motors
        heard = bench.ask(2, mks.MoveAbsoluteAxis(-TURN, 60, 0), 1.5)
        assert said(heard) == CARRIED_OUT
        assert bench.time_of(DONE) == pytest.approx(1.0, abs=LATE_S)
        assert (bench.world.motors - before) == (0, -TURN, 0, 0, 0, 0)
        assert bench.counts(2) == -TURN
        assert bench.world.joints["shoulder"] == pytest.approx(
            math.radians(70 + 360 / 50), abs=1e-4
        )

    def test_a_ramp_is_as_steep_as_its_acc_says(self, bench):
        # 1 rpm every (256 - 240) * 50 us: 600 rpm in 0.48 s, 2.4 turns up and as many down
        bench.ask(1, mks.MoveAbsoluteAxis(10 * TURN, 600, 240), 0.1)
        assert bench.state(1) is mks.MotorState.ACCELERATING
        bench.run(0.5)
        assert bench.state(1) is mks.MotorState.FULL_SPEED
        bench.run(0.5)
        assert bench.state(1) is mks.MotorState.DECELERATING
        bench.run(1.0)
        assert bench.state(1) is mks.MotorState.STOPPED
        assert bench.time_of(DONE) == pytest.approx(2 * 0.48 + (10 - 4.8) / 10, abs=LATE_S)

    @pytest.mark.parametrize("request_", [mks.Stop(0), mks.EmergencyStop()])
    def test_without_a_ramp_it_stands_at_once(self, bench, request_):
        bench.ask(1, mks.MoveAbsoluteAxis(10 * TURN, 60, 0), 1.0)
        bench.send(1, request_)
        bench.run()
        assert bench.counts(1) == pytest.approx(TURN, abs=20)
        there = bench.world.motors
        bench.run(1.0)
        assert bench.world.motors == there

    def test_it_sets_no_zero_in_motion_and_ignores_other_kinds_of_motions(self, bench):
        bench.ask(1, mks.MoveAbsoluteAxis(TURN, 60, 0), 0.1)
        assert said(bench.ask(1, mks.SetZero())) == [FAILED]
        by_a_turn = mks.OtherMotion(mks.Code.RELATIVE_AXIS, bytes.fromhex("003C00004000"))
        assert bench.ask(1, by_a_turn) == []
        bench.run(1.0)
        assert bench.counts(1) == TURN

    def test_zero_is_where_the_shaft_stands_and_the_raw_count_goes_on(self, bench):
        bench.ask(1, mks.MoveAbsoluteAxis(1000, 100, 0), 1.0)
        there = bench.world.motors
        bench.ask(1, mks.SetZero())
        assert bench.counts(1) == 0
        assert bench.ask(1, mks.ReadRawEncoder())[0].answer.counts == 1000
        bench.ask(1, mks.MoveAbsoluteAxis(TURN, 100, 0), 1.0)
        assert bench.world.motors[0] == there[0] + TURN

    def test_calibration_turns_the_shaft_and_takes_its_time(self, bench):
        there = bench.world.motors
        assert said(bench.ask(1, mks.Calibrate(), 2.0)) == [STARTED]
        assert bench.state(1) is mks.MotorState.CALIBRATING
        assert bench.world.motors != there
        assert said(bench.run(3.0)) == [DONE]
        assert bench.world.motors == there


class TestHolding:
    def test_nothing_moves_in_another_mode_than_the_buss_foc(self, bench):
        there = bench.world.motors
        for mode in set(mks.Mode) - {mks.Mode.BUS_FOC}:
            bench.ask(1, mks.SetMode(mode))
            for request in (mks.MoveAbsoluteAxis(100, 60, 0), mks.Home()):
                assert said(bench.ask(1, request, 0.5)) == [FAILED]
        assert bench.world.motors == there

    def test_without_current_what_it_holds_comes_down_and_it_knows_how_far(self, bench):
        before = bench.world.pose
        assert said(bench.ask(2, mks.Enable(False))) == [DONE]
        assert not bench.world.energised
        fallen = bench.counts(2)
        assert bench.world.pose.z_mm < before.z_mm - 1.0
        assert said(bench.ask(2, mks.MoveAbsoluteAxis(0, 60, 0))) == [FAILED]
        assert bench.ask(2, mks.ReadEnabled())[0].answer.on is False
        there = bench.world.motors
        assert said(bench.ask(2, mks.Enable(True), 0.2)) == [DONE]
        assert (bench.world.motors, bench.counts(2)) == (there, fallen)
        assert bench.world.energised
        bench.ask(2, mks.MoveAbsoluteAxis(0, 60, 200), 2.0)
        assert bench.world.motors[1] == there[1] - fallen


class TestStalls:
    def test_a_stalled_drive_says_so_and_lets_its_shaft_go(self, bench):
        bench.world.stalled.add(1)
        there = bench.world.motors
        heard = bench.ask(2, mks.MoveAbsoluteAxis(TURN, 60, 0), 0.5)
        assert said(heard) == GIVEN_UP
        # a tenth of a turn behind after 0.1 s, looked at every 10 ms, and 50 ms of patience
        assert bench.time_of(FAILED) == pytest.approx(0.16, abs=0.015)
        assert bench.ask(2, mks.ReadStall())[0].answer.on
        assert not bench.world.energised
        assert bench.world.motors != there
        assert said(bench.ask(2, mks.MoveAbsoluteAxis(0, 60, 0))) == [FAILED]
        assert said(bench.ask(2, mks.Enable(True))) == [FAILED]

    def test_cleared_it_holds_where_it_is_and_moves_again(self, bench):
        bench.world.stalled.add(0)
        bench.ask(1, mks.MoveAbsoluteAxis(TURN, 60, 0), 0.5)
        bench.world.stalled.clear()
        assert said(bench.ask(1, mks.ClearStall())) == [DONE]
        assert bench.world.energised
        bench.ask(1, mks.MoveAbsoluteAxis(TURN, 60, 0), 1.5)
        assert bench.counts(1) == TURN

    def test_unprotected_it_goes_on_pulling_and_its_motion_is_never_done(self, bench):
        bench.ask(1, mks.SetStallProtection(False))
        bench.world.stalled.add(0)
        heard = bench.ask(1, mks.MoveAbsoluteAxis(TURN, 60, 0), 3.0)
        assert said(heard) == [STARTED]
        assert bench.state(1) is mks.MotorState.STOPPED
        assert bench.ask(1, mks.ReadAngleError())[0].answer.error == 51200
        assert not bench.ask(1, mks.ReadStall())[0].answer.on
        bench.world.stalled.clear()
        assert said(bench.run(0.5)) == [DONE]
        assert bench.counts(1) == TURN


class TestSwitches:
    def test_homing_ends_at_the_switch_and_calls_it_zero(self):
        homed = HomingSettings(Joints.of(30, 70, -95, -35, 0), 20.0)
        bench = Bench(config=arm_config(homed))
        assert said(bench.ask(1, mks.Home(), 1.0)) == [STARTED]
        assert bench.state(1) is mks.MotorState.HOMING
        assert bench.ask(1, mks.ReadHoming())[0].answer.by_command is mks.HomingState.UNDER_WAY
        assert said(bench.ask(1, mks.MoveAbsoluteAxis(0, 60, 0))) == [FAILED]
        assert said(bench.run(4.0)) == [DONE]
        assert bench.ask(1, mks.ReadHoming())[0].answer.by_command is mks.HomingState.DONE
        assert bench.counts(1) == 0
        assert bench.world.joints.deg["base"] == pytest.approx(30.0, abs=0.01)
        there = bench.world.motors
        for away in (-TURN, TURN):  # from the second place, it first backs off its switch
            bench.ask(1, mks.MoveAbsoluteAxis(away, 300, 240), 2.0)
            assert said(bench.ask(1, mks.Home(), 5.0)) == CARRIED_OUT
            assert bench.world.motors == there

    def test_a_switch_below_is_found_left_and_minded_from_its_own_side(self):
        homed = HomingSettings(Joints.of(-10, 70, -95, -35, 0), 20.0)
        bench = Bench(config=arm_config(homed), limits=True)
        for _ in range(2):  # the second time, it begins at its switch
            assert said(bench.ask(1, mks.Home(), 10.0)) == CARRIED_OUT
            assert bench.world.joints.deg["base"] == pytest.approx(-10.0, abs=0.01)
            assert bench.counts(1) == 0
        heard = bench.ask(1, mks.MoveAbsoluteAxis(-TURN, 60, 0), 2.0)
        assert said(heard) == [STARTED, LIMIT_STOP]
        assert said(bench.ask(1, mks.MoveAbsoluteAxis(TURN, 60, 0), 2.0)) == CARRIED_OUT

    def test_against_a_stop_it_feels_for_the_end(self, bench):
        bench.ask(1, mks.SetHoming(False, True, 120, False, 1))
        assert said(bench.ask(1, mks.Home(), 8.0)) == CARRIED_OUT
        assert bench.world.joints.deg["base"] == pytest.approx(93.0, abs=0.01)
        assert bench.counts(1) == 0


class TestPower:
    def test_without_power_nobody_answers_and_positions_are_lost(self, bench):
        bench.ask(1, mks.MoveAbsoluteAxis(5000, 60, 240), 1.0)
        bench.device.power_off()
        assert not bench.world.energised
        assert bench.ask(1, mks.ReadEncoder(), 0.5) == []
        bench.host.forget(1)
        bench.device.power_on()
        assert [bench.counts(node) for node in IDS] == [0] * 6
        assert bench.world.energised

    def test_a_position_may_be_kept_within_a_turn(self):
        bench = Bench(keeps_angle=True)
        before = bench.counts(1)
        bench.ask(1, mks.MoveAbsoluteAxis(TURN + 5000, 60, 240), 3.0)
        bench.device.power_off()
        bench.device.power_on()
        assert bench.counts(1) == (before + 5000) % TURN

    def test_a_saved_arm_goes_on_where_it_was(self, bench):
        bench.ask(1, mks.MoveAbsoluteAxis(5000, 60, 240), 1.0)
        bench.ask(2, mks.SetMicrosteps(64))
        bench.ask(3, mks.Enable(False))
        saved = json.loads(json.dumps(bench.twin.save()))
        again = Bench(saved=saved)
        assert again.twin.save() == saved
        assert again.counts(1) == 5000
        assert again.ask(2, mks.ReadSetting(mks.Code.MICROSTEPS))[0].answer.value == b"\x40"
        assert [node.enabled for node in again.device.board.nodes].index(False) == 2
        there = again.world.motors
        again.run(1.0)
        assert again.world.motors == there


# -- Faults ----------------------------------------------------------------------------------------


class TestDrives:
    def test_a_dead_one_lets_its_shaft_go_and_comes_back_at_zero(self, bench):
        bench.ask(2, mks.MoveAbsoluteAxis(500, 60, 0), 0.5)
        height_mm = bench.world.pose.z_mm
        bench.twin.faults.add("drive-dead", 2, for_s=1.0)
        bench.twin.faults.add("drive-reset", 2)
        assert bench.ask(2, mks.ReadEncoder(), 0.5) == []
        assert bench.world.pose.z_mm < height_mm
        assert not bench.world.energised
        bench.host.forget(2)
        bench.run(0.6)
        assert bench.counts(2) == 0
        assert bench.world.energised
        bench.twin.faults.add("drive-dead", 2)
        bench.device.power_off()
        bench.twin.faults.end()
        assert not bench.board.nodes[1].port.powered

    def test_reset_in_motion_it_stops_and_knows_nothing_any_more(self, bench):
        bench.send(1, mks.MoveAbsoluteAxis(5 * TURN, 60, 0))
        bench.twin.faults.add("drive-reset", "base", after_s=1.0)
        assert said(bench.run(3.0)) == [STARTED]
        bench.host.forget(1)
        assert bench.counts(1) == 0
        assert bench.state(1) is mks.MotorState.STOPPED
        assert bench.world.joints.deg["base"] == pytest.approx(360 / 50, abs=0.1)

    def test_two_of_one_id_both_answer(self, bench):
        bench.ask(2, mks.MoveAbsoluteAxis(500, 60, 0), 0.5)
        bench.twin.faults.add("drive-id", 2, 1)
        assert said(bench.ask(1, mks.ReadVersion())) == [mks.VersionRead] * 2
        heard = bench.ask(1, mks.ReadEncoder(), 0.1)
        assert said(heard) == [mks.EncoderRead] * 2
        assert [heard[0].answer.counts, heard[1].answer.counts] == [0, 500]
        there = bench.world.motors
        bench.ask(1, mks.MoveAbsoluteAxis(900, 60, 0), 0.5)
        assert tuple(bench.world.motors - there) == (900, 400, 0, 0, 0, 0)
        assert bench.ask(2, mks.ReadEncoder()) == []
        bench.twin.faults.end()
        bench.host.forget(2)
        assert bench.counts(2) == 900

    @pytest.mark.parametrize(
        ("words", "named"),
        [
            (("drive-mode", 1, 9), "modes are 0 to 5"),
            (("drive-id", 1, 4000), "node must be"),
            (("drive-mute", 7), "motors are 1 to 6"),
        ],
    )
    def test_a_fault_that_no_drive_can_have_is_refused(self, bench, words, named):
        with pytest.raises(BadRequest, match=named):
            bench.twin.faults.add(*words)
