"""Which arm a command is about: options, the environment, the default arm file."""

import pytest
from chain_files import shown_files, six_arm, six_links
from cli_calls import Caller, write_bench

from armdrive.storage import files as places


def arm_of(called):
    return called.json["arm"]


def test_the_simulated_arm_is_chosen_by_dialect_by_name_and_by_no_name(call):
    for words in ((), ("--sim", "teachmover"), ("--arm", "sim:teachmover")):
        assert arm_of(call("status", *words, "--json", code=0)) == "sim:teachmover"


def test_an_arm_file_is_chosen_by_name_and_by_path(call, tmp_path):
    write_bench()
    assert "/dev/none" in call.refused("status", "--arm", "bench", code=4)
    path = tmp_path / "other.toml"
    path.write_text('model = "teachmover"\n')
    sentence = call.refused("status", "--arm", str(path), code=4)
    assert "other names no port" in sentence
    assert call.refused("status", "--arm", "benhc", code=2).endswith("did you mean 'bench'?")


def test_of_several_defaults_the_nearest_is_used_and_an_option_before_them_all(call, monkeypatch):
    call("config", "set-default", "sim:robko01", code=0)
    assert arm_of(call("status", "--json", code=0)) == "sim:robko01"
    monkeypatch.setenv("ARMDRIVE_ARM", "bench")
    assert "'bench'" in call.refused("status", code=2)
    write_bench()
    assert "/dev/none" in call.refused("status", code=4)
    assert "ARMDRIVE_ARM" in call("config", "set-default", "sim:grbl", code=0).out
    assert arm_of(call("status", "--sim", "teachmover", "--json", code=0)) == "sim:teachmover"
    monkeypatch.delenv("ARMDRIVE_ARM")
    none = call("config", "set-default", "--none", "--json", code=0).json
    assert none["default"] == "sim:teachmover"


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
    write_bench()
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    call("home", "--arm", "bench", code=0)
    assert arm_of(call("status", "--arm", "bench", "--json", code=0)) == "sim:bench"


# The command line with arms of model files, and a hand that has a heading.


@pytest.fixture
def on_models(capsys, tmp_path, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    folder = places.arm_files()
    folder.mkdir(parents=True)
    links, arm = shown_files()
    posture = "[reference]\nx_mm = 500\ny_mm = 100\nz_mm = 400\npitch_deg = -80\nyaw_deg = 15\n"
    for name, text in (
        ("minilinks", links),
        ("five", arm),
        ("six", six_links()),
        ("bench", six_arm() + posture),
    ):
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    return Caller(capsys)


def test_six_joints_take_a_yaw_and_keep_what_is_not_named(on_models):
    on_models("home", "--arm", "bench", code=0)
    moved = on_models("move", "--arm", "bench", "--yaw", "40", "--z", "450", "--json", code=0).json
    assert moved["pose"]["yaw_deg"] == pytest.approx(40, abs=0.3)
    assert moved["pose"]["pitch_deg"] == pytest.approx(-80, abs=0.2)
    assert moved["pose"]["x_mm"] == pytest.approx(500, abs=0.5)
    assert moved["gripper_mm"] is None
    assert "yaw 40" in on_models("status", "--arm", "bench", code=0).out
