"""Limit switches that are pressed by hand: whether the board really stops at them."""

import io
from datetime import date, datetime
from types import SimpleNamespace

import pytest
from grbl_arm import config, found, ready

from armdrive import Arm
from armdrive.cli.set_up import arm_trials
from armdrive.cli.set_up.arm_trials import Attendance
from armdrive.config.arm import limit_remarks
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.dialog import Dialog
from armdrive.errors import DeviceFault, Refused, SettingsDiffer
from armdrive.registry import simulate
from armdrive.registry.arm_files import load_arm
from armdrive.setup.arm_checks import (
    SawSwitch,
    all_work,
    check_switches,
    make_ready,
    record,
    switches_of,
)
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.sim.mechanics.motors import SwitchState
from armdrive.status import State
from armdrive.storage import files as places

LIMITED = {"hard_limits": True}
MOTORS = ["base", "shoulder", "elbow", "right wrist", "left wrist", "gripper"]

FILE = """\
model = "minimover5"

[connection]
dialect = "grbl"
port = "/dev/ttyNONE"

[grbl]
hard_limits = true      # the board stops at its switches
"""


def pressed(arm, switches, ask=None):
    """Have the simulated person press these switches, and `ask` what to answer, if given."""
    person = SimulatedPerson(arm.twin, lambda _line: None, ask)
    return check_switches(Dialog(person), arm, switches)


def seen_of(arm):
    make_ready(arm)
    return pressed(arm, switches_of(arm.config))


@pytest.mark.parametrize(("firmware", "homing"), [("grbl", True), ("grblhal", False)])
def test_switches_that_raise_alarms_work_and_nothing_moves(firmware, homing):
    arm = found(config(LIMITED), firmware=firmware, homing=homing)  # locked until it homes
    before = arm.twin.world.motors
    seen = seen_of(arm)
    assert seen == dict.fromkeys(MOTORS, SawSwitch.ALARM)
    assert all_work(seen)
    assert arm.twin.world.motors == before
    assert arm.status.state is State.STANDBY
    assert arm.io.read() == 0  # all were let go of


def test_a_board_that_accepts_hard_limits_and_does_nothing_is_found_out():
    arm = found(config(LIMITED))  # the default RAMPS build
    assert seen_of(arm) == dict.fromkeys(MOTORS, SawSwitch.PIN_ALONE)
    assert arm.status.state is State.STANDBY


def test_on_that_board_a_switch_that_closes_in_motion_stops_nothing():
    arm = ready(config(LIMITED))
    handle = arm.move_j(base_deg=20, wait=False)
    arm.sleep(0.3)
    arm.twin.board.set_switch(0, SwitchState.CLOSED)
    handle.wait(30.0)
    assert arm.joints.deg["base"] == pytest.approx(20.0, abs=0.1)


def test_a_switch_on_another_pin_and_one_without_a_wire_are_told():
    arm = found(config(LIMITED), firmware="grbl")
    make_ready(arm)
    base, shoulder, *others = switches_of(arm.config)
    board = arm.twin.board
    press = board.set_switch
    board.set_switch = lambda axis, state: press({0: 1}.get(axis, axis), state)
    assert pressed(arm, (base,)) == {"base": SawSwitch.NOTHING}
    assert pressed(arm, (base, shoulder))["base"] is SawSwitch.NOTHING
    board.set_switch = lambda axis, state: None
    seen = pressed(arm, tuple(others))
    assert not all_work(seen)
    assert all_work({"base": SawSwitch.ALARM, "gripper": SawSwitch.NONE})
    assert seen == dict.fromkeys(MOTORS[2:], SawSwitch.NOTHING)
    assert pressed(arm, (base,), lambda question: "none") == {"base": SawSwitch.NONE}
    arm.estop()
    with pytest.raises(DeviceFault):
        pressed(arm, (base,))


