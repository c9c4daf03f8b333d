"""A motion that a device ends for a reason is told by that reason, and by no garbled byte."""

from __future__ import annotations

import pytest
from test_mks_arm import ready

from armdrive.errors import DeviceFault
from armdrive.motion.context import _evidence, _refused_words
from armdrive.status import Evidence
from armdrive.tasks import RequestRejected


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
def test_what_ended_a_motion_is_said(reply, evidence, words):
    assert _evidence(reply) is evidence
    assert words in _refused_words(reply)


def test_a_mode_that_changes_while_a_burst_is_stored_is_the_reason_that_is_kept():
    arm = ready(segment_s=0.0)
    arm.twin.device.at(arm.pace.now_s() + 0.3, lambda: arm.twin.faults.add("drive-mode", "3", "2"))
    with pytest.raises(DeviceFault, match=r"drive 3 \(elbow\)") as failed:
        arm.move_j(base_deg=40, shoulder_deg=60, elbow_deg=-50)
    assert "garbled" not in str(failed.value)
    assert "refused a valid motion" not in arm.status.trust_reason
    assert arm.twin.world.motors == arm.status.acknowledged
