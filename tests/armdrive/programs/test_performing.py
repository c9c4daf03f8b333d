"""Acts on an arm: each does what it should, and a stop or a pause works at any moment."""

import pytest
from program_acts import fingers, go
from running_bench import (
    BLOCK,
    At,
    Listener,
    Script,
    down,
    performer,
    table_arm,
)

from armdrive.errors import InputTimeout, Stopped
from armdrive.programs import running
from armdrive.programs.acts import (
    AwaitInputs,
    Delay,
    Hold,
    Home,
    Look,
    Outputs,
    Remember,
    Say,
)
from armdrive.programs.language.values import PlaceValue
from armdrive.programs.progress import FOR_EVER
from armdrive.programs.running import ProgramRun, RunPlan
from armdrive.status import Trust
from armdrive.tasks import never

JOINTS = {"base": 10.0, "shoulder": 40.0, "elbow": -60.0, "wrist_pitch": -70.0, "wrist_roll": 5.0}


@pytest.fixture
def arm():
    return table_arm("teachmover", BLOCK)


@pytest.fixture
def does(arm):
    return performer(arm).perform


def test_a_program_goes_to_poses_and_joints_by_line_or_joint_motion(arm, does):
    assert does(go(down(250, 0, 120), speed=0.5)) is None
    assert arm.pose.z_mm == pytest.approx(120, abs=0.5)
    does(go(down(250, 40, 120), line=True))
    assert arm.pose.y_mm == pytest.approx(40, abs=0.5)
    does(go(JOINTS))
    assert arm.joints.deg == pytest.approx(JOINTS, abs=0.2)
    does(go({**JOINTS, "base": 0.0}, line=True, opening_mm=33.0))
    assert arm.joints.deg["base"] == pytest.approx(0, abs=0.2)
    assert arm.gripper.opening_mm == pytest.approx(33, abs=0.2)


def test_a_program_references_only_an_unreferenced_arm(arm, does, monkeypatch):
    monkeypatch.setattr(arm, "home", pytest.fail)
    does(Home())
    monkeypatch.undo()
    arm.disable()
    arm.enable()
    assert arm.status.trust is not Trust.REFERENCED
    does(Home())
    assert arm.status.trust is Trust.REFERENCED


def test_a_program_reads_and_saves_the_position(arm, does):
    seen = does(Look())
    assert isinstance(seen, PlaceValue)
    assert seen.pose == arm.pose
    does(Remember("here", seen.joints_deg, seen.opening_mm))
    assert arm.points["here"].joints.deg == pytest.approx(seen.joints_deg, abs=1e-3)
    does(go(down(250, 0, 120)))
    does(go(seen.joints_deg))
    assert arm.pose.z_mm == pytest.approx(seen.pose.z_mm, abs=0.5)


def test_a_delay_takes_its_time_and_texts_go_to_the_person(arm):
    person, began_s = Listener(), arm.parts.pace.now_s()
    for act in (Delay(7.3), Say("width 30"), Hold("turn the part")):
        performer(arm, person).perform(act)
    assert arm.parts.pace.now_s() - began_s == pytest.approx(7.3, abs=1e-6)
    assert (person.said, person.held) == (["width 30"], ["turn the part"])


def test_a_wait_for_inputs_says_whether_they_came_and_never_invents_them(arm, does):
    awaited = AwaitInputs(high=(4,), within_s=1.0)
    assert does(awaited) is False
    with pytest.raises(InputTimeout):  # nothing sets it in simulated time
        does(AwaitInputs(high=(4,)))
    arm.twin.device.set_input(3, True)
    assert does(awaited) is True


LONG = {
    "go": go(down(250, -60, 80)),
    "line": go(down(250, 60, 15), line=True),
    "fingers": fingers(None),
    "delay": Delay(60.0),
    "await": AwaitInputs(high=(4,)),
}


@pytest.mark.parametrize("name", LONG)
def test_a_stop_in_an_act_ends_it(arm, does, name):
    does(go(down(250, 60, 80), opening_mm=20.0))
    arm.twin.device.at(arm.twin.device.now_s + 0.4, arm.request_stop)
    began_s = arm.parts.pace.now_s()
    with pytest.raises(Stopped):
        does(LONG[name])
    assert arm.parts.pace.now_s() - began_s < 3.0
    with pytest.raises(Stopped):  # and nothing is begun after it
        does(go(down(250, 60, 100)))


