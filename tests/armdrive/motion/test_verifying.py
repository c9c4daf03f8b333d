"""Motions that are verified, and faults in motion."""

import math
import random
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import pytest
from amounts import amount, in_pairs
from faults import arm_config, driven, standing

from armdrive import Arm, Jog, MarkRequest, Verdict
from armdrive.arm.connected import Handle
from armdrive.config.sections import HomingSettings
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError, DeviceFault, NoAnswer, NotReferenced, OperatorNeeded, Stopped
from armdrive.motion.reference import drift_between, judge
from armdrive.motion.resolve import park_pose
from armdrive.moves import JogMove
from armdrive.registry import DIALECTS, simulate
from armdrive.status import Evidence, State, Trust
from armdrive.storage.record import RecordFile
from armdrive.tasks import Alert, AlertKind
from kinematics import Joints, Motors

CONFIG = simulated_config("teachmover")
MODEL = CONFIG.model


def homed(dialect: str = "teachmover") -> Arm:
    """Return an arm that stands at its mark, where it was referenced."""
    arm = Arm(connect_simulated(simulated_config(dialect)))
    arm.enable()
    arm.twin.device.bring_to(arm.model.arm.ik(arm.model.reference.pose), 0.0)
    arm.reference.confirm()
    return arm


@pytest.mark.parametrize(
    ("dialect", "motor"), [("robko01", 2), *amount([], [("teachmover", 1), ("grbl", 4)])]
)
def test_lost_steps_are_measured_to_the_step(dialect, motor):
    arm = homed(dialect)
    chance = random.Random(f"{dialect} {motor}")
    lost = chance.randint(4, 40)
    arm.twin.faults.add("lose-steps", str(motor), str(lost))
    here = arm.joints.deg
    arm.move_j(
        base_deg=12.0,
        shoulder_deg=here["shoulder"] + 8.0,
        wrist_pitch_deg=here["wrist_pitch"] + 12.0,
    )
    truth = arm.status.acknowledged - arm.twin.world.motors
    assert truth.largest == lost
    found = arm.reference.verify(speed=1.0)
    assert found.drift.steps == truth
    assert arm.status.acknowledged - arm.twin.world.motors == truth
    assert found.verdict is Verdict.DRIFT
    said, _ = arm.model.transmission.to_joints(arm.status.acknowledged)
    seen = arm.twin.world.joints
    for angle, one, other in zip(found.drift.turned, said, seen, strict=True):
        assert angle == pytest.approx(one - other, abs=1e-9)
    tip = arm.model.arm.fk(said)
    off_mm = math.dist(arm.twin.world.tip, (tip.x_mm, tip.y_mm, tip.z_mm))
    assert found.drift.tip_mm == pytest.approx(off_mm, abs=1e-6)


def test_steps_that_a_drive_makes_up_for_are_no_drift():
    config = arm_config("mks")
    arm = driven(config, at=config.model.arm.ik(park_pose(config)))
    arm.twin.faults.add("lose-steps", "2", "400")
    here = arm.joints.deg
    arm.move_j(base_deg=4.0, shoulder_deg=here["shoulder"] + 3.0)
    assert arm.status.acknowledged == arm.twin.world.motors
    found = arm.reference.verify(speed=1.0)
    assert found.verdict is Verdict.ROUNDING
    assert arm.status.trust is Trust.REFERENCED


@pytest.mark.parametrize("dialect", amount(["teachmover"], ["teachmover", "grbl"]))
def test_an_arm_that_lost_nothing_is_within_rounding_and_keeps_its_reference(dialect):
    arm = homed(dialect)
    arm.move_j(base_deg=-5.0, shoulder_deg=arm.joints.deg["shoulder"] + 3.0)
    found = arm.reference.verify(accept=True)
    assert found.verdict is Verdict.ROUNDING
    assert not found.accepted
    assert arm.status.trust is Trust.REFERENCED
    assert arm.status.state is State.STANDBY


def test_a_difference_too_small_to_see_is_not_drift_but_can_be_accepted():
    arm = homed()
    arm.twin.faults.add("lose-steps", "base", "3")
    arm.move_j(base_deg=10.0)
    found = arm.reference.verify(accept=lambda _: pytest.fail("nobody is asked"))
    assert found.verdict is Verdict.ROUNDING
    assert found.drift.steps.largest == 3
    assert arm.status.trust is Trust.REFERENCED
    assert arm.reference.verify(accept=True).accepted
    assert arm.status.acknowledged == arm.twin.world.motors


def drifted() -> Arm:
    arm = homed()
    arm.twin.faults.add("lose-steps", "base", "12")
    arm.move_j(base_deg=20.0)
    return arm


