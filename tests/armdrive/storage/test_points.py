"""Named points: people and programs share the file, and no change is lost."""

import math
import re
import tomllib
from dataclasses import replace
from datetime import datetime

import pytest
from amounts import every_row
from chain_files import connected, five_joints
from faults import OVER_THE_TABLE, ready_arm, sim_arm, sim_config
from hypothesis import given
from hypothesis import strategies as st
from pages import page_path

from armdrive.errors import (
    BadRequest,
    NotReferenced,
    OutOfBounds,
    PointsChanged,
    PointsFileError,
    Refused,
    UnknownPoint,
)
from armdrive.storage import files as places
from armdrive.storage.files import StateFiles
from armdrive.storage.point_file import Points, PointWriter, points_of, rounded
from armdrive.storage.points import POINT_KEYS, Point, parse_points
from kinematics import JOINT_NAMES, Joints, preset

ARM = preset("teachmover").arm
HERE = Point(OVER_THE_TABLE, 20.0, "", datetime(2026, 11, 22, 10, 30))
THERE = Point(Joints.of(30.0, 50.0, -80.0, -40.0, 10.0), 5.0, "above the block")


@pytest.fixture
def book(tmp_path):
    return a_book(tmp_path / "points" / "bench.toml")


def a_book(path, **more):
    return Points(path, "bench", JOINT_NAMES, ARM.fk, lambda: HERE, **more)


@pytest.fixture
def arm():
    return ready_arm(sim_config(planned_burst_s=2.0))


# -- as a mapping -----------------------------------------------------------------------------


def test_points_behave_like_a_mapping_and_are_read_from_the_file_each_time(book):
    assert not book
    book["pick"] = THERE
    book["place"] = HERE
    other = a_book(book.path)
    assert list(other) == ["pick", "place"]
    assert other["pick"] == rounded({"pick": THERE})["pick"]
    assert "pick" in other
    assert other.get("nowhere") is None
    del other["pick"]
    assert list(book) == ["place"]


def test_a_name_that_is_not_there_suggests_one(book):
    book["pick"] = THERE
    with pytest.raises(UnknownPoint, match=r"no point 'pik'.*did you mean 'pick'") as missed:
        book["pik"]
    assert isinstance(missed.value, KeyError)
    del book["pick"]
    with pytest.raises(UnknownPoint, match="no point has been saved yet"):
        book["pick"]


@pytest.mark.parametrize("name", ["", "2nd", "a b", "a.b", "ä", "a" * 41, "a\n"])
def test_an_invalid_name_is_refused(book, name):
    with pytest.raises(BadRequest, match="is not a valid name"):
        book[name] = THERE
    with pytest.raises(BadRequest):
        book.teach(name)
    assert not book.path.exists()


def test_a_point_that_could_not_be_read_again_leaves_the_file_as_it_is(book, monkeypatch):
    monkeypatch.setattr("armdrive.storage.point_file.LARGEST_BYTES", 4000)
    book["pick"] = THERE
    before = book.path.read_bytes()
    of_another_arm = replace(THERE, joints=replace(THERE.joints, names=tuple("abcde")))
    with pytest.raises(BadRequest, match=r"needs the joints base, shoulder, .*, not a, b, c, d, e"):
        book["place"] = of_another_arm
    with pytest.raises(BadRequest, match="more than 4000 bytes: not written"):
        book["place"] = replace(THERE, note="x" * 4000)
    assert book.path.read_bytes() == before


def test_a_point_is_kept_with_its_joints_in_the_arm_s_order(book):
    there = THERE.joints
    book["pick"] = replace(THERE, joints=Joints(there.angles_rad[::-1], there.names[::-1]))
    assert book["pick"].joints.names == there.names
    assert book["pick"].joints.deg == pytest.approx(there.deg, abs=0.01)


def test_teaching_names_the_present_place_and_moves_a_point_only_on_request(book):
    assert book.teach("pick", note="first") == replace(HERE, note="first")
    with pytest.raises(BadRequest, match="already"):
        book.teach("pick")
    assert book.teach("pick", again=True).note == "first"
    assert book.teach("pick", again=True, note="second").note == "second"


