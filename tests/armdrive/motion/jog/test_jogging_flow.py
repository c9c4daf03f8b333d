"""Jogging of a driven arm, within its bounds."""

import math

import pytest
from amounts import amount, every_row
from faults import OVER_THE_TABLE, arm_config, driven, ready_arm, sim_arm, stand_still_s

from armdrive import Arm, Jog
from armdrive.errors import BadRequest, NotReferenced, OutOfBounds, WrongState
from armdrive.moves import JogMove, JointMove
from armdrive.runtime.position import ArmCoordinates
from armdrive.status import Evidence, State, Trust
from kinematics import Joints


def test_a_jog_that_is_refused_in_a_motion_is_refused_no_longer_than_the_motion_lasts():
    arm = ready_arm()
    motion = arm.start(JointMove({"base_deg": 20.0}, 1.0))
    arm.sleep(0.2)
    arm.jogging.nudge(Jog.joint(base=1.0), speed=1.0)
    assert "not possible while the arm is moving" in arm.status.notice
    motion.wait()
    assert arm.status.notice == ""


def test_a_hold_renewed_while_the_jog_is_ending_takes_it_up_again():
    arm = ready_arm()
    arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=0.1)
    for _ in range(60):
        arm.sleep(0.01)
        if arm.twin.link.messages[-1].startswith(b"@READ") and arm.twin.link.named(b"@STEP"):
            break
    here = arm.twin.world.joints.deg["base"]
    arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=0.2)
    arm.sleep(1.0)
    assert arm.twin.world.joints.deg["base"] > here + 1.0
    assert arm.status.state is State.STANDBY


def test_a_hold_is_never_longer_than_a_second_however_long_was_asked():
    arm = ready_arm()
    arm.jogging.hold(Jog.joint(base=1.0), speed=0.5, for_s=1e9)
    arm.sleep(1.5)
    stood = arm.twin.world.motors
    arm.sleep(1.0)
    assert arm.twin.world.motors == stood
    assert arm.joints.deg["base"] > 0.0
    steps = len(arm.twin.link.named(b"@STEP"))
    with pytest.raises(BadRequest, match="for_s must be a finite number"):
        arm.jogging.hold(Jog.joint(base=1.0), speed=0.5, for_s=math.nan)
    arm.sleep(1.0)
    assert len(arm.twin.link.named(b"@STEP")) == steps


def test_a_slow_hold_is_as_slow_as_asked_even_below_a_step_a_burst():
    arm = ready_arm()
    arm.jog_j(base=1.0, speed=0.01, duration_s=4.0)
    angle = arm.parts.core.position.coordinates.joints.deg["base"]
    assert 0.4 * 4.0 * 0.01 * math.degrees(0.37) < angle <= 4.1 * 0.01 * math.degrees(0.37)
    assert abs(arm.twin.world.motors[0]) <= angle * 7072 / 360 + 1


@pytest.mark.parametrize("known", amount([True], [True, False]))
def test_an_increment_may_take_as_long_as_it_needs(known):
    """At a two-hundredth of the speed, the base turns by a degree in ten seconds."""
    arm = ready_arm() if known else sim_arm(at=None)
    began_s, before_deg = arm.status.time_s, arm.twin.world.joints.deg["base"]
    arm.jog_j(base_deg=70.0, speed=0.005)
    assert arm.status.time_s - began_s > 620.0
    assert arm.twin.world.joints.deg["base"] - before_deg == pytest.approx(70.0, abs=0.1)


SLOWEST = {
    "hold": lambda arm, speed: arm.jog_j(base=1e-5, speed=speed, duration_s=3.0),
    "increment": lambda arm, speed: arm.start(JogMove(Jog.joint(base=1.0), 1e-5 * speed)),
    "move": lambda arm, speed: arm.start(JointMove({"base_deg": 1.0}, 1e-5 * speed)),
}


