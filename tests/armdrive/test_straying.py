"""Arms without coordination: how far they leave the straight way, and room for it near guards."""

import math
from dataclasses import replace

import pytest

from armdrive.connecting import connect_simulated, simulated_config
from armdrive.dialects import DIALECTS
from armdrive.flows.straying import SMALL_STEPS, has_room
from armdrive.sim.twin import make_twin
from kinematics import Joints, Motors, Pose

UNCOORDINATED = [name for name, row in DIALECTS.items() if not row.abilities.coordinated]
FEW_STEPS_MM = 6.0
"""What bursts of a few steps may stray, which are sent in any case."""

OVER_THE_TABLE = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)


def standing(name, joints=OVER_THE_TABLE, **motion):
    config = simulated_config(name)
    config = replace(config, motion=replace(config.motion, **motion))
    twin = make_twin(config)
    twin.world.drive_to(twin.world.body.transmission.to_motors(joints, 20.0))
    arm = connect_simulated(config, twin=twin)
    arm.enable()
    arm.declare_posture(joints, opening_mm=20.0)
    return arm


def test_there_are_such_arms():
    assert UNCOORDINATED


@pytest.mark.parametrize("name", UNCOORDINATED)
@pytest.mark.parametrize("limit_mm", [2.0, 5.0, 20.0])
def test_the_tip_stays_as_near_to_the_straight_way_as_it_is_told(name, limit_mm):
    arm = standing(name, straying_mm=limit_mm)
    seen = []
    drive = arm.twin.world.drive
    arm.twin.world.drive = lambda *args: (drive(*args), seen.append(arm.twin.world.joints))[0]
    goal = Joints.of(20.0, 55.0, -100.0, -20.0, 25.0)
    moved = arm.move_j(**{f"{joint}_deg": turn for joint, turn in goal.deg.items()})
    assert len(seen) > 10
    geometry = arm.model.arm
    way = [
        geometry.fk(
            Joints(
                tuple(a + (b - a) * share / 150 for a, b in zip(OVER_THE_TABLE, goal, strict=True))
            )
        )
        for share in range(151)
    ]
    left_mm = max(
        min(math.dist(_place(geometry.fk(joints)), _place(pose)) for pose in way)
        for joints in seen[::3]
    )
    rounding_mm = 1.0
    assert left_mm <= moved.straying_mm + rounding_mm
    assert moved.straying_mm <= max(limit_mm, FEW_STEPS_MM)


def _place(pose):
    return pose.x_mm, pose.y_mm, pose.z_mm


@pytest.mark.parametrize("name", UNCOORDINATED)
def test_a_burst_is_shorter_where_a_guard_is_near(name):
    high, low = (standing(name, straying_mm=100.0) for _ in range(2))
    low.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=1.0, pitch_deg=-60))
    target = Motors((90, -60, 80, 40, 70, 0))
    rate_hz = high.speeds.motor_hz
    assert has_room(high.core, high.core.acknowledged + target, rate_hz)
    assert not has_room(low.core, low.core.acknowledged + target, rate_hz)
    few = Motors((SMALL_STEPS, -3, 2, 1, 1, 0))
    assert has_room(low.core, low.core.acknowledged + few, rate_hz)


@pytest.mark.parametrize("name", UNCOORDINATED)
def test_a_way_just_above_the_table_never_goes_into_it(name):
    arm = standing(name)
    arm.move_to(Pose.of(x_mm=220, y_mm=-60, z_mm=2.0, pitch_deg=-70))
    arm.move_to(Pose.of(x_mm=260, y_mm=70, z_mm=2.0, pitch_deg=-50))
    assert arm.twin.world.incidents == []