# -- what a file may hold ---------------------------------------------------------------------


def joints_line(angle=0):
    return f"joints_deg = {{ base = {angle}, shoulder = 40, elbow = -80, wrist_pitch = -40, wrist_roll = 0 }}"  # noqa: E501


WRONG = [
    ("[points.a]\njoints_deg = 3\n", "points.a.joints_deg"),
    (f"[point.a]\n{joints_line()}\n", "did you mean 'points'"),
    (f"[points.a]\n{joints_line()}\ngriper_mm = 3\n", "did you mean 'gripper_mm'"),
    ("[points.a]\njoints_deg = { base = 3 }\n", "missing shoulder, elbow"),
    (f"[points.a]\n{joints_line('nan')}\n", "finite"),
    (f"[points.a]\n{joints_line()}\nknee = 3\n", "unknown key 'knee'"),
    (f"[points.a]\n{joints_line().replace('base', 'bse')}\n", "did you mean 'base'"),
    (f"[points.a]\n{joints_line()}\ngripper_mm = inf\n", "finite"),
    (f'[points.a]\n{joints_line()}\ntaught = "today"\n', "a date and a time"),
    (f"[points.a]\n{joints_line()}\nnote = 3\n", "must be text"),
    (f'[points."a b"]\n{joints_line()}\n', "is not a valid name"),
    ("[points\n", "line 1"),
    ("a = " + "[" * 3000, ""),
]  # fmt: skip


@pytest.mark.parametrize(("text", "words"), WRONG)
def test_a_file_that_makes_no_sense_says_where_and_stays_as_it_is(book, text, words):
    book.path.parent.mkdir(parents=True)
    book.path.write_text(text, encoding="utf-8")
    with pytest.raises(PointsFileError) as wrong:
        book["a"]
    assert words in str(wrong.value)
    assert str(book.path) in str(wrong.value)
    with pytest.raises(PointsFileError):
        book["new"] = THERE
    assert book.path.read_text(encoding="utf-8") == text


def test_a_binary_file_or_a_folder_in_its_place_is_reported(book):
    book.path.parent.mkdir(parents=True)
    book.path.write_bytes(b"\xff\xfe")
    with pytest.raises(PointsFileError, match="utf-8"):
        book.read()
    book.path.unlink()
    book.path.mkdir()
    with pytest.raises(PointsFileError, match="cannot be read"):
        book.read()


# -- by hand and by program -------------------------------------------------------------------

BY_HAND = f"""\
# my own heading

[points.old] # mine
{joints_line(1.23456789)}

# where blocks come from
[points.pick]
{joints_line()}   # checked on Monday
note = "x"

[points.last]   # the demo
{joints_line(5)}   # slowly
"""


def write(book, text):
    book.path.parent.mkdir(parents=True, exist_ok=True)
    book.path.write_text(text, encoding="utf-8")


def test_a_change_leaves_every_other_line_as_a_person_wrote_it(book):
    write(book, BY_HAND)
    book["new"] = HERE
    text = book.path.read_text(encoding="utf-8")
    assert text.startswith(BY_HAND)
    book["pick"] = replace(HERE, note="y")
    text = book.path.read_text(encoding="utf-8")
    assert "# where blocks come from\n[points.pick]" in text
    assert "checked on Monday" not in text
    for line in ("# my own heading", "[points.old] # mine", joints_line(1.23456789), "# slowly"):
        assert line in text
    del book["old"]
    assert "1.23456789" not in book.path.read_text(encoding="utf-8")
    assert list(book) == ["pick", "last", "new"]


def test_a_point_is_renamed_unless_the_name_is_taken(book):
    write(book, BY_HAND)
    before = book["pick"]
    book.rename("pick", "grip")
    assert book["grip"] == before
    assert set(book) == {"old", "grip", "last"}
    with pytest.raises(BadRequest, match="already"):
        book.rename("grip", "old")
    with pytest.raises(UnknownPoint):
        book.rename("pick", "other")


