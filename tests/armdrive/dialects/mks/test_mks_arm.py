"""A whole arm on simulated MKS drives: straight ways, homing, and faults of a single drive."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from faults import arm_config, driven

from armdrive import Arm
from armdrive.config.sections import HomingSettings
from armdrive.errors import DeviceFault, LinkLost, Stopped
from armdrive.motion.context import refused_motion
from armdrive.status import Evidence, Trust
from armdrive.tasks import RequestRejected
from kinematics import Joints
from tests.conformance.observation import place
from tests.conformance.rows_moving import off_line_mm

LOOK_S = 0.02


def ready(**settings) -> Arm:
    """An arm that stands in the air, referenced."""
    return driven(arm_config("mks", device=settings))


def watched(arm, handle, look):
    """Look at the arm until a motion has ended, and return the most of what was seen."""
    most = 0.0
    while not handle.done:
        arm.sleep(LOOK_S)
        most = max(most, look())
    handle.wait()
    return most


@pytest.mark.parametrize(("segment_s", "most_mm"), [(0.04, 0.5), (0.0, 1.5)])
def test_a_line_is_straight_in_motion_whether_steered_or_in_bursts(segment_s, most_mm):
    arm = ready(segment_s=segment_s)
    start = arm.pose
    end = replace(start, y_mm=start.y_mm + 80.0)
    handle = arm.move_l(end, wait=False)
    look = lambda: off_line_mm(arm.twin.world.tip, place(start), place(end))  # noqa: E731
    assert watched(arm, handle, look) < most_mm
    assert arm.twin.world.motors == arm.status.acknowledged


def test_drives_that_are_not_steered_find_out_of_a_guard_in_bursts_of_some_size():
    low = Joints.of(0.0, -5.0, -60.0, -40.0, 0.0)
    arm = driven(arm_config("mks", device={"segment_s": 0.0}), at=low)
    start = arm.pose
    assert start.z_mm < -10.0
    moved = arm.move_l(replace(start, z_mm=start.z_mm + 20.0))
    assert moved.bursts < 30


@pytest.mark.parametrize(
    ("ends", "error", "evidence"),
    [
        (lambda arm: arm.request_stop(), Stopped, Evidence.HOMING_FAILED),
        (lambda arm: arm.twin.faults.add("unplug"), LinkLost, Evidence.LOST_IN_MOTION),
    ],
    ids=["stop", "pulled cable"],
)
def test_an_arm_whose_homing_ended_early_is_suspect_and_shown_where_it_was_last_seen(
    ends, error, evidence
):
    """Encoders count on, but nobody knows whether a home was set meanwhile."""
    homing = HomingSettings(Joints.of(40.0, 40.0, -80.0, -40.0, 0.0), 20.0, ((1,),))
    arm = driven(replace(arm_config("mks"), homing=homing))
    before = arm.joints["base"]
    arm.twin.device.at(arm.parts.pace.now_s() + 1.0, lambda: ends(arm))
    with pytest.raises(error):
        arm.home()
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.trust_reason == evidence.value
    assert abs(arm.joints["base"] - before) > math.radians(1.0)


@pytest.mark.parametrize(
    ("reply", "evidence", "words"),
    [
        (RequestRejected(), Evidence.MOTION_REFUSED, "a byte may have been corrupted"),
        (RequestRejected("the door is open"), Evidence.BROKEN_OFF, "aborted: the door is open"),
        (
            RequestRejected("drive 2 is mute", silent=True),
            Evidence.SILENT,
            "aborted: drive 2 is mute",
        ),
    ],
)
def test_the_reason_why_a_motion_ended_is_reported(reply, evidence, words):
    learnt, why = refused_motion(reply)
    assert learnt is evidence
    assert words in why


def test_a_mode_that_changes_between_bursts_is_the_reason_that_is_kept():
    arm = ready(segment_s=0.0)
    arm.twin.device.at(
        arm.parts.pace.now_s() + 0.3, lambda: arm.twin.faults.add("drive-mode", "3", "2")
    )
    with pytest.raises(DeviceFault, match=r"drive 3 \(elbow\)") as failed:
        arm.move_j(base_deg=40, shoulder_deg=60, elbow_deg=-50)
    assert "garbled" not in str(failed.value)
    assert "refused a valid motion" not in arm.status.trust_reason
    assert arm.twin.world.motors == arm.status.acknowledged
