"""States of an arm, and its stops."""

import os
import signal
from dataclasses import replace
from itertools import product

import pytest
from faults import Rule, as_it_stands, late_by, ready_arm, sim_arm, sim_config

from armdrive import Arm, Jog, JogMove
from armdrive.config.sections import HomingSettings
from armdrive.connect.control_socket import answered
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError, DeviceFault, LinkLost, OperatorNeeded, Stopped, WrongState
from armdrive.motion.device import set_outputs
from armdrive.motion.resolve import prepare
from armdrive.programs.running import Waits
from armdrive.runtime.arm_state import alerted
from armdrive.runtime.states import TRANSITIONS, Event, after
from armdrive.status import State, Trust
from armdrive.tasks import Alert, AlertKind, MoveBy, SwitchOn
from firmware_protocol.teachmover import Key


def test_an_event_leads_somewhere_or_is_refused_with_the_way_out():
    for state, event in product(State, Event):
        if (state, event) in TRANSITIONS:
            assert after(state, event) is TRANSITIONS[state, event]
            continue
        with pytest.raises(WrongState) as refusal:
            after(state, event)
        sentence = str(refusal.value)
        assert event.value in sentence
        assert state.value in sentence
        assert len(sentence.partition(": ")[2].split()) >= 2


def test_the_table_keeps_its_laws():
    for state in State:
        assert after(state, Event.STOP) not in (State.MOVING, State.HOMING)
        assert after(state, Event.LOST) is State.DISCONNECTED
    leaving = {
        event for (state, event), to in TRANSITIONS.items() if state is State.ERROR_STOP is not to
    }
    assert leaving == {Event.RESET, Event.RESET_SWITCHED, Event.LOST}
    for event, moving in ((Event.MOVE, State.MOVING), (Event.HOME, State.HOMING)):
        starts = [s for (s, e), to in TRANSITIONS.items() if e is event and to is moving]
        assert starts == [State.STANDBY]
    changes = {(state, to) for (state, _), to in TRANSITIONS.items() if to is not state}
    assert {state for state, _ in changes} == {to for _, to in changes} == set(State)


REFUSED = [
    (lambda arm: arm.move_j(base_deg=1.0), "a motion"),
    (lambda arm: arm.jog_j(base_deg=1.0), "jogging"),
    (lambda arm: arm.move_motors(1, 0, 0, 0, 0, 0, speed=0.1), "turning motors"),
    (lambda arm: arm.reference.confirm(), "confirming the reference"),
    (lambda arm: arm.reference.declare(arm.joints), "declaring a posture"),
    (lambda arm: arm.io.set(1), "switching an output"),
    (lambda arm: arm.io.wait(high=1), "waiting for inputs"),
    (lambda arm: arm.controller.read_program(), "using the arm's own program memory"),
    (lambda arm: arm.disable(), "switching the motors off"),
]


@pytest.mark.parametrize(("call", "action"), REFUSED, ids=[action for _, action in REFUSED])
def test_a_call_in_error_stop_is_refused_by_its_own_name_and_says_what_to_do_first(call, action):
    arm = ready_arm()
    arm.estop()
    assert arm.status.state is State.ERROR_STOP
    with pytest.raises(WrongState) as refusal:
        call(arm)
    assert str(refusal.value) == (
        f"{action} is not possible while the arm is in error-stop: look at the arm, then call "
        "`reset()`"
    )


def test_a_moving_arm_is_neither_switched_off_nor_reset():
    """Not even once it stands: the caller no longer expects it then."""
    arm = ready_arm()
    handle = arm.move_j(base_deg=20.0, wait=False)
    arm.sleep(0.3)
    for call in (arm.disable, arm.reset):
        with pytest.raises(WrongState, match="not possible while the arm is moving"):
            call()
    handle.wait()
    arm.sleep(1.0)
    assert (arm.status.state, arm.status.trust) == (State.STANDBY, Trust.REFERENCED)