def test_points_written_in_one_line_are_edited_too(book):
    inline = f"points.pick = {{ {joints_line()} }}  # mine\n"
    write(book, inline)
    book["new"] = HERE
    assert inline in book.path.read_text(encoding="utf-8")
    book["pick"] = HERE
    assert book["pick"].taught == HERE.taught
    assert list(book) == ["pick", "new"]


def test_a_change_by_another_program_is_not_overwritten(book):
    book["pick"] = THERE
    shown = book["pick"]
    a_book(book.path)["pick"] = HERE
    with pytest.raises(PointsChanged, match="'pick' was changed"):
        book.put("pick", THERE, instead_of=shown)
    with pytest.raises(PointsChanged):
        book.remove("pick", instead_of=shown)
    with pytest.raises(PointsChanged, match="is new"):
        book.put("pick", THERE, instead_of=None)
    del a_book(book.path)["pick"]
    with pytest.raises(PointsChanged, match="has gone"):
        book.put("pick", THERE, instead_of=shown)
    assert not book


class Meddler(StateFiles):
    """A disk on which another program writes the file just before it is replaced."""

    def __init__(self, path, times, number=0):
        self.path, self.times, self.number = path, times, number

    def sync(self, handle):
        if self.times > 0:
            self.times -= 1
            self.number += 1
            a_book(self.path)[f"other{self.number}"] = THERE


def test_a_file_that_changes_while_it_is_written_loses_nothing(tmp_path):
    path = tmp_path / "bench.toml"
    book = a_book(path, files=Meddler(path, 2))
    book["mine"] = HERE
    assert set(book) == {"mine", "other1", "other2"}
    busy = a_book(path, files=Meddler(path, 1000, number=10))
    with pytest.raises(PointsChanged, match="being written"):
        busy["late"] = HERE
    assert "late" not in book


class FullDisk(StateFiles):
    def write(self, handle, data):
        raise OSError(28, "No space left on device")


def test_a_full_disk_leaves_the_old_file(tmp_path):
    path = tmp_path / "bench.toml"
    a_book(path)["pick"] = THERE
    before = path.read_bytes()
    with pytest.raises(PointsFileError, match="No space left"):
        a_book(path, files=FullDisk())["place"] = HERE
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_to_a_shared_file_stays_a_link(tmp_path):
    shared = tmp_path / "shared.toml"
    a_book(shared)["pick"] = THERE
    link = tmp_path / "bench.toml"
    link.symlink_to(shared)
    a_book(link)["place"] = HERE
    assert link.is_symlink()
    assert set(a_book(shared)) == {"pick", "place"}


# -- laws -------------------------------------------------------------------------------------

NAMES = st.sampled_from(["a", "b-c", "Pick", "x_1", "points", "steps"])
ANGLES = st.floats(-400.0, 400.0)
POINTS = st.builds(
    lambda angles, opening, note, day: Point(Joints.of(*angles), opening, note, day),
    st.tuples(*[ANGLES] * 5),
    st.none() | st.floats(0.0, 100.0),
    st.text(max_size=12),
    st.none() | st.datetimes(datetime(1990, 1, 1), datetime(2100, 1, 1)),
)
TAUGHT = st.dictionaries(NAMES, POINTS, min_size=1, max_size=5)
WRITER = PointWriter("bench", ARM.fk)


@given(TAUGHT)
def test_written_points_read_back_the_same(taught):
    text = WRITER.document(taught)
    tomllib.loads(text)
    assert rounded(parse_points(text, JOINT_NAMES)) == rounded(taught)


@given(TAUGHT, TAUGHT)
def test_every_change_of_our_own_layout_is_made_in_place(before, after):
    text = WRITER.edited(WRITER.document(before), rounded(before), rounded(after))
    assert text is not None
    assert rounded(parse_points(text, JOINT_NAMES)) == rounded(after)
    assert WRITER.edited(text, rounded(after), rounded(after)) == text


@every_row("sign", ["\x85", "\u2028", "\u2029", "\x1c", "\r\n", "\x0b", "\n[points.b]\n"])
def test_a_note_with_signs_that_part_lines_is_kept(sign):
    taught = {"a": replace(THERE, note=f"one{sign}two"), "b": THERE}
    text = WRITER.document(taught)
    assert WRITER.edited(text, rounded(taught), rounded(taught)) == text


