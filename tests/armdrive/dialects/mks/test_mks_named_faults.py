"""MKS drives that restart where their counts hardly show it, and a serial adapter that fails.

`tests/conformance/faults.py` lists what is reported of every other fault in motion.
"""

from __future__ import annotations

import re
import sys

import pytest
from can_fault_bench import ENDED, check_recovery, fail_in_motion
from faults import arm_config, driven
from served import Served
from waiting import until

from armdrive import Arm
from armdrive.moves import Jog
from armdrive.status import State, Trust
from kinematics import Joints

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


@pytest.mark.parametrize(
    ("fault", "base_deg"),
    [("brown-out", -3.0), ("brown-out", 0.0), ("reset", -1.0), ("reset", 0.5)],
)
def test_all_drives_that_lose_their_power_near_zero_are_found_out(fault, base_deg):
    arm = driven(arm_config("mks"), at=Joints.of(base_deg, 0.0, 0.0, 0.0, 0.0))
    said, _ = fail_in_motion(arm, fault, {"base_deg": 40})
    assert re.search("reset|power|switched", said), said
    assert arm.status.trust is Trust.SUSPECT
    check_recovery(arm)


@pytest.mark.parametrize(
    ("drive", "goal"),
    [(1, {"shoulder_deg": 60}), (3, {"base_deg": 60}), (6, {"base_deg": 60})],
)
def test_a_drive_that_does_not_move_and_is_reset_meanwhile_is_named(drive, goal):
    """Its firmware keeps the angle within a turn, so that it does not count from zero."""
    arm = driven(arm_config("mks"), at=Joints.of(30.0, 40.0, -80.0, -40.0, 0.0), keeps_angle=True)
    said, _ = fail_in_motion(arm, f"drive-reset {drive}", goal)
    assert f"drive {drive} (" in said
    assert "reset" in said
    assert arm.status.trust is Trust.SUSPECT
    check_recovery(arm)


@needs_pty
@pytest.mark.parametrize("fault", ["alone", "bus-off"])
def test_a_serial_adapter_whose_frames_nobody_takes_ends_a_motion_and_comes_back(fault, tmp_path):
    path = tmp_path / "can0"
    with Served("mks", pty=path) as bus, Arm.connect(bus.port, dialect="mks") as arm:
        arm.enable()
        arm.hold(Jog.joint(base=1.0), speed=0.5, for_s=20.0)
        bus.watch.wait_until_moving()
        bus.tell(f"fault {fault}")
        until(lambda: arm.status.state in ENDED, "the fault was never noticed")
        assert re.search("answer|lost|bus", arm.status.error), arm.status.error
        stood = bus.watch.rest()
        bus.tell("fault off")
        if arm.status.state is State.DISCONNECTED:
            arm.reconnect()
        arm.reset()
        arm.enable()
        assert bus.watch.motors == stood
        arm.jog_j(base_deg=-1.0)
        assert bus.watch.motors != stood
