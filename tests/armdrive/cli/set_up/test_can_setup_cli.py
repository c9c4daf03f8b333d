"""`armdrive can setup`: the command around the talk, and the file that it writes."""

from __future__ import annotations

import sys
import tomllib
from types import SimpleNamespace

import pytest
from can_setup_bench import NAMES, arm
from cli_calls import Terminal, state_files, typed, write_arm_file

from armdrive.cli.set_up import can
from armdrive.dialog.conversation import About
from armdrive.errors import StateFileError
from armdrive.registry import simulate
from armdrive.setup import plan as kept
from armdrive.setup.dialog_runner import DialogClock
from armdrive.setup.plan import plan_of
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.storage import files as places
from armdrive.storage.lock_client import ask_holder

PORT = "can:slcan:/dev/ttyACM7?bitrate=500000"


@pytest.fixture
def drives(monkeypatch):
    """Have the adapter lead to simulated new drives, with eyes and hands that need no terminal."""
    config = arm()
    twin = simulate(config, factory=True)
    link = twin.link
    monkeypatch.setattr(link, "close", lambda: None)
    monkeypatch.setattr("armdrive.transports.opening.open_link", lambda port, baud: link)
    monkeypatch.setattr("armdrive.setup.dialog_runner.RealClock", DialogClock)
    person = SimulatedPerson(twin, print)
    person.unplug_all(len(plan_of(config).drives))
    answer = person.answer
    seen = SimpleNamespace(link=link, mounted={1, 2}, on_mounted=None)

    def told(asked):
        if asked.about is About.MOUNTED and seen.on_mounted is not None:
            return seen.on_mounted(asked)
        if asked.about is About.MOUNTED and asked.motor not in seen.mounted:
            return asked.question.read("no")  # as if the rest of the arm were not there yet
        return answer(asked)

    person.answer = told
    monkeypatch.setattr(can, "TerminalPerson", lambda name: person)
    return seen


def type_in(monkeypatch, *lines):
    monkeypatch.setattr(sys, "stdin", Terminal(typed(*lines)))


def test_practice_needs_no_drives_and_writes_nothing(call):
    called = call("can", "setup", "bench", "--sim", "--json", code=0)
    assert called.json["left_out"] == []
    assert tomllib.loads(called.json["arm_file"])["mks"]["ids"] == [1, 2, 3, 4, 5, 6]
    assert not places.arm_files().exists() or not list(places.arm_files().iterdir())
    assert state_files(kept.ENDING) == []


def test_the_file_is_written_once_that_is_agreed_to_and_the_rest_goes_on_later(
    call, drives, monkeypatch
):
    path = places.arm_files() / "bench.toml"
    type_in(monkeypatch, "no")
    called = call("can", "setup", "bench", "--port", PORT, code=1)
    assert "Left out: right wrist, left wrist, gripper, base" in called.out
    assert not path.exists()
    assert kept.read("bench", arm().calibration)["elbow"].done
    type_in(monkeypatch, "yes")
    called = call("can", "setup", "bench", "--port", PORT, code=1)
    assert "its settings: nothing to do" in called.out
    table = tomllib.loads(path.read_text())
    assert table["connection"]["port"] == PORT
    assert "armdrive jog --arm bench" in called.out
    before = path.read_text()
    type_in(monkeypatch)
    called = call("can", "setup", "bench", code=1)  # the port is the file's now
    assert "contains all this already" in called.out
    assert path.read_text() == before


def test_a_file_that_is_there_is_taken_as_it_is_and_its_old_text_kept(call, drives, monkeypatch):
    path = write_arm_file(
        "bench",
        '# mine\nmodel = "minimover5-mks"\ntitle = "Mine"\n\n[connection]\ndialect = "mks"\n'
        f'port = "{PORT}"\n\n[limits_deg]\nbase = [-80, 80]\n\n[motor_signs]\nshoulder = -1\n',
    )
    old = path.read_text()
    type_in(monkeypatch, "yes")
    call("can", "setup", "bench", code=1)
    table = tomllib.loads(path.read_text())
    assert table["title"] == "Mine"
    assert table["limits_deg"] == {"base": [-80, 80]}
    assert table["motor_signs"] == {"shoulder": 1}  # it was written the wrong way round
    assert path.with_name("bench.toml.before").read_text() == old
    type_in(monkeypatch)
    assert "contains all this already" in call("can", "setup", "bench", code=1).out


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (("bench",), 3, "run this in a terminal, or give --sim"),
        (("bench", "--yes"), 3, "plug real drives in"),
        (("bench", "--sim", "--yes", "--port", PORT), 2, "--sim needs no --port"),
        (("../x", "--sim", "--yes"), 2, "cannot name a file"),
    ],
)
def test_impossible_options_are_refused(call, words, code, sentence):
    assert sentence in call.refused("can", "setup", *words, code=code)