def test_an_arm_that_cannot_be_enabled_is_closed_and_a_closed_one_is_not_used_again():
    arm = Arm.connect("sim:mks")
    arm.twin.faults.add("mute")
    with pytest.raises(ArmError, match="no answer"), arm:
        pytest.fail("it was entered")
    assert arm.closed
    with pytest.raises(WrongState, match="closed for good"), arm:
        pytest.fail("it was entered")


WAITING = [lambda arm: arm.sleep(2.0), lambda arm: arm.io.wait(high=1, within_s=2.0)]


@pytest.mark.parametrize("wait", WAITING)
def test_nothing_goes_on_by_itself_after_a_suspension(wait):
    arm = ready_arm()
    device = arm.twin.device
    device.at(device.now_s + 0.5, lambda: arm.parts.engine.suspended(100.0))
    with pytest.raises(Stopped, match="was suspended: after a suspension, nothing continues"):
        wait(arm)


# -- Stops -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("error", [0.0, 0.5, 0.9, -0.3, 3.0])
def test_every_burst_fits_its_announced_length_and_once_measured_really_does(error):
    arm = ready_arm(sim_config(planned_burst_s=0.3), speed_error=error)
    link, lengths = arm.twin.link, []
    controller = arm.parts.core.controller
    begin = controller.begin

    def spied(request, now_s):
        begin(request, now_s)
        if isinstance(request, MoveBy):
            nominal_s = request.steps.largest / controller.usable_rate_hz(request.rate_hz)
            lengths.append((nominal_s, nominal_s * (1.0 + error), arm.parts.core.stops.burst_s))

    controller.begin = spied
    arm.move_j(base_deg=50, shoulder_deg=60, wrist_roll_deg=70)
    arm.move_j(base_deg=40, speed=0.07)
    arm.jog_l(x_mm=-17, speed=0.6)
    arm.jog_j(gripper_mm=11, wrist_pitch_deg=7, speed=1.0)
    arm.gripper.grasp(force_n=30.0)
    assert len(lengths) > 20
    assert link.overlaps == []
    doubt = arm.config.device.speed_margin
    assert all(nominal <= burst + 1e-9 for nominal, _, burst in lengths)
    assert all(real <= burst * max((1.0 + error) / doubt, 1.0) + 1e-9 for _, real, burst in lengths)
    fast = [(real, burst) for _, real, burst in lengths[2:12]]
    assert all(real <= burst * 1.03 for real, burst in fast)


@pytest.mark.parametrize("state", ["standby", "disabled", "error-stop", "disconnected"])
def test_stop_works_in_every_state_and_twice(state):
    arm = ready_arm()
    if state == "disabled":
        arm.disable()
    elif state == "error-stop":
        arm.estop()
    elif state == "disconnected":
        arm.close()
    arm.stop()
    arm.stop()
    assert arm.status.state.value == state


def test_a_stop_by_another_program_is_seen_at_rest_and_named_by_a_motion():
    arm = ready_arm()
    arm.parts.runner.request_stop(elsewhere=True)
    with pytest.raises(Stopped, match="by another program"):
        arm.sleep(0.1)
    arm.sleep(0.1)
    assert arm.status.notice == "the arm was stopped: another program asked for it"
    arm.jogging.nudge(Jog.joint(base=5.0), speed=0.5)
    arm.sleep(0.1)
    arm.parts.runner.request_stop(elsewhere=True)
    with pytest.raises(Stopped, match="by another program"):
        arm.sleep(1.0)
    arm.sleep(1.0)
    assert arm.status.notice == "the jog was stopped: another program asked for it"
    arm.jogging.nudge(Jog.joint(base=5.0), speed=0.5)
    arm.sleep(0.1)
    arm.request_stop()
    arm.sleep(1.0)
    assert arm.status.notice == "the jog was stopped"


