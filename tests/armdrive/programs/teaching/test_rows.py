"""A program as rows of the arm's own memory: they lead where it leads, or it is refused."""

import pytest

from armdrive import Arm
from armdrive.cli.chosen_arm import connect_remembered
from armdrive.connect.target import find
from armdrive.errors import Refused
from armdrive.programs.program import read_program
from armdrive.programs.teaching.rows import rows_of
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point
from kinematics import Joints

CONFIG = find("sim:teachmover").config
POINTS = {
    "above": Point(Joints.of(20.0, 40.0, -80.0, -40.0, 0.0)),
    "pick": Point(Joints.of(20.0, 30.0, -70.0, -50.0, 0.0)),
    "under": Point(Joints.of(0.0, -30.0, -20.0, -40.0, 0.0)),
    "behind": Point(Joints.of(120.0, 40.0, -80.0, -40.0, 0.0)),
}


@pytest.fixture(scope="module")
def arm():
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        yield arm


@pytest.fixture(autouse=True)
def book():
    points = points_of(CONFIG.name, CONFIG.model.arm)
    points.put_all(POINTS, again=True)
    return points


def rows(arm, text):
    return rows_of(arm, read_program(text), arm.controller.read_program().origin)


def test_rows_are_absolute_and_the_fingers_stay_until_a_line_moves_them(arm):
    made = rows(arm, "move above\nspeed 30%\nmove pick\nspeed 100%\nopen_now 30\nmove above")
    assert [row.number for row in made.rows] == [1, 2, 3, 4]
    grip = [row.positions[5] for row in made.rows]
    elbow = [row.positions[2] for row in made.rows]
    assert [row.speed for row in made.rows] == [240, 129, 240, 240]
    assert grip[0] - elbow[0] == grip[1] - elbow[1] != grip[2] - elbow[2]
    assert made.rows[1].positions[:5] == made.rows[2].positions[:5]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("move above\nmove_line pick", "line 2 cannot be a row: .*joint motions"),
        ("move above\ndelay 1", "line 2 cannot be a row: .*motions only"),
        ("move above\ngrasp", "line 2 cannot be a row: .*openings of the fingers only"),
        ("move above\nmove under", "line 2 cannot be a row: .*table"),
        ("move above\nmove behind", "line 2 cannot be a row: the base would turn"),
        ("repeat\n  move above\n  move pick\nend", "line 2 cannot be a row: .*holds 64 rows"),
        ("open_now", "the program has no `move`"),
    ],
)
def test_a_line_that_the_memory_cannot_hold_is_refused_by_its_number(arm, text, sentence):
    with pytest.raises(Refused, match=sentence):
        rows(arm, text)


def test_the_arm_itself_runs_what_was_taught(call, tmp_path):
    program, path = tmp_path / "fetch.arm", tmp_path / "fetch.pendant"
    program.write_text("move above\nmove pick\n", encoding="utf-8")
    call("home", code=0)
    assert "2 rows" in call("pendant", "make", str(program), str(path), code=0).out
    call("pendant", "write", str(path), "--yes", code=0)
    with connect_remembered(CONFIG) as arm:
        device = arm.twin.device
        arm.parts.engine.link.write(b"@RUN\r", arm.parts.engine.now_s)  # as the pendant's key does
        arm.sleep(60.0)
        assert device.registers == arm.controller.read_program().rows[-1].positions
        tip = CONFIG.model.arm.fk(POINTS["pick"].joints)
        assert device.world.tip == pytest.approx((tip.x_mm, tip.y_mm, tip.z_mm), abs=1.0)
