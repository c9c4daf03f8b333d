"""Commands on the simulated arm: each goes on from where the one before it left the arm."""

import io
import json
import sys

import pytest
from cli_calls import Terminal, write_arm_file
from simulated_port import SimulatedPorts

import tui
from armdrive.cli.chosen_arm import world_file
from armdrive.cli.drive import jog
from armdrive.connect.target import state_file
from armdrive.registry import DIALECTS
from armdrive.status import Trust
from armdrive.storage import files as places

ARM = "sim:teachmover"


def edit(path, change):
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))


def test_home_then_move_then_status_continue_one_another(call):
    homed = call("home", "--json", code=0).json
    assert homed["trust"] == "referenced"
    assert homed["pose"]["z_mm"] == pytest.approx(0.0, abs=0.5)
    moved = call("move", "--x", "250", "--z", "120", "--pitch", "-90", "--json", code=0).json
    assert moved["pose"]["x_mm"] == pytest.approx(250, abs=0.5)
    seen = call("status", "--json", code=0).json
    assert seen["pose"] == moved["pose"]
    assert seen["trust"] == "restored"
    assert seen["simulated"] is True


def test_planned_motion_without_a_reference_is_refused_with_the_way_to_one(call):
    sentence = call.refused("move", "--x", "250", code=3)
    assert "`armdrive home`" in sentence
    assert call("status", "--json").json["trust"] == "unknown"


def test_fresh_forgets_the_world_and_the_reference(homed):
    homed("move", "--z", "80", code=0)
    fresh = homed("status", "--fresh", "--json", code=0).json
    assert fresh["trust"] == "unknown"
    assert fresh["acknowledged_steps"] == [0] * 6


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        (("--x", "900"), "out of reach"),
        (("--z", "-40"), "table"),
        (("--base", "120"), "base"),
        (("--gripper", "200"), "gripper"),
    ],
)
def test_a_goal_beyond_a_bound_is_refused_and_nothing_moves(homed, goal, said):
    before = homed("status", "--json").json
    called = homed("move", *goal, code=3)
    assert said in called.err
    assert called.err.count("\n") == 1
    assert homed("status", "--json").json["acknowledged_steps"] == before["acknowledged_steps"]
    previewed = homed("move", *goal, "--preview", code=3)
    assert previewed.err == called.err  # with its code
    assert called.err.partition("] ")[2].strip() not in previewed.out
    in_json = homed("move", *goal, "--preview", "--json", code=3)
    assert json.loads(in_json.err) == in_json.json["refusal"]


def test_home_yes_believes_the_person_and_moves_nothing(call):
    before = call("status", "--json").json["read_back_steps"]
    homed = call("home", "--yes", "--json", code=0).json
    assert homed["trust"] == "referenced"
    assert homed["pose"]["x_mm"] == pytest.approx(127, abs=0.5)
    world = json.loads(world_file(ARM).read_text())
    assert world["registers"] == before


def test_an_arm_that_was_pushed_meanwhile_is_not_believed(homed):
    def pushed(world):
        world["registers"][0] += 50

    def turned(world):
        world["world"]["motors"][0] += 400  # and no register knows

    edit(world_file(ARM), turned)  # the simulated operator sees that it is not as recorded
    sentence = homed.refused("move", "--z", "80", code=3)
    assert "restored" in sentence
    assert "--allow-restored" in sentence
    edit(world_file(ARM), pushed)
    assert homed("status", "--json").json["trust"] == "suspect"
    sentence = homed.refused("move", "--z", "80", code=3)
    assert "registers differ" in sentence
    assert "armdrive home" in sentence


def test_a_damaged_world_ends_in_a_sentence_with_the_way_out(homed):
    for text in ("", "{", "[]", '{"world": 1, "registers": []}', "\x00"):
        world_file(ARM).write_text(text)
        sentence = homed.refused("status", code=1)
        assert str(world_file(ARM)) in sentence
        assert "--fresh" in sentence
        homed("status", "--fresh", code=0)
        homed("status", code=0)


