"""`armdrive jog`: an arm whose link may be lost, and a model with no arm."""

import json

import pytest
from cli_calls import write_bench

import tui
from armdrive.cli import presenter
from armdrive.cli.chosen_arm import connect_remembered
from armdrive.cli.drive import jog
from armdrive.connect import parts
from armdrive.connect.target import find


@pytest.fixture
def _terminal(monkeypatch):
    """Have a terminal that can draw."""
    monkeypatch.setattr(presenter, "at_terminal", lambda: True)
    monkeypatch.setenv("TERM", "xterm-256color")


@pytest.fixture
def desk(monkeypatch, _terminal):
    """A desk that closes at once; returns its arguments."""
    shown = []

    def run_desk(arm, *, first, hint, **more):
        shown.append(arm)
        shown.append((first, hint))
        return 0

    monkeypatch.setattr(tui, "run_desk", run_desk)

    def connect(config, options):
        return parts.connect_simulated(config, reconnect=options.reconnect)

    monkeypatch.setattr(parts, "connect_real", connect)
    return shown


def test_the_desk_begins_where_it_is_asked_to_and_offers_the_set_up(call, desk, tmp_path):
    call("jog", code=0)
    assert desk[1][0] == ""
    assert "f5 sets up a real one" in desk[1][1].lower()
    call("jog", "--sim", "teachmover", "--setup", code=0)
    assert desk[3] == ("setup", "")
    write_bench()
    call("jog", code=0)
    assert desk[5] == ("", "")
    path = tmp_path / "stack.arm"
    path.write_text("home\n")
    call("jog", "--sim", "teachmover", "--program", str(path), code=0)
    assert desk[7][0] == "program"


@pytest.fixture
def watched(monkeypatch, _terminal):
    """The names of the arms that are watched; watching ends at once."""
    names = []

    def run_watch(name, model, *, ascii_only):
        names.append(name)
        return 0

    monkeypatch.setattr(tui, "run_watch", run_watch)
    return names


PORT = find("/dev/x", dialect_name="robko01").config
BY_PORT = ("--port", "/dev/x", "--dialect", "robko01")


@pytest.mark.parametrize(
    ("config", "words"),
    [
        (find("sim:teachmover").config, ("jog", "--sim", "teachmover")),
        (PORT, ("jog", *BY_PORT)),
        (PORT, ("watch", "--screen", *BY_PORT)),
        (PORT, ("watch", "--screen")),
    ],
)
def test_an_arm_that_another_program_holds_is_watched(call, watched, config, words):
    with connect_remembered(config):
        said = call(*words, code=0).out
    assert watched == [config.name]
    assert ("was watched, not driven" in said) == (words[0] == "jog")


@pytest.mark.parametrize("words", [("--sim", "teachmover"), ("--model", "puma")])
def test_no_desk_is_opened_where_the_framework_would_draw_nothing(call, desk, monkeypatch, words):
    for kind in ("dumb", "unknown", "Dumb"):
        monkeypatch.setenv("TERM", kind)
        said = call("jog", *words, code=2).err
        assert f"TERM={kind}" in said
        assert "TERM=xterm-256color armdrive" in said
    assert desk == []


def test_the_keys_are_listed_without_opening_anything(call, desk):
    listed = call("jog", "--show-keys", "--keys", "azerty", "--json", code=0).out
    rows = {row["id"]: row for row in json.loads(listed)["keys"]}
    assert rows["axis-1"]["keys"] == ["q", "a"]
    assert rows["stop"]["keys"][0] == "space"
    assert "space" in call("jog", "--show-keys", code=0).out
    assert desk == []


def test_a_file_that_cannot_be_used_is_refused_before_anything_is_opened(call, desk):
    for words, said in (
        (["--program", "nowhere.arm"], "nowhere.arm"),
        (["--program", "stack.py"], "`armdrive run` runs scripts"),
        (["--keys", "azery"], "'azery'"),
    ):
        assert said in call("jog", *words, code=2).err
    assert desk == []


# A model with no arm.


@pytest.mark.usefixtures("_terminal")
def test_a_model_is_shown_and_no_arm_is_opened(call, monkeypatch):
    opened = []

    def run_model(subject, *, ascii_only, keys):
        opened.append((subject.name, ascii_only))
        return 0

    monkeypatch.setattr(jog, "run_model", run_model)
    monkeypatch.setattr(jog, "connect_chosen", None)
    call("jog", "--model", "puma", "--ascii", code=0)
    assert opened == [("puma", True)]
