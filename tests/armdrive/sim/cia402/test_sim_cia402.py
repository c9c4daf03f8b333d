"""A simulated CiA 402 drive moves as the profile says, and its arm with it."""

import json
import math

import pytest
from bus_sim import IDS
from cia402_sim import (
    CSP,
    ENABLE,
    HOMING,
    PERIOD_S,
    PP,
    QUICK_STOP,
    TURN,
    Bench,
    arm_config,
)

from armdrive.config.sections import HomingSettings
from armdrive.registry import simulate
from armdrive.sim.mechanics.motors import SwitchState
from firmware_protocol import canopen
from kinematics import Motors

GO = ENABLE | canopen.ControlBit.NEW_SET_POINT | canopen.ControlBit.AT_ONCE
BEHIND = ENABLE | canopen.ControlBit.NEW_SET_POINT
RELATIVE = GO | canopen.ControlBit.RELATIVE
HALT = ENABLE | canopen.ControlBit.HALT
RATE, UP, DOWN = 10_000, 20_000, 40_000
LATE_S = 0.02
METHOD, OFFSET = canopen.Place(0x6098), canopen.Place(0x607C)
HOMED = canopen.StatusBit.REACHED | canopen.StatusBit.ACKNOWLEDGED


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture
def profile(bench):
    bench.enable(1, mode=PP)
    for place, value in (
        (canopen.PROFILE_SPEED, RATE),
        (canopen.PROFILE_ACCELERATION, UP),
        (canopen.PROFILE_DECELERATION, DOWN),
    ):
        bench.write(1, place, value)
    return bench


@pytest.fixture
def cyclic(bench):
    bench.set_up(1)
    bench.enable(1)
    return bench


def hand_over(bench, target, word=GO):
    bench.write(1, canopen.TARGET_POSITION, target)
    bench.write(1, canopen.CONTROLWORD, word)
    bench.write(1, canopen.CONTROLWORD, ENABLE)


def drive_along(bench, targets):
    for target in targets:
        bench.order(1, ENABLE, CSP, target)
        bench.sync()


class TestStates:
    def test_found_drives_neither_hold_nor_move(self, bench):
        assert bench.state(1).state is canopen.DriveState.DISABLED
        assert not bench.world.energised

    def test_enabling_holds_the_shaft_where_it_is_and_disabling_lets_the_arm_sag(self, bench):
        before = bench.world.motors
        bench.enable(*IDS, mode=PP)
        assert bench.state(6).state is canopen.DriveState.ENABLED
        assert bench.world.energised
        assert bench.world.motors == before
        bench.write(2, canopen.CONTROLWORD, 0)
        assert bench.state(2).state is canopen.DriveState.DISABLED
        assert bench.world.motors[1] != before[1]
        assert bench.count(2) == bench.world.motors[1] - before[1]

    @pytest.mark.parametrize(
        ("option", "ends"),
        [
            (canopen.QuickStopOption.DISABLE, canopen.DriveState.DISABLED),
            (canopen.QuickStopOption.QUICK_RAMP, canopen.DriveState.DISABLED),
            (canopen.QuickStopOption.QUICK_RAMP_AND_STAY, canopen.DriveState.QUICK_STOP),
            (canopen.QuickStopOption.CURRENT_LIMIT_AND_STAY, canopen.DriveState.QUICK_STOP),
        ],
    )
    def test_a_quick_stop_ends_as_its_option_says(self, profile, option, ends):
        profile.write(1, canopen.QUICK_STOP_OPTION, option)
        hand_over(profile, 10 * TURN)
        profile.run(1.0)
        profile.write(1, canopen.CONTROLWORD, QUICK_STOP)
        profile.run(0.1)
        assert profile.state(1).state is ends
        assert profile.board.nodes[0].motor.holding is ends.holds
        there = profile.count(1)
        profile.run(1.0)
        assert profile.count(1) == there

    def test_a_quick_stop_goes_by_its_ramp_and_is_led_out_of_without_moving(self, profile):
        profile.write(1, canopen.QUICK_STOP_OPTION, canopen.QuickStopOption.QUICK_RAMP_AND_STAY)
        profile.write(1, canopen.QUICK_STOP_DECELERATION, RATE)
        hand_over(profile, 10 * TURN)
        profile.run(1.5)
        begins = profile.count(1)
        profile.write(1, canopen.CONTROLWORD, QUICK_STOP)
        profile.run(0.9)
        assert not profile.state(1).has(canopen.StatusBit.REACHED)
        profile.run(0.2)
        assert profile.state(1).has(canopen.StatusBit.REACHED)
        there = profile.count(1)
        assert there - begins == pytest.approx(RATE / 2, abs=RATE * LATE_S)
        profile.write(1, canopen.CONTROLWORD, ENABLE)
        profile.run(1.0)
        assert profile.state(1).state is canopen.DriveState.ENABLED
        assert profile.count(1) == there