@pytest.mark.parametrize("call", SLOWEST)
def test_a_motion_of_less_than_a_step_an_hour_does_not_keep_the_program_busy(call, monkeypatch):
    """As of a stick that is a hair off its middle: all of the way up to the next step was drawn."""
    drawn = []
    motors = ArmCoordinates.motors
    noted = lambda there, transmission: drawn.append(there) or motors(there, transmission)  # noqa: E731
    monkeypatch.setattr(ArmCoordinates, "motors", noted)
    arm = driven(arm_config("grbl"))
    began_s, before = arm.status.time_s, arm.twin.world.motors
    SLOWEST[call](arm, 0.05)
    arm.sleep(3.0)
    arm.stop()
    assert arm.status.time_s - began_s == pytest.approx(6.0 if call == "hold" else 3.0, abs=1.5)
    assert len(drawn) < 1000
    assert arm.twin.world.motors == before
    arm.move_j(base_deg=arm.joints.deg["base"] + 1.0)


def test_at_most_one_increment_waits_behind_the_one_under_way():
    arm = ready_arm()
    arm.jogging.nudge(Jog.joint(base=2.0), speed=1.0)
    arm.sleep(0.1)
    for _ in range(20):
        arm.jogging.nudge(Jog.joint(base=2.0), speed=1.0)
    arm.sleep(3.0)
    assert arm.joints.deg["base"] == pytest.approx(4.0, abs=0.03)


def test_a_jog_slides_up_to_its_limit_and_stops_there_without_an_error():
    arm = ready_arm()
    arm.move_j(base_deg=86)
    for _ in range(12):
        arm.jogging.hold(Jog.joint(base=1.0, wrist_roll=0.2), speed=1.0, for_s=0.3)
        arm.sleep(0.1)
    arm.sleep(1.0)
    assert arm.status.state is State.STANDBY
    assert arm.joints.deg["base"] == pytest.approx(90.0, abs=0.03)
    assert arm.joints.deg["wrist_roll"] > 5.0
    for _ in range(3):
        arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=0.3)
        arm.sleep(0.1)
    assert "limit" in arm.status.notice
    arm.jogging.hold(Jog.joint(base=-1.0), speed=1.0, for_s=0.5)
    arm.sleep(0.4)
    assert arm.status.notice == ""  # it leads back
    arm.sleep(1.0)
    assert "limit" in arm.jog_j(base_deg=50).note
    arm.jog_j(base_deg=-5)
    assert arm.joints.deg["base"] == pytest.approx(85.0, abs=0.03)


def test_joints_of_an_unknown_posture_are_jogged_slowly_and_without_limits():
    arm = sim_arm()
    began_s = arm.status.time_s
    arm.jog_j(shoulder_deg=-3, speed=1.0)
    slow = 0.15 * arm.config.motion.unreferenced_speed
    assert arm.status.time_s - began_s >= math.radians(3) / slow
    assert arm.status.trust is Trust.UNKNOWN
    assert arm.status.joints is None
    arm.twin.world.drive_to(
        arm.twin.world.body.transmission.to_motors(Joints.of(80, 60, -90, 0, 0))
    )
    assert arm.jog_j(base_deg=12).note == ""


@pytest.mark.parametrize("dialect", ["teachmover", "grbl"])
def test_a_jog_that_began_with_limits_never_goes_on_without_them(dialect):
    """A held key would drive the arm on, into a guard, when its position is no longer trusted."""
    arm = driven(arm_config(dialect), at=OVER_THE_TABLE)

    def hold(times):
        for _ in range(times):
            arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=0.25)
            arm.sleep(0.1)
        return arm.twin.world.motors

    hold(5)
    arm.parts.core.learn(Evidence.READ_BACK_DIFFERS, arm.status.time_s)
    stood = hold(5)
    assert hold(10) == stood
    assert "no limit would stop it" in arm.status.notice
    arm.sleep(1.0)
    assert hold(10) != stood


