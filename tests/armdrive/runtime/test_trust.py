"""Trust in the position: its table, what planned motion needs, and what lowers it on a wire."""

import pytest
from amounts import every_row
from faults import OVER_THE_TABLE, Rule, as_it_stands, late_by, lost, ready_arm, sim_arm
from hypothesis import given
from hypothesis import strategies as st
from pages import page_path

from armdrive import Arm
from armdrive.blocking import run_blocking
from armdrive.connect.connection import CLOSING_S
from armdrive.errors import ArmError, DeviceFault, NotReferenced, PositionMismatch, Refused
from armdrive.errors.table import code_of_name
from armdrive.motion.context import LONGEST_S
from armdrive.motion.reference import confirmed_posture, take_reference
from armdrive.runtime import persistence
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.states import FIRST_BELIEF, Belief, require_reference
from armdrive.status import Current, Evidence, State, Trust, code_of_reason
from armdrive.storage.record import FORMAT, from_text
from kinematics import Pose

RAISING = {Evidence.HOMED, Evidence.DECLARED, Evidence.CONFIRMED, Evidence.HOMED_BY_SWITCHES}
RANK = {Trust.UNKNOWN: 0, Trust.SUSPECT: 1, Trust.RESTORED: 2, Trust.REFERENCED: 3}
AT_CONNECT = {Evidence.RECORD_MATCHES}


def test_every_kind_of_evidence_has_a_row_and_words():
    for evidence in Evidence:
        belief = Belief(Trust.REFERENCED, "it was homed").after(evidence, 3.0, "detail")
        assert belief.trust is evidence.trust
        assert belief.since_s == 3.0
        assert evidence.value in belief.reason
        assert "detail" in belief.reason


def test_a_reason_has_the_code_of_its_evidence_whatever_detail_follows():
    for evidence in Evidence:
        code = code_of_name(evidence.name)
        assert code_of_reason(f"{evidence.value} (detail)") == code
        assert bool(code) == (evidence.trust is not Trust.REFERENCED)
        assert code_of_reason(f"not that {evidence.value}") == ""


@given(st.lists(st.sampled_from([e for e in Evidence if e not in RAISING | AT_CONNECT])))
def test_nothing_but_a_reference_or_a_confirmation_raises_trust(history):
    for start in Trust:
        belief = Belief(start, "as it was")
        for evidence in history:
            after = belief.after(evidence, 0.0)
            assert RANK[after.trust] <= RANK[belief.trust]
            belief = after


@every_row("evidence", [e for e in Evidence if e.trust is Trust.SUSPECT])
def test_unknown_stays_unknown_and_a_suspect_position_tells_its_first_and_latest_reason(evidence):
    assert FIRST_BELIEF.after(evidence, 1.0) == FIRST_BELIEF
    doubt = Belief(Trust.SUSPECT, "the first reason; then another")
    both = Belief(Trust.SUSPECT, f"the first reason; then {evidence.value}")
    assert doubt.after(evidence, 1.0) == both
    assert both.after(evidence, 2.0, "again") == both


@pytest.mark.parametrize(
    ("trust", "allowed", "word"),
    [
        (Trust.UNKNOWN, True, "`home()`"),
        (Trust.SUSPECT, True, "`home()`"),
        (Trust.RESTORED, False, "allow_restored"),
    ],
)
def test_a_refusal_gives_the_reason_and_the_remedy(trust, allowed, word):
    with pytest.raises(NotReferenced) as refusal:
        require_reference(Belief(trust, "for a reason"), allow_restored=allowed)
    assert "for a reason" in str(refusal.value)
    assert word in str(refusal.value)


def test_a_restored_position_is_enough_if_the_caller_allowed_it():
    require_reference(Belief(Trust.RESTORED, ""), allow_restored=True)
    require_reference(Belief(Trust.REFERENCED, ""), allow_restored=False)


PLANNED = [
    lambda arm: arm.move_j(base_deg=5),
    lambda arm: arm.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=150, pitch_deg=-90)),
    lambda arm: arm.move_l(Pose.of(x_mm=250, y_mm=0, z_mm=150, pitch_deg=-90)),
    lambda arm: arm.park(),
    lambda arm: arm.gripper.open(),
    lambda arm: arm.gripper.grasp(),
]