@pytest.mark.parametrize("by_switches", [False, True])
def test_a_decision_after_another_programs_stop_is_not_refused(by_switches):
    """With a person in between, or with the count of the stops that were known."""
    config = simulated_config("grbl" if by_switches else "teachmover")
    if by_switches:
        homing = HomingSettings(config.model.arm.ik(config.model.reference.pose))
        config = replace(config, homing=homing, device=replace(config.device, homing=True))
    arm = Arm(connect_simulated(config))
    arm.enable()

    def stop_elsewhere():
        arm.parts.runner.request_stop(elsewhere=True)
        arm.parts.pace.clock.advance()  # at rest there is nothing to stop

    stop_elsewhere()
    arm.home(stops=arm.stops)
    arm.sleep(0.1)
    stop_elsewhere()
    Waits(arm).delay(0.1)
    known = arm.stops
    stop_elsewhere()
    with pytest.raises(Stopped):
        arm.home(stops=known)
    stop_elsewhere()
    if by_switches:  # it would move by itself
        with pytest.raises(Stopped, match="by another program"):
            arm.home()
    arm.home()
    arm.sleep(0.1)


def test_a_stop_before_the_first_step_lets_nothing_begin():
    arm = ready_arm()
    handle = arm.move_j(base_deg=30, wait=False)
    arm.request_stop()
    with pytest.raises(Stopped):
        handle.wait()
    assert not arm.twin.link.named(b"@STEP")
    assert arm.status.state is State.STANDBY


def test_a_stop_ends_waiting_jogs_for_good():
    arm = ready_arm()
    arm.jogging.nudge(Jog.joint(base=5.0), speed=0.5)
    arm.request_stop()
    arm.sleep(1.0)
    assert not arm.twin.link.named(b"@STEP")
    arm.jog_j(shoulder_deg=1)
    assert arm.joints.deg["base"] == pytest.approx(0.0, abs=1e-9)


def test_a_handle_can_be_cancelled_and_tells_that_it_was_stopped():
    arm = ready_arm()
    handle = arm.move_j(base_deg=60, wait=False)
    arm.sleep(1.0)
    assert not handle.done
    with pytest.raises(TimeoutError):
        handle.wait(0.2)
    handle.cancel()
    assert handle.done
    with pytest.raises(Stopped, match="before its goal"):
        handle.wait()
    assert arm.status.trust is Trust.REFERENCED


def test_closing_ends_a_motion_under_way_and_the_arm_stands():
    arm = ready_arm()
    handle = arm.move_j(base_deg=60, wait=False)
    arm.sleep(0.5)
    arm.close()
    assert handle.done
    assert not arm.twin.device.moving
    assert arm.status.state is State.DISCONNECTED
    with pytest.raises(WrongState, match="closed for good: create a new one"):
        arm.move_j(base_deg=0)
    with pytest.raises(WrongState, match="closed for good: create a new one"):
        arm.home()
    arm.close()


def test_a_reset_right_behind_the_emergency_stop_waits_for_the_burst():
    arm = ready_arm(speed_error=0.9)
    arm.move_j(base_deg=80, shoulder_deg=75, elbow_deg=-40, wait=False)
    arm.sleep(0.3)
    arm.estop()
    arm.reset()
    assert not arm.twin.device.moving
    assert arm.twin.world.motors == arm.status.acknowledged


def test_a_second_emergency_stop_during_the_reset_is_not_lost():
    arm = ready_arm()
    arm.estop()
    arm.stop()
    arm.twin.link.on_write = lambda data: arm.estop()
    with pytest.raises(Stopped):
        arm.reset()
    assert arm.status.state is State.ERROR_STOP


def test_a_stop_while_a_posture_is_confirmed_leaves_the_reference_as_it_was():
    arm = ready_arm()
    arm.disable()
    arm.enable()
    arm.twin.link.on_write = lambda data: arm.request_stop()
    with pytest.raises(Stopped, match="nothing was referenced"):
        arm.reference.declare(arm.joints)
    assert arm.status.trust is Trust.SUSPECT


def test_an_alert_while_the_motors_are_switched_on_stays_latched():
    arm = Arm.connect("sim:mks")
    alert = Alert(AlertKind.ALARM_LOST, "the arm has sagged")
    begin = arm.parts.core.controller.begin

    def alarmed(request, now_s):
        begin(request, now_s)
        if isinstance(request, SwitchOn):
            alerted(arm.parts.core, alert, now_s)

    arm.parts.core.controller.begin = alarmed
    with pytest.raises(DeviceFault, match="the arm has sagged"):
        arm.enable()
    assert arm.status.state is State.ERROR_STOP