@pytest.mark.parametrize("dialect", ["teachmover", "grbl"])
def test_a_new_press_jogs_without_limits_while_the_arm_still_stops_from_the_last(dialect):
    """It was decided on after the loss of the position, whichever motion is still under way."""
    arm = driven(arm_config(dialect), at=OVER_THE_TABLE)
    for _ in range(5):
        arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=0.25)
        arm.sleep(0.1)
    arm.parts.core.learn(Evidence.READ_BACK_DIFFERS, arm.status.time_s)
    arm.jogging.release()
    assert arm.status.state is State.MOVING
    for _ in range(20):
        arm.jogging.hold(Jog.joint(base=-1.0), speed=1.0, for_s=0.25)
        arm.sleep(0.1)
        assert "no limit" not in arm.status.notice
    turned_deg = arm.twin.world.joints.deg["base"]
    arm.jogging.hold(Jog.joint(base=-1.0), speed=1.0, for_s=0.25)
    arm.sleep(0.5)
    assert arm.twin.world.joints.deg["base"] < turned_deg - 0.5


@pytest.mark.parametrize("dialect", ["teachmover", "grbl"])
@pytest.mark.parametrize("ended", ["position lost", "stopped"])
def test_a_tap_that_becomes_a_hold_is_the_same_press(dialect, ended):
    """A keyboard repeats a key only half a second after its press: much may happen meanwhile."""
    arm = driven(arm_config(dialect), at=OVER_THE_TABLE)

    def hold():
        for _ in range(10):
            arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=0.25)
            arm.sleep(0.1)
        return arm.twin.world.motors

    arm.jogging.nudge(Jog.joint(base=1.0), speed=1.0)
    arm.sleep(0.4)
    if ended == "stopped":
        arm.request_stop()
        arm.parts.runner.know_of(arm.stops)
    else:
        arm.parts.core.learn(Evidence.READ_BACK_DIFFERS, arm.status.time_s)
    stood = arm.twin.world.motors
    assert hold() == stood
    assert "let go, then jog again" in arm.status.notice.lower()
    arm.sleep(1.0)
    arm.jogging.nudge(Jog.joint(base=1.0), speed=1.0)
    assert hold() != stood


@pytest.mark.parametrize("dialect", ["teachmover", "grbl"])
@pytest.mark.parametrize("lost_first", [False, True])
def test_a_tap_that_waits_is_made_only_with_the_limits_it_was_given(dialect, lost_first):
    arm = driven(arm_config(dialect), at=OVER_THE_TABLE)
    before_deg = arm.twin.world.joints.deg["base"]
    arm.jogging.nudge(Jog.joint(base=6.0), speed=0.5)
    wait_for_motion(arm)
    if lost_first:
        arm.parts.core.learn(Evidence.READ_BACK_DIFFERS, arm.status.time_s)
    arm.jogging.nudge(Jog.joint(base=2.0), speed=0.5)
    if not lost_first:
        arm.parts.core.learn(Evidence.READ_BACK_DIFFERS, arm.status.time_s)
    arm.sleep(10.0)
    turned_deg = arm.twin.world.joints.deg["base"] - before_deg
    assert turned_deg == pytest.approx(8.0 if lost_first else 6.0, abs=0.5)
    assert ("no limit would stop it" in arm.status.notice) is not lost_first


@pytest.mark.parametrize(
    ("make", "frame", "error", "words"),
    [
        (sim_arm, "base", NotReferenced, "joint by joint"),
        (ready_arm, "bench", BadRequest, "no frame is called 'bench'; known are base, tool"),
    ],
    ids=["unknown posture", "unknown frame"],
)
def test_a_jog_of_the_tip_is_refused_in_a_sentence(make, frame, error, words):
    arm = make()
    with pytest.raises(error, match=words):
        arm.jog_l(frame=frame, x=1.0, duration_s=1.0)
    arm.jogging.hold(Jog.cartesian(frame=frame, x=1.0), speed=0.5, for_s=0.5)
    arm.sleep(1.0)
    assert words in arm.status.notice
    assert not arm.twin.link.named(b"@STEP")


