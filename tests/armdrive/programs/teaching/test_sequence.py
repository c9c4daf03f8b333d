"""Sequences: forwards, backwards, stopped at any moment, and never going on by themselves."""

import math

import pytest
from faults import ready_arm, sim_config
from running_bench import at_each_start

from armdrive.errors import BadRequest, OutOfBounds, Refused, Stopped
from armdrive.moves import GripperMove, LineMove
from armdrive.programs.teaching.sequence import Stepper
from armdrive.sim.world.table import TableBlock
from armdrive.storage.points import Point, Step, StepList
from kinematics import Joints

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


def at(arm, point):
    tip = arm.model.arm.points(POINTS[point].joints)[-1]
    return math.dist(arm.twin.world.tip, tip) < 1.0


def test_running_carries_out_every_step_in_order(arm, stepper):
    seen = []
    assert stepper.run(seen.append) == 6
    assert tuple(seen) == STEPS.steps
    assert at(arm, "up")
    assert arm.gripper.opening_mm == pytest.approx(40.0, abs=0.2)
    assert stepper.next is None
    with pytest.raises(Refused, match="at its end"):
        stepper.forward()
    assert stepper.run() == 0
    stepper.rewind()
    assert stepper.forward() == Step("left")
    assert at(arm, "left")


def test_steps_forwards_and_backwards_and_the_fingers_stay(arm, stepper):
    for _ in range(5):
        stepper.forward()
    assert at(arm, "right")
    assert stepper.before == (STEPS.steps[2], "left")
    opening = arm.gripper.opening_mm
    assert stepper.backward() == "left"
    assert at(arm, "left")
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
    assert not at(arm, "left")
    assert not at(arm, "right")
    assert stepper.before == (STEPS.steps[2], "left")
    assert stepper.backward() == "left"
    assert at(arm, "left")
    assert stepper.at == 1
    stepper.forward()
    stepper.forward()
    assert at(arm, "right")


def test_a_stop_while_a_sequence_waits_ends_it(arm):
    stepper = Stepper(arm, StepList((Step(wait_s=100.0), Step("left"))), POINTS)
    began_s, device = arm.pace.now_s(), arm.twin.device
    device.at(device.now_s + 1.0, arm.request_stop)
    before = arm.status.acknowledged
    with pytest.raises(Stopped, match="step 1"):
        stepper.run()
    assert arm.pace.now_s() - began_s < 2.0
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
    assert at(arm, "left")


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
    assert not at(arm, "left")


def test_halting_ends_a_run_behind_the_step_under_way(arm, stepper):
    assert stepper.run(lambda _: stepper.halt()) == 1
    assert at(arm, "left")
    assert stepper.run() == 5


def test_a_step_that_is_refused_stays_the_next_one(arm):
    stepper = Stepper(arm, StepList((Step("left"), Step("away"))), POINTS)
    with pytest.raises(OutOfBounds):
        stepper.run()
    assert stepper.at == 1
    assert at(arm, "left")


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
    assert at(arm, "up")
    assert stepper.before == (STEPS.steps[5], "right")
    assert len(seen) == 1


def test_what_is_before_is_known_at_every_moment_of_every_step(arm, stepper):
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