@pytest.mark.parametrize("call", PLANNED)
def test_no_planned_motion_without_a_reference_and_no_byte_of_one(call):
    arm = sim_arm()
    before = len(arm.twin.link.sent)
    with pytest.raises(NotReferenced, match=r"planned motion needs a trusted position.*home"):
        call(arm)
    assert len(arm.twin.link.sent) == before
    with pytest.raises(NotReferenced, match="knowing where the arm is needs a trusted position"):
        _ = arm.pose


def test_the_pendant_makes_a_standing_arm_suspect_within_seconds():
    arm = ready_arm()
    arm.twin.device.jog((30, 0, 0, 0, 0, 0))
    arm.sleep(2.5)
    assert arm.status.trust is Trust.SUSPECT
    assert "pendant" in arm.status.trust_reason
    assert arm.status.joints.deg["base"] == pytest.approx(30 / 7072 * 360, abs=0.05)


def test_a_second_doubt_is_told_beside_the_first_one():
    arm = ready_arm()
    arm.disable()
    arm.enable()
    arm.twin.device.jog((30, 0, 0, 0, 0, 0))
    arm.sleep(2.5)
    first, latest = Evidence.CURRENT_DROPPED, Evidence.MOVED_BY_OTHERS
    assert arm.status.trust_reason == f"{first.value}; then {latest.value}"
    assert arm.status.trust_code == "E715"
    assert arm.status.notice == Evidence.MOVED_BY_OTHERS.value


@pytest.mark.parametrize("seconds", [0.35, 0.6, 0.9])
def test_a_pendant_move_just_before_a_motion_is_seen_before_the_motion(seconds):
    arm = ready_arm()
    arm.sleep(2.0)
    arm.sleep(seconds)
    arm.twin.device.jog((200, 0, 0, 0, 0, 0))
    before = arm.twin.world.motors
    with pytest.raises(NotReferenced):
        arm.move_j(base_deg=40)
    assert arm.twin.world.motors == before


@pytest.mark.parametrize("off_s", [0.1, 5.0])
def test_a_controller_that_lost_its_power_while_idle_is_suspect_and_keeps_its_posture(off_s):
    arm = ready_arm()
    arm.move_j(base_deg=20)
    device = arm.twin.device
    device.power_off()
    device.at(device.now_s + off_s, device.power_on)
    arm.sleep(off_s + 8.0)
    assert arm.status.trust is Trust.SUSPECT
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
    assert arm.status.joints.deg["base"] == pytest.approx(20.0, abs=0.05)
    assert arm.status.current is not Current.HELD
    with pytest.raises(NotReferenced):
        arm.move_j(base_deg=0)


def test_a_brown_out_between_bursts_is_found_while_the_motion_goes_on():
    arm = ready_arm()
    device = arm.twin.device
    steps = []

    def cut_once(data):
        steps.append(data)
        if len(steps) == 4:
            device.power_off()
            device.power_on()

    arm.twin.link.on_write = cut_once
    began_s = arm.status.time_s
    with pytest.raises((PositionMismatch, DeviceFault)):
        arm.move_j(base_deg=85, shoulder_deg=80, speed=0.3)
    assert arm.status.time_s - began_s < 6.0
    assert arm.status.trust is Trust.SUSPECT


def test_a_lost_answer_to_a_motion_is_suspect_and_a_reset_does_not_mend_that():
    arm = ready_arm()
    arm.twin.link.back.append(Rule(b"1", lost))
    with pytest.raises(ArmError):
        arm.move_j(base_deg=1)
    assert (arm.status.trust, arm.status.state) == (Trust.SUSPECT, State.ERROR_STOP)
    arm.reset()
    assert (arm.status.trust, arm.status.state) == (Trust.SUSPECT, State.STANDBY)
    arm.reference.declare(OVER_THE_TABLE)
    assert arm.status.trust is Trust.REFERENCED


def test_dropping_the_current_says_suspect_and_only_disable_sends_it():
    arm = sim_arm()
    arm.home()
    arm.estop()
    arm.reset()
    arm.move_j(shoulder_deg=60)
    assert not arm.twin.link.named(b"@RESET")
    arm.disable()
    assert len(arm.twin.link.named(b"@RESET")) == 1
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.current is Current.OFF
    assert "sag" in arm.status.trust_reason
    arm.enable()
    with pytest.raises(NotReferenced):
        arm.move_j(base_deg=1)
    arm.close()
    assert len(arm.twin.link.named(b"@RESET")) == 1


