"""A task that never waits is ended, so that a stop still works."""

import pytest
from faults import ready_arm

from armdrive.blocking import run_blocking
from armdrive.errors import ArmError
from armdrive.tasks import ReadPosition, RequestRejected, SleepUntil


def restless(now_s):
    while True:
        yield SleepUntil(now_s)


def test_a_flow_that_goes_round_without_waiting_is_ended():
    arm = ready_arm()
    with pytest.raises(ArmError, match="without waiting"):
        run_blocking(arm.runner.perform(restless(arm.pace.now_s() - 1.0)))
    assert arm.move_j(base_deg=2).joints.deg["base"] == pytest.approx(2.0, abs=0.05)


def test_a_script_that_goes_round_without_waiting_is_ended():
    controller = ready_arm().core.controller
    controller.script = lambda _request: restless_script()
    controller.begin(ReadPosition(), 0.0)
    controller.advance(0.0)
    assert isinstance(controller.next_event(), RequestRejected)
    assert not controller.busy


def restless_script():
    while True:
        yield -1.0
