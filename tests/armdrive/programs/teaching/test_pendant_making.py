"""A sequence as rows of the arm's own memory: they lead where it leads, or it is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pages import blocks, page

from armdrive.cli.chosen_arm import connect_remembered
from armdrive.connect.target import find
from armdrive.dialects.teachmover.pendant import parse_pendant, taught_by
from armdrive.errors import OutOfBounds, Refused
from armdrive.programs.teaching.export import rows_of
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point, Step, StepList
from kinematics import Joints

CONFIG = find("sim:teachmover").config
ORIGIN = (0, -1375, 289, 256, 256, 581)
POINTS = {
    "above": Point(Joints.of(20.0, 40.0, -80.0, -40.0, 0.0), 40.0),
    "pick": Point(Joints.of(20.0, 30.0, -70.0, -50.0, 0.0), 12.0),
    "bare": Point(Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)),
    "under": Point(Joints.of(0.0, -30.0, -20.0, -40.0, 0.0), 12.0),
    "behind": Point(Joints.of(120.0, 40.0, -80.0, -40.0, 0.0), 12.0),
}


def rows(*steps):
    return rows_of(CONFIG, StepList(steps), POINTS, ORIGIN)


def test_rows_are_absolute_and_the_fingers_stay_until_a_step_moves_them():
    made = rows(Step("above"), Step("pick", speed=0.3), Step(gripper=30.0), Step("above"))
    assert [row.number for row in made.rows] == [1, 2, 3, 4]
    grip = [row.positions[5] for row in made.rows]
    elbow = [row.positions[2] for row in made.rows]
    assert [row.speed for row in made.rows] == [240, 129, 240, 240]
    assert grip[0] - elbow[0] == grip[1] - elbow[1] != grip[2] - elbow[2]
    assert made.rows[1].positions[:5] == made.rows[2].positions[:5]


@given(
    st.lists(
        st.sampled_from([Step("above"), Step("pick"), Step(gripper=30.0), Step(gripper="open")]),
        max_size=5,
    )
)
def test_rows_lead_where_the_sequence_leads_but_for_rounding(steps):
    made = rows(Step("above"), *steps)
    points, sequence = taught_by(CONFIG, made, "back")
    again = rows_of(CONFIG, sequence, points, ORIGIN)
    assert again.rows[-1].positions == pytest.approx(made.rows[-1].positions, abs=1)


@pytest.mark.parametrize(
    ("steps", "sentence"),
    [
        ((Step("above"), Step("pick", "line")), r"step 2 \(to pick along a line\).*joint motions"),
        ((Step("above"), Step(wait_s=1.0)), r"step 2 \(delay 1 s\).*not known"),
        ((Step("above"), Step(gripper="grasp")), r"step 2 \(gripper grasp\).*give a width"),
        ((Step("above"), Step(gripper=500.0)), r"step 2 .*the fingers open from 0"),
        ((Step(gripper="open"),), "step 1 .*begin with a step to a point"),
        ((Step("bare"),), "step 1 .*the opening of the fingers there is unknown"),
        ((), "has no steps"),
    ],
)
def test_a_step_that_the_memory_cannot_hold_is_refused_by_its_number(steps, sentence):
    with pytest.raises(Refused, match=sentence):
        rows(*steps)


@pytest.mark.parametrize(
    ("point", "sentence"), [("under", "table"), ("behind", "the base would turn")]
)
def test_a_way_that_the_driver_would_refuse_is_not_made_for_the_pendant(point, sentence):
    with pytest.raises(OutOfBounds, match=f"step 2 .*{sentence}"):
        rows(Step("above"), Step(point))


def test_without_a_reference_there_are_no_rows():
    with pytest.raises(Refused, match="home it first"):
        rows_of(CONFIG, StepList((Step("above"),)), POINTS, None)


def test_the_arm_itself_runs_what_was_taught(call, tmp_path):
    path = tmp_path / "fetch.pendant"
    call("home", code=0)
    book = points_of(CONFIG.name, CONFIG.model.arm)
    book["above"], book["pick"] = POINTS["above"], POINTS["pick"]
    book.put_sequence("fetch", StepList((Step("above"), Step("pick"))), instead_of=None)
    assert "2 rows" in call("pendant", "make", "fetch", str(path), code=0).out
    call("pendant", "write", str(path), "--yes", code=0)
    with connect_remembered(CONFIG) as arm:
        device = arm.twin.device
        arm.engine.link.write(b"@RUN\r", arm.engine.now_s)  # as the pendant's key does
        arm.sleep(60.0)
        assert device.registers == arm.read_pendant_program().rows[-1].positions
        tip = CONFIG.model.arm.fk(POINTS["pick"].joints)
        assert device.world.tip == pytest.approx((tip.x_mm, tip.y_mm, tip.z_mm), abs=1.0)


def test_the_rows_of_the_page_read():
    (shown,) = [text for text in blocks(page("teachmover")) if text.startswith("armdrive pendant")]
    program = parse_pendant(shown)
    assert [row.number for row in program.rows] == [1, 2, 3]
    assert program.origin is not None
