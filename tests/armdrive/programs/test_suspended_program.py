"""A program that was suspended, or its computer: nothing goes on by itself after that."""

import pytest
from running_bench import BLOCK, Listener, performer, table_arm

from armdrive.errors import Stopped
from armdrive.programs import running as performing
from armdrive.programs.acts import (
    AwaitInputs,
    Delay,
    Hold,
    Look,
    Outputs,
    Say,
)
from armdrive.tasks import never


@pytest.fixture
def arm():
    return table_arm("teachmover", BLOCK)


SUSPENDED_IN = {"a delay": Delay(5.0), "a wait": AwaitInputs(high=(2,)), "a look": Look()}


@pytest.mark.parametrize("name", SUSPENDED_IN)
def test_a_suspension_ends_the_program_wherever_it_falls(arm, name):
    arm.twin.device.at(arm.twin.device.now_s + 0.3, lambda: arm.engine.absent(60.0))
    does = performer(arm).perform
    if name == "a look":
        does(SUSPENDED_IN[name])
        arm.pace.wait(never, 1.0)
    with pytest.raises(Stopped, match="suspended, and nothing goes on by itself"):
        does(SUSPENDED_IN[name])
    with pytest.raises(Stopped):
        does(Outputs(on=(1,)))
    assert arm.status.outputs is None
    assert performer(arm).perform(Look()) is not None


def test_a_suspension_that_nobody_has_noticed_yet_counts_once(arm):
    does = performer(arm).perform
    arm.engine.asleep_s = lambda: 2.0
    with pytest.raises(Stopped):
        does(Say("on"))


def test_a_wait_of_a_script_ends_as_well(arm):
    for wait in (lambda: arm.sleep(5.0), lambda: arm.wait_inputs(high=2, within_s=5.0)):
        arm.twin.device.at(arm.twin.device.now_s + 0.3, lambda: arm.engine.absent(60.0))
        with pytest.raises(Stopped, match=r"suspended|stop"):
            wait()
    arm.sleep(0.1)  # the next one is asked for after it


def test_a_person_lets_a_program_go_on_after_a_suspension(arm, monkeypatch):
    class Sleeper(Listener):
        def hold(self, text, over):
            arm.engine.absent(60.0)

    does = performer(arm, Sleeper()).perform
    does(Hold("look"))
    monkeypatch.setattr(performing.time, "sleep", lambda _: arm.engine.absent(9.0) or arm.resume())
    arm.pause()
    does(Outputs(on=(1,)))
    assert arm.status.outputs == 1
