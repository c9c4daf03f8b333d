"""A device that loses its power in a motion, and the reason for which its position is doubted."""

import pytest
from faults import arm_config, driven

from armdrive.registry import DIALECTS
from armdrive.status import Evidence, State


@pytest.mark.parametrize("dialect", DIALECTS)
def test_only_a_motion_that_was_never_answered_is_said_to_be(dialect):
    arm = driven(arm_config(dialect))
    arm.move_j(base_deg=40, wait=False)
    arm.sleep(0.5)
    assert arm.status.state is State.MOVING
    device = arm.twin.device
    device.power_off()
    device.at(arm.status.time_s + 3.0, device.power_on)
    arm.sleep(6.0)
    assert arm.status.state is State.ERROR_STOP
    answered = DIALECTS[dialect].abilities.reports_while_moving
    reason = Evidence.SILENT if answered else Evidence.ANSWER_LOST
    assert arm.status.trust_reason == reason.value
