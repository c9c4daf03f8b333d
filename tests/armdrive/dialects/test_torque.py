"""What holds an arm is said of every dialect, in the status and the docs; disable parks first."""

from __future__ import annotations

from dataclasses import astuple

import pytest

from armdrive import Arm
from armdrive.abilities import HELD, SAGS
from armdrive.cli import terminal_operator
from armdrive.cli.drive import motors
from armdrive.errors import Refused
from armdrive.registry import DIALECTS
from tests.conformance.memory_bench import MemoryBench


@pytest.fixture
def answers(monkeypatch):
    """A terminal at which somebody gives these answers, one after the other."""
    given: list[bool] = []
    asked: list[str] = []

    def agreed(question: str) -> bool:
        asked.append(question)
        return given.pop(0)

    for module in (terminal_operator, motors):
        monkeypatch.setattr(module, "agreed", agreed)
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    return given, asked


@pytest.mark.parametrize("row", DIALECTS.values(), ids=lambda row: row.name)
def test_the_docs_and_the_status_say_what_holds_each_arm(row):
    sentences = astuple(row.torque)
    assert all(each.startswith((HELD, SAGS)) for each in sentences)
    with Arm.connect(f"sim:{row.name}") as arm:
        shown = str(arm.status)
    assert f"disable   the arm {row.torque.disable}" in shown
    assert f"estop     the arm {row.torque.estop}" in shown


@pytest.mark.parametrize(
    "name", [name for name, row in DIALECTS.items() if not row.abilities.grip_switch]
)
def test_fingers_that_feel_nothing_refuse_to_grasp(name):
    with MemoryBench(name) as bench, pytest.raises(Refused, match="grip switch"):
        bench.ready().gripper.grasp()


def test_a_simulated_arm_is_parked_and_then_switched_off(call):
    call("home", code=0)
    text = call("disable", code=0).out
    assert text.index("parked: ") < text.index("the motors are off")
    view = call("status", "--json", code=0).json
    assert view["trust"] == "suspect"
    assert view["trust_code"] == "E715"
    assert view["torque"]["disable"] == DIALECTS["teachmover"].torque.disable


def test_an_arm_that_cannot_be_parked_stays_as_it_is(call):
    assert "--no-park" in call.refused("disable", "--yes", code=3)
    assert call("disable", "--no-park", "--json", code=0).json["current"] == "off"


PARK, SUPPORT = "Park the arm first? Type yes: ", "support the arm"


@pytest.mark.parametrize(
    ("given", "code", "parked"),
    [([True], 0, True), ([False, True], 0, False), ([False, False], 3, False)],
)
def test_a_person_is_asked_to_park_first_and_then_whether_the_arm_is_supported(
    call, answers, given, code, parked
):
    answers[0][:] = given
    call("home", code=0)
    done = call("disable", code=code)
    assert ("parked: " in done.out) == parked
    assert ("the motors are off" in done.out) == (code == 0)
    assert ("[E204]" in done.err) == (code == 3)
    first, *others = answers[1]
    assert first == PARK
    assert [SUPPORT in each for each in others] == [True] * (len(given) - 1)


@pytest.mark.parametrize("name", DIALECTS)
def test_enable_moves_nothing_and_brings_it_back(call, name):
    call("disable", "--no-park", "--sim", name, code=0)
    view = call("enable", "--sim", name, "--json", code=0).json
    assert view["state"] == "standby"