class TestProfile:
    def test_a_trapezoid_is_driven_with_both_ramps(self, profile):
        hand_over(profile, 2 * TURN)
        profile.run(0.25)
        speed = profile.read(1, canopen.Place(0x606C))
        assert speed == pytest.approx(UP * 0.25, abs=UP * LATE_S)
        assert not profile.state(1).has(canopen.StatusBit.REACHED)
        profile.run(0.4)
        assert profile.read(1, canopen.Place(0x606C)) == RATE
        # half a second up, a quarter down, and what is between at full speed
        total_s = 0.5 + 0.25 + (2 * TURN - RATE * 0.375) / RATE
        profile.run(total_s - 0.65 - 2 * LATE_S)
        assert not profile.state(1).has(canopen.StatusBit.REACHED)
        profile.run(4 * LATE_S)
        assert profile.state(1).has(canopen.StatusBit.REACHED)
        assert profile.count(1) == 2 * TURN

    def test_a_target_is_relative_or_not_replaces_comes_behind_and_is_within_limits(self, profile):
        hand_over(profile, TURN)
        hand_over(profile, -TURN // 10)
        profile.run(2.0)
        assert profile.count(1) == -TURN // 10
        hand_over(profile, 1000)
        hand_over(profile, 2000, BEHIND)
        assert profile.state(1).has(canopen.StatusBit.ACKNOWLEDGED)
        profile.run(2.0)
        assert profile.count(1) == 2000
        hand_over(profile, 700, RELATIVE)
        hand_over(profile, 600, RELATIVE)
        profile.run(2.0)
        assert profile.count(1) == 3300
        profile.write(1, canopen.Place(0x607D, 2), 500)
        hand_over(profile, TURN)
        profile.run(1.0)
        assert profile.count(1) == 500
        assert profile.state(1).has(canopen.StatusBit.LIMITED)

    def test_a_halt_holds_until_it_ends(self, profile):
        hand_over(profile, TURN)
        profile.run(0.6)
        profile.write(1, canopen.CONTROLWORD, HALT)
        profile.run(0.5)
        there = profile.count(1)
        assert 0 < there < TURN
        assert profile.state(1).has(canopen.StatusBit.REACHED)
        profile.write(1, canopen.CONTROLWORD, ENABLE)
        profile.run(1.5)
        assert profile.count(1) == TURN

    def test_no_word_of_arrival_may_come(self, profile):
        profile.twin.faults.add("no-done", "1")
        hand_over(profile, 100)
        profile.run(1.0)
        assert profile.count(1) == 100
        assert not profile.state(1).has(canopen.StatusBit.REACHED)


class TestCyclic:
    def test_targets_are_interpolated_from_sync_to_sync(self, cyclic):
        before = cyclic.world.motors
        cyclic.order(1, ENABLE, CSP, 50)
        cyclic.run(0.1)
        assert cyclic.count(1) == 0  # not before the SYNC
        drive_along(cyclic, range(50, 1001, 50))
        cyclic.order(1, ENABLE, CSP, 1100)
        told = cyclic.sync(PERIOD_S / 2)[1]
        assert told[0].state is canopen.DriveState.ENABLED
        assert told[0].has(canopen.StatusBit.ACKNOWLEDGED)
        assert told[1:] == (CSP, 1000)
        assert cyclic.count(1) == pytest.approx(1050, abs=20)
        cyclic.run()
        assert (cyclic.world.motors - before) == (1100, 0, 0, 0, 0, 0)

    @pytest.mark.parametrize(("quirk", "goes_on"), [("hold", False), ("extrapolate", True)])
    def test_the_behaviour_of_a_drive_whose_targets_stop(self, quirk, goes_on):
        bench = Bench(hold_after_loss=quirk)
        bench.set_up(1)
        bench.enable(1)
        drive_along(bench, range(50, 501, 50))
        bench.run(0.2)
        assert (bench.count(1) > 1000) is goes_on
        assert goes_on or bench.count(1) == 500

    def test_a_target_too_far_is_not_followed_and_is_an_error(self, cyclic):
        cyclic.write(1, canopen.FOLLOWING_ERROR_WINDOW, 1000)
        cyclic.write(1, canopen.FOLLOWING_ERROR_TIMEOUT_MS, 20)
        drive_along(cyclic, [100 * TURN])
        cyclic.run(0.5)
        word = cyclic.state(1)
        assert word.state is canopen.DriveState.FAULT
        assert word.has(canopen.StatusBit.FOLLOWING_ERROR)
        assert cyclic.read(1, canopen.ERROR_CODE) == 0x8611
        assert cyclic.count(1) < 10 * TURN

    def test_an_old_target_is_gone_to_as_soon_as_the_mode_begins(self, bench):
        bench.write(1, canopen.TARGET_POSITION, 300)
        bench.enable(1, mode=PP)
        bench.write(1, canopen.TARGET_POSITION, 300)
        bench.run(0.1)
        assert bench.count(1) == 0
        bench.write(1, canopen.MODE, CSP)
        bench.run(0.1)
        assert bench.count(1) == 300

    def test_a_drive_without_the_mode_refuses_it(self):
        bench = Bench(csp=False)
        assert bench.read(1, canopen.Place(0x6502)) == 0b100001
        assert bench.write(1, canopen.MODE, CSP) == canopen.AbortCode.VALUE
        bench.set_up(1)
        bench.enable(1, mode=PP)
        bench.order(1, ENABLE, CSP, 1000)
        bench.sync()
        assert bench.sync()[1][1:] == (PP, 0)


class TestStalls:
    def test_a_shaft_that_does_not_follow_is_a_fault_and_comes_down(self, profile):
        profile.enable(2, mode=PP)
        profile.write(1, canopen.FOLLOWING_ERROR_WINDOW, 500)
        profile.write(1, canopen.FOLLOWING_ERROR_TIMEOUT_MS, 50)
        profile.twin.faults.add("stall", "1")
        hand_over(profile, TURN)
        heard = profile.run(1.0)
        said = [canopen.Emergency.read(frame) for frame in heard if frame.can_id == 0x81]
        assert [each.code for each in said] == [0x8611]
        assert profile.state(1).state is canopen.DriveState.FAULT
        assert not profile.board.nodes[0].motor.holding
        assert profile.board.nodes[1].motor.holding

    def test_a_fault_is_reset_by_a_rising_edge_alone(self, profile):
        profile.board.put_in_fault(0, 0x4310)
        profile.run(0.1)
        profile.write(1, canopen.CONTROLWORD, 0x80)
        assert profile.state(1).state is canopen.DriveState.FAULT  # still too hot
        profile.board.fix(0, 0x4310)
        profile.write(1, canopen.CONTROLWORD, 0x80)
        assert profile.state(1).state is canopen.DriveState.FAULT  # no edge
        profile.write(1, canopen.CONTROLWORD, 0)
        profile.heard.clear()
        profile.write(1, canopen.CONTROLWORD, 0x80)
        said = [canopen.Emergency.read(frame) for _, frame in profile.heard if frame.can_id == 0x81]
        assert [each.code for each in said] == [0]
        assert profile.state(1).state is canopen.DriveState.DISABLED
        assert profile.read(1, canopen.ERROR_CODE) == 0

    def test_a_push_is_turned_back_and_seen_meanwhile(self, profile):
        profile.twin.world.stalled.add(0)
        profile.device.push([400, 0, 0, 0, 0, 0])
        assert profile.count(1) == 400
        assert profile.read(1, canopen.FOLLOWING_ERROR) == -400
        profile.twin.world.stalled.clear()
        profile.run(0.1)
        assert profile.count(1) == 0


class TestHoming:
    AHEAD = TURN

    def fitted(self, ahead=AHEAD, **settings):
        probe = simulate(arm_config())
        goal = probe.world.motors + Motors((ahead, 0, 0, 0, 0, 0))
        joints, opening_mm = probe.world.body.transmission.to_joints(goal)
        bench = Bench(config=arm_config(HomingSettings(joints, opening_mm)), **settings)
        bench.enable(1, mode=HOMING)
        bench.write(1, METHOD, 18 if ahead > 0 else 17)
        return bench, bench.world.motors[0] + ahead

    @pytest.mark.parametrize("ahead", [AHEAD, -AHEAD])
    def test_the_switch_is_sought_left_and_called_home(self, ahead):
        bench, goal = self.fitted(ahead)
        bench.write(1, OFFSET, 1234)
        bench.write(1, canopen.CONTROLWORD, ENABLE | canopen.ControlBit.NEW_SET_POINT)
        assert not bench.state(1).value & HOMED
        bench.run(3.0)
        assert bench.state(1).value & HOMED == HOMED
        assert bench.world.motors[0] == goal
        assert bench.count(1) == 1234

    @pytest.mark.parametrize("ahead", [AHEAD, -AHEAD])
    def test_a_search_that_begins_at_the_switch_leaves_it(self, ahead):
        bench, goal = self.fitted(ahead)
        bench.write(1, canopen.MODE, PP)
        hand_over(bench, ahead + (500 if ahead > 0 else -500))
        bench.run(20.0)
        assert bench.device.inputs & 1
        assert bench.read(1, canopen.DIGITAL_INPUTS) == (2 if ahead > 0 else 1)
        bench.write(1, canopen.MODE, HOMING)
        bench.write(1, canopen.CONTROLWORD, ENABLE | canopen.ControlBit.NEW_SET_POINT)
        bench.run(3.0)
        assert bench.world.motors[0] == goal
        assert bench.count(1) == 0

    @pytest.mark.parametrize("ahead", [AHEAD, -AHEAD])
    def test_a_search_for_the_other_switch_runs_away_from_this_one(self, ahead):
        bench, _ = self.fitted(ahead)
        bench.write(1, METHOD, 17 if ahead > 0 else 18)
        began = bench.world.motors[0]
        bench.write(1, canopen.CONTROLWORD, ENABLE | canopen.ControlBit.NEW_SET_POINT)
        bench.run(3.0)
        assert not bench.state(1).has(canopen.StatusBit.ACKNOWLEDGED)
        assert (bench.world.motors[0] - began) * ahead < 0
        assert bench.device.moving

    @pytest.mark.parametrize("state", [SwitchState.OPEN, SwitchState.CLOSED])
    def test_a_switch_that_sticks_is_never_found(self, state):
        bench, _ = self.fitted()
        bench.board.set_switch(0, state)
        bench.write(1, canopen.CONTROLWORD, ENABLE | canopen.ControlBit.NEW_SET_POINT)
        bench.run(3.0)
        assert not bench.state(1).has(canopen.StatusBit.ACKNOWLEDGED)
        assert bench.device.moving

    @pytest.mark.parametrize("word", [ENABLE, HALT | canopen.ControlBit.NEW_SET_POINT, QUICK_STOP])
    def test_a_search_is_broken_off(self, word):
        bench, _ = self.fitted()
        bench.write(1, canopen.CONTROLWORD, ENABLE | canopen.ControlBit.NEW_SET_POINT)
        bench.run(0.3)
        bench.write(1, canopen.CONTROLWORD, word)
        bench.run(0.5)
        there = bench.count(1)
        assert 0 < there < self.AHEAD
        assert not bench.state(1).has(canopen.StatusBit.ACKNOWLEDGED)
        bench.run(1.0)
        assert bench.count(1) == there

    @pytest.mark.parametrize("method", [35, 37])
    def test_home_may_be_where_it_stands(self, bench, method):
        bench.enable(1, mode=HOMING)
        bench.write(1, METHOD, method)
        bench.write(1, OFFSET, -77)
        bench.write(1, canopen.CONTROLWORD, ENABLE | canopen.ControlBit.NEW_SET_POINT)
        assert bench.state(1).value & HOMED == HOMED
        assert bench.count(1) == -77

    def test_without_a_method_it_fails(self, bench):
        assert bench.write(1, METHOD, 24) == canopen.AbortCode.VALUE
        bench.enable(1, mode=HOMING)
        bench.write(1, canopen.CONTROLWORD, ENABLE | canopen.ControlBit.NEW_SET_POINT)
        assert bench.state(1).has(canopen.StatusBit.FOLLOWING_ERROR)

    def test_a_limit_switch_stops_what_leads_into_it(self):
        bench, goal = self.fitted(limits=True)
        bench.write(1, canopen.QUICK_STOP_OPTION, canopen.QuickStopOption.QUICK_RAMP_AND_STAY)
        bench.write(1, canopen.MODE, PP)
        hand_over(bench, 5 * self.AHEAD)
        heard = bench.run(2.0)
        assert [canopen.Emergency.read(f).code for f in heard if f.can_id == 0x81] == [0x8612]
        assert bench.state(1).state is canopen.DriveState.QUICK_STOP
        assert 0 < bench.world.motors[0] - goal < TURN


class TestSaving:
    def test_a_drive_is_made_again_as_it_stood(self, cyclic):
        drive_along(cyclic, range(50, 501, 50))
        cyclic.run()
        saved = json.loads(json.dumps(cyclic.twin.save()))
        again = Bench(saved=saved)
        assert again.twin.save() == saved
        assert again.world.motors == cyclic.world.motors
        told = again.sync()[1]
        assert told[0].state is canopen.DriveState.ENABLED
        assert told[1:] == (CSP, 500)
        drive_along(again, [550, 600])
        again.run()
        assert again.count(1) == 600

    @pytest.mark.parametrize("state", ["quick_stop", "fault"])
    def test_one_that_does_nothing_more_is_made_again_so(self, profile, state):
        profile.write(1, canopen.QUICK_STOP_OPTION, canopen.QuickStopOption.QUICK_RAMP_AND_STAY)
        if state == "fault":
            profile.board.put_in_fault(0, 0x4310)
        else:
            profile.write(1, canopen.CONTROLWORD, QUICK_STOP)
        profile.run()
        again = Bench(saved=json.loads(json.dumps(profile.twin.save())))
        assert again.state(1).state is canopen.DriveState[state.upper()]
        assert again.device.board.nodes[0].motor.holding is (state == "quick_stop")

    def test_the_reported_state_of_a_drive(self, profile):
        profile.watch(1, 200)
        seen = profile.device.board.details()["drives"][0]
        assert seen["state"] == "enabled"
        assert seen["statusword"] == "0637"
        assert seen["watch_s"] == 0.2
        assert math.isclose(seen["rate"], 0.0)
