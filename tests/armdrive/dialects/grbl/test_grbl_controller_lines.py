"""The lines, durations and settings of a GRBL driver; a lost byte never changes a motion."""

import math
from dataclasses import replace

import pytest
from grbl_arm import config
from hypothesis import example, given, settings
from hypothesis import strategies as st

from armdrive.dialects.grbl.planner import (
    InFlightLines,
    Limits,
    SegmentBuffer,
    line_path,
    planned_s,
)
from armdrive.dialects.grbl.settings import BoardAxes, Comparison, feed
from armdrive.sim.mechanics.planner import PathLimits, PathRack
from firmware_protocol.grbl import GRBL, MEGA_5X, Block, GcodeError, Modal, parse_line
from kinematics import Motors

COUNTS = st.integers(-400, 400)
STEPS = st.tuples(*[COUNTS] * 6).map(Motors).filter(lambda steps: steps.largest > 0)
ZERO = Motors([0] * 6)
LIMITS = Limits((1.0,) * 6, (400.0,) * 6, (3000.0,) * 6, 1.0)
MODES = Modal(distance="G91", feed=1000.0)


def axes_of(unit="steps"):
    return BoardAxes.of(config(device={"unit": unit}))


def moved(text):
    """Return how a board reads a line, by axis; None if it refuses the line."""
    content = parse_line(text, MEGA_5X)
    if not isinstance(content, Block):
        return None
    try:
        modes = MODES.during(content)
    except GcodeError:
        return None
    assert modes.distance == "G91", "a relative line was taken for an absolute one"
    return dict(content.axes)


@settings(max_examples=60)
@given(STEPS, st.floats(0.02, 5.0), st.booleans())
def test_a_line_that_lost_a_byte_goes_no_further_than_twice_or_is_refused(steps, lasts_s, jog):
    axes = axes_of()
    head = "$J=G91" if jog else "G91G1"
    text = f"{head}{feed(line_path(steps, lasts_s, LIMITS))}{axes.words(ZERO, steps)}"
    whole = dict(zip("XYZABC", steps, strict=True))
    assert moved(text) == {letter: count for letter, count in whole.items() if count}
    for index in range(len(text)):
        made = moved(text[:index] + text[index + 1 :])
        for letter, count in (made or {}).items():
            assert abs(count) <= abs(whole[letter]), text
    assert moved(text + text) is None  # the end of the line was lost


@given(STEPS, st.floats(0.01, 100.0))
def test_a_feed_is_never_faster_than_asked_and_hardly_slower(steps, lasts_s):
    asked = line_path(steps, lasts_s, LIMITS)
    written = float(feed(asked)[1:]) / 60.0
    assert asked.speed * 0.998 - 1e-4 <= written <= asked.speed * (1 + 1e-9)
    assert len("$J=G91" + feed(asked)) <= 20


@example([Motors([1] * 6)] * 1000)  # if each were rounded by itself, the errors would add up
@settings(max_examples=50)
@given(st.lists(STEPS, min_size=1, max_size=30))
def test_relative_ways_in_degrees_add_up_to_the_last_decimal(ways):
    axes = axes_of("degrees")
    at, sums = ZERO, dict.fromkeys("XYZABC", 0.0)
    for steps in ways:
        for letter, value in (moved("G91G1F100" + axes.words(at, at + steps)) or {}).items():
            sums[letter] += value
        at = at + steps
    for letter, count, per in zip("XYZABC", at, axes.steps_per_unit, strict=True):
        assert sums[letter] * per == pytest.approx(count, abs=0.01)


@settings(max_examples=60)
@given(st.lists(st.tuples(STEPS, st.floats(0.02, 0.5)), min_size=1, max_size=6))
def test_the_planners_time_is_what_a_planner_takes(lines):
    limits = Limits((1.0,) * 6, (400.0, 150.0, 300.0, 300.0, 300.0, 200.0), (3000.0,) * 6, 1.0)
    rack = PathRack(ZERO, PathLimits((1.0,) * 6, limits.rates, limits.accelerations, 1.0))
    ways = [line_path(steps, lasts_s, limits) for steps, lasts_s in lines]
    for (steps, _), one in zip(lines, ways, strict=True):
        rack.queue(steps, one.speed, 0.0)
    rack.resume(0.0)
    assert planned_s(ways, limits) == pytest.approx(rack.done_s, rel=1e-6)


