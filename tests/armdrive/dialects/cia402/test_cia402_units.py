"""The units of speeds and ramps: told by the drive, stated by the arm file, or measured."""

import re

import pytest
from amounts import amount
from cia402_rig import Rig, steps

from armdrive.tasks import (
    Done,
    Halted,
    HomeDevice,
    MeasuredUnits,
    MeasureUnits,
    MoveAlong,
    MoveBy,
    ReadPosition,
    Registers,
    RequestRejected,
)
from firmware_protocol.canopen import QUICK_STOP_DECELERATION

RPM, TENTH_OF_RPM, DEGREES = 0x00B4_4700, 0xFFB4_4700, 0x0041_0300  # the first is Nanotec's default
RPM_HZ = 10_000 / 60
FAST = MoveBy(steps(30_000), 20_000.0)


def rig_with(settings: dict | None = None, **options) -> Rig:
    """Return a bench with few cycles, because slow turns take their time."""
    return Rig({"period_ms": 30} | (settings or {}), **options)


@pytest.mark.parametrize(
    ("told", "unit_hz", "ramp_hz_s", "strategy"),
    [
        (RPM, RPM_HZ, RPM_HZ, "cyclic"),
        (TENTH_OF_RPM, RPM_HZ / 10, RPM_HZ / 10, "profile"),
        (0, RPM_HZ, RPM_HZ / 10, "profile"),
        (0, 1000 / 65536, 1e6 / 65536, "cyclic"),
    ],
)
def test_motors_turn_by_units_that_drives_tell_or_the_arm_file_states(
    told, unit_hz, ramp_hz_s, strategy
):
    stated = {"speed_units": (unit_hz,) * 6, "ramp_units": (ramp_hz_s,) * 6}
    untold = {"missing": "60A9", "speed_unit": unit_hz, "ramp_unit": ramp_hz_s}
    options = {"constant": f"60A9:00={told}"} if told else untold
    settings = {"strategy": strategy, **({} if told else stated)}
    rig = rig_with(settings, **options).ready()
    node, before = rig.node(1), rig.positions
    slope = node.objects.number_of(QUICK_STOP_DECELERATION, 0)
    assert slope == round(rig.controller.limits.quick_hz_s / ramp_hz_s)
    rig.begin(MoveBy(steps(30_000, -15_000), 20_000.0))
    rig.run(1.0)
    assert 15_000 < (rig.positions - before)[0] < 20_500
    assert rig.finish() == Done()
    assert rig.positions - before == steps(30_000, -15_000)
    assert not rig.alerts()
    strays = rig.controller.deviation_steps(steps(9), 20_000.0)[0]
    assert strays == (
        0.0 if rig.controller._exchange.is_cyclic else pytest.approx(2.0 * max(unit_hz, 1.0))
    )


UNTOLD = ({"missing": "60A9"}, {"constant": f"60A9:00={DEGREES}"})


@pytest.mark.parametrize("options", UNTOLD, ids=["missing", "degrees"])
def test_without_a_known_unit_the_motors_hold_and_nothing_moves(options):
    rig = rig_with(**options).ready()
    before = rig.positions
    for request in (FAST, MoveAlong(iter([FAST]), 0.3), HomeDevice()):
        reply = rig.do(request)
        assert isinstance(reply, RequestRejected)
        assert not reply.moved
        assert "drive 1 (base) does not report its unit of speed (object 60A9)" in reply.reason
        assert "armdrive can setup" in reply.reason
    assert isinstance(rig.do(ReadPosition()), Registers)
    assert rig.positions == before


UNITS = [
    (1.0, 1.0, "1 increments/s, one of ramps 1 increments/s a second"),
    (RPM_HZ, RPM_HZ, "1 rpm, one of ramps 1 rpm a second"),
    (RPM_HZ, RPM_HZ / 10, "1 rpm, one of ramps 0.1 rpm a second"),
    (RPM_HZ / 10, RPM_HZ / 10, "0.1 rpm, one of ramps 0.1 rpm a second"),
    (RPM_HZ / 1000, RPM_HZ, "0.001 rpm, one of ramps 1 rpm a second"),
    (10_000.0, 10_000.0, "1 turns/s, one of ramps 1 turns/s a second"),
    (1000 / 65536, 1e6 / 65536, "0.01"),
]


