"""Counts that fall to zero in a motion that began at zero, on a device that does not greet."""

import pytest
from faults import as_it_stands

from armdrive import Arm
from armdrive.registry import DIALECTS
from armdrive.status import Trust


def at_zeros(dialect):
    arm = Arm.connect(f"sim:{dialect}")
    arm.enable()
    return as_it_stands(arm)


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
    arm = at_zeros("robko01")
    seen_in_motion(arm, base_deg)
    arm.twin.faults.add("brown-out", for_s=0.1)
    arm.sleep(0.02)
    arm.stop()
    arm.sleep(1.0)
    assert not arm.twin.device.registers.largest
    assert arm.status.trust is Trust.SUSPECT
    assert "fell to zero" in arm.status.trust_reason


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_motion_back_to_zero_that_is_stopped_keeps_its_position(dialect):
    arm = at_zeros(dialect)
    there = arm.joints.deg["base"]
    arm.move_j(base_deg=there + 20.0)
    for after_s in (0.1, 0.3, 0.5):
        arm.move_j(base_deg=there, wait=False)
        arm.sleep(after_s)
        arm.stop()
        assert arm.status.trust is Trust.REFERENCED
    arm.move_j(base_deg=there - 5.0, wait=False)
    arm.sleep(0.8)
    arm.stop()
    assert arm.status.trust is Trust.REFERENCED
    assert arm.twin.world.motors == arm.status.acknowledged
