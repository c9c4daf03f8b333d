"""Characters that the wire spoils on their way to an Armdroid: doubled, or become others."""

import pytest
from armdroid_bench import honest, ready_arm

from armdrive.errors import DeviceFault
from armdrive.status import Trust


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


def test_a_board_that_says_that_its_motors_are_off_is_believed():
    arm = ready_arm()
    arm.twin.link.line.send(b"0t", arm.pace.now_s())  # as a garbled line may read
    arm.sleep(0.5)
    assert not arm.twin.world.energised
    assert arm.status.trust is Trust.SUSPECT
