"""A hold that comes while an increment is under way takes its place, and letting go ends both."""

import pytest

from armdrive import Arm, Jog
from armdrive.status import State

LOOK_S = 0.005
STEP = 30.0


def stands_after_s(arm: Arm) -> float:
    """Let time pass until the motors have stood for a while; return how long they went on."""
    began_s = since_s = arm.status.time_s
    last = arm.twin.world.motors
    while arm.status.time_s < since_s + 0.8:
        arm.sleep(LOOK_S)
        if arm.twin.world.motors != last:
            last, since_s = arm.twin.world.motors, arm.status.time_s
    return since_s - began_s


def wait_for_motion(arm: Arm) -> None:
    before, until_s = arm.twin.world.motors, arm.status.time_s + 3.0
    while arm.twin.world.motors == before:
        assert arm.status.time_s < until_s
        arm.sleep(LOOK_S)


@pytest.fixture(params=["teachmover", "robko01", "armdroid", "grbl"])
def arm(request):
    with Arm.connect(f"sim:{request.param}") as made:
        made.enable()
        made.twin.device.bring_to(made.model.arm.ik(made.model.reference.pose), 0.0)
        made.confirm_reference()
        made.jog_j(shoulder_deg=10, elbow_deg=-10, speed=1.0)
        yield made


def test_letting_go_ends_an_increment_that_became_a_hold(arm):
    arm.nudge(Jog.joint(base=STEP), speed=0.1)
    wait_for_motion(arm)
    for _ in range(5):
        arm.hold(Jog.joint(base=1.0), speed=0.1, for_s=0.25)
        arm.sleep(0.1)
    bound_s = arm.status.stop_time_s
    before = arm.twin.world.joints.deg["base"]
    arm.release()
    assert stands_after_s(arm) <= bound_s + LOOK_S
    assert arm.twin.world.joints.deg["base"] - before < STEP / 4
    assert arm.status.state is State.STANDBY


def test_a_hold_that_expires_ends_the_increment_as_well(arm):
    arm.nudge(Jog.joint(base=STEP), speed=0.1)
    wait_for_motion(arm)
    bound_s = arm.status.stop_time_s
    arm.hold(Jog.joint(base=1.0), speed=0.1, for_s=0.2)
    assert stands_after_s(arm) <= 0.2 + bound_s + LOOK_S


def test_an_increment_without_a_held_key_runs_to_its_end(arm):
    before = arm.twin.world.joints.deg["base"]
    arm.nudge(Jog.joint(base=6.0), speed=0.5)
    wait_for_motion(arm)
    stands_after_s(arm)
    assert arm.twin.world.joints.deg["base"] - before == pytest.approx(6.0, abs=0.5)
