"""What is known of backlash over time: by the next program, after references, of simulated arms."""

import tomllib
from dataclasses import replace
from types import SimpleNamespace

import pytest
from backlash_bench import (
    DIALECTS,
    MIDDLE,
    PLAY,
    arm_with_play,
    config_of,
    move_at_random,
    reference_from_one_side,
)
from faults import as_it_stands

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.errors import ArmError, BadRequest
from armdrive.registry import simulate
from armdrive.registry.arm_files import parse_arm
from armdrive.status import Trust
from armdrive.storage.record import FileRecorder
from kinematics import Joints

every_dialect = pytest.mark.parametrize("dialect", DIALECTS)


@every_dialect
def test_the_next_program_knows_on_which_side_of_its_play_each_motor_is(dialect, tmp_path):
    arm = arm_with_play(dialect)
    config = arm.config
    for number in range(2):
        arm.close()
        twin = simulate(config, arm.twin.save())
        recorder = FileRecorder(tmp_path / "record.json")
        with Arm(
            connect_simulated(config, twin=twin, recorder=recorder, allow_restored=True)
        ) as arm:
            arm.enable()
            if number == 0:
                reference_from_one_side(arm)
            assert arm.status.trust is (Trust.REFERENCED if number == 0 else Trust.RESTORED)
            assert max(move_at_random(arm, 1, seed=number)) == 0
            assert arm.core.position.slack.unsure == ()


def test_another_backlash_needs_another_reference(tmp_path):
    arm = arm_with_play("teachmover", home=False)
    arm.close()
    trusts = []
    for widths in ((12,) * 6, (12,) * 6, (11,) * 6, ()):
        config = replace(arm.config, backlash_steps=widths)
        recorder = FileRecorder(tmp_path / "record.json")
        twin = simulate(config, play=12)
        with Arm(connect_simulated(config, twin=twin, recorder=recorder)) as again:
            trusts.append(again.status.trust)
            if len(trusts) == 1:
                again.declare_posture(Joints.of(0, 40, -80, -40, 0), opening_mm=20)
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
    arm.twin.device.jog((-5 if arm.core.position.slack.taken[0] else 5, 0, 0, 0, 0, 0))
    arm.sleep(2.0)
    status = arm.status
    assert status.trust is Trust.SUSPECT
    assert status.acknowledged == position == arm.twin.world.motors
    assert arm.core.position.slack.unsure


def test_a_lost_byte_of_a_burst_is_noticed_though_it_only_moved_motors_in_their_play():
    arm = arm_with_play("teachmover")
    arm.move_j(**{f"{name}_deg": deg for name, deg in MIDDLE.items()})
    arm.twin.board.drive.rack.count((3, 0, 0, 0, 0, 0))
    with pytest.raises(ArmError):
        arm.move_j(base_deg=5.0)
    assert arm.status.trust is Trust.SUSPECT


def test_a_controller_that_lost_its_power_leaves_the_backlash_in_doubt():
    arm = arm_with_play("teachmover")
    assert arm.core.position.slack.unsure == ()
    arm.twin.device.power_off()
    arm.twin.device.power_on()
    arm.sleep(2.0)
    assert arm.status.trust is Trust.SUSPECT
    assert arm.core.position.slack.unsure == (0, 1, 2, 3, 4, 5)


def test_a_saved_twin_keeps_where_its_play_is():
    arm = arm_with_play("teachmover")
    saved = arm.twin.save()
    again = simulate(arm.config, saved)
    assert again.world.play.ahead == arm.twin.world.play.ahead
    assert any(again.world.play.ahead)
    assert simulate(arm.config, saved, play=3).world.play.widths == (3,) * 6


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


@pytest.mark.parametrize("play", [-1, (1, 2), 1.5, 10**6, (True,) * 6])
def test_a_play_that_cannot_be_is_refused(play):
    with pytest.raises(BadRequest, match="play is a whole number"):
        simulate(config_of("teachmover", 0), play=play)
