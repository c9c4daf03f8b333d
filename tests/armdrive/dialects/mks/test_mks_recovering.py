"""A drive in another mode keeps the arm from moving until somebody has mended it."""

from __future__ import annotations

import pytest

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError, DeviceFault
from armdrive.registry.simulate import simulate
from armdrive.status import State


def other_mode():
    """An arm of which one drive was in another mode while it was connected, and the fault."""
    config = simulated_config("mks")
    twin = simulate(config)
    twin.faults.add("drive-mode", "3", "2")
    arm = Arm(connect_simulated(config, twin=twin))
    with pytest.raises(DeviceFault, match="in mode 2"):
        arm.enable()
    return arm


def test_a_mode_that_was_set_right_is_found_by_the_reset():
    arm = other_mode()
    arm.twin.faults.end()
    arm.reset()
    arm.enable()
    assert arm.status.state is State.STANDBY
    before = arm.twin.world.motors
    arm.jog_j(base_deg=1.0)
    assert arm.twin.world.motors[0] > before[0] + 2000


def test_a_mode_that_is_wrong_still_keeps_the_arm_from_moving():
    arm = other_mode()
    arm.reset()
    with pytest.raises(DeviceFault, match="in mode 2"):
        arm.enable()
    with pytest.raises(ArmError):
        arm.jog_j(base_deg=1.0)
