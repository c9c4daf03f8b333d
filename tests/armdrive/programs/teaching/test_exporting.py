"""A taught sequence as a program: it reads back, and does what the sequence does, to the byte."""

import math

import pytest
from amounts import amount
from faults import OVER_THE_TABLE, ready_arm
from hypothesis import given, settings
from hypothesis import strategies as st
from pages import blocks, page

from armdrive.cli.chosen_arm import connect_remembered
from armdrive.connect.target import find
from armdrive.dialects.teachmover.pendant import parse_pendant, taught_by
from armdrive.errors import OutOfBounds, Refused
from armdrive.programs.language.grammar import parse
from armdrive.programs.language.writing import unparse
from armdrive.programs.program import read_program
from armdrive.programs.running import Performer
from armdrive.programs.teaching.export import exact_deg, program_names, program_of, rows_of
from armdrive.programs.teaching.sequence import Stepper
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point, Step, StepList
from kinematics import Joints

FK = find("sim:teachmover").config.model.arm.fk
UP = OVER_THE_TABLE
POINTS = {
    "above": Point(UP, 40.0, "safe"),
    "pick-1": Point(Joints.of(0.0, 36.1234, -82.0, -38.5, 7.25), 25.5),
    "drop": Point(Joints.of(-30.0, 40.0, -80.0, -40.0, 0.0)),
}
FETCH = StepList(
    (
        Step("above", speed=0.8),
        Step(gripper="open"),
        Step("pick-1", "line", 0.3),
        Step(gripper="point", speed=0.3),
        Step(gripper="grasp"),
        Step(wait_s=0.5),
        Step("above", "line", 0.3),
        Step("drop"),
        Step(gripper=31.5, speed=0.5),
        Step(gripper="close"),
    ),
    "one block",
)
WANTED = """\
# The sequence fetch, as it was taught.
# one block

# safe
point above_2 = joints(base 0, shoulder 40, elbow -80, wrist_pitch -40, wrist_roll 0)  # above: TIP
"""


class Silent:
    def say(self, text):
        """Hear nothing."""

    def hold(self, text, over):
        """Do not wait."""


def exported(steps=FETCH, points=POINTS):
    return unparse(program_of("fetch", steps, points, FK))


def sent_by(drive):
    """Return all lines of motion that were sent, and where the arm ended."""
    with ready_arm() as arm:
        drive(arm)
        return arm.twin.link.named(b"@STEP"), arm.twin.world.motors


def by_program(text):
    def drive(arm):
        machine = read_program(text).machine(joint_names=arm.config.model.arm.joint_names)
        performer = Performer(arm, Silent())
        while (stage := machine.next()) is not None:
            machine.answer(performer.perform(stage.act))

    return drive


def by_steps(steps, points):
    return lambda arm: Stepper(arm, steps, points).run()


def test_the_program_sends_the_very_bytes_of_the_sequence():
    sent, ended = sent_by(by_steps(FETCH, POINTS))
    assert sent_by(by_program(exported())) == (sent, ended)
    assert len(sent) > 20


@settings(max_examples=amount(8, 1000))
@given(
    st.lists(
        st.one_of(
            st.builds(
                Step,
                st.sampled_from(sorted(POINTS)),
                st.just("joint"),
                st.sampled_from([0.25, 0.5, 1.0]),
            ),
            st.builds(
                lambda gripper, speed: Step(gripper=gripper, speed=speed),
                st.sampled_from(["open", "close", 20.0, 33.3]),
                st.sampled_from([0.5, 1.0]),
            ),
            st.sampled_from([0.0, 0.25]).map(lambda wait_s: Step(wait_s=wait_s)),
        ),
        min_size=1,
        max_size=5,
    )
)
def test_any_sequence_goes_the_same_way_as_its_program(steps):
    made = StepList(tuple(steps))
    assert sent_by(by_program(exported(made))) == sent_by(by_steps(made, POINTS))


def test_it_reads_well_and_reads_back():
    text = exported()
    tree = program_of("fetch", FETCH, POINTS, FK)
    assert parse(text) == tree
    head = WANTED.replace("TIP", str(FK(UP)))
    assert text.startswith(head)
    body = text.split("\n\n", 2)[2]
    assert body == (
        "speed 80%\nmove above_2\nspeed 100%\nopen_now\nspeed 30%\nmove_line pick_1\n"
        "open_now 25.5\ngrasp\ndelay 0.5\nmove_line above_2\n\nspeed 100%\nmove drop\n"
        "speed 50%\nopen_now 31.5\nspeed 100%\nclose_now\n"
    )


