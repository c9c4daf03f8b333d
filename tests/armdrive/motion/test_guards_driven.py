"""Guards while an arm is driven: refused before the first byte, clipped while jogging, left."""

from dataclasses import replace
from itertools import pairwise

import pytest
from faults import ready_arm, sim_config
from grbl_arm import config
from grbl_arm import ready as ready_board
from robko_bench import ready_robko, robko_config

from armdrive import Jog
from armdrive.errors import OutOfBounds
from armdrive.motion.jog.bounds import Bounds
from kinematics import Joints, Pose
from kinematics.guards import AngleSum
from kinematics.guards.shapes import Box

RADII = (35.0, 30.0, 25.0)
STANDS_OFF_MM = 70.0
"""How near a tip comes to the wall whose forearm ends 30 mm thick at an upright hand's wrist."""

WALL = Box("wall", (0.0, 100.0, -10.0), (500.0, 104.0, 600.0))
FOREARM = AngleSum("forearm elevation", (("shoulder", 1.0), ("elbow", 1.0)), -1.8, 0.5)
LOOK_S = 0.05
LAST_MM = 5.0
"""The guard's tolerance, and the last steps before it, which are made at once."""


def guarded(config, **guards):
    model = config.model
    return replace(config, model=replace(model, guards=replace(model.guards, **guards)))


def walled(config):
    return guarded(config, radii_mm=RADII, boxes=(WALL,))


def over(y_mm, z_mm=120.0):
    return Pose.of(x_mm=250, y_mm=y_mm, z_mm=z_mm, pitch_deg=-90)


def test_a_path_through_a_box_is_refused_before_the_first_byte():
    arm = ready_arm(walled(sim_config()))
    arm.move_to(over(0))
    sent = len(arm.twin.link.sent)
    for call in (arm.move_to, arm.move_l):
        with pytest.raises(OutOfBounds, match="inside the box 'wall'") as caught:
            call(over(180))
        assert caught.value.name == "box wall"
        assert caught.value.value < 0.0 == caught.value.bound
    assert len(arm.twin.link.sent) == sent


def test_a_path_through_a_box_to_a_goal_beyond_it_is_refused():
    pillar = Box("pillar", (240.0, 95.0, -10.0), (260.0, 105.0, 600.0))
    arm = ready_arm(guarded(sim_config(), radii_mm=RADII, boxes=(pillar,)))
    arm.move_to(over(0))
    behind = over(250)
    assert not arm.config.model.guards.violations(
        arm.config.model.arm, arm.config.model.arm.ik(behind)
    )
    with pytest.raises(OutOfBounds, match="inside the box 'pillar'"):
        arm.move_to(behind)


def test_a_goal_in_a_box_is_refused_with_the_nearest_pose_that_can_be_taken():
    arm = ready_arm(walled(sim_config()))
    arm.move_to(over(0))
    with pytest.raises(OutOfBounds, match="nearest pose that is allowed") as caught:
        arm.move_to(over(90))
    nearest = caught.value.nearest
    assert nearest.y_mm == pytest.approx(STANDS_OFF_MM, abs=1.0)
    arm.move_to(nearest)


def test_a_forearm_beyond_its_elevation_is_refused_in_degrees():
    arm = ready_arm(guarded(sim_config(), sums=(FOREARM,)))
    with pytest.raises(OutOfBounds, match="forearm elevation would be -10") as caught:
        arm.move_j(shoulder_deg=25, elbow_deg=-132, wrist_pitch_deg=60)
    assert caught.value.name == "range of the forearm elevation"
    assert -110.0 <= caught.value.value < -103.13
    assert caught.value.bound == pytest.approx(-103.13, abs=0.01)


def test_a_jog_stops_before_a_box_and_may_turn_back():
    arm = ready_arm(walled(sim_config()))
    arm.move_to(over(30))
    jogged = arm.jog_l(y=1.0, speed=1.0, duration_s=4.0)
    assert "box 'wall'" in jogged.note
    assert 60.0 < arm.twin.world.pose.y_mm <= STANDS_OFF_MM + 1.1
    arm.jog_l(y_mm=-20)
    assert arm.twin.world.pose.y_mm < 57.0


