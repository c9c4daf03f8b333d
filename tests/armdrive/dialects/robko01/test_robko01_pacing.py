"""What the driver computes of a Robko's motion, against axes that know nothing of it."""

from __future__ import annotations

import pytest
from amounts import amount
from hypothesis import example, given, settings
from hypothesis import strategies as st

from armdrive.dialects.robko01.settings import (
    BOARDS,
    SLACK_S,
    TOLD_BY_S,
    Pacing,
    RobkoBoard,
    RobkoSettings,
)
from armdrive.dialects.speed_table import PaceMeter
from armdrive.registry.arm_files import parse_arm
from armdrive.sim.mechanics.profiles import UncoordinatedRack

BOARD = st.sampled_from(
    [*BOARDS.values(), RobkoBoard(700.0, 300.0, 0.0), RobkoBoard(75.0, 125.0, 0.008)]
)
STEPS = st.tuples(*[st.integers(-90, 90)] * 6).filter(any)
RATES = st.one_of(st.floats(1.0, 400.0), st.sampled_from([31.25, 62.0, 62.5, 63.0, 125.0]))


def moved(board, steps, speeds, start_s=0.0):
    rack = UncoordinatedRack(
        (0,) * 6,
        acceleration_hz_s=board.acceleration_steps_s2,
        grid_s=board.step_chance_s,
        stagger_s=board.step_chance_s / 8,
    )
    for axis, (each, speed) in enumerate(zip(steps, speeds, strict=True)):
        if each:
            rack.move_at(axis, each, speed, start_s)
    return rack


@settings(max_examples=amount(50, 1000))
@given(BOARD, STEPS, RATES, st.floats(0.0, 0.05))
@example(BOARDS["avr"], (30, 16, 0, 0, 0, 0), 125.0, 0.0)
def test_no_axis_lasts_longer_or_strays_further_than_was_computed(board, steps, rate_hz, start_s):
    pacing = Pacing(board)
    speeds = pacing.speeds(steps, rate_hz)
    rack = moved(board, steps, speeds, start_s)
    took_s, longest = rack.done_s - start_s, max(map(abs, steps))
    assert took_s <= pacing.lasts_s(longest, rate_hz) + 1e-9
    lead = next(axis for axis, each in enumerate(steps) if abs(each) == longest)
    bound = pacing.strays_steps(steps, rate_hz)
    for look in range(41):
        seen = rack.positions(start_s + took_s * look / 40)
        share = seen[lead] / steps[lead]
        strays = (abs(at - share * each) for at, each in zip(seen, steps, strict=True))
        assert all(far <= most + 1e-9 for far, most in zip(strays, bound, strict=True))
    assert all(0 < speed <= 30_000 for speed, each in zip(speeds, steps, strict=True) if each)


@settings(max_examples=amount(50, 1000))
@given(BOARD, RATES, st.integers(1, 200), st.integers(1, 50))
def test_more_steps_last_longer_and_no_usable_rate_is_above_the_one_wanted(
    board, rate_hz, steps, more
):
    pacing = Pacing(board)
    most_hz = min(max(rate_hz, 1.0), board.max_rate_hz) if board.obeys_speed else board.max_rate_hz
    assert pacing.usable_hz(rate_hz) <= most_hz + 1e-6
    assert pacing.usable_hz(pacing.usable_hz(rate_hz)) == pytest.approx(pacing.usable_hz(rate_hz))
    assert pacing.lasts_s(steps, rate_hz) < pacing.lasts_s(steps + more, rate_hz)
    assert pacing.lasts_s(0.0, rate_hz) == 0.0


def test_the_rates_of_an_avr_board_are_parts_of_125():
    pacing = Pacing(BOARDS["avr"])
    wanted = [float("inf"), 124.0, 100.0, 62.0, 42.0, 0.0]
    real = [pacing.usable_hz(rate_hz) for rate_hz in wanted]
    assert real == pytest.approx([125.0, 62.5, 62.5, 125 / 3, 125 / 3, 1.0])


def test_one_axis_alone_strays_from_nothing():
    assert Pacing(BOARDS["avr"]).strays_steps((0, 90, 0, 0, 0, 0), 125.0) == (0.0,) * 6


def meter_of(doubt: float) -> PaceMeter:
    return PaceMeter(doubt, TOLD_BY_S, SLACK_S, SLACK_S)


def test_the_meter_believes_slowness_at_once_and_speed_bit_by_bit():
    meter = meter_of(1.5)
    assert meter.doubt == 1.5
    assert meter.learn(0.05, 0.2)  # too short to tell
    assert meter.doubt == 1.5
    assert meter.learn(0.4, 0.4)
    assert meter.doubt == 1.0
    assert meter.learn(0.4, 0.6)
    assert meter.doubt == pytest.approx(1.5)
    assert meter.learn(0.4, 0.4)
    assert 1.3 < meter.doubt < 1.4
    assert not meter.learn(0.4, 3.0)
    assert not meter_of(1.0).learn(0.4, 0.01)


def test_short_motions_end_a_suspicion_but_raise_none():
    meter = meter_of(1.5)
    meter.learn(0.05, 0.5)
    assert meter.doubt == 1.5
    meter.learn(0.4, 4.0)
    assert meter.doubt == 10.0
    for _ in range(20):
        meter.learn(0.04, 0.05)
    assert meter.doubt < 1.4


def test_an_arm_file_corrects_what_is_known_of_a_board():
    table = {
        "model": "robko01",
        "connection": {"dialect": "robko01", "port": "udp://192.168.1.9:10182"},
        "robko01": {"board": "esp32", "acceleration_steps_s2": 700, "watchdog_s": 3},
    }
    config = parse_arm(table, name="bench")
    assert config.connection.baud == 115_200
    assert config.motion.planned_burst_s == 0.5
    assert config.device.known == RobkoBoard(700.0, 100.0, 0.0, obeys_speed=False)
    assert RobkoSettings().known == BOARDS["avr"]
