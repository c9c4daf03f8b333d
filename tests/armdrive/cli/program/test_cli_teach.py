"""`armdrive teach`, and the shaping actions of `armdrive points`."""

import json
import sys
import threading

import pytest
from cli_calls import Terminal, write_arm_file, write_bench
from waiting import LONG_S

from armdrive.cli.chosen_arm import connect_remembered
from armdrive.cli.program import teach
from armdrive.connect.target import find, simulated_config
from armdrive.dialects.teachmover.pendant import FIRST_LINE
from armdrive.errors import ArmError
from armdrive.motion import device as program_memory
from armdrive.programs.teaching.sequence import StepRecorder
from armdrive.status import status_view
from armdrive.storage import files as places
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point, Step, StepList
from kinematics import Joints

UP, DOWN = Joints.of(20.0, 40.0, -80.0, -40.0, 0.0), Joints.of(20.0, 30.0, -85.0, -35.0, 0.0)


@pytest.fixture
def book():
    config = find("sim:teachmover").config
    points = points_of(config.name, config.model.arm)
    points["above"], points["pick"] = Point(UP, 40.0), Point(DOWN, 12.0)
    steps = StepList((Step("above"), Step(gripper="open"), Step("pick", "line", 0.3)))
    points.put_sequence("fetch", steps, instead_of=None)
    return points


def shown(call, name="fetch"):
    return call("points", "show", name, "--json", code=0).json["steps"]


def test_steps_are_added_inserted_moved_retimed_and_removed(call, book):
    call("teach", "add", "fetch", "gripper", "grasp", code=0)
    call("teach", "insert", "fetch", "2", "delay", "0.5", code=0)
    assert shown(call) == [
        "to above", "delay 0.5 s", "gripper open", "to pick along a line at 30%", "gripper grasp",
    ]  # fmt: skip
    call("teach", "move", "fetch", "2", "5", code=0)
    said = call("teach", "retime", "fetch", "--factor", "2", "--wait", "1", code=0).out
    assert "note: step 1 goes at 100%, not at 200%" in said
    call("teach", "remove", "fetch", "2", "3", code=0)
    assert shown(call) == ["to above", "gripper grasp", "delay 1 s"]


def test_a_new_sequence_begins_with_its_first_step(call, book):
    printed = call("teach", "add", "tour", "to above line at 20%", "--json", code=0).json
    assert printed["steps"] == ["to above along a line at 20%"]
    assert shown(call, "tour") == ["to above along a line at 20%"]


@pytest.mark.parametrize(
    ("line", "code", "sentence"),
    [
        ("teach add fetch fly home", 2, "is not a step"),
        ("teach add fetch to nowhere", 2, "which does not exist"),
        ("teach add fetch gripper 900", 3, "opens from 0 to 76"),
        ("teach insert fetch 1 gripper 900", 3, "opens from 0 to 76"),
        ("teach insert fetch 9 to above", 2, "no place 9"),
        ("teach remove nothing 1", 2, "no sequence 'nothing'"),
        ("teach move fetch 1 7", 2, "no place 7"),
        ("teach reverse fetch fetch", 2, "is new in the file"),
        ("points offset fetch far --x 900", 3, "the point 'above' cannot go there"),
    ],
)
def test_an_impossible_edit_is_refused_and_nothing_is_written(call, book, line, code, sentence):
    before = book.path.read_text(encoding="utf-8")
    assert sentence in call.refused(*line.split(), code=code)
    assert book.path.read_text(encoding="utf-8") == before


def test_the_way_back_stands_under_a_new_name_and_tells_what_it_left_out(call, book):
    said = call("teach", "reverse", "fetch", "back", code=0).out
    assert "note: step 2 (gripper open) is left out" in said
    assert shown(call, "back") == ["to pick at 30%", "to above along a line at 30%"]


def test_the_place_where_the_arm_stands_becomes_the_next_step(call):
    call("home", code=0)
    call("teach", "here", "tour", code=0)
    call("move", "--z", "60", code=0)
    call("teach", "here", "tour", "--line", "--speed", "0.5", code=0)
    assert shown(call, "tour") == ["to tour-1", "to tour-2 along a line at 50%"]


def test_a_sequence_is_mirrored_offset_and_copied(call, book):
    call("points", "mirror", "fetch", "left", code=0)
    assert book["left-pick"].joints.deg["base"] == pytest.approx(-20.0, abs=1e-3)
    call("points", "offset", "pick", "pick2", "--x", "10", "--turn", "5", code=0)
    arm = find("sim:teachmover").config.model.arm
    assert arm.fk(book["pick2"].joints).z_mm == pytest.approx(arm.fk(DOWN).z_mm, abs=0.01)
    call("points", "copy", "fetch", "again", code=0)
    assert shown(call, "again")[0] == "to again-above"
    assert "already" in call.refused("points", "copy", "fetch", "again", code=2)
    call("points", "copy", "fetch", "again", "--again", code=0)


