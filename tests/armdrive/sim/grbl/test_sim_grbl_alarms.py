"""Resets, limits and their alarms on the simulated GRBL board."""

from __future__ import annotations

import pytest
from grbl_bench import MACHINE, SLOPE, Bench, with_switches_ahead

from armdrive.errors import BadRequest
from armdrive.sim.device import HasSwitches, Resettable
from armdrive.sim.mechanics.switches import SwitchState
from firmware_protocol.grbl import State

HOLD, RESUME, RESET, DOOR = "!", "~", "\x18", "\x84"
LIMITED = {**MACHINE, 21: 1}
SOFT = {**MACHINE, 22: 1, 20: 1}


def test_a_reset_in_motion_is_an_alarm_and_loses_the_ramp_that_was_not_made():
    bench = Bench()
    before = bench.device.world.motors[0]
    bench.say("G1X100F1500", 1.0)
    assert bench.say(RESET, 0.4) == ["ALARM:3"]
    bench.wait(1.0)
    assert bench.heard[-2:] == ["Grbl 1.1q ['$' for help]", "[MSG:'$H'|'$X' to unlock]"]
    assert bench.ask().state is State.ALARM
    ramp = 25.0**2 / (2 * SLOPE) * 10
    assert bench.device.world.motors[0] - before == pytest.approx(
        bench.board.drive.counts[0] + ramp, abs=1.5
    )
    assert bench.say("G1X5F100") == ["error:9"]
    assert bench.say("$J=X5F100") == ["error:8"]
    assert bench.say("$X") == ["[MSG:Caution: Unlocked]", "ok"]
    assert bench.ask().state is State.IDLE
    bench.say("G1X-100F1500", 1.0)
    bench.put(HOLD + RESET)  # while it brakes
    assert bench.wait(0.4) == ["ALARM:3"]


def test_an_arm_that_does_not_run_on_loses_nothing():
    bench = Bench(coast=0.0)
    before = bench.device.world.motors[0]
    bench.say("G1X100F1500", 1.0)
    bench.say(RESET, 1.0)
    assert bench.device.world.motors[0] - before == bench.board.drive.counts[0]
    with pytest.raises(BadRequest, match="coast"):
        Bench(coast=-1.0)


def test_an_alarm_in_motion_switches_the_motors_off_until_the_board_has_started():
    bench = Bench()
    bench.say("G1X100F1500", 1.0)
    bench.say(RESET, 0.4)
    assert not bench.device.world.energised
    bench.wait(0.6)
    assert bench.device.world.energised
    shoulder = bench.device.world.joints["shoulder"]
    assert shoulder < Bench().device.world.joints["shoulder"]  # it has sagged


@pytest.mark.parametrize(
    ("firmware", "off"),
    [
        ("grbl", (0.255, 0.755)),
        ("mega5x", (0.255, 0.755)),
        ("fluidnc", (0.0, 0.5)),
        ("grblhal", None),
    ],
)
def test_when_a_reset_in_motion_takes_the_current_away_is_that_of_the_firmware(firmware, off):
    bench = Bench({**MACHINE, 1: 255}, firmware=firmware)
    bench.say("G1X100F1500", 1.0)
    bench.put(RESET)
    began_s, seen = bench.now_s, []
    for _ in range(200):
        bench.wait(0.005)
        if not bench.device.world.energised:
            seen.append(bench.now_s - began_s)
    assert bench.heard.count("ALARM:3") == 1
    assert bench.device.world.energised
    if off is None:
        assert not seen
    else:
        assert (seen[0], seen[-1]) == pytest.approx(off, abs=0.015)


def test_a_reset_clears_what_was_queued_and_read():
    bench = Bench()
    bench.say(HOLD)
    bench.put("G1X5F3000\n" * 5)
    bench.wait(0.2)
    bench.say(RESET, 0.5)
    bench.say("", 1.0)
    assert bench.heard[-1] == "ok"
    assert (bench.x, bench.heard.count("ok")) == (0.0, 1)


def test_a_line_at_work_is_answered_with_ok_by_the_reset_that_ends_it():
    bench = Bench()
    bench.say("G4P5")
    bench.say(RESET, 0.2)
    assert bench.heard[-2:] == ["ok", "Grbl 1.1q ['$' for help]"]


def test_a_reset_board_reports_zero_whatever_the_truth_and_the_arm_has_sagged():
    bench = Bench()
    assert isinstance(bench.device.board, Resettable)
    bench.say("G1X50F3000", 3.0)
    before = bench.device.world.motors
    bench.device.board.reset()
    assert bench.wait(0.5) == []  # its loader waits, the motors have no current
    assert not bench.device.world.energised
    bench.wait(2.0)
    assert len(bench.banners) == 2
    assert bench.ask().machine_position == (0.0,) * 6
    assert bench.ask().state is State.IDLE
    assert bench.device.world.energised
    assert bench.device.world.motors[1] != before[1]


