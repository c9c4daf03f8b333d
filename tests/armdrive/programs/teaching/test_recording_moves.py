"""Recording: a step wherever the arm comes to rest, for its fingers, and nothing in between."""

import pytest

from armdrive import Arm, Stepper
from armdrive.errors import NotReferenced
from armdrive.programs.teaching.sequence import Choices, SeenPosture, StepRecorder, seen_in
from armdrive.status import status_view
from armdrive.storage.points import Step
from kinematics import JOINT_NAMES, Joints, Pose

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
def test_what_is_recorded(what):
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


def test_what_was_recorded_of_an_arm_leads_it_the_same_way_again():
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