def test_an_unaccepted_drift_makes_the_position_suspect_and_gives_its_size():
    arm = drifted()
    found = arm.reference.verify()
    assert not found.accepted
    assert "base +12" in str(found)
    assert "+0.61°" in str(found)
    assert arm.status.trust is Trust.SUSPECT
    assert "base +12" in arm.status.trust_reason
    assert arm.status.trust_code == "E721"
    with pytest.raises(NotReferenced):
        arm.move_j(base_deg=0.0)


@pytest.mark.parametrize("accept", [True, lambda found: found.verdict is Verdict.DRIFT])
def test_an_accepted_drift_is_gone(accept):
    arm = drifted()
    assert arm.reference.verify(accept=accept).accepted
    assert arm.status.acknowledged == arm.twin.world.motors
    assert arm.status.trust is Trust.REFERENCED
    arm.move_j(base_deg=10.0)
    assert arm.reference.verify().verdict is Verdict.ROUNDING


def test_a_reference_that_was_taken_elsewhere_may_be_wrong_by_its_numbers():
    arm = homed()
    joints = arm.joints
    arm.reference.declare(joints.replace(shoulder=joints["shoulder"] + 0.05))
    assert arm.reference.verify().verdict is Verdict.CALIBRATION


def test_a_difference_larger_than_any_loss_of_steps_is_not_drift():
    truth = MODEL.transmission.to_motors(MODEL.arm.ik(MODEL.reference.pose))
    drift = drift_between(CONFIG, truth + Motors((0, 400, 0, 0, 0, 0)), truth)
    assert judge(drift, Evidence.HOMED.value) is Verdict.CALIBRATION
    small = drift_between(CONFIG, truth + Motors((1, -1, 0, 1, 0, 0)), truth)
    assert judge(small, Evidence.DECLARED.value) is Verdict.ROUNDING


def test_a_verification_needs_a_position_and_an_operator():
    unknown, alone = Arm.connect("sim:teachmover"), homed()
    alone.operator = None
    for arm, error, words in (
        (unknown, NotReferenced, "home"),
        (alone, OperatorNeeded, "with an operator"),
    ):
        before = arm.twin.world.motors
        with pytest.raises(error, match=words):
            arm.reference.verify()
        assert arm.twin.world.motors == before


def test_an_unconfirmed_verification_changes_nothing():
    arm = drifted()
    asked = []

    def refuses(request) -> bool:
        asked.append(request)
        return False

    with pytest.raises(OperatorNeeded):
        arm.reference.verify(operator=refuses)
    assert isinstance(asked[0], MarkRequest)
    assert "small jogs" in str(asked[0])
    assert arm.status.state is State.STANDBY
    assert arm.status.trust is Trust.REFERENCED


def test_a_stop_while_the_operator_is_at_work_ends_the_verification():
    arm = drifted()

    def stops(request) -> bool:
        request.arm.stop()
        return True

    with pytest.raises(Stopped):
        arm.reference.verify(operator=stops, accept=True)
    assert arm.status.trust is Trust.REFERENCED
    assert "reference posture" in arm.status.trust_reason


def test_a_restored_position_that_is_right_at_the_mark_is_referenced(tmp_path):
    config = simulated_config("teachmover")
    first = Arm(connect_simulated(config, record_store=RecordFile(tmp_path / "r.json")))
    first.home()
    first.park()
    first.close()
    arm = Arm(
        connect_simulated(
            config,
            twin=simulate(config, first.twin.save()),
            record_store=RecordFile(tmp_path / "r.json"),
            allow_restored=True,
        )
    )
    assert arm.status.trust is Trust.RESTORED
    assert arm.reference.verify().verdict is Verdict.ROUNDING
    assert arm.status.trust is Trust.REFERENCED


# -- Faults ----------------------------------------------------------------------------------------

KINDS = amount(["teachmover", "robko01", "grbl", "cia402"], list(DIALECTS))
"""A device that greets, one that does not, a queue and a bus."""
WORDS = "somebody has opened the door"
MOTIONS: dict[str, Callable[[Arm], Handle[Any]]] = {
    "move": lambda arm: arm.move_j(base_deg=20.0, speed=0.5, wait=False),
    "jog": lambda arm: arm.start(JogMove(Jog.joint(base=20.0), 0.5)),
}
HOMING = HomingSettings(Joints.of(40.0, 40.0, -80.0, -40.0, 0.0), 20.0, ((1,), (2,)))


def alert(arm: Arm) -> None:
    """Have the device report an alarm that leaves its position right."""
    arm.parts.engine.controller.io.notify(Alert(AlertKind.ALARM, WORDS))


@in_pairs("dialect, motion, stopped", KINDS, list(MOTIONS), (True, False))
def test_no_motion_ends_well_in_error_stop(dialect, motion, stopped):
    arm = driven(arm_config(dialect))
    handle = MOTIONS[motion](arm)
    arm.sleep(0.4)
    assert arm.status.state is State.MOVING
    if stopped:
        arm.request_stop()
    alert(arm)
    with pytest.raises(DeviceFault, match=WORDS):
        handle.wait()
    assert arm.status.state is State.ERROR_STOP


