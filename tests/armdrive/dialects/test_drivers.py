"""What drivers have in common: sections of arm files, speed tables, silence, and torque."""

from __future__ import annotations

from dataclasses import astuple

import pytest
from amounts import every_row
from faults import arm_config, driven
from hypothesis import given
from hypothesis import strategies as st

from armdrive import Arm
from armdrive.abilities import HELD, SAGS
from armdrive.cli import terminal_operator
from armdrive.cli.drive import motors
from armdrive.dialects.speed_table import SpeedTable
from armdrive.errors import ArmFileError, Refused
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import parse_arm
from armdrive.status import Evidence, State
from tests.conformance.memory_bench import MemoryBench

# -- Sections --------------------------------------------------------------------------------------


REFUSED = [
    ("grbl", "minimover5", {"axes": "XYZ"}, "6 motors"),
    ("grbl", "minimover5", {"axes": "XYZABX"}, "its own letter"),
    ("grbl", "minimover5", {"unit": "inches"}, "steps, degrees"),
    ("grbl", "minimover5", {"travel": [1.0, 2.0]}, "6 entries"),
    ("grbl", "minimover5", {"outputs": ["laser"]}, "flood, mist"),
    ("grbl", "minimover5", {"servo": "M5"}, "grbl.servo"),
    ("grbl", "minimover5", {"ramp": 1.0}, "ramp_s"),
    ("armdroid", "armdroid1", {"channels": [6, 5, 4, 3, 2, 2]}, "armdroid.channels"),
    ("armdroid", "armdroid1", {"speed_table": [[0, 20.0], [250, 200.0]]}, "armdroid.speed_table"),
    ("robko01", "robko01", {"board": "uno"}, "robko01.board"),
]


@every_row("dialect, model, section, words", REFUSED)
def test_a_section_is_refused_by_the_name_of_its_key(dialect, model, section, words):
    table = {"model": model, "connection": {"dialect": dialect}, dialect: section}
    with pytest.raises(ArmFileError, match=words):
        DIALECTS[dialect].controller(parse_arm(table, name="bench"))


# -- Speed tables ----------------------------------------------------------------------------------


TABLE = SpeedTable(((3, 30.0), (140, 150.0), (190, 250.0), (240, 470.0)))


@every_row("interpolated, settings", [(True, range(3, 241)), (False, [3, 140, 190, 240])])
@given(st.floats(1.0, 600.0))
def test_a_rate_gets_the_fastest_setting_that_is_no_faster(interpolated, settings, rate_hz):
    table = SpeedTable(TABLE.points, interpolated=interpolated)
    no_faster = [each for each in settings if TABLE.rate_hz(each) <= rate_hz + 1e-9]
    assert table.setting(rate_hz) == max(no_faster, default=3)


def test_a_setting_of_the_table_is_in_the_part_that_it_begins():
    assert [TABLE.part(setting) for setting in (3, 139, 140, 190, 239, 240)] == [0, 0, 1, 2, 2, 3]
    assert [TABLE.rate_hz(setting) for setting, _ in TABLE.points] == [30.0, 150.0, 250.0, 470.0]


# -- Silence ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_controller_that_falls_silent_in_motion_makes_the_position_suspect(dialect):
    arm = driven(arm_config(dialect))
    arm.move_j(base_deg=40, wait=False)
    arm.sleep(0.5)
    assert arm.status.state is State.MOVING
    device = arm.twin.device
    device.power_off()
    device.at(arm.status.time_s + 3.0, device.power_on)
    arm.sleep(6.0)
    assert arm.status.state is State.ERROR_STOP
    first, *_ = arm.status.trust_reason.split("; then ")  # that it restarted may follow
    assert first == Evidence.ANSWER_LOST.value


# -- Torque ----------------------------------------------------------------------------------------


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
    assert text.index("parked: ") < text.index("motor current off")
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
    assert ("motor current off" in done.out) == (code == 0)
    assert ("[E204]" in done.err) == (code == 3)
    first, *others = answers[1]
    assert first == PARK
    assert [SUPPORT in each for each in others] == [True] * (len(given) - 1)


@pytest.mark.parametrize("name", ["teachmover", "mks"])
def test_enable_moves_nothing_and_brings_it_back(call, name):
    call("disable", "--no-park", "--sim", name, code=0)
    view = call("enable", "--sim", name, "--json", code=0).json
    assert view["state"] == "standby"
