"""Calls of Arm: their forms, their reference page, their signals."""

import ast
import inspect
import math
import sys

import pytest
from faults import ready_arm, sim_config
from pages import DOCS

import armdrive
from armdrive import Arm, InputTimeout, LinkLost, State
from armdrive import arm as arm_module
from armdrive.arm import device as signalling
from armdrive.errors import BadRequest, Refused, WrongState
from armdrive.motion.connecting import INPUTS_POLL_S
from armdrive.runtime import overrides

sys.path.append(str(DOCS))
import reference

sys.path.remove(str(DOCS))


def test_the_two_forms_of_a_call_with_wait_are_the_call_itself():
    """With `wait=True`, the default, a call returns what was done; with False, a handle of it."""
    (arm,) = (
        each for each in ast.parse(inspect.getsource(arm_module)).body
        if isinstance(each, ast.ClassDef) and each.name == "Arm"
    )  # fmt: skip
    forms: dict[str, list[ast.FunctionDef | ast.AsyncFunctionDef]] = {}
    for each in arm.body:
        if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef) and "wait" in {
            one.arg for one in each.args.kwonlyargs
        }:
            forms.setdefault(each.name, []).append(each)
    assert set(forms) == {"move_j", "move_to", "move_l", "move_c", "move_path"}
    for waited, begun, call in forms.values():
        at = [one.arg for one in call.args.kwonlyargs].index("wait")
        for form, literal, default, returned in (
            (waited, "Literal[True]", "True", "Moved"),
            (begun, "Literal[False]", None, "Handle[Moved]"),
            (call, "bool", "True", "Moved | Handle[Moved]"),
        ):
            wait, value = form.args.kwonlyargs[at], form.args.kw_defaults[at]
            assert ast.unparse(wait.annotation) == literal
            assert (value and ast.unparse(value)) == default
            assert ast.unparse(form.returns) == returned
            wait.annotation, form.args.kw_defaults[at] = None, None
        assert ast.unparse(waited.args) == ast.unparse(begun.args) == ast.unparse(call.args)


def test_the_reference_page_has_every_public_call():
    names = set(dir(armdrive.Arm))
    inner = reference.INNER[armdrive.Arm]
    calls = {name for name in names - inner if not name.startswith("_")}
    page = reference.page()
    for name in sorted(calls):
        if inspect.isfunction(inspect.getattr_static(armdrive.Arm, name)):
            assert f".{name}(" in page, name
    assert names >= inner


# -- Signals ---------------------------------------------------------------------------------------


def later(arm, by_s, action):
    """Have something happen at the device's own time."""
    arm.twin.device.at(arm.twin.device.now_s + by_s, action)


@pytest.mark.parametrize("dialect", ["teachmover", "robko01", "grbl"])
def test_an_input_is_seen_within_two_looks_of_its_coming(dialect):
    with Arm.connect(f"sim:{dialect}") as arm:
        began_s = arm.parts.pace.now_s()
        later(arm, 5.0, lambda: arm.twin.device.set_input(2, True))
        bits = arm.io.wait(high=3, within_s=20.0)
        assert bits >> 2 & 1
        late_s = arm.parts.pace.now_s() - began_s - 5.0
        assert 0.0 <= late_s <= 2 * INPUTS_POLL_S + 0.1


def test_several_inputs_are_waited_for_together():
    arm = ready_arm()
    device = arm.twin.device
    device.set_input(4, True)
    device.set_input(1, True)
    later(arm, 1.0, lambda: device.set_input(3, True))
    later(arm, 2.0, lambda: device.set_input(4, False))
    began_s = arm.parts.pace.now_s()
    bits = arm.io.wait(high=(2, 4), low=[5], within_s=10.0)
    assert bits & 0b11010 == 0b01010
    assert arm.parts.pace.now_s() - began_s > 1.9


def test_a_wait_ignores_readings_from_before_it():
    arm = ready_arm()
    arm.twin.device.set_input(2, True)
    arm.io.read()
    arm.twin.device.set_input(2, False)
    with pytest.raises(InputTimeout):
        arm.io.wait(high=3, within_s=0.5)


def test_an_input_timeout_names_the_missing_inputs_and_the_present_ones():
    arm = ready_arm()
    arm.twin.device.set_input(4, True)
    began_s = arm.parts.pace.now_s()
    with pytest.raises(InputTimeout, match=r"waited 2 s for high 3 and low 5.*00010000") as raised:
        arm.io.wait(high=3, low=5, within_s=2.0)
    assert arm.parts.pace.now_s() - began_s == pytest.approx(2.0)
    assert isinstance(raised.value, TimeoutError)
    assert raised.value.code == "E114"
    assert arm.status.state is State.STANDBY


