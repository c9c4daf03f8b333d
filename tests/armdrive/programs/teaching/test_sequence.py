"""Sequences: forwards, backwards, stopped at any moment, and never going on by themselves."""

import math

import pytest
from faults import ready_arm, sim_config
from hypothesis import given
from hypothesis import strategies as st
from running_bench import at_each_start

from armdrive import Arm
from armdrive.errors import BadRequest, NotReferenced, OutOfBounds, Refused, Stopped
from armdrive.moves import GripperMove, LineMove
from armdrive.programs.teaching import steps as editing
from armdrive.programs.teaching.sequence import Choices, SeenPosture, Stepper, StepRecorder, seen_in
from armdrive.programs.teaching.steps import parse_step
from armdrive.sim.world.table import TableBlock
from armdrive.status import status_view
from armdrive.storage.points import GRIPPER_WORDS, Point, Step, StepList
from kinematics import JOINT_NAMES, Joints, Pose

POINTS = {
    "left": Point(Joints.of(20.0, 40.0, -80.0, -40.0, 0.0), 30.0),
    "right": Point(Joints.of(-20.0, 40.0, -80.0, -40.0, 0.0), 40.0),
    "up": Point(Joints.of(-20.0, 60.0, -80.0, -60.0, 0.0)),
    "away": Point(Joints.of(0.0, 300.0, -80.0, -40.0, 0.0)),
}
STEPS = StepList(
    (
        Step("left"),
        Step(gripper=10.0),
        Step("right", "line", 0.5),
        Step(wait_s=0.5),
        Step(gripper="point"),
        Step("up"),
    )
)


@pytest.fixture
def arm():
    return ready_arm(sim_config(planned_burst_s=0.5))


@pytest.fixture
def stepper(arm):
    return Stepper(arm, STEPS, POINTS)


def stop_soon(arm):
    arm.sleep(0.3)
    arm.request_stop()


def is_at(arm, point):
    tip = arm.model.arm.points(POINTS[point].joints)[-1]
    return math.dist(arm.twin.world.tip, tip) < 1.0


def test_running_carries_out_every_step_in_order(arm, stepper):
    seen = []
    assert stepper.run(seen.append) == 6
    assert tuple(seen) == STEPS.steps
    assert is_at(arm, "up")
    assert arm.gripper.opening_mm == pytest.approx(40.0, abs=0.2)
    assert stepper.next is None
    with pytest.raises(Refused, match="at its end"):
        stepper.forward()
    assert stepper.run() == 0
    stepper.rewind()
    assert stepper.forward() == Step("left")
    assert is_at(arm, "left")


def test_steps_forwards_and_backwards_and_the_fingers_stay(arm, stepper):
    for _ in range(5):
        stepper.forward()
    assert is_at(arm, "right")
    assert stepper.before == (STEPS.steps[2], "left")
    opening = arm.gripper.opening_mm
    assert stepper.backward() == "left"
    assert is_at(arm, "left")
    assert arm.gripper.opening_mm == opening
    assert stepper.before is None
    with pytest.raises(Refused, match="no earlier point"):
        stepper.backward()
    assert stepper.next == Step(gripper=10.0)


def test_the_way_back_is_of_the_kind_of_the_way_there(arm, stepper):
    for _ in range(3):
        stepper.forward()
    way = []
    with at_each_start(arm, lambda move, _: way.append(move)):
        stepper.backward()
    assert [(type(move), move.speed) for move in way] == [(LineMove, 0.5)]


def test_a_stop_in_motion_leaves_the_step_to_be_done_again_or_taken_back(arm, stepper):
    stepper.forward()
    stepper.forward()
    with pytest.raises(Stopped), at_each_start(arm, lambda *_: stop_soon(arm)):
        stepper.forward()
    assert stepper.at == 2
    assert not is_at(arm, "left")
    assert not is_at(arm, "right")
    assert stepper.before == (STEPS.steps[2], "left")
    assert stepper.backward() == "left"
    assert is_at(arm, "left")
    assert stepper.at == 1
    stepper.forward()
    stepper.forward()
    assert is_at(arm, "right")


def test_a_stop_while_a_sequence_waits_ends_it(arm):
    stepper = Stepper(arm, StepList((Step(wait_s=100.0), Step("left"))), POINTS)
    began_s, device = arm.parts.pace.now_s(), arm.twin.device
    device.at(device.now_s + 1.0, arm.request_stop)
    before = arm.status.acknowledged
    with pytest.raises(Stopped, match="step 1"):
        stepper.run()
    assert arm.parts.pace.now_s() - began_s < 2.0
    assert arm.status.acknowledged == before
    assert not stepper.running


def test_a_stop_between_two_steps_ends_it_too(arm, stepper):
    before = []

    def shown(step):
        before.append(step)
        if len(before) == 2:
            arm.request_stop()

    with pytest.raises(Stopped, match="step 2"):
        stepper.run(shown)
    assert stepper.at == 1
    assert is_at(arm, "left")


