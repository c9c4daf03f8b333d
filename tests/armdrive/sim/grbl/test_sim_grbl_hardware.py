"""The motor current, the fingers and the planner of the simulated GRBL board."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from grbl_bench import MACHINE, Bench, config_of

from armdrive.sim.grbl.firmware import ALWAYS_ON_MS, IDLE_MS, BoardSettings
from armdrive.sim.grbl.hardware import BoardOutputs, MotorCurrent, OutputFingers, OutputWiring


def current_of(idle_ms):
    world = Bench().device.world
    return world, MotorCurrent(world, BoardSettings(6, {IDLE_MS: idle_ms}))


def test_the_current_is_off_at_first_unless_the_motors_stay_on():
    assert not current_of(25)[0].energised
    assert current_of(ALWAYS_ON_MS)[0].energised


@pytest.mark.parametrize(("idle_ms", "rest_s"), [(25, 7.025), (ALWAYS_ON_MS, math.inf)])
def test_at_rest_the_current_goes_off_after_the_idle_delay_unless_the_motors_stay_on(
    idle_ms, rest_s
):
    world, current = current_of(idle_ms)
    current.keep_on()
    assert world.energised
    current.release_at_rest(7.0)
    assert current.off_s == rest_s
    current.release(8.0)
    assert current.off_s == 8.0 + idle_ms / 1000
    current.cut(9.0)
    assert not world.energised
    assert current.off_s == math.inf


def fingers_of(wiring, kind="output"):
    bench = Bench(config=config_of(kind))
    outputs, world = BoardOutputs(), bench.device.world
    build = replace(bench.board.build, fingers=wiring, opening_mm=(0.0, 76.0), finger_mm_s=10.0)
    return world, outputs, OutputFingers(world, build, outputs)


def test_fingers_arrive_after_the_time_that_their_way_takes():
    world, outputs, fingers = fingers_of(OutputWiring("analog", 2))
    fingers.follow_output(1.0)
    assert fingers.due_s == math.inf  # a servo without a signal stays
    before = world.opening_mm
    outputs.put("M68", 2, 0.5)
    fingers.follow_output(1.0)
    assert fingers.due_s == pytest.approx(1.0 + abs(38.0 - before) / 10.0)
    assert world.opening_mm == before
    fingers.arrive(fingers.due_s)
    assert world.opening_mm == pytest.approx(38.0)
    assert fingers.due_s == math.inf


def test_fingers_that_forget_stay_where_they_are():
    _, outputs, fingers = fingers_of(OutputWiring("flood"))
    outputs.cool("M8")
    fingers.follow_output(1.0)
    assert fingers.due_s < math.inf
    fingers.forget()
    assert fingers.due_s == math.inf


def test_no_output_moves_fingers_that_a_motor_moves():
    _, outputs, fingers = fingers_of(OutputWiring("flood"), kind="stepper")
    outputs.cool("M8")
    fingers.follow_output(1.0)
    assert fingers.due_s == math.inf


def test_the_planner_is_full_when_as_many_lines_wait_as_it_has_blocks():
    board = Bench(MACHINE, firmware="grbl").board
    for count in range(1, board.firmware.blocks + 1):
        assert not board.drive.full(board.now_s)
        board.drive.rack.hold(board.now_s)
        board.drive.queue_to((float(count),) * 6, 1.0, board.now_s)
    assert board.drive.full(board.now_s)
    assert board.drive.goal_units == (float(board.firmware.blocks),) * 6
