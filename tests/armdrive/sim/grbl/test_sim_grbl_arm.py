"""What the simulated GRBL board does to the arm: motor current, outputs, a saved world."""

from __future__ import annotations

import pytest
from grbl_bench import MACHINE, SLOPE, Bench, config_of

from firmware_protocol.grbl import State

RESET = "\x18"


def test_the_factory_delay_switches_the_motors_off_after_every_move():
    bench = Bench({**MACHINE, 1: 25})
    assert not bench.device.world.energised
    bench.say("G1X5F3000", 0.1)
    assert bench.device.world.energised
    lasts_s = 5 / 50 + 50 / SLOPE
    bench.wait(lasts_s - 0.1)
    assert bench.device.world.energised
    before = bench.device.world.joints["shoulder"]
    bench.wait(0.05)
    assert not bench.device.world.energised
    assert bench.device.world.joints["shoulder"] < before
    assert bench.device.registers[0] == 50
    assert bench.say("$1=255", 0.1) == ["ok"]
    bench.say("G1X10F3000", 5.0)
    assert bench.device.world.energised


def test_sleep_switches_them_off_until_a_reset_which_leaves_the_board_locked():
    bench = Bench()
    assert bench.say("$SLP") == ["ok", "[MSG:Sleeping]"]
    bench.wait(0.5)
    assert not bench.device.world.energised
    assert bench.say("$X") == []
    bench.say(RESET, 0.25)
    assert bench.ask() is None  # seen: it takes 0.26 s
    bench.wait(0.25)
    assert (bench.ask().state, bench.device.world.energised) == (State.ALARM, True)


@pytest.mark.parametrize(
    ("kind", "device", "shut", "half", "wide"),
    [
        ("servo", {}, "M3S0", "M3S500", "M3S1000"),
        ("servo", {"servo_closed": 90.0, "servo_open": 10.0}, "M3S90", "M3S50", "M3S10"),
        ("servo", {"servo": "M67E2"}, "M67E2Q0", "M67E2Q500", "M67E2Q1000"),
        ("output", {}, "M8", None, "M9"),
        ("output", {"gripper_closes": False}, "M9", None, "M8"),
        ("output", {"outputs": ("flood", "P3"), "gripper_output": 1}, "M62P3", None, "M63P3"),
    ],
)
def test_a_gripper_on_an_output_takes_its_time(kind, device, shut, half, wide):
    bench = Bench({}, config=config_of(kind, **device), firmware="grblhal")
    world, speed = bench.device.world, bench.device.board.build.finger_mm_s
    for line, opening_mm in ((shut, 0.0), (wide, 76.0), (half, 38.0)):
        if line is None:
            continue
        before = world.opening_mm
        bench.say(line)
        assert world.opening_mm == pytest.approx(before)
        bench.wait(abs(before - opening_mm) / speed)
        assert world.opening_mm == pytest.approx(opening_mm)


def test_outputs_wait_for_the_motion_before_them_and_show():
    bench = Bench(firmware="grblhal")
    bench.say("G1X5F600", 0.02)
    bench.say("M8", 0.1)
    assert not bench.device.board.details()["outputs"]["flood"]
    bench.put("M65P1\n")
    bench.wait(1.0)
    bench.say("M3S700")
    bench.say("M64P1")
    outputs = bench.device.board.details()["outputs"]
    assert (outputs["flood"], outputs["spindle"], outputs["speed"]) == (True, "M3", 700)
    assert outputs["digital"] == {"1": True}
    assert bench.ask().speed == 700
    assert bench.ask().accessories == "SF"
    bench.say(RESET, 0.3)
    assert bench.device.board.details()["outputs"]["spindle"] == "M5"


def test_a_saved_board_knows_its_settings_its_place_and_its_lock():
    bench = Bench({**MACHINE, 22: 1})
    bench.say("$X")
    bench.say("G1X5Y-3F3000", 1.0)
    bench.say("G10L2P1X2")
    bench.say("$110=4000")
    bench.say("G1X100F1500", 0.5)
    bench.say(RESET, 2.0)
    saved = bench.device.to_json()
    again = Bench({}, saved={"dialect": "grbl", **saved})
    assert again.device.registers == bench.device.registers
    assert again.device.world.motors == bench.device.world.motors
    assert again.ask().state is State.ALARM
    assert again.ask().machine_position == bench.ask().machine_position
    assert again.board.settings[110] == 4000.0
    assert again.board.parser.stored["G54"][0] == 2.0
    assert again.banners == []
    again.say("$X")
    again.say("G91G1X1F600", 2.0)
    assert again.board.drive.counts[0] - bench.board.drive.counts[0] == 10


def test_a_saved_board_that_resets_on_open_has_forgotten_its_place():
    bench = Bench()
    bench.say("G1X5F3000", 1.0)
    again = Bench({}, saved={"dialect": "grbl", **bench.device.to_json()}, resets_on_open=True)
    assert len(again.banners) == 1
    assert again.ask().machine_position == (0.0,) * 6
    assert again.device.world.motors[1] != bench.device.world.motors[1]