@pytest.mark.parametrize(
    ("speed", "ramp", "words", "strategy"),
    [(*row, ("cyclic", "profile")[number % 2]) for number, row in enumerate(UNITS)][
        -amount(2, len(UNITS)) :
    ],
)
def test_units_are_measured_by_slow_turns_of_one_motor(speed, ramp, words, strategy):
    rig = rig_with({"strategy": strategy}, missing="60A9", speed_unit=speed, ramp_unit=ramp).ready()
    before, most, seen = rig.positions, 0.0, []
    rig.begin(MeasureUnits(1, 2778))
    while (reply := rig.reply()) is None and rig.now_s < 120.0:
        rig.run(0.01)
        seen.append(rig.positions - before)
        most = max(most, abs(rig.node(2).motor.point.rate(rig.now_s)))
    assert isinstance(reply, MeasuredUnits)
    assert reply.speed_hz == pytest.approx(speed, rel=0.03)
    assert reply.ramp_hz_s == pytest.approx(ramp, rel=0.03)
    assert words in str(reply)
    assert not reply.reported
    assert {way[0] for way in seen} == {0}
    assert max(abs(way[1]) for way in seen) <= 2778
    assert abs((rig.positions - before)[1]) <= 8
    assert most < 12_000.0
    assert rig.now_s < 40.0
    assert not rig.alerts()


def test_units_are_measured_also_with_the_longest_cycle():
    rig = rig_with({"period_ms": 50}, missing="60A9", speed_unit=1.0, ramp_unit=1.0).ready()
    reply = rig.do(MeasureUnits(0, 2778), 60.0)
    assert isinstance(reply, MeasuredUnits), reply
    assert (reply.speed_hz, reply.ramp_hz_s) == pytest.approx((1.0, 1.0), rel=0.03)


def test_a_unit_that_the_drive_tells_is_measured_too():
    rig = rig_with(constant=f"60A9:00={RPM}").ready()
    assert rig.do(MeasureUnits(0, 2000), 60.0).reported
    rig = rig_with(constant=f"60A9:00={RPM}", speed_unit=RPM_HZ / 10).ready()
    assert not rig.do(MeasureUnits(0, 2000), 60.0).reported


def test_a_stop_ends_a_measurement_and_so_does_a_drive_that_falls_silent():
    rig = rig_with(missing="60A9").ready()
    rig.begin(MeasureUnits(0, 2000))
    rig.run(2.0)
    rig.stop()
    assert rig.finish() == Halted()
    rig.check_stands()
    rig.begin(MeasureUnits(0, 2000))
    rig.run(2.0)
    rig.device.board.node(0).port.plugged = False
    reply = rig.finish()
    assert isinstance(reply, RequestRejected)
    assert "drive 1 (base)" in reply.reason


def blocked(rig):
    rig.twin.world.stalled.add(0)


@pytest.mark.parametrize(
    ("unit", "happens", "words"),
    [
        ({"ramp_unit": 1e6}, None, r"\(base\) does not gain speed as a ramp of increments/s² does"),
        ({"speed_unit": 1e5}, None, r"too fast to be timed.* cia402\.speed_units"),
        ({}, blocked, r"drive 1 \(base\) does not turn whatever speed it gets"),
    ],
)
def test_a_unit_that_cannot_be_measured_is_named_with_what_to_look_at(unit, happens, words):
    rig = rig_with(missing="60A9", **unit).ready()
    if happens is not None:
        happens(rig)
    assert re.search(words, rig.do(MeasureUnits(0, 300), 60.0).reason)
    rig.twin.world.stalled.clear()
    rig.check_stands()
    assert not rig.alerts() or happens
