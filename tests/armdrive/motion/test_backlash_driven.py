"""Backlash compensation of a driven arm, and its reference."""

import math
import tomllib
from dataclasses import replace
from types import SimpleNamespace

import pytest
from amounts import amount, every_row
from backlash_bench import (
    MIDDLE,
    PLAY,
    arm_with_play,
    config_of,
    move_at_random,
    off_mm,
    off_steps,
    reference_from_one_side,
)
from faults import as_it_stands

from armdrive import Arm, Jog, Pose
from armdrive.connect.parts import connect_simulated
from armdrive.errors import ArmError, BadRequest, Stopped
from armdrive.registry import simulate
from armdrive.registry.arm_files import parse_arm
from armdrive.runtime.backlash import Slack
from armdrive.sim.world.table import TableBlock
from armdrive.status import State, Trust
from armdrive.storage.record import RecordFile
from armdrive.tasks import MoveAlong, MoveBy
from firmware_protocol.teachmover import Key
from kinematics import Joints

every_kind = pytest.mark.parametrize(
    "dialect", amount(["teachmover", "grbl"], ["teachmover", "armdroid", "grbl"])
)
"""Bursts of coordinated motors, bursts of others, and a queue."""

AT_MIDDLE = {f"{name}_deg": deg for name, deg in MIDDLE.items()}


@every_kind
def test_without_compensation_the_arm_is_off_by_its_play_and_with_it_by_nothing(dialect):
    plain = arm_with_play(dialect, backlash=0)
    assert max(move_at_random(plain, 4)) == PLAY
    plain.move_j(base_deg=4.0)
    plain.move_j(base_deg=1.0)
    assert off_mm(plain) > 2.0
    arm = arm_with_play(dialect)
    assert arm.status.notice == ""
    assert max(move_at_random(arm, 4)) == 0
    assert off_mm(arm) < 1e-9


def test_nothing_drifts_over_many_moves():
    arm = arm_with_play("teachmover", play=(12, 7, 30, 3, 0, 5), backlash=(12, 7, 30, 3, 0, 5))
    assert max(move_at_random(arm, 30, seed=2, deg=3.0)) == 0


def test_a_backlash_that_was_measured_a_little_wrong_is_off_by_no_more_than_that():
    arm = arm_with_play("teachmover", backlash=PLAY - 2)
    assert max(move_at_random(arm, 30)) <= 2 + 2  # beside the reference, which was no better


def beside_line_mm(arm):
    """Draw a line along y there and back; return the largest deviation of the tip."""
    pose = Pose.of(x_mm=300, y_mm=-35, z_mm=120, pitch_deg=-70)
    arm.move_to(pose)
    worst_mm = 0.0
    for goal in (replace(pose, y_mm=35.0), pose):
        handle = arm.move_l(goal, wait=False)
        while not handle.done:
            arm.sleep(0.02)
            x_mm, _, z_mm = arm.twin.world.tip
            worst_mm = max(worst_mm, math.hypot(x_mm - 300, z_mm - 120))
        moved = handle.wait()
        motion = arm.config.motion
        exact = arm.abilities.coordinated
        assert moved.deviation_mm <= (motion.line_tolerance_mm if exact else motion.deviation_mm)
        assert off_steps(arm) == 0
    return worst_mm


@every_kind
def test_a_line_is_kept_where_motors_turn_round_in_it(dialect):
    """The shoulder's and the elbow's in the middle of the line, the base's at its ends."""
    true_mm = beside_line_mm(arm_with_play(dialect, play=0, backlash=0))
    assert beside_line_mm(arm_with_play(dialect)) <= true_mm + 0.5


@every_kind
def test_jogging_by_small_increments_moves_the_arm_every_time(dialect):
    arm = arm_with_play(dialect)
    arm.move_j(**AT_MIDDLE)
    for sign in (1, -1, -1, 1, -1, 1):
        before = arm.twin.world.joints["base"]
        arm.jog_j(base_deg=0.3 * sign)
        assert (arm.twin.world.joints["base"] - before) * sign > 0.004
        assert off_steps(arm) == 0


@every_kind
def test_a_reversed_and_released_jog_ends_at_the_reported_position(dialect):
    arm = arm_with_play(dialect)
    arm.move_j(**AT_MIDDLE)
    for sign, for_s in ((1.0, 0.5), (-1.0, 0.12), (1.0, 0.31), (-1.0, 0.45)):
        arm.jogging.hold(Jog.joint(base=sign, elbow=-sign), speed=0.7, for_s=for_s)
        arm.sleep(for_s + 1.0)
        assert arm.status.state is State.STANDBY
        assert off_steps(arm) == 0
    assert arm.status.trust is Trust.REFERENCED