def test_a_held_arm_is_recorded_until_it_is_given_back(call, monkeypatch):
    arm = connect_remembered(simulated_config("teachmover"), pace=10.0)
    arm.reference.confirm()
    watched = {base_deg: threading.Event() for base_deg in (0, 30, -10)}
    see = StepRecorder.see

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

    monkeypatch.setattr(StepRecorder, "see", seen)
    driver = threading.Thread(target=drive)
    driver.start()
    lines = call("teach", "follow", "tour", "--rest", "0", "--json", code=0).json_lines
    driver.join()
    assert [line["text"] for line in lines] == shown(call, "tour")
    assert shown(call, "tour") == ["to tour-1", "gripper 0 mm", "to tour-2", "to tour-3"]


@pytest.fixture
def views(monkeypatch, call):
    """What is seen of an arm, which the test says; the arm itself is not held by anybody."""
    call("home", code=0)
    view = json.loads(call("status", "--json", code=0).out)
    told = []
    monkeypatch.setattr(teach, "one_holder", lambda _: "sim:teachmover")
    monkeypatch.setattr("armdrive.cli.program.teach.watch_holder", lambda *_: iter_views(told))
    return view, told


def iter_views(told):
    for each in told:
        if isinstance(each, BaseException):
            raise each
        yield each


def test_ctrl_c_ends_a_recording_and_keeps_it(call, views):
    view, told = views
    told += [view, KeyboardInterrupt()]
    said = call("teach", "follow", "tour", code=0).out
    assert "tour: 2 steps over 1 point," in said
    assert shown(call, "tour") == ["to tour-1", "gripper 0 mm"]


def test_steps_recorded_before_the_position_was_lost_are_kept(call, views):
    view, told = views
    told += [view, view | {"trust": "suspect", "trust_reason": "moved by the pendant"}]
    said = call("teach", "follow", "tour", code=3)
    assert "moved by the pendant" in said.err
    assert len(shown(call, "tour")) == 2


def test_a_holder_that_falls_silent_at_once_leaves_nothing(call, views):
    _, told = views
    told.append(ArmError("it does not answer"))
    assert "it does not answer" in call.refused("teach", "follow", "tour", "--json", code=1)


def test_a_name_that_is_taken_is_refused_before_anything_is_recorded(call, views, book):
    view, told = views
    told += [view, AssertionError("it was recorded")]
    assert "fetch already" in call.refused("teach", "follow", "fetch", code=2)


def test_the_status_of_an_arm_is_what_a_recording_reads():
    with connect_remembered(simulated_config("teachmover")) as arm:
        arm.reference.confirm()
        assert {"state", "trust", "joints", "gripper_mm", "gripping"} <= status_view(
            arm.status
        ).keys()


def test_a_sequence_repeats_as_often_as_requested(call, book):
    call("home", code=0)
    said = call("points", "run", "fetch", "--times", "3", code=0).out
    assert said.count("to above") == 3
    assert "above 0" in call("points", "run", "fetch", "--times", "0", code=2).err


# `armdrive points`: naming, listing, going, running; each command goes on from the last one.


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


def test_points_are_listed_shown_and_gone_to(taught):
    listed = taught("points", "list", code=0).out
    assert str(places.points_file("sim:teachmover")) in listed
    assert "over the block" in listed
    view = taught("points", "list", "--json", code=0).json
    assert list(view["points"]) == ["above", "pick"]
    shown = taught("points", "show", "above", code=0).out
    assert "tip x 250." in shown
    assert taught("points", "show", "pick", "--json", code=0).json["pose"]["z_mm"] == pytest.approx(
        60, abs=0.5
    )
    before = joints(taught)
    preview = taught("points", "go", "above", "--line", "--preview", code=0).out
    assert "-> base front, elbow up" in preview
    assert joints(taught) == before
    gone = taught("points", "go", "above", "--line", "--speed", "0.5", "--json", code=0).json
    assert gone["pose"]["z_mm"] == pytest.approx(120, abs=0.5)


def test_points_are_renamed_and_deleted(taught):
    taught("points", "rename", "pick", "grip", code=0)
    assert list(taught("points", "list", "--json", code=0).json["points"]) == ["above", "grip"]
    assert taught("points", "delete", "grip", "--json", code=0).json["done"]
    assert "grip" not in taught("points", "list", code=0).out


def test_a_sequence_that_a_person_wrote_is_shown_and_run(taught):
    path = places.points_file("sim:teachmover")
    path.write_text(
        path.read_text(encoding="utf-8")
        + '[sequences.lift]\nsteps = [{ point = "above" }, { wait_s = 0.1 }, { point = "pick", how = "line" }]\n',  # noqa: E501
        encoding="utf-8",
    )
    assert "3 steps" in taught("points", "list", code=0).out
    assert "along a line" in taught("points", "show", "lift", code=0).out
    assert taught("points", "show", "lift", "--json", code=0).json["steps"][1] == "delay 0.1 s"
    ran = taught("points", "run", "lift", code=0).out
    assert "  3  to pick along a line" in ran
    assert "used by lift" in taught.refused("points", "delete", "pick", code=2)
    taught("points", "rename", "pick", "grip", code=0)
    assert taught("points", "run", "lift", "--json", code=0).json["pose"]["z_mm"] < 61
    taught("points", "delete", "lift", code=0)
    assert "lift" not in taught("points", "list", code=0).out