@every_row(
    "call",
    [
        lambda arm: arm.jog_j(knee_deg=1),
        lambda arm: arm.jog_l(shoulder_deg=1),
        lambda arm: arm.jog_j(shoulder_mm=1),
        lambda arm: arm.jog_j(),
        lambda arm: arm.jog_j(base=2.0, duration_s=1.0),
        lambda arm: arm.jog_j(base=1.0, duration_s=-1.0),
        lambda arm: arm.jogging.hold(Jog.joint(base=1.5), speed=0.5, for_s=0.2),
    ],
)
def test_a_jog_that_means_nothing_is_refused_before_anything_moves(call):
    arm = ready_arm()
    with pytest.raises(BadRequest):
        call(arm)
    arm.sleep(1.0)
    assert not arm.twin.link.named(b"@STEP")


def test_while_homing_the_operator_can_jog_and_planned_motion_is_refused():
    arm = sim_arm()
    seen = []

    def operator(request):
        request.arm.jog_j(shoulder_deg=2)
        request.arm.jogging.hold(Jog.joint(base=1.0), speed=0.3, for_s=0.3)
        request.arm.sleep(1.0)
        request.arm.move_motors(5, 0, 0, 0, 0, 0)
        seen.append(request.arm.status.state)
        with pytest.raises(NotReferenced):
            request.arm.move_j(base_deg=1)
        return arm.operator(request)

    arm.home(operator=operator)
    assert seen == [State.HOMING]
    assert arm.status.trust is Trust.REFERENCED
    assert arm.twin.world.pose.x_mm == pytest.approx(127.0, abs=0.3)


def test_the_operator_may_use_the_pendant_between_his_jogs():
    arm = sim_arm()

    def operator(request):
        request.arm.jog_j(shoulder_deg=2)
        arm.twin.device.jog((40, 0, -10, 0, 0, 0))
        request.arm.sleep(1.0)
        request.arm.jog_j(shoulder_deg=1)
        return arm.operator(request)

    arm.home(operator=operator)
    assert arm.twin.world.motors == arm.status.acknowledged


# -- a hold that overtakes an increment -----------------------------------------------------------

LOOK_S = 0.005
STEP = 30.0


def stands_after_s(arm: Arm) -> float:
    """Let time pass until the motors have stood for a while; return how long they went on."""
    began_s = arm.status.time_s
    return stand_still_s(arm, LOOK_S, quiet_s=0.8) - began_s


def wait_for_motion(arm: Arm) -> None:
    before, until_s = arm.twin.world.motors, arm.status.time_s + 3.0
    while arm.twin.world.motors == before:
        assert arm.status.time_s < until_s
        arm.sleep(LOOK_S)


@pytest.fixture(params=["teachmover", "grbl"])
def arm(request):
    with Arm.connect(f"sim:{request.param}") as made:
        made.enable()
        made.twin.device.bring_to(made.model.arm.ik(made.model.reference.pose), 0.0)
        made.reference.confirm()
        made.jog_j(shoulder_deg=10, elbow_deg=-10, speed=1.0)
        yield made


@pytest.mark.parametrize("at_once", [False, True])
@pytest.mark.parametrize("lets_go", [False, True])
def test_an_increment_that_became_a_hold_ends_with_it(arm, lets_go, at_once):
    """A desk that was kept waiting hands over a press and its repeats `at_once`."""
    before = arm.twin.world.joints.deg["base"]
    arm.jogging.nudge(Jog.joint(base=STEP), speed=0.1)
    if not at_once:
        wait_for_motion(arm)
    began_s = arm.status.time_s
    arm.jogging.hold(Jog.joint(base=1.0), speed=0.1, for_s=1.0 if lets_go else 0.2)
    if lets_go:
        wait_for_motion(arm)
        arm.jogging.release()
    let_go_s = max(arm.status.time_s, began_s + 0.2 * (not lets_go))
    bound_s = arm.status.stop_time_s
    stood_s = arm.status.time_s + stands_after_s(arm)
    assert stood_s <= let_go_s + bound_s + LOOK_S
    assert arm.twin.world.joints.deg["base"] - before < STEP / 4


# -- Bounds ----------------------------------------------------------------------------------------