@every_kind
def test_releasing_a_jog_during_backlash_compensation_stops_within_the_same_time(dialect):
    arm = arm_with_play(dialect, play=190, backlash=190)
    arm.move_j(**AT_MIDDLE)
    arm.jog_j(base_deg=2)
    before = arm.twin.world.motors
    bound_s = arm.status.silent_time_s
    arm.jogging.hold(Jog.joint(base=-1.0), speed=1.0, for_s=0.3)
    arm.sleep(0.3 + bound_s)
    registers = arm.twin.device.registers
    arm.sleep(1.0)
    assert arm.twin.device.registers == registers
    assert arm.twin.world.motors == before == arm.status.acknowledged
    assert list(arm.parts.core.position.slack.taken) == arm.twin.world.play.ahead
    assert 0 < arm.parts.core.position.slack.taken[0] < 190


@every_kind
def test_a_pause_during_backlash_compensation_stops_and_resumes_there(dialect):
    arm = arm_with_play(dialect, play=90, backlash=90)
    arm.move_j(**AT_MIDDLE)
    for number, after_s in enumerate((0.03, 0.15, 0.3)):
        handle = arm.move_j(base_deg=-3.0 if number % 2 else 3.0, shoulder_deg=40, wait=False)
        arm.sleep(after_s)
        bound_s = arm.status.silent_time_s
        arm.pause()
        arm.sleep(bound_s + 0.02)
        registers = arm.twin.device.registers
        arm.sleep(0.5)
        assert arm.twin.device.registers == registers
        arm.resume()
        handle.wait()
        assert off_steps(arm) == 0


@pytest.mark.parametrize(
    ("dialect", "wide"),
    [("teachmover", PLAY), ("grbl", 90), *amount([], [("armdroid", 90), ("robko01", 90)])],
)
def test_a_stop_at_any_moment_of_backlash_compensation_keeps_the_position(dialect, wide):
    arm = arm_with_play(dialect, play=wide, backlash=wide)
    arm.move_j(**AT_MIDDLE)
    for number, after_s in enumerate((0.05, 0.09, 0.16, 0.31, 0.02, 0.6)):
        way = 8.0 if number % 2 else -8.0
        handle = arm.move_j(base_deg=way, shoulder_deg=42.0 - way, speed=0.6, wait=False)
        arm.sleep(after_s)
        arm.stop()
        with pytest.raises((Stopped, ArmError)):
            handle.wait()
        assert off_steps(arm) == 0
        assert list(arm.parts.core.position.slack.taken) == arm.twin.world.play.ahead
    assert arm.status.trust is Trust.REFERENCED


@every_kind
def test_no_burst_is_longer_than_announced_whatever_the_backlash(dialect):
    arm = arm_with_play(dialect, play=150, backlash=150)
    arm.move_j(**AT_MIDDLE)
    controller, lengths = arm.parts.core.controller, []
    begin = controller.begin

    def noted(pieces):
        for each in pieces:
            lengths.append(each.duration_s)
            yield each

    def spied(request, now_s):
        if isinstance(request, MoveBy):
            lengths.append(controller.duration_s(request.steps.largest, request.rate_hz))
        if isinstance(request, MoveAlong):
            request = replace(request, segments=noted(request.segments))
        begin(request, now_s)

    controller.begin = spied
    for way in (6.0, -6.0):
        arm.move_j(base_deg=way, elbow_deg=-75 + way)
        assert off_steps(arm) == 0
    assert lengths
    assert max(lengths) <= arm.config.motion.planned_burst_s + 1e-6


def test_fingers_that_a_motor_with_backlash_pulls_measure_what_they_hold():
    arm = arm_with_play("teachmover")
    pose = Pose.of(x_mm=250, y_mm=0, z_mm=20, pitch_deg=-90)
    arm.gripper.open()
    arm.move_to(replace(pose, z_mm=90))
    arm.twin.world.put(TableBlock("A", 250.0, 0.0, 0.0, 30.0, 40.0))
    arm.move_to(pose)
    for _ in range(3):
        assert arm.gripper.grasp() == pytest.approx(30.0, abs=0.3)
        arm.gripper.open()
    assert off_steps(arm) == 0


def test_a_stop_that_may_have_come_on_either_side_of_a_reversal_is_suspect(monkeypatch):
    arm, see = arm_with_play("teachmover"), Slack.see

    def ambiguous(slack, made):
        driven = see(slack, made)
        slack.vague = True
        return driven

    handle = arm.move_j(base_deg=30.0, wait=False)
    arm.sleep(0.5)
    monkeypatch.setattr(Slack, "see", ambiguous)
    arm.twin.device.board.press(Key.STOP)
    with pytest.raises(ArmError):
        handle.wait()
    assert arm.status.trust is Trust.SUSPECT
    assert "stopped while reversing" in arm.status.trust_reason


# -- References ------------------------------------------------------------------------------------


@every_kind
def test_the_next_program_knows_on_which_side_of_its_play_each_motor_is(dialect, tmp_path):
    arm = arm_with_play(dialect)
    config = arm.config
    for number in range(2):
        arm.close()
        twin = simulate(config, arm.twin.save())
        recorder = RecordFile(tmp_path / "record.json")
        with Arm(
            connect_simulated(config, twin=twin, record_store=recorder, allow_restored=True)
        ) as arm:
            arm.enable()
            if number == 0:
                reference_from_one_side(arm)
            assert arm.status.trust is (Trust.REFERENCED if number == 0 else Trust.RESTORED)
            assert max(move_at_random(arm, 1, seed=number)) == 0
            assert arm.parts.core.position.slack.unsure == ()