def test_a_road_knows_where_on_it_a_position_is():
    road = InFlightLines(ZERO, LIMITS, 2.0, SegmentBuffer(9))
    for index in range(3):
        steps = Motors((100, 10 * index, 0, 0, 0, 0))
        road.send(steps, line_path(steps, 0.3, LIMITS), 0.0)
        road.answered(0.0)
    assert road.report(Motors((50, 1, 0, 0, 0, 0)), 0.0, idle=False)
    assert road.waiting == 3
    assert road.report(Motors((150, 5, 0, 0, 0, 0)), 0.0, idle=False)
    assert road.waiting == 2
    assert not road.report(Motors((150, 15, 0, 0, 0, 0)), 0.0, idle=False)
    assert not road.report(Motors((320, 30, 0, 0, 0, 0)), 0.0, idle=False)
    assert road.report(Motors((300, 30, 0, 0, 0, 0)), 0.0, idle=True)
    assert road.empty
    assert not road.report(Motors((300, 40, 0, 0, 0, 0)), 0.0, idle=True)


def test_a_road_knows_when_its_motion_may_have_ended():
    road = InFlightLines(ZERO, LIMITS, 2.0, SegmentBuffer(9))
    assert not road.ends_by(1.0)  # nothing is under way
    steps = Motors((100, 0, 0, 0, 0, 0))
    road.send(steps, line_path(steps, 0.5, LIMITS), 0.0)
    road.answered(0.01)
    ends_s = road.ends_s
    assert 0.5 <= ends_s <= 0.8
    assert road.ends_by(ends_s)
    assert not road.ends_by(ends_s - 0.001)
    road.report(Motors((50, 0, 0, 0, 0, 0)), 1.0, idle=False)
    assert road.ends_s == pytest.approx(1.25)  # the motion is late: half of it is still to come
    road.report(steps, 1.4, idle=True)
    assert not road.ends_by(9.0)


def told(**changes):
    board = "XYZABC"
    axes = axes_of()
    expected = axes.expected(config().device)
    values = {"1": "255", "10": "3", "11": "1.000", "13": "0", "20": "0", "21": "0", "22": "0"}
    for index in range(6):
        values[f"{100 + index}"] = "1.000"
        values[f"{110 + index}"] = f"{expected.rates[index] * 60 + 1:.3f}"
        values[f"{120 + index}"] = f"{expected.accelerations[index] + 1:.3f}"
    values |= {key.removeprefix("s"): value for key, value in changes.items()}
    numbers = {int(key): value for key, value in values.items() if value is not None}
    return Comparison(config().device, axes, board, numbers)


@pytest.mark.parametrize(
    ("changes", "mend", "must"),
    [
        ({"s1": "25"}, "$1=255", True),
        ({"s1": None}, "$1=255", True),
        ({"s10": "1"}, "$10=3", True),
        ({"s10": "508"}, "$10=511", True),
        ({"s13": "1"}, "$13=0", True),
        ({"s102": "250.000"}, "$102=1", True),
        ({"s110": "500.000"}, "$110=24987.072", False),
        ({"s124": "10.000"}, "$124=4164.512", False),
        ({"s11": "0.010"}, "$11=1", False),
        ({"s20": "1"}, "$20=0", False),
        ({"s22": "1"}, "$22=0", False),
    ],
)
def test_each_setting_that_differs_is_told_with_the_line_that_mends_it(changes, mend, must):
    assert list(told().differences()) == []
    (found,) = told(**changes).differences()
    assert (found.mend, found.must) == (mend, must)


def test_what_the_board_really_does_is_reckoned_with():
    limits = told(s110="600.000", s121="50.000").limits()
    assert limits.rates[0] == pytest.approx(10.0)
    assert limits.accelerations[1] == 50.0


def test_axes_are_found_in_the_boards_own_order():
    device = replace(config().device, axes="CBAZYX")
    axes = BoardAxes.of(replace(config(), device=device))
    assert axes.motors((1.0, 2.0, 3.0, 4.0, 5.0, 6.0), "XYZABC") == Motors((6, 5, 4, 3, 2, 1))
    assert axes.words(ZERO, Motors((7, 0, 0, 0, 0, -8))) == "C+7X-8"


def test_a_line_fits_the_shortest_board():
    far = Motors([-123_456] * 6)
    for unit in ("steps", "degrees"):
        words = axes_of(unit).words(ZERO, far)
        assert len("$J=G91" + feed(line_path(far, 400.0, LIMITS)) + words) <= GRBL.max_line
    assert math.isfinite(planned_s([line_path(far, 400.0, LIMITS)], LIMITS))
