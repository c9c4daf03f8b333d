"""`armdrive record` and `armdrive replay`: from a fault on a pseudo-terminal to what it was."""

import sys
from pathlib import Path

import pytest
from recorder_bench import recorded_arm
from served import Served

from armdrive import Arm, ArmError
from armdrive.cli.chosen_arm import connect_remembered
from armdrive.connect.target import simulated_config
from armdrive.storage.files import recordings
from armdrive.storage.lock_client import ask_holder

sys.path.insert(0, str(Path(__file__).parents[4] / "benchmarks"))


@pytest.fixture
def recording(tmp_path):
    arm = recorded_arm()
    arm.move_motors(0, 0, 0, 0, 5, 0)
    file = arm.recorder.save(tmp_path / "recording.jsonl")
    arm.close()
    return str(file)


def test_a_replay_that_agrees_prints_the_timeline_and_ends_well(call, recording):
    out = call("replay", recording, code=0).out
    assert "call: move_motors 0, 0, 0, 0, 5, 0" in out
    assert r"-> @STEP" in out
    assert "step at speed" in out
    assert "no difference: " in out.splitlines()[-1]
    called = call("replay", recording, "--quiet", "--set", "speed_error=0.5", code=0)
    assert "the simulated arm took" in called.out
    assert "speed_error" in call.refused("replay", recording, "--set", "speed_eror=1", code=2)


def test_a_replay_that_differs_says_where_and_exits_with_1(call, tmp_path):
    arm = recorded_arm()
    arm.twin.faults.add("mute")
    with pytest.raises(ArmError):
        arm.move_motors(0, 0, 0, 0, 5, 0)
    parted = str(arm.recorder.save(tmp_path / "parted.jsonl"))
    arm.close()
    out = call("replay", parted, code=1).out
    assert out.count("they differ at") == 2  # in its place, and at the end
    assert "The simulated device's state: power on" in out
    view = call("replay", parted, "--json", code=1).json
    assert view["agree"] is False
    assert view["parting"]["twin_state"]["moving"] is False
    out = call("log", parted, code=0).out  # compares nothing
    assert "they differ" not in out
    assert "no answer to" in out
    shown = call("log", parted, "--json", code=0).json_lines
    assert len(shown) == view["entries"]
    assert any(each.get("words", "").startswith("step at speed") for each in shown)


def test_the_holder_of_an_arm_writes_on_request(call):
    with connect_remembered(simulated_config("teachmover")):
        (file,) = [each["recording"] for each in call("record", "--json", code=0).json_lines]
        assert Path(file).parent == recordings()
        assert call("replay", file, "--quiet", code=0)
        assert "path" not in ask_holder("sim:teachmover", "record")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_a_fault_on_a_real_port_leaves_a_file_whose_replay_shows_it(call, tmp_path):
    with Served("teachmover", pty=tmp_path / "arm") as sim:
        with Arm.connect(sim.port, dialect="teachmover") as arm:
            arm.reference.confirm()
            sim.tell("fault mute")
            with pytest.raises(ArmError):
                arm.jog_j(base_deg=2)
        (file,) = recordings().glob("*error-stop*")
    out = call("replay", str(file), code=1).out
    assert "they differ at" in out
    assert "the simulated device sent a message that the arm did not send" in out
    assert "no answer to `@" in out  # the move, or a look at the arm that came before it
