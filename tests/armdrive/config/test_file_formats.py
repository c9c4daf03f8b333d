"""Files that people keep say their format; in one that is not known, nothing is read or changed."""

import tomllib
from pathlib import Path

import pytest
from amounts import every_row
from cli_calls import write_arm_file
from faults import OVER_THE_TABLE

from armdrive.config.link_model import read_model
from armdrive.errors import ArmFileError, PointsFileError
from armdrive.registry.arm_files import load_arm
from armdrive.setup.filing import new_text
from armdrive.storage import files as places
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point, parse_points
from armdrive.text.toml import FORMAT
from armdrive.text.toml_amend import Change, amended
from armdrive.trace.files import texts_of
from kinematics import JOINT_NAMES, preset

ARM = preset("teachmover").arm
EXAMPLES = Path(__file__).parents[3] / "examples"

NEWER = f"format 2 is newer than this armdrive reads ({FORMAT}). Update armdrive."
KNOWN = ["", "format = 1\n", '"format" = 1\n', "format = 0x1\n"]
UNKNOWN = [
    ("format = 2", NEWER),
    ("format = 9223372036854775807", "format 9223372036854775807 is newer than"),
    ("format = 0", "format: expected the whole number 1, got 0"),
    ("format = true", "format: expected the whole number 1, got True"),
    ('format = "1"', "format: expected the whole number 1, got '1'"),
    ("format = 1.0", "format: expected the whole number 1, got 1.0"),
    ("format.new = 1", "format: expected the whole number 1, got {'new': 1}"),
    ("format = 2026-11-23", "format: expected the whole number 1, got datetime.date(2026, 11, 23)"),
]
LINKS = "[[links]]\na_mm = 10\n"
POINT = """\
[points.a]               # where the blocks wait
joints_deg = { base = 0, shoulder = 40, elbow = -80, wrist_pitch = -40, wrist_roll = 0 }
"""
FUTURE = 'model = 7\nlengths = "as measured"\npoints = 3\nlinks = 4\nwhatever = true\n'
"""Keys that no file of this format has: none of them is complained about where it is unknown."""


def points_at(path, here=None):
    path.parent.mkdir(parents=True, exist_ok=True)
    return points_of(path.stem, ARM) if here is None else points_of(path.stem, ARM, lambda: here)


def read_points(path):
    return parse_points(path.read_text(encoding="utf-8"), JOINT_NAMES)


KINDS = [
    pytest.param(load_arm, 'model = "teachmover"\n', ArmFileError, id="arm file"),
    pytest.param(read_model, LINKS, ArmFileError, id="model file"),
    pytest.param(read_points, POINT, PointsFileError, id="points"),
]


@pytest.mark.parametrize(("read", "rest", "_failure"), KINDS)
def test_a_file_of_this_format_is_read_and_one_that_does_not_say_is_such_a_file(
    tmp_path, read, rest, _failure
):
    path, found = tmp_path / "a.toml", []
    for line in KNOWN:
        path.write_text(line + rest, encoding="utf-8")
        found.append(read(path))
    assert found == [found[0]] * len(KNOWN)


@pytest.mark.parametrize(("read", "_right", "failure"), KINDS)
def test_an_unknown_format_is_one_sentence_and_nothing_else_is_read(
    tmp_path, read, _right, failure
):
    path = tmp_path / "a.toml"
    for line, sentence in UNKNOWN:
        path.write_text(f"{line}\n{FUTURE}", encoding="utf-8")
        with pytest.raises(failure) as refused:
            read(path)
        assert sentence in str(refused.value)
        assert "\n" not in str(refused.value)
        if failure is ArmFileError:
            assert str(refused.value).startswith(f"{path}: format")


# -- arm files and model files ----------------------------------------------------------------


def test_check_reports_an_unknown_format_alone(call):
    write_arm_file("bench", f"format = 2\n{FUTURE}")
    write_arm_file("fine", 'format = 1\nmodel = "teachmover"\n')
    write_arm_file("typo", 'fromat = 1\nmodel = "teachmover"\ntitel = "x"\n')
    said = call("config", "check", "bench", "--json", code=2).json
    assert said["arm"] == "bench"
    assert said["problems"] == [NEWER]
    assert call("config", "check", "fine", "--json", code=0).json["problems"] == []
    write_arm_file("table", f"format = 2\n{LINKS}")
    arms = call("config", "list", "--json", code=0).json["arms"]
    assert {each["name"] for each in arms if NEWER in each["error"]} == {"bench", "table"}
    problems = call("config", "check", "typo", "--json", code=2).json["problems"]
    assert ["format" in problems[0], "title" in problems[1]] == [True, True]


def test_a_file_of_an_unknown_format_is_not_edited():
    with pytest.raises(ArmFileError, match="Update armdrive"):
        amended('format = 2\nmodel = "teachmover"\n', [Change(("motor_signs", "elbow"), -1)])


def first_key(text):
    table = tomllib.loads(text)
    assert table["format"] == FORMAT
    return next(iter(table))


def test_every_text_of_an_arm_states_its_format_first(call):
    path = write_arm_file("bench", 'model = "teachmover"\n')
    config = load_arm(path)
    shown = call("config", "show", "bench", "--json", code=0).json["toml"]
    for text in (shown, texts_of(config)[0], new_text(config)):
        assert first_key(text) == "format"


@every_row("path", sorted(EXAMPLES.glob("*.toml")))
def test_the_examples_state_their_format(path):
    assert first_key(path.read_text(encoding="utf-8")) == "format"


# -- points -----------------------------------------------------------------------------------


HERE = Point(OVER_THE_TABLE, 20.0)


def test_no_call_writes_points_of_an_unknown_format():
    path = places.points_file("bench")
    book = points_at(path, HERE)
    book.teach("a")
    assert first_key(path.read_text(encoding="utf-8")) == "format"
    path.write_text(f"format = 2\n{FUTURE}", encoding="utf-8")
    before = path.read_bytes()
    for edit in (
        lambda: book.teach("b"),
        lambda: book.__setitem__("b", HERE),
        lambda: book.__delitem__("a"),
        lambda: book.put("b", HERE, instead_of=None),
        lambda: book.remove("a", instead_of=HERE),
        lambda: book.rename("a", "b"),
        lambda: book.put_all({"b": HERE}, again=True),
        book.clear,
    ):
        with pytest.raises(PointsFileError, match="Update armdrive"):
            edit()
        assert path.read_bytes() == before
    assert sorted(path.parent.iterdir()) == [path]