def test_every_mistake_is_one_sentence(taught):
    assert "did you mean 'pick'" in taught.refused("points", "go", "pikc", code=2)
    assert "already" in taught.refused("points", "save", "pick", code=2)
    taught("points", "save", "pick", "--again", "--json", code=0)
    assert "is not a valid name" in taught.refused("points", "save", "a b", code=2)
    assert "no sequence" in taught.refused("points", "run", "pick", code=2)
    places.points_file("sim:teachmover").write_text("[points.a]\nknee = 3\n", encoding="utf-8")
    assert "unknown key 'knee'" in taught.refused("points", "list", "--json", code=2)


@pytest.mark.parametrize(
    "words",
    ["points save 9a", "points go nowhere", "points run nowhere", "teach here 9a",
     "teach here tour --point 9a"],
)  # fmt: skip
def test_a_wrong_name_is_refused_before_the_arm_is_opened(call, words):
    write_bench()  # whose port is not there
    call.refused(*words.split(), "--arm", "bench", code=2)


def test_no_points_say_how_one_is_made_and_need_no_port(call):
    write_arm_file(
        "bench", 'model = "teachmover"\n[connection]\ndialect = "teachmover"\nport = "/dev/none"\n'
    )
    assert "points save NAME" in call("points", "list", "--arm", "bench", code=0).out
    assert not places.points_file("bench").exists()


# `armdrive pendant`: a program out of the arm, into a file, and back.


ROWS = "move 1 240 100 -200 300 -400 500 -600\nraw 2 1 2 3 4 5 6 7\n"
WORDS = [[1, 3841, 14436, 28716, 43252, 65280, 65025, 64769], [2, 1, 2, 3, 4, 5, 6, 7]]


@pytest.fixture
def rows(tmp_path):
    path = tmp_path / "rows.pendant"
    path.write_text(f"{FIRST_LINE}\n{ROWS}", encoding="utf-8")
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


@pytest.mark.parametrize(("answer", "code"), [("no\n", 3), ("\n", 3), ("yes\n", 0)])
def test_writing_asks_first(call, rows, monkeypatch, answer, code):
    monkeypatch.setattr(sys, "stdin", Terminal(answer))
    call("pendant", "write", str(rows), code=code)
    assert words(call) == (WORDS if code == 0 else [])


def test_without_a_person_to_ask_the_answer_is_no(call, rows):
    assert "--yes" in call.refused("pendant", "write", str(rows), "--json", code=3)
    assert words(call) == []


def test_a_file_that_cannot_be_used_is_named_with_its_line(call, tmp_path):
    path = tmp_path / "bad.pendant"
    assert "cannot be read" in call.refused("pendant", "write", str(path), code=2)
    path.write_text(f"{FIRST_LINE}\nmove 1\n", encoding="utf-8")
    assert "line 2" in call.refused("pendant", "write", str(path), code=2)


def test_a_program_of_a_homed_arm_becomes_points_that_can_be_gone_to(call, tmp_path):
    call("home", code=0)
    path = tmp_path / "home.pendant"
    path.write_text(f"{FIRST_LINE}\nmove 1 140 0 0 0 0 0 0\n", encoding="utf-8")
    call("pendant", "write", str(path), "--yes", code=0)
    out = tmp_path / "out.pendant"
    call("pendant", "read", str(out), code=0)
    text = out.read_text(encoding="utf-8")
    assert "\norigin " in text
    assert "150 steps/s; base 0.0°" in text
    call("pendant", "points", str(out), "there", code=0)
    assert "there is there-1, there already" in call.refused(
        "pendant", "points", str(out), "there", code=2
    )
    call("pendant", "points", str(out), "there", "--again", code=0)
    assert "to there-1 at 32%" in call("points", "show", "there", code=0).out


def test_rows_without_an_origin_become_no_points(call, rows):
    assert "origin is unknown" in call.refused("pendant", "points", str(rows), "there", code=3)


def test_ctrl_c_in_the_middle_of_writing_names_the_rows(call, rows, monkeypatch):
    write_row = program_memory._write_row

    def interrupted(context, row):
        if row[0] == 2:
            raise KeyboardInterrupt
        yield from write_row(context, row)

    monkeypatch.setattr(program_memory, "_write_row", interrupted)
    said = call("pendant", "write", str(rows), "--yes", code=130)
    assert "row 1 new in the arm; the next one perhaps" in said.err


def test_an_unknown_position_is_reported_before_writing(call, rows, monkeypatch):
    text = rows.read_text(encoding="utf-8").replace("move", "origin 1 2 3 4 5 6\nmove")
    rows.write_text(text, encoding="utf-8")
    assert "This arm was not homed" in call("pendant", "write", str(rows), code=3).out
    call("home", code=0)
    assert "count from elsewhere" in call.refused(
        "pendant", "write", str(rows), "--yes", "--json", code=3
    )
    call("pendant", "write", str(rows), "--yes", "--as-is", code=0)
    assert words(call) == WORDS