def test_the_alarm_of_a_switch_that_is_let_go_is_reset_too():
    arm = found(config(LIMITED), firmware="grbl")
    make_ready(arm)
    board = arm.twin.board
    press = board.set_switch

    def bouncing(axis, state):
        press(axis, state)
        if state is SwitchState.FREE:
            press(axis, SwitchState.CLOSED)
            press(axis, SwitchState.FREE)

    board.set_switch = bouncing
    assert pressed(arm, switches_of(arm.config)[:1]) == {"base": SawSwitch.ALARM}
    arm.sleep(1.0)
    assert arm.status.state is State.STANDBY


def test_an_arm_that_counts_on_no_switches_is_refused():
    with pytest.raises(Refused, match=r"hard_limits = true under \[grbl\], .* --arm \S+ --fix"):
        switches_of(config())
    with pytest.raises(Refused, match=r"\(teachmover\) has no limit switches"):
        switches_of(simulated_config("teachmover"))


@pytest.mark.parametrize(
    ("firmware", "todo"),
    [
        ("mega5x", r"\$21.*doctor --arm .* writes it"),
        ("fluidnc", r"\$21.*in the board's configuration file.*: change it there"),
    ],
)
def test_a_board_without_the_setting_is_to_be_mended_first(firmware, todo):
    arm = found(config(LIMITED), firmware=firmware, factory=True)
    with pytest.raises(SettingsDiffer, match=todo):
        make_ready(arm)


def test_the_day_is_written_into_the_arm_file_and_nothing_else_changes(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text(FILE, encoding="utf-8")
    made = load_arm(path)
    assert "config limits bench" in limit_remarks(made)[0]
    record(path, made, date(2026, 11, 23)).write()
    assert path.read_text(encoding="utf-8").startswith(FILE)
    again = load_arm(path)
    assert again.device.hard_limits_checked == "2026-11-23"
    assert limit_remarks(again) == ()


def arm_file(text=FILE):
    path = places.arm_files() / "bench.toml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def test_the_command_on_a_simulated_board_says_what_it_made_of_each_switch(call):
    path = arm_file()
    said = call("config", "limits", "bench", "--sim", "--yes", code=1).out
    assert "base: the board sees it, and raises no alarm" in said
    assert "would stop nothing" in said
    told = call("config", "limits", "bench", "--sim", "--json", code=1).json
    assert told == {"switches": dict.fromkeys(MOTORS, "pin_alone"), "works": False}
    assert "press the switches of a real arm" in call.refused("config", "limits", "bench", code=3)
    assert path.read_text(encoding="utf-8") == FILE


def test_a_person_presses_each_switch_and_the_day_is_written(monkeypatch, call):
    path = arm_file()

    class Person(io.StringIO):
        """Does to the simulated arm what the answers say, as they are given."""

        def readline(self):
            number, phase = divmod(self.count, 2)
            self.count += 1
            if number == len(MOTORS):
                return "yes\n"
            board = self.arm.twin.board
            board.set_switch(number, SwitchState.FREE if phase else SwitchState.CLOSED)
            return "released\n" if phase else "pressed\n"

    person = Person()
    person.count = 0

    def opened(made, *, simulated):
        assert not simulated
        twin = simulate(made, firmware="grbl")
        person.arm = Arm(connect_simulated(made, twin=twin))
        person.arm.simulated = False
        return person.arm

    noon = SimpleNamespace(now=lambda zone: datetime(2026, 5, 4, 12, tzinfo=zone))
    monkeypatch.setattr(arm_trials, "datetime", noon)
    monkeypatch.setattr(arm_trials, "trial_arm", opened)
    attended = Attendance(simulated=False, alone=False, tell=print)
    monkeypatch.setattr(arm_trials, "attendance", lambda *_: attended)
    monkeypatch.setattr("sys.stdin", person)
    said = call("config", "limits", "bench", code=0).out
    assert "Press the limit switch of base (X) by hand" in said
    assert load_arm(path).device.hard_limits_checked == "2026-05-04"
