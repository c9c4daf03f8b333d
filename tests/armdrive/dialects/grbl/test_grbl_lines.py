"""The bounds of a GRBL board's motion, the lines that are written for it, and its settings."""

import math
from dataclasses import replace

import pytest
from amounts import every_row
from grbl_arm import config
from hypothesis import example, given, settings
from hypothesis import strategies as st

from armdrive.config.sections import HomingSettings
from armdrive.dialects.controller import StopPart
from armdrive.dialects.grbl.planner import (
    InFlightLines,
    Limits,
    MotionBounds,
    SegmentBuffer,
    line_path,
    planned_s,
)
from armdrive.dialects.grbl.settings import BoardAxes, Comparison, feed
from armdrive.dialects.grbl.variants import BEHAVIOURS
from armdrive.errors import ArmFileError
from armdrive.sim.mechanics.planner import PathLimits, PathRack
from firmware_protocol.grbl import (
    GRBL,
    Block,
    Dialect,
    GcodeError,
    Modal,
    Variant,
    parse_line,
)
from kinematics import Joints, Motors

LIMITS = Limits((1.0,) * 6, (400.0,) * 6, (4000.0,) * 6, 1.0)


# How long motion continues.


def bounds(segments=9, most_hz=(300.0,) * 6):
    return MotionBounds(LIMITS, most_hz, SegmentBuffer(segments), 1e-4)


def test_a_motor_brakes_from_what_its_arm_its_board_and_its_motion_ask_of_it_at_most():
    assert bounds().ramp_s() == pytest.approx(300.0 / 4000.0)
    assert bounds(most_hz=(500.0,) * 6).ramp_s() == pytest.approx(400.0 / 4000.0)
    assert bounds().ramp_s([StopPart(1.0, 100.0)]) == pytest.approx(100.0 / 4000.0)


def test_a_stop_waits_for_what_the_segment_buffer_holds():
    small, large = (bounds(segments).stopping(0.4) for segments in (5, 12))
    assert large.asked_s - small.asked_s == pytest.approx(
        SegmentBuffer(12).longest_s - SegmentBuffer(5).longest_s
    )
    quick = bounds().stopping(0.4, [StopPart(1.0, 300.0)])
    slow = bounds().stopping(0.4, [StopPart(1.0, 40.0)])
    assert quick.asked_s < slow.asked_s <= bounds().stopping(0.4).asked_s


def test_a_rate_is_neither_faster_nor_slower_than_the_board_can():
    assert bounds().usable_rate_hz(math.inf) == 400.0
    assert bounds().usable_rate_hz(0.0) == pytest.approx(30.5, abs=0.1)
    assert bounds().usable_rate_hz(100.0) == 100.0
    assert bounds().duration_s(200.0, 200.0) == pytest.approx(1.0 + 200.0 / 4000.0)


# -- The lines that are written, and the settings that are read ------------------------------------

COUNTS = st.integers(-400, 400)
STEPS = st.tuples(*[COUNTS] * 6).map(Motors).filter(lambda steps: steps.largest > 0)
ZERO = Motors([0] * 6)
LINE_LIMITS = Limits((1.0,) * 6, (400.0,) * 6, (3000.0,) * 6, 1.0)
MODES = Modal(distance="G91", feed=1000.0)


def axes_of(unit="steps"):
    return BoardAxes.of(config(device={"unit": unit}))


def moved(text):
    """Return how a board reads a line, by axis; None if it refuses the line."""
    content = parse_line(text, Dialect(axes="XYZABC"))
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
    text = f"{head}{feed(line_path(steps, lasts_s, LINE_LIMITS))}{axes.words(ZERO, steps)}"
    whole = dict(zip("XYZABC", steps, strict=True))
    assert moved(text) == {letter: count for letter, count in whole.items() if count}
    for index in range(len(text)):
        made = moved(text[:index] + text[index + 1 :])
        for letter, count in (made or {}).items():
            assert abs(count) <= abs(whole[letter]), text
    assert moved(text + text) is None  # the end of the line was lost