@pytest.mark.parametrize(("dialect", "motion"), list(product(KINDS, MOTIONS)))
def test_a_stop_does_not_hide_a_power_failure(dialect, motion):
    arm = driven(arm_config(dialect))
    handle = MOTIONS[motion](arm)
    arm.sleep(0.4)
    arm.twin.faults.add("brown-out")
    arm.request_stop()
    with pytest.raises(ArmError) as told:
        handle.wait()
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.state is State.ERROR_STOP or arm.status.trust_reason in str(told.value)


@pytest.mark.parametrize("dialect", amount(["armdroid", "cia402"], list(DIALECTS)))
def test_a_stop_says_that_the_arm_did_not_answer_it(dialect):
    """Nobody waits for the end of a held jog, so only the stop can tell."""
    arm = driven(arm_config(dialect))
    arm.jogging.hold(Jog.joint(base=1.0), speed=0.5, for_s=1.0)
    arm.sleep(0.4)
    arm.twin.faults.add("brown-out")
    with pytest.raises(NoAnswer):
        arm.stop()
    arm.stop()  # it has been told


@pytest.mark.parametrize("motion", MOTIONS)
def test_an_emergency_stop_is_named_by_the_motion_that_it_ends(motion):
    arm = driven(arm_config("teachmover"))
    handle = MOTIONS[motion](arm)
    arm.sleep(0.4)
    arm.estop()
    with pytest.raises(Stopped, match=r"emergency stop.*reset"):
        handle.wait()


@pytest.mark.parametrize("dialect", ["grbl", "mks"])
def test_an_alarm_in_a_homing_group_ends_the_homing(dialect):
    arm = homing(dialect)
    before, told = arm.twin.world.motors, []
    arm.twin.device.at(arm.parts.pace.now_s() + 0.5, lambda: alert(arm))
    with pytest.raises(DeviceFault, match=WORDS):
        arm.home(report=told.append)
    nothing_was_referenced(arm)
    assert not told
    assert arm.twin.world.motors[1] == before[1], "the next group was homed in error-stop"


@pytest.mark.parametrize("dialect", ["grbl", "mks"])
def test_an_alarm_after_the_last_homing_group_leaves_nothing_referenced(dialect):
    arm = homing(dialect)
    told = []

    def report(group):
        told.append(group)
        if len(told) == len(HOMING.groups):
            alert(arm)

    with pytest.raises(DeviceFault, match=WORDS):
        arm.home(report=report)
    nothing_was_referenced(arm)


def homing(dialect: str) -> Arm:
    """Return a referenced arm that homes by its switches."""
    device = {"homing": True} if dialect == "grbl" else {}
    return driven(replace(arm_config(dialect, device=device), homing=HOMING))


def nothing_was_referenced(arm: Arm) -> None:
    assert arm.status.state is State.ERROR_STOP
    assert WORDS in arm.status.error
    assert arm.status.trust_reason == Evidence.HOMING_FAILED.value


# -- counts that fall to zero, on a device that does not greet ------------------------------------


def seen_in_motion(arm, base_deg):
    """Begin to move; return when the driver has been told that the counts have changed."""
    start = arm.status.read_back
    arm.move_j(base_deg=base_deg, wait=False)
    for _ in range(200):
        arm.sleep(0.005)
        if arm.status.read_back != start:
            return


@pytest.mark.parametrize("base_deg", [30.0, -30.0])
def test_counts_that_return_to_their_start_are_those_of_a_restarted_device(base_deg):
    arm = standing("robko01")
    seen_in_motion(arm, base_deg)
    arm.twin.faults.add("brown-out", for_s=0.1)
    arm.sleep(0.02)
    arm.stop()
    arm.sleep(1.0)
    assert not arm.twin.device.registers.largest
    assert arm.status.trust is Trust.SUSPECT
    assert "registers are zero" in arm.status.trust_reason


@pytest.mark.parametrize("dialect", amount(["robko01"], ["teachmover", "robko01", "grbl", "mks"]))
def test_a_motion_back_to_zero_that_is_stopped_keeps_its_position(dialect):
    arm = standing(dialect)
    there = arm.joints.deg["base"]
    arm.move_j(base_deg=there + 10.0)
    for after_s in (0.1, 0.4):
        arm.move_j(base_deg=there, wait=False)
        arm.sleep(after_s)
        arm.stop()
        assert arm.status.trust is Trust.REFERENCED
    arm.move_j(base_deg=there - 5.0, wait=False)
    arm.sleep(0.8)
    arm.stop()
    assert arm.status.trust is Trust.REFERENCED
    assert arm.twin.world.motors == arm.status.acknowledged