@pytest.mark.parametrize(
    "flawed_jog",
    [
        lambda arm: arm.jog_l(y_mm=60),
        lambda arm: arm.jog_l(y=1.0, speed=1.0, duration_s=3.0),
    ],
)
def test_a_jog_is_audited_although_it_keeps_to_its_bounds_by_itself(flawed_jog, monkeypatch):
    """Nothing goes unaudited: also not what a course proposes that sees no guard."""
    monkeypatch.setattr(Bounds, "holds", lambda *_: True)
    arm = ready_arm(walled(sim_config()))
    arm.move_to(over(40))
    assert "box 'wall'" in flawed_jog(arm).note
    assert arm.twin.world.pose.y_mm <= STANDS_OFF_MM + 1.0


@pytest.mark.parametrize("speed", [1.0, 0.2])
def test_an_arm_that_runs_on_while_it_stops_is_slowed_before_a_guard(speed):
    arm = ready_robko(walled(robko_config()))
    arm.move_to(over(30))
    runs_on_s = arm.core.controller.stopping(arm.config.motion.jog_burst_s).asked_motion_s
    assert runs_on_s > 0.0
    ways = []
    before_mm, before_s = arm.twin.world.pose.y_mm, arm.status.time_s
    for _ in range(40):
        arm.hold(Jog.cartesian(y=1.0), speed=speed, for_s=1.0)
        arm.sleep(0.25)
        here_mm, now_s = arm.twin.world.pose.y_mm, arm.status.time_s
        ways.append((here_mm, (here_mm - before_mm) / (now_s - before_s)))
        before_mm, before_s = here_mm, now_s
    assert ways[-1][0] == pytest.approx(STANDS_OFF_MM, abs=3.0)
    for (here_mm, _), (_, after_mm_s) in pairwise(ways):
        assert here_mm + after_mm_s * runs_on_s <= STANDS_OFF_MM + 1.0 + 1.0


def test_an_arm_that_drives_on_from_leg_to_leg_could_stop_before_a_guard_at_any_moment():
    """The jog's own ramp is too short for that: it is slowed for as long as its device runs on."""
    arm = ready_board(walled(config(jog_ramp_s=0.02)))
    arm.move_to(over(10))
    runs_on_s = arm.core.controller.stopping(arm.config.motion.jog_burst_s).asked_motion_s
    before_mm = arm.twin.world.pose.y_mm
    fastest_mm_s = 0.0
    for _ in range(130):
        arm.hold(Jog.cartesian(y=1.0), speed=1.0, for_s=1.0)
        arm.sleep(LOOK_S)
        here_mm = arm.twin.world.pose.y_mm
        speed_mm_s = (here_mm - before_mm) / LOOK_S
        assert before_mm + speed_mm_s * runs_on_s <= STANDS_OFF_MM + LAST_MM
        fastest_mm_s, before_mm = max(fastest_mm_s, speed_mm_s), here_mm
    assert before_mm == pytest.approx(STANDS_OFF_MM, abs=3.0)
    assert fastest_mm_s * runs_on_s > 10.0


def test_an_arm_that_stands_in_a_box_may_leave_it_by_itself():
    arm = ready_arm(walled(sim_config()))
    inside = arm.config.model.arm.ik(over(90))
    arm.declare_posture(inside)
    with pytest.raises(OutOfBounds, match="box 'wall'"):
        arm.move_l(over(100))
    assert "box 'wall'" in arm.jog_l(y_mm=5).note
    arm.jog_l(y_mm=-5)
    arm.move_to(over(0))
    assert arm.pose.y_mm == pytest.approx(0.0, abs=0.5)


def test_the_postures_that_an_arm_is_used_in_break_no_guard_with_a_slim_base():
    config = guarded(sim_config(), radii_mm=RADII, base_radius_mm=30.0, base_top_mm=120.0)
    arm, model = ready_arm(config), config.model
    for joints in (Joints.of(0, 0, 0, 0, 0), Joints.of(0, 70, -95, -35, 0)):
        assert model.guards.violations(model.arm, joints) == ()
    assert model.guards.violations(model.arm, model.arm.ik(model.reference.pose)) == ()
    arm.park()