def test_another_kind_of_arm_is_refused(call):
    write_arm_file("old", 'model = "teachmover"\n')
    assert 'dialect = "mks"' in call.refused("can", "setup", "old", "--sim", "--yes", code=2)


def test_answers_that_end_leave_what_was_done(call, drives, monkeypatch):
    monkeypatch.undo()
    monkeypatch.setattr("armdrive.transports.opening.open_link", lambda port, baud: drives.link)
    monkeypatch.setattr("armdrive.setup.dialog_runner.RealClock", DialogClock)
    type_in(monkeypatch, "?", "back", "yes")
    called = call("can", "setup", "bench", "--port", PORT, code=3)
    assert "`armdrive can setup bench` continues there" in called.err
    assert "shipped as id 1" in called.out  # what ? explains
    assert "no way back" in called.out


def test_an_adapter_is_chosen_from_those_that_are_there(call, drives, monkeypatch):
    from armdrive.transports.ports import CanPort

    there = [CanPort(PORT, "CANable"), CanPort("can:socketcan:can0", "the kernel's")]
    monkeypatch.setattr("armdrive.transports.ports.list_can_ports", lambda ports: there)
    monkeypatch.setattr("serial.tools.list_ports.comports", list)
    drives.mounted = set()
    type_in(monkeypatch, "/dev/ttyACM7", "1", "yes")
    called = call("can", "setup", "bench", code=1)
    lines = called.out.splitlines()
    assert "  can:gs_usb:0?bitrate=500000               the same on Windows and macOS" in lines
    assert "write the adapter, such as" in called.out
    assert (
        tomllib.loads((places.arm_files() / "bench.toml").read_text())["connection"]["port"] == PORT
    )


def test_unreadable_notes_are_reported_with_the_remedy():
    path = kept.path_of("bench")
    path.parent.mkdir(parents=True, exist_ok=True)
    for text in ("{", '{"calibration": "x", "motors": {"base": {"gear": "much"}}}', "[]", '"x"'):
        path.write_text(text)
        with pytest.raises(StateFileError, match="delete it"):
            kept.read("bench", "x")
    kept.write("bench", "x", {"base": kept.Notes(way="left", gear=3.0, done=True)})
    assert kept.read("bench", "x")["base"].way == "left"
    assert kept.read("bench", "y")["base"] == kept.Notes(done=True)  # steps mean something else
    assert kept.read("other", "x") == {}
    assert set(NAMES) == {each.name for each in plan_of(arm()).drives}


def test_an_interview_about_drives_that_count_by_their_encoder_asks_for_no_microsteps(call):
    answers = ("--template", "printed-six", "--yes")
    file = places.arm_files().parent / "answers.toml"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text('name = "six"\ntemplate = "printed-six"\ndialect = "mks"\n')
    call("config", "new", "--answers", str(file), code=0)
    table = tomllib.loads((places.arm_files() / "six.toml").read_text())
    assert table["connection"]["dialect"] == "mks"
    call("config", "new", "seven", *answers, code=0)
    pulses = tomllib.loads((places.arm_files() / "seven.toml").read_text())
    for drive, motor in zip(table["motors"], pulses["motors"], strict=False):
        assert drive["steps_per_turn"] == pytest.approx(motor["steps_per_turn"] * 16384 / 3200)


def test_another_program_can_stop_a_setup(call, drives, monkeypatch):
    type_in(monkeypatch)
    said = []

    def stop(asked):
        said.append(ask_holder("bench", "status")["error"])
        ask_holder("bench", "stop")
        return asked.question.read("yes")

    drives.on_mounted = stop
    called = call("can", "setup", "bench", "--port", PORT, code=130)
    assert "sets its drives up" in said[0]
    assert "interrupted" in called.err
    assert not (places.arm_files() / "bench.toml").exists()
