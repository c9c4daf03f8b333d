"""Inputs that are waited for and outputs that are switched one by one, on every clock."""

from __future__ import annotations

import math

import pytest
from faults import ready_arm, sim_config

from armdrive import Arm, InputTimeout, LinkLost, State, Stopped
from armdrive.arm import device as signalling
from armdrive.dialects.grbl.settings import PINS
from armdrive.errors import BadRequest, Refused, WrongState
from armdrive.motion.connecting import INPUTS_POLL_S
from armdrive.registry import dialect


def later(arm, by_s, action):
    """Have something happen at the device's own time."""
    arm.twin.device.at(arm.twin.device.now_s + by_s, action)


@pytest.mark.parametrize("dialect", ["teachmover", "robko01", "grbl"])
def test_an_input_is_seen_within_two_looks_of_its_coming(dialect):
    with Arm.connect(f"sim:{dialect}") as arm:
        began_s = arm.pace.now_s()
        later(arm, 5.0, lambda: arm.twin.device.set_input(2, True))
        bits = arm.wait_inputs(high=3, within_s=20.0)
        assert bits >> 2 & 1
        late_s = arm.pace.now_s() - began_s - 5.0
        assert 0.0 <= late_s <= 2 * INPUTS_POLL_S + 0.1


def test_several_are_waited_for_together_high_and_low():
    arm = ready_arm()
    device = arm.twin.device
    device.set_input(4, True)
    device.set_input(1, True)
    later(arm, 1.0, lambda: device.set_input(3, True))
    later(arm, 2.0, lambda: device.set_input(4, False))
    began_s = arm.pace.now_s()
    bits = arm.wait_inputs(high=(2, 4), low=[5], within_s=10.0)
    assert bits & 0b11010 == 0b01010
    assert arm.pace.now_s() - began_s > 1.9


def test_an_old_reading_answers_nothing():
    arm = ready_arm()
    arm.twin.device.set_input(2, True)
    arm.read_inputs()
    arm.twin.device.set_input(2, False)
    with pytest.raises(InputTimeout):
        arm.wait_inputs(high=3, within_s=0.5)


def test_the_deadline_is_an_error_that_says_what_is_not_so_and_how_the_inputs_are():
    arm = ready_arm()
    arm.twin.device.set_input(4, True)
    began_s = arm.pace.now_s()
    with pytest.raises(InputTimeout, match=r"waited 2 s for high 3 and low 5.*00010000") as raised:
        arm.wait_inputs(high=3, low=5, within_s=2.0)
    assert arm.pace.now_s() - began_s == pytest.approx(2.0)
    assert isinstance(raised.value, TimeoutError)
    assert raised.value.code == "E114"
    assert arm.status.state is State.STANDBY


@pytest.mark.parametrize("within_s", [None, math.inf, 1e300])
def test_on_simulated_time_a_wait_for_ever_ends(within_s, monkeypatch):
    monkeypatch.setattr(signalling, "SIMULATED_S", 5.0)
    with pytest.raises(InputTimeout, match="waited 5 s"):
        ready_arm().wait_inputs(high=1, within_s=within_s)


def test_a_stop_ends_the_wait():
    arm = ready_arm()
    later(arm, 1.0, arm.request_stop)
    with pytest.raises(Stopped, match="waited for inputs"):
        arm.wait_inputs(high=1, within_s=60.0)
    assert arm.core.readings.awaiting == 0


def test_a_lost_wire_ends_the_wait():
    arm = ready_arm()
    later(arm, 1.0, arm.twin.link.cut)
    with pytest.raises(LinkLost):
        arm.wait_inputs(high=1, within_s=60.0)


def test_nobody_waits_for_what_nobody_looks_at():
    with Arm.connect("sim:grbl") as arm:
        arm.disable()
        with pytest.raises(WrongState, match="enable"):
            arm.wait_inputs(high=1, within_s=1.0)
        arm.enable()
        arm.estop()
        with pytest.raises(WrongState, match="reset"):
            arm.wait_inputs(high=1, within_s=1.0)


def test_the_arm_may_move_meanwhile_and_is_not_held_up():
    arm = ready_arm(pace=30.0)
    handle = arm.move_j(base_deg=40, wait=False)
    later(arm, 1.0, lambda: arm.twin.device.set_input(1, True))
    arm.wait_inputs(high=2, within_s=120.0)
    assert handle.wait().bursts
    arm.close()


def test_a_motion_may_begin_while_another_thread_waits(request):
    import threading

    arm = ready_arm(pace=30.0)
    request.addfinalizer(arm.close)
    seen = []
    waiter = threading.Thread(target=lambda: seen.append(arm.wait_inputs(high=2, within_s=600.0)))
    waiter.start()
    while not arm.core.readings.awaiting:
        arm.sleep(0.01)
    for angle in (10, 0, 10, 0):
        arm.move_j(base_deg=angle)
    assert seen == []
    arm.twin.device.set_input(1, True)
    waiter.join(timeout=30.0)
    assert seen
    assert seen[0] & 0b10


@pytest.mark.parametrize("idle_poll_s", [0.0, 30.0])
def test_waiting_looks_as_often_as_it_says_whatever_the_arm_file_has(idle_poll_s):
    arm = ready_arm(sim_config(idle_poll_s=idle_poll_s))
    later(arm, 1.0, lambda: arm.twin.device.set_input(2, True))
    began_s = arm.pace.now_s()
    arm.wait_inputs(high=3, within_s=20.0)
    assert arm.pace.now_s() - began_s < 1.3
    before = arm.core.readings.sensed
    arm.sleep(5.0)
    assert arm.core.readings.sensed - before <= 1


@pytest.mark.parametrize(
    "words",
    [{}, {"high": 0}, {"high": 9}, {"low": True}, {"high": 1, "low": (1, 2)}, {"high": "a"}],
)
def test_what_names_no_input_is_refused(words):
    with pytest.raises(BadRequest):
        ready_arm().wait_inputs(**words)


def test_one_output_is_switched_and_the_others_stay():
    arm = ready_arm()
    arm.set_output(3)
    assert arm.status.outputs == 0b100
    arm.set_output(1)
    arm.set_output(3, False)
    assert arm.status.outputs == 0b001
    arm.set_output(1, on=False)
    assert arm.status.outputs == 0
    with pytest.raises(BadRequest):
        arm.set_output(9)


@pytest.mark.parametrize("name", ["armdroid", "mks", "cia402"])
def test_an_arm_without_inputs_says_so_instead_of_waiting_for_ever(name):
    with Arm.connect(f"sim:{name}") as arm, pytest.raises(Refused, match="has no inputs"):
        arm.wait_inputs(high=1)


def test_a_board_has_an_input_for_each_pin_that_it_reports():
    assert dialect("grbl").abilities.inputs == len(PINS)