def test_there_is_nothing_to_confirm_without_a_restored_position():
    arm = ready_arm()
    with pytest.raises(Refused, match=r"no restored position .* the position is referenced\n"):
        arm.reference.confirm_restored()


def test_a_board_that_restarts_as_a_posture_is_declared_is_named_as_the_reason():
    arm = Arm.connect("sim:grbl")
    arm.twin.link.line.say(b"\r\nGrbl 1.1h ['$' for help]\r\n", arm.parts.pace.now_s())
    with pytest.raises(DeviceFault, match="the board was reset"):
        as_it_stands(arm)
    assert arm.status.trust is Trust.UNKNOWN


def test_a_posture_is_not_taken_from_a_controller_that_was_restarted_meanwhile():
    arm = ready_arm()
    arm.move_j(base_deg=20)
    here = arm.joints
    device = arm.twin.device
    device.power_off()
    device.power_on()
    with pytest.raises(DeviceFault, match="changed a moment ago"):
        arm.reference.declare(here)
    assert arm.status.trust is Trust.SUSPECT
    arm.reference.declare(arm.twin.world.joints, opening_mm=20.0)
    assert arm.status.trust is Trust.REFERENCED


@pytest.mark.parametrize(("counts", "trust"), [(0, Trust.SUSPECT), (40, Trust.REFERENCED)])
def test_counts_of_zero_after_a_silence_may_mean_a_restart(counts, trust):
    arm = sim_arm()
    as_it_stands(arm)
    arm.move_motors(counts, 0, 0, 0, 0, 0)
    arm.twin.link.to.append(Rule(b"@READ", lost))
    arm.sleep(3.0)
    assert arm.twin.link.to[0].times == 0, "the rule has been used"
    assert arm.status.trust is trust


DISTURBED = {"lost": lost, "late": late_by(1.2)}


@pytest.mark.parametrize("how", DISTURBED)
def test_a_posture_is_not_taken_of_an_arm_that_moved_while_the_wire_was_disturbed(how):
    arm = ready_arm()
    here, device = arm.joints, arm.twin.device
    arm.twin.link.to.append(Rule(b"@READ", DISTURBED[how]))
    device.at(device.now_s + 0.4, lambda: device.jog((0, 0, 0, 25, 0, 0)))
    with pytest.raises(DeviceFault, match="confirm its posture again"):
        arm.reference.declare(here, opening_mm=20.0)
    assert arm.status.trust is not Trust.REFERENCED
    arm.reference.declare(arm.twin.world.joints, opening_mm=20.0)
    assert arm.status.acknowledged == arm.twin.world.motors


def test_a_posture_that_the_pendant_has_just_brought_about_is_taken():
    arm = ready_arm()
    arm.twin.device.jog((0, 0, 0, 25, 0, 0))
    arm.reference.declare(arm.twin.world.joints, opening_mm=20.0)
    assert arm.status.trust is Trust.REFERENCED
    assert arm.status.acknowledged == arm.twin.world.motors


def test_a_posture_is_not_taken_when_the_look_before_has_seen_the_registers_fall():
    arm = ready_arm()
    arm.move_j(base_deg=20)
    arm.twin.device.jog((0, 0, 0, 25, 0, 0))
    arm.sleep(3.0)
    here, device = arm.twin.world.joints, arm.twin.device
    assert arm.status.trust is Trust.SUSPECT
    there = ArmCoordinates(here, 20.0)
    word = confirmed_posture(arm.parts.core, there, Evidence.DECLARED, arm.parts.pace.now_s())
    device.power_off()
    device.power_on()
    run_blocking(arm.parts.runner.perform(arm.parts.context.look()))
    with pytest.raises(DeviceFault, match="confirm its posture again"):
        run_blocking(arm.parts.runner.perform(take_reference(arm.parts.context, word)))
    assert arm.status.trust is Trust.SUSPECT


# -- the page on trust ----------------------------------------------------------------------------

PAGE = page_path("trust")


def test_the_page_shows_a_record_that_can_be_read():
    text = PAGE.read_text(encoding="utf-8")
    shown = text.partition("```json\n")[2].partition("```")[0]
    assert from_text(shown.encode()).trust == "referenced"


def test_the_page_gives_the_times_and_names_of_the_code():
    text = PAGE.read_text(encoding="utf-8")
    assert persistence.STILL_S == 2.0
    assert "two seconds" in text
    assert f"{LONGEST_S:g} s" in text
    assert f"{CLOSING_S:g} s" in text
    assert f'"format": {FORMAT}' in text