def test_point_names_that_a_program_cannot_have_get_different_ones():
    assert program_names(["pick-1", "pick_1", "MOVE", "home", "Drop", "drop"]) == {
        "pick-1": "pick_1",
        "pick_1": "pick_1_2",
        "MOVE": "MOVE_2",
        "home": "home_2",
        "Drop": "Drop",
        "drop": "drop_2",
    }


@given(st.floats(-4.0, 4.0))
def test_an_angle_is_written_as_the_very_same_one(angle):
    assert math.radians(exact_deg(angle)) == pytest.approx(angle, rel=1e-15, abs=1e-300)


@given(st.integers(-1_800_000, 1_800_000))
def test_an_angle_of_a_file_keeps_its_four_decimals(tenthousandths):
    deg = tenthousandths / 10_000
    assert exact_deg(math.radians(deg)) == deg


@pytest.mark.parametrize(
    ("steps", "sentence"),
    [
        ((), "has no steps"),
        ((Step("drop"), Step(gripper="point")), "states no opening"),
        ((Step(gripper="point"),), "states no opening"),
        ((Step(gripper=-3.0),), "opening in mm must be at least 0, not -3"),
    ],
)
def test_a_sequence_that_no_program_can_express_is_refused(steps, sentence):
    with pytest.raises(Refused, match=sentence):
        exported(StepList(steps))


def test_the_command_writes_a_file_that_is_a_program(call, tmp_path):
    path = tmp_path / "fetch.arm"
    config = find("sim:teachmover").config
    book = points_of(config.name, config.model.arm)
    for name, point in POINTS.items():
        book[name] = point
    book.put_sequence("fetch", FETCH, instead_of=None)
    assert "armdrive run" in call("points", "export", "fetch", str(path), code=0).out
    assert path.read_text(encoding="utf-8") == exported(points=book)
    said = call("points", "export", "fetch", str(path), "--force", "--json", code=0).json
    assert said["sha256"] == read_program(path.read_text(encoding="utf-8")).digest
    assert "no sequence" in call.refused("points", "export", "none", str(tmp_path / "x"), code=2)


# A sequence as rows of the arm's own memory: they lead where it leads, or it is refused.


CONFIG = find("sim:teachmover").config
ORIGIN = (0, -1375, 289, 256, 256, 581)
TAUGHT = {
    "above": Point(Joints.of(20.0, 40.0, -80.0, -40.0, 0.0), 40.0),
    "pick": Point(Joints.of(20.0, 30.0, -70.0, -50.0, 0.0), 12.0),
    "bare": Point(Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)),
    "under": Point(Joints.of(0.0, -30.0, -20.0, -40.0, 0.0), 12.0),
    "behind": Point(Joints.of(120.0, 40.0, -80.0, -40.0, 0.0), 12.0),
}


def rows(*steps):
    return rows_of(CONFIG, StepList(steps), TAUGHT, ORIGIN)


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
        rows_of(CONFIG, StepList((Step("above"),)), TAUGHT, None)


def test_the_arm_itself_runs_what_was_taught(call, tmp_path):
    path = tmp_path / "fetch.pendant"
    call("home", code=0)
    book = points_of(CONFIG.name, CONFIG.model.arm)
    book["above"], book["pick"] = TAUGHT["above"], TAUGHT["pick"]
    book.put_sequence("fetch", StepList((Step("above"), Step("pick"))), instead_of=None)
    assert "2 rows" in call("pendant", "make", "fetch", str(path), code=0).out
    call("pendant", "write", str(path), "--yes", code=0)
    with connect_remembered(CONFIG) as arm:
        device = arm.twin.device
        arm.parts.engine.link.write(b"@RUN\r", arm.parts.engine.now_s)  # as the pendant's key does
        arm.sleep(60.0)
        assert device.registers == arm.controller.read_program().rows[-1].positions
        tip = CONFIG.model.arm.fk(TAUGHT["pick"].joints)
        assert device.world.tip == pytest.approx((tip.x_mm, tip.y_mm, tip.z_mm), abs=1.0)


def test_the_rows_of_the_page_read():
    (shown,) = [text for text in blocks(page("teachmover")) if text.startswith("armdrive pendant")]
    program = parse_pendant(shown)
    assert [row.number for row in program.rows] == [1, 2, 3]
    assert program.origin is not None