def test_an_increment_that_is_too_long_ends_at_the_bound_and_says_why():
    arm = ready_arm()
    jogged = arm.jog_l(z_mm=-400.0, gripper_mm=5.0)
    assert "table" in jogged.note
    assert -1.5 < arm.twin.world.pose.z_mm < 0.0
    assert arm.status.state is State.STANDBY
    assert "gripper" in arm.jog_j(gripper_mm=200.0).note
    assert arm.twin.world.opening_mm == pytest.approx(76.0, abs=0.1)


def test_a_long_increment_of_the_tip_is_straight():
    arm = ready_arm()
    before, off_mm = arm.twin.world.tip, 0.0
    arm.jogging.nudge(Jog.cartesian(y=150.0), speed=1.0)
    for _ in range(400):
        arm.sleep(0.02)
        x_mm, _, z_mm = arm.twin.world.tip
        off_mm = max(off_mm, math.hypot(x_mm - before[0], z_mm - before[2]))
    assert arm.twin.world.tip[1] == pytest.approx(before[1] + 150.0, abs=0.4)
    assert off_mm < 1.0


def test_an_increment_that_had_to_wait_too_long_is_dropped():
    arm = ready_arm()
    arm.jogging.nudge(Jog.joint(base=60.0), speed=1.0)
    arm.sleep(0.1)
    arm.jogging.nudge(Jog.joint(base=5.0), speed=1.0)
    arm.sleep(8.0)
    assert arm.joints.deg["base"] == pytest.approx(60.0, abs=0.03)
    assert "dropped" in arm.status.notice


def test_a_program_cannot_queue_increments_either():
    arm = ready_arm()
    arm.jogging.nudge(Jog.joint(base=2.0), speed=1.0)
    with pytest.raises(WrongState, match="already waiting"):
        arm.jog_j(base_deg=5.0)
    arm.sleep(1.0)
    assert arm.joints.deg["base"] == pytest.approx(2.0, abs=0.03)


def test_fingers_at_the_end_of_their_range_leave_the_tip_alone():
    arm = ready_arm()
    arm.gripper.open(65.0)
    before = arm.twin.world.tip
    jogged = arm.jog_l(z=0.3, gripper=1.0, duration_s=6.0, speed=0.5)
    assert jogged.note == "the gripper stopped at the limit"
    assert arm.twin.world.tip[2] > before[2] + 30.0


TOO_FAR = [
    pytest.param(lambda arm: arm.jog_j(base_deg=1e6), "base", 1e6, 180.0, id="increment"),
    pytest.param(lambda arm: arm.jog_j(base_deg=-181.0), "base", -181.0, 180.0, id="just too far"),
    pytest.param(lambda arm: arm.jog_j(gripper_mm=200.0), "gripper", 200.0, 76.0, id="fingers"),
    pytest.param(
        lambda arm: arm.start(JogMove(Jog.joint(elbow=1e6))), "elbow", 1e6, 149.0, id="move"
    ),
    pytest.param(
        lambda arm: arm.jog_j(base=-1.0, duration_s=1e5, speed=0.01), "base", None, 180.0, id="held"
    ),
]


@pytest.mark.parametrize(("call", "name", "amount", "whole"), TOO_FAR)
def test_no_jog_without_limits_is_longer_than_the_whole_range(call, name, amount, whole):
    arm = sim_arm()
    with pytest.raises(OutOfBounds, match=f"the {name} would move by .* whole range is") as refused:
        call(arm)
    assert refused.value.name == name
    assert refused.value.bound == pytest.approx(whole, abs=0.1)
    assert amount is None or refused.value.value == pytest.approx(amount)
    assert not arm.twin.link.named(b"@STEP")


def test_a_jogs_notice_is_cleared_by_the_next_motion():
    arm = ready_arm()
    arm.jog_l(z_mm=-400.0)
    assert "table" in arm.status.notice
    arm.move_j(base_deg=5.0)
    assert arm.status.notice == ""
    arm.jogging.hold(Jog.cartesian(frame="bench", x=1.0), speed=0.5, for_s=0.5)
    assert "bench" in arm.status.notice
    arm.gripper.open(30.0)
    assert arm.status.notice == ""
