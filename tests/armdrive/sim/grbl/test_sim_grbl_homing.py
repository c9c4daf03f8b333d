"""Homing on the simulated GRBL board, with switches that work and switches that do not."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import pytest
from grbl_bench import HOMING, Bench, config_of, homing_bench, stands_at

from armdrive.config.sections import HomingSettings
from armdrive.sim.mechanics.switches import LimitSwitch, SwitchState
from firmware_protocol.grbl import State

RESET = "\x18"


def test_homing_over_a_hundred_units_takes_three_and_a_half_seconds():
    """Seen on a Mega for one axis; the default build homes one axis after another."""
    bench = homing_bench()
    began_s = bench.now_s
    bench.put("$H\n")
    while "ok" not in bench.wait(0.01):
        assert bench.now_s < 20.0
    assert bench.now_s - began_s == pytest.approx(3.6, abs=0.2)
    assert bench.ask().machine_position == (-1.0,) * 6
    assert bench.reports[-1].state is State.IDLE
    expected = [switch.at - 10 for switch in bench.board.switches.by_axis.values()]
    assert list(bench.device.world.motors) == expected


def test_an_axis_homes_alone_and_downwards_where_its_bit_says_so():
    bench = homing_bench({**HOMING, 23: 1})
    low = LimitSwitch(partial(stands_at, bench, 0), -300, -1)
    bench.board.switches.by_axis = {**bench.board.switches.by_axis, 0: low}
    bench.say("$HX", 20.0)
    assert bench.ask().machine_position == (-199.0, 0, 0, 0, 0, 0)
    assert bench.device.world.motors[0] == -290


def test_the_board_is_silent_while_it_homes():
    bench = homing_bench()
    bench.say("$H", 0.5)
    assert bench.ask() is None
    bench.wait(10.0)
    assert bench.heard[-2] == "ok"
    newer = Bench({**HOMING}, firmware="grblhal")
    newer.say("$H", 0.5)
    assert newer.ask().state is State.HOME


def test_a_switch_that_is_stuck_open_is_not_found():
    bench = homing_bench()
    bench.device.board.set_switch(3, SwitchState.OPEN)
    start = bench.device.world.motors[3]
    bench.say("$H", 60.0)
    assert bench.heard[-4:] == [
        "ALARM:9",
        "ok",
        "Grbl 1.1q ['$' for help]",
        "[MSG:'$H'|'$X' to unlock]",
    ]
    assert bench.device.world.motors[3] - start == 1.5 * 200 * 10
    assert bench.ask().state is State.ALARM
    assert bench.device.world.energised


def test_a_switch_that_is_stuck_closed_is_not_left_by_pulling_off():
    bench = homing_bench()
    bench.device.board.set_switch(3, SwitchState.CLOSED)
    bench.say("$H", 60.0)
    assert "ALARM:8" in bench.heard
    assert bench.ask().state is State.ALARM
    bench.device.board.set_switch(3, SwitchState.FREE)
    bench.say("$H", 60.0)
    assert bench.ask().state is State.IDLE


def test_a_reset_ends_homing_with_an_alarm():
    bench = homing_bench()
    bench.say("$H", 1.0)
    bench.say(RESET, 2.0)
    assert "ALARM:6" in bench.heard
    assert bench.ask().state is State.ALARM


def test_homing_ends_in_the_posture_of_the_arm_file():
    config = config_of(homing=True)
    there = config.model.arm.ik(config.model.reference.pose)
    config = replace(config, homing=HomingSettings(there, 10.0))
    bench = Bench({}, config=config)
    bench.say("$H", 0.0)
    bench.wait(400.0)
    assert bench.ask().state is State.IDLE
    for found, wanted in zip(bench.device.world.joints, there, strict=True):
        assert found == pytest.approx(wanted, abs=0.01)