def test_a_stop_before_the_motion_of_a_step_is_handed_over_stops_it(arm, stepper):
    start = arm.start

    def late(move, **how):
        arm.request_stop()
        arm.sleep(0.5)
        return start(move, **how)

    arm.start = late
    with pytest.raises(Stopped):
        stepper.run()
    assert stepper.at == 0
    assert not is_at(arm, "left")


def test_halting_ends_a_run_behind_the_step_under_way(arm, stepper):
    assert stepper.run(lambda _: stepper.halt()) == 1
    assert is_at(arm, "left")
    assert stepper.run() == 5


def test_a_step_that_is_refused_stays_the_next_one(arm):
    stepper = Stepper(arm, StepList((Step("left"), Step("away"))), POINTS)
    with pytest.raises(OutOfBounds):
        stepper.run()
    assert stepper.at == 1
    assert is_at(arm, "left")


def test_a_step_that_cannot_run_gives_the_reason(arm):
    with pytest.raises(BadRequest, match="no steps"):
        Stepper(arm, StepList(), POINTS)
    stepper = Stepper(arm, StepList((Step("up"), Step(gripper="point"))), POINTS)
    stepper.forward()
    with pytest.raises(Refused, match="no opening"):
        stepper.forward()


def test_the_fingers_open_close_and_grasp():
    block = TableBlock("cube", x_mm=250.0, y_mm=0.0)
    arm = ready_arm(sim_config(planned_burst_s=0.5), blocks=(block,))
    steps = StepList((Step(gripper="open"), Step(gripper="close"), Step(gripper="grasp")))
    stepper = Stepper(arm, steps, {})
    stepper.forward()
    assert arm.gripper.opening_mm == pytest.approx(arm.model.gripper_range_mm[1], abs=0.2)
    assert stepper.run() == 2
    assert arm.gripper.opening_mm == pytest.approx(0.0, abs=0.5)


def test_steps_say_what_they_do():
    assert [str(step) for step in STEPS.steps] == [
        "to left",
        "gripper 10 mm",
        "to right along a line at 50%",
        "delay 0.5 s",
        "gripper point",
        "to up",
    ]


def test_a_stop_on_the_way_back_from_the_end_leads_back_to_where_that_began(arm, stepper):
    """What is before can be asked at any moment: a screen shows it while the arm moves."""
    stepper.run()
    seen = []

    def stopping(*_):
        seen.append(stepper.before)
        stop_soon(arm)

    with pytest.raises(Stopped), at_each_start(arm, stopping):
        stepper.backward()
    assert stepper.next is None
    assert stepper.before == (STEPS.steps[5], "up")
    assert stepper.backward() == "up"
    assert is_at(arm, "up")
    assert stepper.before == (STEPS.steps[5], "right")
    assert len(seen) == 1


def test_the_previous_point_is_known_during_every_step(arm, stepper):
    asked = []

    def watched(move, handle):
        wait = handle.wait
        if not isinstance(move, GripperMove):
            handle.wait = lambda: (asked.append(stepper.before), wait())[1]

    with at_each_start(arm, watched):
        stepper.run()
        stepper.backward()
    assert asked == [
        None,
        (STEPS.steps[2], "left"),
        (STEPS.steps[5], "right"),
        (STEPS.steps[5], "up"),
    ]


# Editing the steps of a sequence: laws, numbers that there are not, and steps in words.


SPEEDS = st.integers(1, 100).map(lambda percent: percent / 100)
NAMES = st.sampled_from(["pick", "above", "drop-2", "to", "wait", "line"])
ANY_STEP = st.one_of(
    st.builds(Step, NAMES, st.sampled_from(["joint", "line"]), SPEEDS),
    st.builds(
        lambda gripper, speed: Step(gripper=gripper, speed=speed),
        st.sampled_from(GRIPPER_WORDS) | st.integers(0, 760).map(lambda tenths: tenths / 10),
        SPEEDS,
    ),
    st.integers(0, 36000).map(lambda tenths: Step(wait_s=tenths / 10)),
)
LISTS = st.lists(ANY_STEP, min_size=1, max_size=8).map(lambda steps: StepList(tuple(steps), "note"))
PLACE = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)
ONE_PLACE = {name: Point(PLACE, 25.0) for name in ("pick", "above", "drop-2", "to", "wait", "line")}


def words(steps):
    return [str(step) for step in steps.steps]


def fetch(*texts):
    return StepList(tuple(map(parse_step, texts)))


@given(ANY_STEP)
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
     "to 7up", "to pick at 120%", "delay -1", "gripper nan", "delay 1_5"],
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


@given(LISTS, ANY_STEP, st.data())
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
    back = editing.reverse(steps, ONE_PLACE)
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
    assert words(editing.reverse(steps, ONE_PLACE).steps) == [
        "to pick", "gripper 25 mm", "to above",
    ]  # fmt: skip


