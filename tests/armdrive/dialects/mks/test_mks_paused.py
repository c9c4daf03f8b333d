"""A pause that falls into a moment in which the bus stands still: the arm stands until it ends."""

from __future__ import annotations

import pytest
from test_mks_arm import ready

from armdrive.status import State, Trust

PAUSED_S = 60.0


def paused_in_a_hold_up(for_s):
    """Return an arm whose next motion meets late answers after 0.4 s, and a pause after 0.7 s."""
    arm = ready()
    device, began_s = arm.twin.device, arm.pace.now_s()
    device.at(began_s + 0.4, lambda: arm.twin.faults.add("delay", 1.0, "next", side="device"))
    device.at(began_s + 0.7, arm.pause)
    device.at(began_s + 0.7 + for_s, arm.resume)
    return arm


def test_the_call_waits_for_as_long_as_the_arm_is_paused():
    arm = paused_in_a_hold_up(PAUSED_S)
    arm.move_j(base_deg=30)
    assert arm.pace.now_s() > PAUSED_S
    assert arm.status.trust is Trust.REFERENCED
    assert arm.twin.world.motors == arm.status.acknowledged


@pytest.mark.parametrize("after_s", [1.5, 3.0])
def test_the_arm_says_that_it_is_paused_and_stands(after_s):
    arm = paused_in_a_hold_up(PAUSED_S)
    motion = arm.move_j(base_deg=30, wait=False)
    arm.sleep(after_s)
    stood = arm.twin.world.motors
    assert arm.status.paused
    assert arm.status.state is State.MOVING
    arm.sleep(5.0)
    assert arm.twin.world.motors == stood
    arm.stop()
    assert motion.done
    assert arm.twin.world.motors == stood
    assert arm.status.trust is Trust.REFERENCED