def test_an_alert_during_the_reset_stays_latched():
    arm = ready_arm()
    arm.estop()
    arm.stop()
    alert = Alert(AlertKind.ALARM, "the STOP key of the pendant was pressed")
    arm.twin.link.on_write = lambda data: alerted(arm.parts.core, alert, arm.parts.engine.now_s)
    with pytest.raises(DeviceFault, match="the STOP key of the pendant was pressed"):
        arm.reset()
    assert arm.status.state is State.ERROR_STOP
    assert "the STOP key of the pendant was pressed" in arm.status.error
    arm.twin.link.on_write = lambda data: None
    arm.reset()
    assert (arm.status.state, arm.status.error) == (State.STANDBY, "")


def test_a_reset_with_a_late_answer_on_the_line_takes_it_for_nothing_else():
    arm = ready_arm()
    arm.twin.link.back.append(Rule(b"1", late_by(1.4)))
    with pytest.raises(ArmError):
        arm.move_j(base_deg=1)
    arm.reset()
    assert arm.twin.world.motors == arm.status.acknowledged
    as_it_stands(arm)
    arm.move_j(base_deg=2)
    assert arm.twin.world.joints.deg["base"] == pytest.approx(2.0, abs=0.1)


def test_the_pendants_stop_ends_a_burst_and_the_position_is_still_known():
    arm = ready_arm()
    device = arm.twin.device
    device.at(device.now_s + 0.8, lambda: device.board.press(Key.STOP))
    with pytest.raises(ArmError, match="STOP key"):
        arm.move_j(base_deg=60)
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.trust is Trust.REFERENCED
    assert arm.twin.world.motors == arm.status.acknowledged
    arm.reset()
    arm.move_j(base_deg=0)
    assert arm.twin.world.joints.deg["base"] == pytest.approx(0.0, abs=0.1)


def test_motors_that_a_stop_left_off_their_way_are_not_believed():
    """A person pressed STOP and moved the arm before the registers were read."""
    arm = ready_arm()
    device, link = arm.twin.device, arm.twin.link

    def moves_it(data):
        if data.startswith(b"@READ"):
            link.on_write = lambda _: None
            device.jog((0, 0, 40, 0, 0, 0))

    def press():
        device.board.press(Key.STOP)
        link.on_write = moves_it

    device.at(device.now_s + 0.8, press)
    with pytest.raises(ArmError, match="STOP key"):
        arm.move_j(base_deg=60)
    assert arm.status.trust is Trust.SUSPECT
    assert arm.twin.world.motors == arm.status.acknowledged


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ("request_stop", "the reference has not changed"),
        ("stop", "the reference has not changed"),
        ("estop", "emergency stop"),
    ],
)
def test_a_stop_while_homing_ends_the_homing_and_nothing_is_referenced(how, words):
    arm = sim_arm()

    def operator(request):
        request.arm.jogging.hold(Jog.joint(shoulder=1.0), speed=0.2, for_s=1.0)
        request.arm.sleep(0.3)
        getattr(request.arm, how)()
        request.arm.sleep(1.0)
        return True

    with pytest.raises(Stopped, match=words):
        arm.home(operator=operator)
    assert arm.status.state is (State.ERROR_STOP if how == "estop" else State.STANDBY)
    assert arm.status.trust is Trust.UNKNOWN
    if how == "estop":
        assert "emergency" in arm.status.error


def test_a_stop_while_homing_waits_for_an_idle_poll_lets_no_operator_begin():
    arm, asked = ready_arm(), []
    while not arm.parts.engine.busy:
        arm.sleep(0.001)
    device = arm.twin.device
    device.at(device.now_s + 0.001, arm.request_stop)
    with pytest.raises(Stopped, match="homing was stopped before it began"):
        arm.home(operator=asked.append)
    assert not asked
    assert arm.status.state is State.STANDBY