def test_another_backlash_needs_another_reference(tmp_path):
    arm = arm_with_play("teachmover", home=False)
    arm.close()
    trusts = []
    for widths in ((12,) * 6, (12,) * 6, (11,) * 6, ()):
        config = replace(arm.config, backlash_steps=widths)
        recorder = RecordFile(tmp_path / "record.json")
        twin = simulate(config, play=12)
        with Arm(connect_simulated(config, twin=twin, record_store=recorder)) as again:
            trusts.append(again.status.trust)
            if len(trusts) == 1:
                again.reference.declare(Joints.of(0, 40, -80, -40, 0), opening_mm=20)
    assert trusts == [Trust.UNKNOWN, Trust.RESTORED, Trust.UNKNOWN, Trust.UNKNOWN]


def test_the_simulated_operator_comes_from_one_side():
    arm = arm_with_play("teachmover", home=False)
    arm.home()
    assert arm.status.notice == ""
    assert max(move_at_random(arm, 5)) == 0


def test_a_declared_posture_reports_unknown_backlash():
    arm = arm_with_play("teachmover", home=False)
    as_it_stands(arm)
    assert "base" in arm.status.notice
    assert "half" in arm.status.notice
    assert max(move_at_random(arm, 10)) <= PLAY / 2
    as_it_stands(arm)
    assert arm.status.notice == ""
    assert max(move_at_random(arm, 10)) == 0


HOMED = """
model = "minimover5"
backlash_mm = 0.4
[connection]
dialect = "grbl"
[grbl]
homing = true
[homing]
joints_deg = { base = 0, shoulder = 40, elbow = -80, wrist_pitch = -40, wrist_roll = 0 }
opening_mm = 10
[backlash_deg]
base = 0.5
shoulder = 0.5
elbow = 0.5
"""


def test_homing_by_switches_ends_in_the_same_place_and_reports_unknown_backlash():
    arm = Arm(connect_simulated(parse_arm(tomllib.loads(HOMED), name="homed")))
    places = []
    for way in (-3.0, 4.0):
        arm.home()
        places.append(arm.twin.world.motors)
        assert "base, shoulder, elbow, gripper" in arm.status.notice
        assert arm.status.trust is Trust.REFERENCED
        arm.jog_j(base_deg=way, elbow_deg=-way)
    assert places[0] == places[1]


def test_a_pendant_that_turns_a_motor_within_its_play_is_noticed():
    arm = arm_with_play("teachmover")
    position = arm.status.acknowledged
    arm.twin.device.jog((-5 if arm.parts.core.position.slack.taken[0] else 5, 0, 0, 0, 0, 0))
    arm.sleep(2.0)
    status = arm.status
    assert status.trust is Trust.SUSPECT
    assert status.acknowledged == position == arm.twin.world.motors
    assert arm.parts.core.position.slack.unsure


def test_a_lost_byte_of_a_burst_is_noticed_though_it_only_moved_motors_in_their_play():
    arm = arm_with_play("teachmover")
    arm.move_j(**{f"{name}_deg": deg for name, deg in MIDDLE.items()})
    arm.twin.board.drive.rack.count((3, 0, 0, 0, 0, 0))
    with pytest.raises(ArmError):
        arm.move_j(base_deg=5.0)
    assert arm.status.trust is Trust.SUSPECT


def test_a_controller_that_lost_its_power_leaves_the_backlash_in_doubt():
    arm = arm_with_play("teachmover")
    assert arm.parts.core.position.slack.unsure == ()
    arm.twin.device.power_off()
    arm.twin.device.power_on()
    arm.sleep(2.0)
    assert arm.status.trust is Trust.SUSPECT
    assert arm.parts.core.position.slack.unsure == (0, 1, 2, 3, 4, 5)


def test_the_command_line_gives_a_simulated_arm_play(monkeypatch):
    from armdrive.cli import main
    from armdrive.sim import serving as run

    played = []
    monkeypatch.setattr("sys.stdin", SimpleNamespace(closed=True))
    monkeypatch.setattr(run, "make_server", lambda **_: SimpleNamespace(address="nowhere"))
    monkeypatch.setattr(
        run, "run_device", lambda device, *_, **__: played.append(device.world.play)
    )
    assert main(["sim", "teachmover", "--tcp", "127.0.0.1:0", "--play", "12"]) == 0
    assert main(["sim", "teachmover", "--tcp", "127.0.0.1:0"]) == 0
    assert [play.widths for play in played] == [(12,) * 6, ()]


@every_row("play", [-1, (1, 2), 1.5, 10**6, (True,) * 6])
def test_a_play_that_cannot_be_is_refused(play):
    with pytest.raises(BadRequest, match="play is a whole number"):
        simulate(config_of("teachmover", 0), play=play)
