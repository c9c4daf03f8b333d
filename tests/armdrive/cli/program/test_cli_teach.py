"""`armdrive teach`, `armdrive points` and `armdrive pendant`."""

import json
import sys
import threading

import pytest
from cli_calls import Terminal
from waiting import LONG_S

from armdrive.cli.chosen_arm import connect_remembered
from armdrive.cli.program import teach
from armdrive.connect.target import find, simulated_config
from armdrive.dialects.teachmover.pendant import FORMAT_LINE
from armdrive.programs.teaching import ProgramRecorder
from armdrive.storage import files as places
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point
from kinematics import Joints

UP, DOWN = Joints.of(20.0, 40.0, -80.0, -40.0, 0.0), Joints.of(20.0, 30.0, -85.0, -35.0, 0.0)


@pytest.fixture
def book():
    config = find("sim:teachmover").config
    points = points_of(config.name, config.model.arm)
    points["above"], points["pick"] = Point(UP, 40.0), Point(DOWN, 12.0)
    return points


@pytest.fixture
def tour(tmp_path, monkeypatch):
    """The program that is recorded, in the current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path / "tour.arm"


def test_a_held_arm_is_recorded_until_it_is_given_back(call, monkeypatch, tour):
    arm = connect_remembered(simulated_config("teachmover"), pace=10.0)
    arm.reference.confirm()
    watched = {base_deg: threading.Event() for base_deg in (0, 30, -10)}
    see = ProgramRecorder.see

    def seen(recorder, what, now_s):
        made = see(recorder, what, now_s)
        if what.joints is not None:
            watched[round(what.joints.deg["base"])].set()
        return made

    def drive():
        with arm:
            for base_deg, seen_there in watched.items():
                arm.move_j(base_deg=base_deg)
                assert seen_there.wait(LONG_S)

    monkeypatch.setattr(ProgramRecorder, "see", seen)
    driver = threading.Thread(target=drive)
    driver.start()
    lines = call("teach", "tour.arm", "--rest", "0", "--json", code=0).json_lines
    driver.join()
    assert [line["text"] for line in lines] == tour.read_text(encoding="utf-8").splitlines()
    assert [line["text"] for line in lines] == [
        "move tour_1", "close_now", "move tour_2", "move tour_3",
    ]  # fmt: skip
    call("run", "tour.arm", "--check", code=0)


@pytest.fixture
def views(monkeypatch, call):
    """What is seen of an arm, which the test says; the arm itself is not held by anybody."""
    call("home", code=0)
    view = json.loads(call("status", "--json", code=0).out)
    told = []
    config = simulated_config("teachmover")
    monkeypatch.setattr(teach, "one_holder", lambda _: config.name)
    monkeypatch.setattr(teach, "held_config", lambda *_: config)
    monkeypatch.setattr("armdrive.cli.program.teach.watch_holder", lambda *_: iter_views(told))
    return view, told


def iter_views(told):
    for each in told:
        if isinstance(each, BaseException):
            raise each
        yield each


def test_ctrl_c_ends_a_recording_and_keeps_it(call, views, tour):
    view, told = views
    told += [view, KeyboardInterrupt()]
    assert "1 point, in " in call("teach", "tour.arm", code=0).out
    assert tour.read_text(encoding="utf-8") == "move tour_1\nclose_now\n"


def test_a_name_that_is_taken_is_refused_before_anything_is_recorded(call, views, tour, book):
    view, told = views
    told += [view, AssertionError("it was recorded")]
    book["tour_2"] = Point(UP)
    assert "tour_2 already" in call.refused("teach", "tour.arm", code=2)
    assert "must end in .arm" in call.refused("teach", "tour", code=2)
    assert "is not a valid name" in call.refused("teach", "9.arm", code=2)
    tour.write_text("move above\n", encoding="utf-8")
    assert "exists already" in call.refused("teach", "tour.arm", code=2)
    told[:] = [view, KeyboardInterrupt()]
    call("teach", "tour.arm", "--force", code=0)
    assert tour.read_text(encoding="utf-8").startswith("move tour_1\n")


# `armdrive points`: naming, listing, going; each command goes on from the last one.


@pytest.fixture
def taught(call):
    """A simulated arm with two points."""
    call("home", code=0)
    call("move", "--x", "250", "--z", "120", "--pitch", "-90", code=0)
    call("points", "save", "above", "--note", "over the block", code=0)
    call("move", "--z", "60", "--line", code=0)
    call("points", "save", "pick", code=0)
    return call


def joints(call):
    return call("status", "--json", code=0).json["joints"]


def test_every_mistake_is_one_sentence(taught):
    assert "did you mean 'pick'" in taught.refused("points", "go", "pikc", code=2)
    assert "already" in taught.refused("points", "save", "pick", code=2)
    taught("points", "save", "pick", "--again", "--json", code=0)
    assert "is not a valid name" in taught.refused("points", "save", "a b", code=2)
    places.points_file("sim:teachmover").write_text("[points.a]\nknee = 3\n", encoding="utf-8")
    assert "unknown key 'knee'" in taught.refused("points", "list", "--json", code=2)


# `armdrive pendant`: a program out of the arm, into a file, and back.


ROWS = "move 1 240 100 -200 300 -400 500 -600\nraw 2 1 2 3 4 5 6 7\n"
WORDS = [[1, 3841, 14436, 28716, 43252, 65280, 65025, 64769], [2, 1, 2, 3, 4, 5, 6, 7]]


@pytest.fixture
def rows(tmp_path):
    path = tmp_path / "rows.pendant"
    path.write_text(f"{FORMAT_LINE}\n{ROWS}", encoding="utf-8")
    return path


def words(call):
    return [row["words"] for row in call("pendant", "show", "--json", code=0).json["rows"]]


def test_a_file_goes_into_the_arm_and_comes_out_the_same(call, rows, tmp_path):
    said = call("pendant", "write", str(rows), "--yes", code=0).out
    assert "2 rows are in the arm: 2 written" in said
    assert words(call) == WORDS
    out = tmp_path / "again.pendant"
    assert "2 rows are in" in call("pendant", "read", str(out), code=0).out
    call("pendant", "write", str(out), "--yes", code=0)
    assert words(call) == WORDS
    assert "raw     2" in call("pendant", "show", code=0).out


def test_writing_asks_first(call, rows, monkeypatch):
    for answer, code in (("no\n", 3), ("\n", 3), ("yes\n", 0)):
        monkeypatch.setattr(sys, "stdin", Terminal(answer))
        call("pendant", "write", str(rows), code=code)
        assert words(call) == (WORDS if code == 0 else [])


def test_a_file_that_cannot_be_used_is_named_with_its_line(call, tmp_path):
    path = tmp_path / "bad.pendant"
    assert "cannot be read" in call.refused("pendant", "write", str(path), code=2)
    path.write_text(f"{FORMAT_LINE}\nmove 1\n", encoding="utf-8")
    assert "line 2" in call.refused("pendant", "write", str(path), code=2)


def test_rows_of_a_homed_arm_say_where_they_lead(call, tmp_path):
    call("home", code=0)
    path = tmp_path / "home.pendant"
    path.write_text(f"{FORMAT_LINE}\nmove 1 140 0 0 0 0 0 0\n", encoding="utf-8")
    call("pendant", "write", str(path), "--yes", code=0)
    out = tmp_path / "out.pendant"
    call("pendant", "read", str(out), code=0)
    text = out.read_text(encoding="utf-8")
    assert "\norigin " in text
    assert "150 steps/s; base 0.0°" in text
