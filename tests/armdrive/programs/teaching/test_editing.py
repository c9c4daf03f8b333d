"""Editing the steps of a sequence: laws, numbers that there are not, and steps in words."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armdrive.errors import BadRequest
from armdrive.programs.teaching import steps as editing
from armdrive.programs.teaching.steps import parse_step
from armdrive.storage.points import GRIPPER_WORDS, Point, Step, StepList
from kinematics import Joints

SPEEDS = st.integers(1, 100).map(lambda percent: percent / 100)
NAMES = st.sampled_from(["pick", "above", "drop-2", "to", "wait", "line"])
STEPS = st.one_of(
    st.builds(Step, NAMES, st.sampled_from(["joint", "line"]), SPEEDS),
    st.builds(
        lambda gripper, speed: Step(gripper=gripper, speed=speed),
        st.sampled_from(GRIPPER_WORDS) | st.integers(0, 760).map(lambda tenths: tenths / 10),
        SPEEDS,
    ),
    st.integers(0, 36000).map(lambda tenths: Step(wait_s=tenths / 10)),
)
LISTS = st.lists(STEPS, min_size=1, max_size=8).map(lambda steps: StepList(tuple(steps), "note"))
PLACE = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)
POINTS = {name: Point(PLACE, 25.0) for name in ("pick", "above", "drop-2", "to", "wait", "line")}


def words(steps):
    return [str(step) for step in steps.steps]


def fetch(*texts):
    return StepList(tuple(map(parse_step, texts)))


@given(STEPS)
def test_a_step_reads_as_it_is_printed(step):
    assert parse_step(str(step)) == step


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("to pick line", Step("pick", "line")),
        ("to   pick at 30 %", Step("pick", speed=0.3)),
        ("gripper 30", Step(gripper=30.0)),
        ("to pick at 0.3", Step("pick", speed=0.3)),
        ("delay 2", Step(wait_s=2.0)),
    ],
)
def test_shorter_words_are_understood(text, wanted):
    assert parse_step(text) == wanted


@pytest.mark.parametrize(
    "text",
    ["", "pick", "to", "go pick", "gripper wide", "delay long", "to pick at fast%", "to pick twice",
     "to 7up", "to pick at 120%", "delay -1", "gripper nan"],
)  # fmt: skip
def test_an_invalid_step_is_refused(text):
    with pytest.raises(ValueError):  # noqa: PT011 - two families of errors, one meaning
        parse_step(text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("wait 2", "write `delay 2` to wait for seconds"),
        ("to pick at 30", "a speed is a fraction of the limits, not 30: write 0.3 or 30%"),
    ],
)
def test_an_old_spelling_is_refused_with_the_new_one(text, words):
    with pytest.raises(BadRequest, match=words):
        parse_step(text)


@given(LISTS, STEPS, st.data())
def test_an_inserted_step_can_be_removed_again(steps, step, data):
    at = data.draw(st.integers(1, len(steps.steps) + 1))
    longer = editing.inserted(steps, at, (step,))
    assert longer.steps[at - 1] == step
    assert editing.removed(longer, at) == steps


@given(LISTS, st.data())
def test_a_step_that_is_moved_and_moved_back_leaves_all_as_it_was(steps, data):
    numbers = st.integers(1, len(steps.steps))
    old, new = data.draw(numbers), data.draw(numbers)
    there = editing.moved(steps, old, new)
    assert there.steps[new - 1] == steps.steps[old - 1]
    assert editing.moved(there, new, old) == steps


@pytest.mark.parametrize(
    ("edit", "sentence"),
    [
        (lambda steps: editing.inserted(steps, 4, ()), "no place 4: they are from 1 to 3"),
        (lambda steps: editing.removed(steps, 0), "no step 0"),
        (lambda steps: editing.removed(steps, 2, 3), "no step 3"),
        (lambda steps: editing.removed(steps, 2, 1), "step 1 comes before step 2"),
        (lambda steps: editing.moved(steps, 1, 3), "no place 3"),
        (lambda steps: editing.Timing(factor=0.0), "factor is above 0"),
        (lambda _: editing.removed(StepList(), 1), "the sequence is empty"),
    ],
)
def test_a_step_number_out_of_range_is_named(edit, sentence):
    with pytest.raises(BadRequest, match=sentence):
        edit(fetch("to pick", "delay 1"))


def test_speeds_and_waits_are_changed_in_all_steps_or_in_some():
    steps = fetch("to pick", "delay 2", "gripper grasp at 50%", "to above line at 30%")
    slower = editing.retimed(steps, editing.Timing(factor=0.5, wait_factor=2.0))
    assert words(slower.steps) == [
        "to pick at 50%", "delay 4 s", "gripper grasp at 25%", "to above along a line at 15%",
    ]  # fmt: skip
    one = editing.retimed(steps, editing.Timing(speed=0.2, wait_s=1.0), 2, 3)
    assert words(one.steps)[1:3] == ["delay 1 s", "gripper grasp at 20%"]
    assert one.steps.steps[0] == steps.steps[0]


def test_a_speed_above_the_limit_is_clipped_and_reported():
    made = editing.retimed(fetch("to pick at 60%", "to above"), editing.Timing(factor=2.0))
    assert words(made.steps) == ["to pick", "to above"]
    assert made.notes == ("step 1 goes at 100%, not at 120%", "step 2 goes at 100%, not at 200%")


def test_a_reversed_sequence_opens_where_the_original_gripped():
    steps = fetch(
        "to above", "gripper open", "to pick line at 30%", "gripper grasp", "delay 0.5",
        "to above line at 50%", "to drop-2", "gripper open",
    )  # fmt: skip
    back = editing.reverse(steps, POINTS)
    assert words(back.steps) == [
        "to drop-2",
        "gripper grasp",
        "to above",
        "to pick along a line at 50%",
        "delay 0.5 s",
        "gripper open",
        "to above along a line at 30%",
    ]
    assert back.notes == (
        "step 2 (gripper open) is left out: the opening of the fingers before it is unknown",
    )


def test_the_opening_of_a_point_is_a_width_on_the_way_back():
    steps = fetch("to above", "gripper point", "to pick", "gripper close")
    assert words(editing.reverse(steps, POINTS).steps) == [
        "to pick", "gripper 25 mm", "to above",
    ]  # fmt: skip


@given(LISTS)
def test_there_and_back_and_there_is_the_way_there(steps):
    back = editing.reverse(steps, POINTS).steps
    again = editing.reverse(back, POINTS).steps
    assert again.points == steps.points
    assert back.points == tuple(reversed(steps.points))