@given(STEPS, st.floats(0.01, 100.0))
def test_a_feed_is_never_faster_than_asked_and_hardly_slower(steps, lasts_s):
    asked = line_path(steps, lasts_s, LINE_LIMITS)
    written = float(feed(asked)[1:]) / 60.0
    assert asked.speed * 0.998 - 1e-4 <= written <= asked.speed * (1 + 1e-9)
    assert len("$J=G91" + feed(asked)) <= 20


@example([Motors([1] * 6)] * 1000)  # if each were rounded by itself, the errors would add up
@settings(max_examples=25)
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


def test_lines_in_flight_know_which_of_them_the_arm_is_on_and_when_it_should_stand():
    lines = InFlightLines(ZERO, LINE_LIMITS, 2.0, SegmentBuffer(9))
    for index in range(3):
        steps = Motors((100, 10 * index, 0, 0, 0, 0))
        lines.send(steps, line_path(steps, 0.3, LINE_LIMITS), 0.0)
        lines.answered(0.0)
    assert 0.9 <= lines.ends_s <= 1.1
    assert lines.report(Motors((50, 1, 0, 0, 0, 0)), 0.5, idle=False)
    assert lines.ends_s == pytest.approx(0.5 + 0.75)  # the motion is late
    assert lines.report(Motors((150, 5, 0, 0, 0, 0)), 0.6, idle=False)
    assert not lines.report(Motors((50, 1, 0, 0, 0, 0)), 0.6, idle=False)  # it ran back
    assert not lines.report(Motors((150, 15, 0, 0, 0, 0)), 0.6, idle=False)
    assert not lines.report(Motors((320, 30, 0, 0, 0, 0)), 0.6, idle=False)
    assert lines.report(Motors((300, 30, 0, 0, 0, 0)), 0.6, idle=True)
    assert lines.empty
    assert not lines.report(Motors((300, 40, 0, 0, 0, 0)), 0.6, idle=True)


def test_the_time_ahead_is_that_of_the_planner():
    lines = InFlightLines(ZERO, LINE_LIMITS, 2.0, SegmentBuffer(9))
    assert lines.ahead_s(0.1) <= 0.0
    steps = Motors((100, 0, 0, 0, 0, 0))
    path = line_path(steps, 0.5, LINE_LIMITS)
    lines.send(steps, path, 0.0)
    assert lines.ahead_s(0.1) == pytest.approx(0.5 - 9 * 0.01)
    assert lines.ahead_s(0.1, path) == pytest.approx(1.0 - 9 * 0.01)
    lines.report(Motors((50, 0, 0, 0, 0, 0)), 0.3, idle=False)
    assert lines.ahead_s(0.1) == pytest.approx(0.25 - 9 * 0.01)


def told(variant=Variant.GRBL, **changes):
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
    return Comparison(config().device, axes, board, numbers, BEHAVIOURS[variant])


def test_grblhal_needs_more_of_its_reports_homing_and_sleep():
    lines = {each.fix for each in told(Variant.GRBLHAL, s62="0").differences()}
    assert lines == {"$10=91", "$62=1"}
    assert not list(told(Variant.GRBLHAL, s10="511", s62="1").differences())
    homes = replace(
        told(Variant.GRBLHAL, s10="511", s22="1"), settings=config(device={"homing": True}).device
    )
    assert {each.fix for each in homes.differences()} == {"$22=3"}


