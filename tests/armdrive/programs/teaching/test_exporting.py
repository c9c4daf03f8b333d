"""A taught sequence as a program: it reads back, and does what the sequence does, to the byte."""

import math

import pytest
from faults import OVER_THE_TABLE, ready_arm
from hypothesis import given
from hypothesis import strategies as st

from armdrive.connect.target import find
from armdrive.errors import Refused
from armdrive.programs.language.grammar import parse
from armdrive.programs.language.writing import unparse
from armdrive.programs.program import read_program
from armdrive.programs.running import Performer
from armdrive.programs.teaching.export import exact_deg, program_names, program_of
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
        ((Step("drop"), Step(gripper="point")), "says no opening"),
        ((Step(gripper="point"),), "says no opening"),
        ((Step(gripper=-3.0),), "from 0 mm on"),
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
