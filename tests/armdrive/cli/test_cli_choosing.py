"""Which arm a command is about: options, the environment, the default arm file."""

from __future__ import annotations

import pytest
from cli_calls import write_arm_file

NOWHERE = 'model = "teachmover"\n[connection]\nport = "/dev/ttyNOWHERE"\n'


def arm_of(called):
    return called.json["arm"]


@pytest.mark.parametrize("words", [(), ("--sim", "teachmover"), ("--arm", "sim:teachmover")])
def test_the_simulated_arm_is_chosen_by_dialect_by_name_and_by_no_name(call, words):
    assert arm_of(call("status", *words, "--json", code=0)) == "sim:teachmover"


def test_an_arm_file_is_chosen_by_name_and_by_path(call, tmp_path):
    write_arm_file("bench", NOWHERE)
    assert "/dev/ttyNOWHERE" in call.refused("status", "--arm", "bench", code=4)
    path = tmp_path / "other.toml"
    path.write_text('model = "teachmover"\n')
    sentence = call.refused("status", "--arm", str(path), code=4)
    assert "other names no port" in sentence


def test_of_several_defaults_the_nearest_is_used_and_an_option_before_them_all(call, monkeypatch):
    write_arm_file("default", NOWHERE)
    assert "/dev/ttyNOWHERE" in call.refused("status", code=4)
    call("config", "set-default", "sim:robko01", code=0)
    assert arm_of(call("status", "--json", code=0)) == "sim:robko01"
    monkeypatch.setenv("ARMDRIVE_ARM", "bench")
    assert "'bench'" in call.refused("status", code=2)
    write_arm_file("bench", NOWHERE)
    assert "/dev/ttyNOWHERE" in call.refused("status", code=4)
    assert "ARMDRIVE_ARM" in call("config", "set-default", "default", code=0).out
    assert arm_of(call("status", "--sim", "teachmover", "--json", code=0)) == "sim:teachmover"
    monkeypatch.delenv("ARMDRIVE_ARM")
    none = call("config", "set-default", "--none", "--json", code=0).json
    assert none["default"] == "default"  # the file of that name


def test_an_arm_file_that_cannot_be_used_is_named_with_the_key(call):
    path = write_arm_file("bench", 'model = "teachmover"\n[connection]\nbuad = 9600')
    sentence = call.refused("status", "--arm", "bench", code=2)
    assert "did you mean 'baud'" in sentence
    assert str(path) in sentence


def test_forced_simulation_turns_a_port_into_its_twin(call, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    port = ("--port", "/dev/ttyNOWHERE", "--dialect", "teachmover")
    homed = call("home", *port, code=0)
    assert "SIMULATED" in homed.out
    call("move", *port, "--x", "250", "--z", "120", code=0)
    seen = call("status", *port, "--json", code=0).json
    assert seen["simulated"] is True
    assert seen["pose"]["x_mm"] == pytest.approx(250, abs=0.5)
    assert call("status", "--json").json["trust"] == "unknown"  # another arm, another world


def test_forced_simulation_remembers_the_twin_apart_from_the_real_arm(call, monkeypatch):
    write_arm_file("bench", NOWHERE)
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    call("home", "--arm", "bench", code=0)
    assert arm_of(call("status", "--arm", "bench", "--json", code=0)) == "sim:bench"


@pytest.mark.parametrize(
    "words",
    [
        ("status", "--arm", ""),
        ("status", "--port", "", "--dialect", "robko01"),
        ("stop", "--arm", " "),
        ("doctor", ""),
        ("doctor", "--arm", ""),
        ("config", "show", ""),
        ("config", "signs", "", "--sim", "--yes"),
        ("can", "monitor", ""),
    ],
)
def test_an_unset_variable_names_no_arm_and_not_the_default_one(call, words):
    assert "the name is empty" in call.refused(*words, code=2)


@pytest.mark.parametrize(
    "words",
    [
        ("watch", "--port", "sim:", "--dialect", "robko01"),
        ("status", "--arm", "sim:"),
        ("config", "set-default", "sim:"),
    ],
)
def test_half_the_name_of_a_simulated_arm_is_refused_with_the_whole_one(call, words):
    assert "write sim:DIALECT, one of teachmover, robko01" in call.refused(*words, code=2)
