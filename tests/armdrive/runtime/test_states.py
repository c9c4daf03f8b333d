"""The one state machine: every state against every event."""

import pytest
from faults import ready_arm

from armdrive.errors import WrongState
from armdrive.runtime.states import TRANSITIONS, Event, after
from armdrive.status import State

PAIRS = [(state, event) for state in State for event in Event]


@pytest.mark.parametrize(("state", "event"), PAIRS, ids=lambda one: one.name)
def test_every_pair_leads_somewhere_or_is_refused_with_the_way_out(state, event):
    if (state, event) in TRANSITIONS:
        assert after(state, event) is TRANSITIONS[state, event]
        return
    with pytest.raises(WrongState) as refusal:
        after(state, event)
    sentence = str(refusal.value)
    assert event.value in sentence
    assert state.value in sentence
    assert len(sentence.partition(": ")[2].split()) >= 2


@pytest.mark.parametrize("state", State)
def test_stop_is_legal_everywhere_and_never_begins_a_motion(state):
    assert after(state, Event.STOP) not in (State.MOVING, State.HOMING)


@pytest.mark.parametrize("state", State)
def test_a_lost_wire_disconnects_from_everywhere(state):
    assert after(state, Event.LOST) is State.DISCONNECTED


def test_only_reset_and_a_lost_wire_leave_error_stop():
    leaving = {
        event for (state, event), to in TRANSITIONS.items() if state is State.ERROR_STOP is not to
    }
    assert leaving == {Event.RESET, Event.RESET_SWITCHED, Event.LOST}


def test_motion_begins_in_standby_alone():
    for event, moving in ((Event.MOVE, State.MOVING), (Event.HOME, State.HOMING)):
        assert [s for (s, e), to in TRANSITIONS.items() if e is event and to is moving] == [
            State.STANDBY
        ]


def test_every_state_can_be_left_and_reached():
    assert {to for (state, _), to in TRANSITIONS.items() if to is not state} == set(State)
    assert {state for (state, _), to in TRANSITIONS.items() if to is not state} == set(State)


REFUSED = [
    (lambda arm: arm.move_j(base_deg=1.0), "a motion"),
    (lambda arm: arm.jog_j(base_deg=1.0), "jogging"),
    (lambda arm: arm.move_motors(1, 0, 0, 0, 0, 0, speed=0.1), "turning motors"),
    (lambda arm: arm.confirm_reference(), "confirming the reference"),
    (lambda arm: arm.declare_posture(arm.joints), "declaring a posture"),
    (lambda arm: arm.set_output(1), "switching an output"),
    (lambda arm: arm.wait_inputs(high=1), "waiting for inputs"),
    (lambda arm: arm.read_pendant_program(), "using the arm's own program memory"),
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