def test_an_operator_that_fails_or_refuses_leaves_the_arm_standing():
    arm = sim_arm()

    def failing(request):
        request.arm.jogging.hold(Jog.joint(base=1.0), speed=0.2, for_s=1.0)
        request.arm.sleep(0.3)
        raise RuntimeError("he fell asleep")

    with pytest.raises(RuntimeError, match="asleep"):
        arm.home(operator=failing)
    assert arm.status.state is State.STANDBY
    assert not arm.twin.device.moving
    with pytest.raises(OperatorNeeded):
        arm.home(operator=lambda request: False)
    assert arm.status.state is State.STANDBY
    assert arm.status.trust is Trust.UNKNOWN


def test_interrupting_the_wait_stops_the_arm_between_two_steps():
    arm = ready_arm()
    sent = []

    def interrupt(data):
        sent.append(data)
        if len(sent) == 3:
            signal.raise_signal(signal.SIGINT)

    arm.twin.link.on_write = interrupt
    with pytest.raises(KeyboardInterrupt):
        arm.move_j(base_deg=60)
    assert arm.status.state is State.STANDBY
    assert arm.status.trust is Trust.REFERENCED
    assert arm.twin.world.motors == arm.status.acknowledged
    assert arm.twin.link.overlaps == []
    arm.move_j(base_deg=0)


WAITS = {
    "sleep": lambda arm, handle: arm.sleep(5.0),
    "io.wait": lambda arm, handle: arm.io.wait(high=7, within_s=5.0),
    "wait": lambda arm, handle: handle.wait(),
    "wait for a time": lambda arm, handle: handle.wait(5.0),
}