def test_while_the_arm_is_paused_no_act_begins_and_a_stop_ends_the_wait(arm, monkeypatch):
    slept = []

    def breath(time_s):
        slept.append(time_s)
        if len(slept) == 3:
            arm.resume()
        if len(slept) > 3:
            arm.request_stop()
            arm.sleep(0.1)

    monkeypatch.setattr(running.time, "sleep", breath)
    arm.pause()
    performer(arm).perform(Outputs(on=(1, 3)))
    assert len(slept) == 3
    performer(arm).perform(Outputs(on=(2,), off=(3,)))
    assert arm.status.outputs == 3  # output 1 has stayed on
    arm.pause()
    with pytest.raises(Stopped):
        performer(arm).perform(Outputs(off=(1,)))
    assert arm.status.outputs == 3


def test_a_pause_lengthens_a_delay(arm, monkeypatch):
    device, paused = arm.twin.device, []

    def breath(_):
        paused.append(arm.sleep(1.0))
        if len(paused) == 7:
            arm.resume()

    monkeypatch.setattr(running.time, "sleep", breath)
    device.at(device.now_s + 0.3, arm.pause)
    began_s = arm.parts.pace.now_s()
    performer(arm).perform(Delay(2.0))
    assert arm.parts.pace.now_s() - began_s == pytest.approx(9.0, abs=0.1)


def test_a_program_runs_the_requested_number_of_loops(arm):
    script = Script((Outputs(on=(1,)), Outputs(off=(1,))))
    run = ProgramRun(RunPlan(script, loops=3), performer(arm))
    assert run.carry_out() == 6
    assert len(script.made) == 3

    plan, ender = RunPlan(script, loops=FOR_EVER), At(99, lambda _: arm.request_stop())
    run = ProgramRun(plan, performer(arm), before=[ender.begins])
    with pytest.raises(Stopped):
        run.carry_out()
    assert (run.loop, run.done, run.at.mark.line) == (50, 98, 1)  # a stop between two acts


def test_a_stop_that_the_last_act_has_outrun_ends_the_program_too(arm):
    stopper = Listener()
    stopper.say = lambda _: arm.request_stop()  # the act does not wait, and ends well
    run = ProgramRun(RunPlan(Script((go(down(250, 0, 120)), Say("done")))), performer(arm, stopper))
    with pytest.raises(Stopped):
        run.carry_out()
    assert (run.done, run.at.mark.line) == (2, 2)


# -- nothing goes on by itself after a suspension -------------------------------------------------


SUSPENDED_IN = {"a delay": Delay(5.0), "a wait": AwaitInputs(high=(2,)), "a look": Look()}


@pytest.mark.parametrize("name", SUSPENDED_IN)
def test_a_suspension_ends_the_program_wherever_it_falls(arm, name):
    arm.twin.device.at(arm.twin.device.now_s + 0.3, lambda: arm.parts.engine.suspended(60.0))
    does, began_s = performer(arm).perform, arm.parts.pace.now_s()
    if name == "a look":
        does(SUSPENDED_IN[name])
        arm.parts.pace.wait(never, 1.0)
    with pytest.raises(Stopped, match="suspended: after a suspension, nothing continues by itself"):
        does(SUSPENDED_IN[name])
    assert arm.parts.pace.now_s() - began_s < 2.0
    with pytest.raises(Stopped):
        does(Outputs(on=(1,)))
    assert arm.status.outputs is None
    assert performer(arm).perform(Look()) is not None


def test_a_person_lets_a_program_go_on_after_a_suspension(arm, monkeypatch):
    class Sleeper(Listener):
        def hold(self, text, over):
            arm.parts.engine.suspended(60.0)

    does = performer(arm, Sleeper()).perform
    does(Hold("look"))
    monkeypatch.setattr(
        running.time, "sleep", lambda _: arm.parts.engine.suspended(9.0) or arm.resume()
    )
    arm.pause()
    does(Outputs(on=(1,)))
    assert arm.status.outputs == 1