def test_with_homing_on_a_board_starts_locked():
    bench = Bench(SOFT)
    bench.device.board.reset()
    bench.wait(2.0)
    assert bench.heard[-1] == "[MSG:'$H'|'$X' to unlock]"
    assert bench.ask().state is State.ALARM
    assert Bench(homing=True).ask().state is State.ALARM


def test_a_safety_door_holds_until_it_is_resumed():
    bench = Bench()
    bench.say("G1X10F600", 0.5)
    bench.say(DOOR, 0.5)
    assert bench.ask().state is State.DOOR
    bench.say(RESUME)
    bench.finish()
    assert bench.x == 10.0


def test_control_pins_do_what_their_commands_do():
    bench = Bench()
    bench.say("G1X10F600", 0.5)
    bench.device.set_input(2, True)
    bench.wait(0.5)
    assert bench.ask().state is State.HOLD
    assert bench.reports[-1].pins == "H"
    bench.device.set_input(2, False)
    bench.device.set_input(3, True)
    bench.finish()
    assert bench.x == 10.0
    bench.device.set_input(4, True)
    bench.wait(0.5)
    assert len(bench.banners) == 2


def test_a_hard_limit_stops_dead_and_the_board_is_mute_until_its_reset():
    bench = with_switches_ahead(Bench(LIMITED, limit_interrupts=True), 10.0)
    bench.say("G1X50F1500", 2.0)
    assert bench.heard[-2:] == ["ALARM:1", "[MSG:Reset to continue]"]
    assert bench.x == pytest.approx(10.0, abs=0.3)
    assert bench.ask() is None
    assert bench.say("$X", 1.0) == []
    assert not bench.device.world.energised
    bench.say(RESET, 0.5)
    assert bench.ask().state is State.ALARM
    assert bench.reports[-1].pins == "X"
    assert bench.device.world.energised
    bench.say("$X")
    bench.say("G1X1F1500", 1.0)  # backing off the switch is a change as well
    assert bench.heard.count("ALARM:1") == 2


@pytest.mark.parametrize(
    "act",
    [
        lambda device: device.board.set_switch(2, SwitchState.CLOSED),
        lambda device: device.push((60, 0, 0, 0, 0, 0)),
    ],
)
def test_a_switch_that_closes_at_rest_is_a_hard_limit(act):
    bench = with_switches_ahead(Bench(LIMITED, firmware="grblhal"), 5.0)
    assert isinstance(bench.device.board, HasSwitches)
    act(bench.device)
    assert bench.wait(0.1) == ["ALARM:1", "[MSG:Reset to continue]"]
    assert bench.ask().state is State.ALARM  # the newer firmware goes on reporting
    with pytest.raises(BadRequest, match="0 to 5"):
        bench.device.board.set_switch(6, SwitchState.OPEN)


@pytest.mark.parametrize(("firmware", "line"), [("mega5x", "$21=1"), ("grbl", "$21=0")])
def test_without_hard_limits_a_switch_only_shows(firmware, line):
    """The usual build of six axes accepts $21=1 and does nothing."""
    bench = with_switches_ahead(Bench(firmware=firmware), 10.0)
    assert bench.say(line) == ["ok"]
    bench.say("G1X12F1500", 2.0)
    bench.device.board.set_switch(2, SwitchState.CLOSED)
    bench.wait(0.1)
    assert (bench.ask().state, bench.reports[-1].pins) == (State.IDLE, "XZ")


def test_a_target_outside_the_travel_is_refused_of_a_jog_and_an_alarm_of_a_move():
    bench = Bench(SOFT)
    bench.say("$X")
    bench.say("$J=X-10F3000", 2.0)
    assert bench.x == -10.0
    assert bench.say("$J=X1F3000") == ["error:15"]
    assert bench.say("$J=X-201F3000") == ["error:15"]
    assert bench.say("G1X1F3000", 1.0) == ["ALARM:2", "[MSG:Reset to continue]"]
    assert bench.ask() is None
    bench.say(RESET, 0.5)
    bench.say("$X")
    assert (bench.ask().machine_position[0], bench.ask().state) == (-10.0, State.IDLE)


def test_a_move_under_way_brakes_before_a_soft_limit_alarm_and_keeps_its_place():
    bench = Bench(SOFT)
    bench.say("$X")
    bench.say("G1X-100F1500", 1.0)
    bench.say("G1X5", 1.0)
    assert bench.heard[-2:] == ["ALARM:2", "[MSG:Reset to continue]"]
    assert bench.x == pytest.approx(-27.0, abs=1.0)
    assert bench.device.world.motors[0] == bench.board.drive.counts[0]