@given(LISTS)
def test_stepping_forward_back_and_forward_ends_at_the_same_place(steps):
    back = editing.reverse(steps, ONE_PLACE).steps
    again = editing.reverse(back, ONE_PLACE).steps
    assert again.points == steps.points
    assert back.points == tuple(reversed(steps.points))


# Recording: a step wherever the arm comes to rest, for its fingers, and nothing in between.


MOVING = SeenPosture(None)


def at(base_deg, opening_mm=30.0, *, gripping=False):
    return SeenPosture(Joints.of(base_deg, 40.0, -80.0, -40.0, 0.0), opening_mm, gripping)


def recorded(*told, choices=None, end_s=100.0):
    recorder = StepRecorder("tour", choices or Choices())
    for now_s, seen in told:
        recorder.see(seen, now_s)
    recorder.end(end_s)
    return recorder


FIRST = ["to tour-1", "gripper 30 mm"]
RECORDED = {
    "every place of rest is a point and the way there a step": (
        [(0, at(0)), (2, MOVING), (3, at(10)), (6, MOVING), (7, at(20))],
        [*FIRST, "to tour-2", "to tour-3"]),
    "a place that the arm only passed is not recorded": (
        [(0, at(0)), (2, MOVING), (3, at(5)), (3.4, MOVING), (4, at(10))], [*FIRST, "to tour-2"]),
    "motion too short to be seen is noticed by the place": (
        [(0, at(0)), (2, at(10)), (4, at(20))], [*FIRST, "to tour-2", "to tour-3"]),
    "the last place counts however short the arm has stood there": (
        [(0, at(0)), (2, MOVING), (99.9, at(10))], [*FIRST, "to tour-2"]),
    "a place that is come back to keeps its point": (
        [(0, at(0)), (2, MOVING), (3, at(10)), (5, MOVING), (6, at(0.01))],
        [*FIRST, "to tour-2", "to tour-1"]),
    "what the fingers do is a step and gripping is a grasp": (
        [(0, at(0, 60.0)), (2, at(0, 31.0, gripping=True)), (4, at(0, 30.0, gripping=True)),
         (6, MOVING), (7, at(10, 30.0, gripping=True)), (9, at(10, 50.0))],
        ["to tour-1", "gripper 60 mm", "gripper grasp", "to tour-2", "gripper 50 mm"]),
    "an arm that rests and goes on where it was adds nothing": (
        [(0, at(0)), (2, MOVING), (3, at(0)), (5, MOVING), (6, at(0))], FIRST),
}  # fmt: skip


@pytest.mark.parametrize("what", RECORDED)
def test_which_motions_are_recorded(what):
    told, steps = RECORDED[what]
    made = recorded(*told)
    assert [str(step) for step in made.steps] == steps
    names = {step.split()[1] for step in steps if step.startswith("to")}
    assert set(made.points) == names
    bases_deg = [point.joints.deg["base"] for point in made.points.values()]
    assert bases_deg == pytest.approx([0.0, 10.0, 20.0][: len(bases_deg)])
    assert made.sequence.note == "recorded"


def test_waits_ways_and_speeds_are_as_chosen():
    choices = Choices("line", 0.4, waits=True, rest_s=1.0)
    made = recorded((0, at(0, None)), (2.5, MOVING), (3, at(10, None)), choices=choices)
    assert made.steps == [
        Step("tour-1", "line", 0.4),
        Step(wait_s=2.5),
        Step("tour-2", "line", 0.4),
    ]


@pytest.mark.parametrize("change", [{"trust": "suspect"}, {"trust": "unknown"}, {"joints": None}])
def test_without_a_position_nothing_is_recorded(change):
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        view = status_view(arm.status) | change
    with pytest.raises(NotReferenced, match="the arm has no trusted position"):
        seen_in(view, JOINT_NAMES)


@pytest.mark.parametrize("change", [{"state": "moving"}, {"state": "homing"}, {"paused": True}])
def test_an_arm_that_moves_or_is_paused_does_not_rest(change):
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        assert seen_in(status_view(arm.status), JOINT_NAMES).joints is not None
        assert seen_in(status_view(arm.status) | change, JOINT_NAMES).joints is None


def test_a_recorded_sequence_repeats_the_motion():
    goals = [Pose.of(x_mm=220, y_mm=y, z_mm=120, pitch_deg=-90) for y in (0, 60, -40)]
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        recorder, tips = StepRecorder("tour", Choices()), []
        for goal in goals:
            arm.move_to(goal)
            arm.gripper.move(20.0 + goal.y_mm / 10)
            tips.append((arm.twin.world.tip, arm.twin.world.motors))
            arm.sleep(1.0)
            recorder.see(seen_in(status_view(arm.status), JOINT_NAMES), arm.status.time_s)
        recorder.end(arm.status.time_s)
        stepper = Stepper(arm, recorder.sequence, recorder.points)
        reached = []
        while stepper.next is not None:
            step = stepper.forward()
            if step.gripper is not None:
                reached.append((arm.twin.world.tip, arm.twin.world.motors))
        assert reached == tips