def test_a_damaged_record_costs_the_reference_and_home_mends_it(homed):
    state_file(ARM).write_text("{")
    seen = homed("status", "--json", code=0).json
    assert seen["trust"] == "unknown"
    assert str(state_file(ARM)) in seen["trust_reason"]
    homed("home", code=0)
    homed("move", "--z", "60", code=0)
    left = {path.name for path in places.states().iterdir()}  # nothing else stays behind
    name = places.file_name(ARM)
    assert left == {f"{name}.json", f"{name}.lock", f"{name}.world.json"}


@pytest.fixture(params=["teachmover", "armdroid"])
def served(request, monkeypatch):
    """Return the controller behind a port, one with registers and one without, with an arm file.

    The conformance table has every dialect restore a record; this is about the words.
    """
    row = DIALECTS[request.param]
    keys = f'dialect = "{row.name}"\nport = "/dev/ttyUSB0"\n'
    write_arm_file("bench", f'model = "{row.preset}"\n[connection]\n{keys}')
    return SimulatedPorts(monkeypatch).put("/dev/ttyUSB0", row.name).device


ASKED = "Does the arm stand like this?"


def test_the_next_command_goes_on_from_where_home_left_the_arm(call, served, monkeypatch):
    home = call("home", "--arm", "bench", "--yes", code=0).out
    assert "--allow-restored" in home
    resets = served.board.title == "Armdroid"  # a board may, whose port is opened without DTR kept
    assert ("keep_dtr_on_close = true" in home) is resets
    move = ("move", "--arm", "bench", "--base", "1", "--speed", "1")
    refused = call.refused(*move, code=3)
    assert "answer its question, or add `--allow-restored`" in refused
    assert "armdrive home" not in refused  # the next command would be refused again
    assert served.world.joints.deg["base"] == 0.0
    call(*move, "--allow-restored", code=0)
    assert served.world.joints.deg["base"] == pytest.approx(1.0, abs=0.2)
    monkeypatch.setattr(sys, "stdin", Terminal("yes\n"))
    move = ("move", "--arm", "bench", "--base", "2", "--speed", "1")
    assert ASKED in call(*move, code=0).out
    assert served.world.joints.deg["base"] == pytest.approx(2.0, abs=0.2)


def test_a_place_is_taught_only_once_the_arm_is_known_to_stand_there(call, served, monkeypatch):
    call("home", "--arm", "bench", "--yes", code=0)
    words = ("points", "save", "pick", "--arm", "bench")
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    assert "add `--allow-restored`" in call.refused(*words, code=3)
    monkeypatch.setattr(sys, "stdin", Terminal("no\n"))
    call(*words, code=3)
    assert "pick" not in call("points", "list", "--arm", "bench", code=0).out
    monkeypatch.setattr(sys, "stdin", Terminal("yes\n"))
    assert ASKED in call(*words, code=0).out


@pytest.mark.parametrize("served", ["armdroid"], indirect=True)  # its motors can be switched
def test_motors_stay_off_in_a_preview_and_until_the_person_has_confirmed(call, served, monkeypatch):
    bench = ("--arm", "bench")
    motions = (
        ("move", "--base", "1", "--speed", "1", *bench),
        ("points", "go", "reference", "--speed", "1", *bench),
    )
    call("home", *bench, "--yes", code=0)
    call("points", "save", "reference", "--allow-restored", *bench, code=0)
    call("move", "--base", "0.5", "--allow-restored", *bench, code=0)
    served.world.energised = False
    for words in motions:
        call(*words, "--preview", "--allow-restored", code=0)
        call(*words, code=3)  # nobody is there to confirm it
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    call("shell", *bench, code=0)
    looked = []
    monkeypatch.setattr(jog, "require_screen", lambda *_: None)
    monkeypatch.setattr(tui, "run_desk", lambda arm, **_: looked.append(arm) or 0)
    call("jog", *bench, code=0)
    assert looked[0].status.trust is Trust.RESTORED
    for words in motions:
        monkeypatch.setattr(sys, "stdin", Terminal("no\n"))
        assert ASKED not in call(*words, "--preview", code=3).out
        assert ASKED in call(*words, code=3).out
    assert not served.world.energised
    for words in motions:
        served.world.energised = False
        monkeypatch.setattr(sys, "stdin", Terminal("yes\n"))
        call(*words, code=0)
        assert served.world.energised
    served.world.energised = False
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    call("shell", *bench, "--allow-restored", code=0)
    assert served.world.energised, "the caller has settled it"