@pytest.mark.parametrize(
    ("within_s", "words"),
    [
        (None, "waited 5 s, the most in simulated"),
        (math.inf, "waited 5 s"),
        (0, "waited 0 s"),
    ],
)
def test_a_wait_in_simulated_time_ends_at_its_limit_or_the_longest(within_s, words, monkeypatch):
    monkeypatch.setattr(signalling, "LONGEST_SIMULATED_WAIT_S", 5.0)
    with pytest.raises(InputTimeout, match=words):
        ready_arm().io.wait(high=1, within_s=within_s)


def test_a_pause_does_not_count_towards_the_deadline_and_an_input_in_it_does(monkeypatch):
    """A person who pauses the arm to fix the feeder must not end the script."""
    monkeypatch.setattr(overrides, "NAP_S", 0.0)  # no other thread resumes it
    arm = ready_arm()
    later(arm, 1.0, arm.pause)
    later(arm, 11.0, arm.resume)
    began_s = arm.parts.pace.now_s()
    with pytest.raises(InputTimeout, match="waited 2 s"):
        arm.io.wait(high=1, within_s=2.0)
    assert arm.parts.pace.now_s() - began_s == pytest.approx(12.0, abs=0.1)
    arm.pause()
    later(arm, 5.0, lambda: arm.twin.device.set_input(1, True))
    assert arm.io.wait(high=2, within_s=2.0) == 0b10


def test_a_wait_in_a_pause_that_nobody_can_end_is_given_up(monkeypatch):
    monkeypatch.setattr(overrides, "LONGEST_SIMULATED_WAIT_S", 20.0)
    monkeypatch.setattr(overrides, "NAPS", 3)
    arm = ready_arm()
    arm.pause()
    with pytest.raises(WrongState, match="has been paused for 20 s, so this call was cancelled"):
        arm.io.wait(high=1, within_s=2.0)


def test_a_lost_wire_ends_the_wait():
    arm = ready_arm()
    later(arm, 1.0, arm.twin.link.cut)
    with pytest.raises(LinkLost):
        arm.io.wait(high=1, within_s=60.0)


def test_a_wait_for_inputs_is_refused_where_they_are_not_read():
    with Arm.connect("sim:grbl") as arm:
        arm.disable()
        with pytest.raises(WrongState, match="enable"):
            arm.io.wait(high=1, within_s=1.0)


def test_a_motion_may_begin_while_another_thread_waits(request):
    import threading

    arm = ready_arm(pace=30.0)
    request.addfinalizer(arm.close)
    seen = []
    waiter = threading.Thread(target=lambda: seen.append(arm.io.wait(high=2, within_s=600.0)))
    waiter.start()
    while not arm.parts.core.readings.awaiting:
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
    began_s = arm.parts.pace.now_s()
    arm.io.wait(high=3, within_s=20.0)
    assert arm.parts.pace.now_s() - began_s < 1.3
    before = arm.parts.core.readings.sensed
    arm.sleep(5.0)
    assert arm.parts.core.readings.sensed - before <= 1


@pytest.mark.parametrize(
    "words",
    [{}, {"high": 0}, {"high": 9}, {"low": True}, {"high": 1, "low": (1, 2)}, {"high": "a"}],
)
def test_an_invalid_input_is_refused(words):
    with pytest.raises(BadRequest):
        ready_arm().io.wait(**words)


def test_one_output_is_switched_and_the_others_stay():
    arm = ready_arm()
    arm.io.set(3)
    assert arm.status.outputs == 0b100
    arm.io.set(1)
    arm.io.set(3, False)
    assert arm.status.outputs == 0b001
    arm.io.set(1, on=False)
    assert arm.status.outputs == 0
    with pytest.raises(BadRequest):
        arm.io.set(9)


@pytest.mark.parametrize("name", ["armdroid", "mks", "cia402"])
def test_an_arm_without_inputs_and_outputs_says_so(name):
    with Arm.connect(f"sim:{name}") as arm:
        arm.enable()
        for call in (arm.io.read, lambda: arm.io.wait(high=1)):
            with pytest.raises(Refused, match="has no inputs"):
                call()
        for call in (lambda: arm.io.set(1), lambda: arm.io.write(0)):
            with pytest.raises(Refused, match="has no outputs"):
                call()
