"""A character that the wire doubles on its way to an Armdroid, whichever it is."""

import pytest
from armdroid_bench import honest, ready_arm

from armdrive.errors import DeviceFault


@pytest.mark.parametrize("number", range(1, 25))
def test_no_doubled_character_makes_the_board_deaf(number):
    arm = ready_arm()
    arm.twin.faults.add("duplicate", f"#{number}", side="host")
    try:
        arm.move_j(base_deg=6.0, shoulder_deg=43.0, speed=0.7)
    except DeviceFault:
        arm.reset()
        arm.declare_posture(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)
    assert honest(arm)
    arm.move_j(base_deg=-2.0)
    assert honest(arm)
