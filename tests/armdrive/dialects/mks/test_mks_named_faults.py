"""What can go wrong with drives on a bus in motion: said clearly, the arm stands, and it is mended.

Every row ends in the same program: with the fault over it is reconnected or reset, referenced, and
moves again.
"""

from __future__ import annotations

import re
import sys

import pytest
from can_fault_bench import ENDED, brought_back, fails_in_motion, is_told_and_stands
from test_mks_arm import mks_arm, ready
from waiting import until
from watched_sim import WatchedSim

from armdrive import Arm
from armdrive.moves import Jog
from armdrive.status import State, Trust
from kinematics import Joints

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")

LOST, FAULT, SILENT = "E407", "E501", "E502"
ROWS = {
    "the interface goes down": ("unplug", "lost|gone|unplugged", LOST),
    "the adapter leaves the bus": ("bus-off", "lost|bus", LOST),
    "nobody acknowledges": ("alone", "answer|lost", SILENT),
    "nothing is heard": ("mute", "answer|heard", SILENT),
    "a drive is reset": ("drive-reset 3", r"drive 3 \(elbow\)", FAULT),
    "a drive says nothing": ("drive-mute 3", r"drive 3 \(elbow\)", FAULT),
    "a drive has no power": ("drive-dead 3", r"drive 3 \(elbow\)", FAULT),
    "a shaft is blocked": ("stall 2", r"drive 2 \(shoulder\)", FAULT),
    "a drive gets another mode": ("drive-mode 3 2", r"drive 3 \(elbow\) is in mode 2", FAULT),
    "a drive gets an id of another": ("drive-id 3 2", r"drive [23]", FAULT),
    "all drives lose their power": ("brown-out", "power|answer|reset", FAULT),
    "all drives are reset": ("reset", "power|reset", FAULT),
}


@pytest.mark.parametrize("settings", [{}, {"segment_s": 0.0}], ids=["steered", "bursts"])
@pytest.mark.parametrize("name", ROWS)
def test_it_is_said_the_arm_stands_and_it_is_mended_in_the_same_program(name, settings):
    fault, words, code = ROWS[name]
    arm = ready(**settings)
    is_told_and_stands(arm, words, code, fault)
    brought_back(arm, arm.twin.world.motors)


@pytest.mark.parametrize("fault", ["brown-out", "reset"])
@pytest.mark.parametrize("base_deg", [-3.0, -1.0, 0.0, 0.5])
def test_all_drives_that_lose_their_power_near_zero_are_found_out(fault, base_deg):
    arm = mks_arm()
    near = Joints.of(base_deg, 0.0, 0.0, 0.0, 0.0)
    arm.twin.device.bring_to(near, 20.0)
    arm.enable()
    arm.declare_posture(near, opening_mm=20.0)
    said, _ = fails_in_motion(arm, fault, {"base_deg": 40})
    assert re.search("reset|power|switched", said), said
    assert arm.status.trust is Trust.SUSPECT
    brought_back(arm)


@pytest.mark.parametrize(
    ("drive", "goal"),
    [(1, {"shoulder_deg": 60}), (3, {"base_deg": 60}), (6, {"base_deg": 60})],
)
def test_a_drive_that_does_not_move_and_is_reset_meanwhile_is_named(drive, goal):
    """Its firmware keeps the angle within a turn, so that it does not count from zero."""
    arm = mks_arm(options={"keeps_angle": True})
    start = Joints.of(30.0, 40.0, -80.0, -40.0, 0.0)
    arm.twin.device.bring_to(start, 20.0)
    arm.enable()
    arm.declare_posture(start, opening_mm=20.0)
    said, _ = fails_in_motion(arm, f"drive-reset {drive}", goal)
    assert f"drive {drive} (" in said
    assert "reset" in said
    assert arm.status.trust is Trust.SUSPECT
    brought_back(arm)


@needs_pty
@pytest.mark.parametrize("fault", ["alone", "bus-off"])
def test_a_serial_adapter_whose_frames_nobody_takes_ends_a_motion_and_comes_back(fault, tmp_path):
    path = tmp_path / "can0"
    with WatchedSim(path, "mks") as bus, Arm.connect(bus.port, dialect="mks") as arm:
        arm.enable()
        arm.hold(Jog.joint(base=1.0), speed=0.5, for_s=20.0)
        bus.watch.wait_until_moving()
        bus.say(f"fault {fault}")
        until(lambda: arm.status.state in ENDED, "the fault was never noticed")
        assert re.search("answer|lost|bus", arm.status.error), arm.status.error
        stood = bus.watch.rest()
        bus.say("fault off")
        if arm.status.state is State.DISCONNECTED:
            arm.reconnect()
        arm.reset()
        arm.enable()
        assert bus.state()["motors"] == stood
        arm.jog_j(base_deg=-1.0)
        assert bus.state()["motors"] != stood