# -- going to points --------------------------------------------------------------------------


def test_a_point_is_gone_back_to_on_the_very_steps_it_was_taught_on(arm):
    arm.move_j(base_deg=23.456, elbow_deg=-71.3)
    taught = arm.status.acknowledged
    arm.points.teach("pick")
    arm.move_j(base_deg=-40, shoulder_deg=60)
    arm.move_to("pick", speed=0.5)
    assert arm.status.acknowledged == taught
    assert arm.twin.world.motors == taught


def test_a_line_to_a_point_ends_in_its_pose_and_notes_another_posture(arm):
    arm.points.teach("start")
    arm.move_j(base_deg=20)
    moved = arm.move_l("start")
    assert moved.note == ""
    assert math.dist(arm.twin.world.tip, ARM.points(OVER_THE_TABLE)[-1]) < 1.0
    turned = arm.points["start"].joints
    arm.points["over"] = Point(turned.replace(wrist_roll=turned[4] + math.tau))
    arm.move_j(base_deg=20)
    assert "posture" in arm.move_l("over").note


GOING = {
    "move_j": lambda arm, joints: arm.move_j(joints),
    "move_j, one joint changed": lambda arm, joints: arm.move_j(
        joints.replace(base_deg=50), base_deg=joints.base_deg
    ),
    "move_to": lambda arm, joints: arm.move_to(joints),
    "move_l": lambda arm, joints: arm.move_l(joints),
    "move_to a point": lambda arm, joints: arm.move_to(Point(joints)),
}


@pytest.mark.parametrize("way", GOING)
def test_an_arm_goes_back_to_joint_angles_that_it_had(arm, way):
    before, steps = arm.joints, arm.status.acknowledged
    arm.move_j(base_deg=20)
    GOING[way](arm, before)
    assert arm.status.acknowledged == steps


def test_a_point_that_a_person_edited_beyond_a_limit_is_audited(arm):
    arm.points["far"] = Point(Joints.of(0.0, 300.0, -80.0, -40.0, 0.0))
    before = arm.status.acknowledged
    with pytest.raises(OutOfBounds, match="shoulder"):
        arm.move_to("far")
    assert arm.status.acknowledged == before


def test_an_unknown_position_cannot_be_taught():
    arm = sim_arm()
    with pytest.raises(NotReferenced):
        arm.points.teach("pick")
    assert not arm.points.path.exists()


def test_every_arm_has_a_file_of_its_own_for_its_own_joints(tmp_path, arm):
    assert arm.points.path == places.points_file("sim:teachmover")
    with connected(five_joints(tmp_path)) as other:
        other.home()
        other.points.teach("pick")
        assert other.points.path != arm.points.path
        assert tuple(other.points["pick"].joints.names) == other.model.arm.joint_names


def test_the_points_of_an_arm_that_is_not_connected_can_be_read_and_not_taught(arm):
    arm.points.teach("pick")
    book = points_of(arm.config.name, arm.config.model.arm)
    assert list(book) == ["pick"]
    with pytest.raises(Refused, match="not connected"):
        book.teach("place")


# -- the page about points ------------------------------------------------------------------------


PAGE = page_path("points")


def test_the_shown_file_reads_and_its_points_can_be_gone_to():
    text = PAGE.read_text(encoding="utf-8")
    taught = parse_points(re.search(r"```toml\n(.*?)```", text, re.DOTALL)[1], JOINT_NAMES)
    model = preset("teachmover")
    assert list(taught) == ["pick", "above"]
    for point in taught.values():
        assert model.arm.violations(point.joints) == ()
        assert model.guards.violation(model.arm, point.joints) is None
    pose = model.arm.fk(taught["pick"].joints)
    shown = f"x {pose.x_mm:.1f}, y {pose.y_mm:.1f}, z {pose.z_mm:.1f} mm"
    assert shown in text


def test_every_key_has_a_row():
    text = PAGE.read_text(encoding="utf-8")
    for key in POINT_KEYS:
        assert f"| `{key}` |" in text