@every_row(
    "changes, fix, must",
    [
        ({"s1": "25"}, "$1=255", True),
        ({"s1": None}, "$1=255", True),
        ({"s10": "1"}, "$10=3", True),
        ({"s10": "508"}, "$10=511", True),
        ({"s13": "1"}, "$13=0", True),
        ({"s102": "250.000"}, "$102=1", True),
        ({"s110": "500.000"}, "$110=24987.072", False),
        ({"s124": "10.000"}, "$124=4164.512", False),
        ({"s110": "0.000"}, "$110=24987.072", True),
        ({"s124": "0.000"}, "$124=4164.512", True),
        ({"s11": "0.010"}, "$11=1", False),
        ({"s20": "1"}, "$20=0", False),
        ({"s22": "1"}, "$22=0", False),
    ],
)
def test_each_differing_setting_is_reported_with_the_line_that_corrects_it(changes, fix, must):
    assert list(told().differences()) == []
    (found,) = told(**changes).differences()
    assert (found.fix, found.must) == (fix, must)


@pytest.mark.parametrize(
    ("angles_deg", "groups", "said", "fix"),
    [
        # the motors of shoulder and elbow count down where these joints are high; the wrist's stand
        # in the middle of their travel, where a switch may be on either side
        ((88, 142, -2, 0, 0), ((3,), (2,), (1, 4, 5)), "0", "$23=6"),
        ((88, 142, -2, 0, 0), ((3,), (2,), (1, 4, 5)), "30", None),
        ((88, 142, -2, 0, 0), ((3,), (2,), (1, 4, 5)), "7", "$23=6"),
        ((-88, 142, -2, 0, 0), ((2,), (1, 4, 5, 3)), "0", "$23=7"),
        ((88, -30, -147, 0, 0), ((3,), (2,), (1, 4, 5)), "6", "$23=0"),
        ((88, -30, -147, 0, 0), ((3,), (2,), (1, 4, 5)), None, None),
    ],
)
def test_a_board_that_would_home_away_from_its_switches_is_named_before(
    angles_deg, groups, said, fix
):
    made = config(device={"homing": True})
    there = Joints(tuple(map(math.radians, angles_deg)), made.model.arm.joint_names)
    made = replace(made, homing=HomingSettings(there, 0.0, groups))
    board = told(s22="1", s23=said)
    board = replace(board, settings=made.device, axes=BoardAxes.of(made))
    assert [each.fix for each in board.differences()] == ([fix] if fix else [])


def test_the_expected_rate_of_a_shared_motor_is_the_sum_of_its_joints():
    base, shoulder, elbow, right, left, gripper = axes_of().expected(config().device).rates
    assert right == left == gripper == base  # 733 and 544 would be their sums
    assert shoulder == pytest.approx(168.8, abs=0.1)
    assert elbow == pytest.approx(251.5, abs=0.1)


def test_the_boards_real_speed_is_used():
    limits = told(s110="600.000", s121="50.000").limits()
    assert limits.rates[0] == pytest.approx(10.0)
    assert limits.accelerations[1] == 50.0
    assert told(s11="0.000").limits().junction == 0.0


def test_a_gripper_on_an_output_that_the_arm_file_does_not_name_is_refused():
    """Otherwise it would be said to open and close, and nothing would be sent."""
    made = config(gripper="output", device={"outputs": ("flood",), "gripper_output": 1})
    with pytest.raises(ArmFileError, match=r"grbl.gripper_output is bit 1, but .* 1 output"):
        BoardAxes.of(made)


def test_axes_are_found_in_the_boards_own_order():
    device = replace(config().device, axes="CBAZYX")
    axes = BoardAxes.of(replace(config(), device=device))
    assert axes.motors((1.0, 2.0, 3.0, 4.0, 5.0, 6.0), "XYZABC") == Motors((6, 5, 4, 3, 2, 1))
    assert axes.words(ZERO, Motors((7, 0, 0, 0, 0, -8))) == "C+7X-8"


def test_a_line_fits_the_shortest_board():
    far = Motors([-123_456] * 6)
    for unit in ("steps", "degrees"):
        words = axes_of(unit).words(ZERO, far)
        assert len("$J=G91" + feed(line_path(far, 400.0, LINE_LIMITS)) + words) <= GRBL.max_line
    assert math.isfinite(planned_s([line_path(far, 400.0, LINE_LIMITS)], LINE_LIMITS))