@pytest.mark.parametrize("name", WAITS)
def test_interrupting_any_wait_stops_the_arm(name):
    arm = ready_arm()
    handle = arm.move_j(base_deg=60, speed=0.3, wait=False)
    device = arm.twin.device
    device.at(device.now_s + 0.3, lambda: signal.raise_signal(signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        WAITS[name](arm, handle)
    assert arm.status.state is State.STANDBY
    with pytest.raises(Stopped):
        handle.wait()


SCRIPTED = {
    "move_j": lambda arm: arm.move_j(base_deg=40),
    "move_l": lambda arm: arm.move_l(replace(arm.pose, y_mm=arm.pose.y_mm + 60)),
    "move_motors": lambda arm: arm.move_motors(400, 0, 0, 0, 0, 0),
    "jog_j": lambda arm: arm.jog_j(base_deg=20),
    "jog_j for a time": lambda arm: arm.jog_j(base=1, duration_s=2.0),
    "jog_l": lambda arm: arm.jog_l(y_mm=40),
    "run": lambda arm: arm.run(JogMove(Jog.joint(base=20))),
    "gripper": lambda arm: arm.gripper.close(),
    "sleep": lambda arm: arm.sleep(2.0),
    "io.wait": lambda arm: arm.io.wait(high=7, within_s=2.0),
}
"""Calls of a script that a stop ends, or that do not begin after one."""


def stopped_elsewhere(arm):
    """Stop an arm as `armdrive stop` does from another terminal."""
    _, answers = answered(arm.parts.connection, {"request": "stop"})
    assert list(answers) == [{"done": "stop"}]


@pytest.mark.parametrize("stop", [lambda arm: arm.request_stop(), stopped_elsewhere])
@pytest.mark.parametrize("name", SCRIPTED)
def test_a_stop_ends_every_call_of_a_script_that_waits(name, stop):
    arm = ready_arm()
    device = arm.twin.device
    device.at(device.now_s + 0.2, lambda: stop(arm))
    with pytest.raises(Stopped, match="stop"):
        SCRIPTED[name](arm)
    assert arm.status.state is State.STANDBY
    assert arm.status.trust is Trust.REFERENCED
    SCRIPTED["move_j"](arm)  # told once, a script may go on


@pytest.mark.parametrize("name", SCRIPTED)
def test_a_stop_from_elsewhere_between_two_calls_keeps_the_next_one_from_beginning(name):
    arm = ready_arm()
    before = arm.twin.world.motors
    stopped_elsewhere(arm)
    arm.parts.pace.wait(lambda: arm.parts.engine.at_rest, 1.0)  # the engine has dealt with the stop
    with pytest.raises(Stopped, match="a stop was requested by another program"):
        SCRIPTED[name](arm)
    assert arm.twin.world.motors == before
    SCRIPTED["jog_j"](arm)
    assert arm.twin.world.motors != before


def test_a_stop_from_elsewhere_that_came_at_the_goal_keeps_the_next_motion_from_beginning():
    arm = ready_arm()
    handle = arm.move_j(base_deg=2, wait=False)
    while not handle.done:
        arm.sleep(0.01)
    stopped_elsewhere(arm)
    handle.wait()
    with pytest.raises(Stopped):
        arm.move_j(base_deg=0)


def test_a_script_s_own_stop_between_two_calls_is_known_to_it():
    arm = ready_arm()
    arm.request_stop()
    arm.stop()
    arm.move_j(base_deg=2, wait=False).cancel()
    arm.jog_j(base_deg=2)


def test_a_person_at_the_keys_jogs_on_after_a_stop_from_elsewhere():
    arm = ready_arm()
    stopped_elsewhere(arm)
    before = arm.twin.world.motors
    arm.parts.pace.wait(lambda: arm.parts.engine.at_rest, 1.0)
    arm.jogging.nudge(Jog.joint(base=2.0), speed=0.5)
    arm.parts.pace.wait(lambda: arm.twin.world.motors != before, 1.0)
    assert arm.twin.world.motors != before


def held(arm, time_s):
    """Hold a jog for a time, renewed as by a key that repeats."""
    end_s = arm.parts.pace.now_s() + time_s
    while arm.parts.pace.now_s() < end_s:
        arm.jogging.hold(Jog.joint(base=1.0), speed=0.5, for_s=0.2)
        arm.parts.pace.wait(lambda: False, 0.03)


LET_GO = [lambda arm: arm.jogging.release(), lambda arm: arm.parts.pace.wait(bool, 0.3)]


@pytest.mark.parametrize("let_go", LET_GO)
@pytest.mark.parametrize("stop", [lambda arm: arm.request_stop(), stopped_elsewhere])
def test_a_key_that_stays_held_does_not_undo_a_stop(stop, let_go):
    arm = ready_arm()
    held(arm, 1.0)
    stop(arm)
    held(arm, 0.5)
    stood = arm.twin.world.motors
    held(arm, 1.0)
    assert arm.twin.world.motors == stood
    assert "let go, then jog again" in arm.status.notice
    assert arm.status.notice_code == Stopped.code
    let_go(arm)
    held(arm, 0.5)
    assert arm.twin.world.motors != stood


def test_a_stop_between_a_call_and_its_plan_lets_nothing_begin(monkeypatch):
    arm = ready_arm()

    def planned(move, ground):
        arm.stop()  # as from another thread: the engine has seen it before there is a motion
        return prepare(move, ground)

    monkeypatch.setattr("armdrive.arm.moving.prepare", planned)
    with pytest.raises(Stopped):
        arm.move_j(base_deg=20.0)
    assert arm.twin.link.named(b"@STEP") == []


def test_a_motion_does_not_wait_behind_work_that_moves_nothing():
    """Otherwise it would begin unexpectedly late."""
    arm = ready_arm()
    work = arm.parts.runner.submit(set_outputs(arm.parts.context, 1))
    arm.sleep(0.001)
    assert arm.status.state is State.STANDBY
    assert not work.done
    with pytest.raises(WrongState):
        arm.move_j(base_deg=8.0)
    arm.sleep(1.0)
    assert work.done
    assert arm.joints.deg["base"] == pytest.approx(0.0, abs=1e-9)


def test_a_stop_by_a_forked_process_is_refused_at_once():
    arm = ready_arm()
    parent = arm.parts.engine.process
    arm.parts.engine.process = os.getpid() + 1
    try:
        for call in (arm.stop, arm.estop, lambda: arm.move_j(base_deg=1)):
            with pytest.raises(LinkLost, match="was forked"):
                call()
    finally:
        arm.parts.engine.process = parent
        arm.close()
