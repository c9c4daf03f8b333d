"""Lines of a program as they are taught, by hand and from an arm's motions."""

import pytest
from amounts import every_row

from armdrive import Arm
from armdrive.errors import NotReferenced
from armdrive.programs.program import ArmProgram, read_program
from armdrive.programs.rehearsal import UnattendedPerson
from armdrive.programs.running import Performer, ProgramRun, RunPlan
from armdrive.programs.teaching import (
    Choices,
    ProgramRecorder,
    SeenPosture,
    TaughtLines,
    seen_in,
)
from armdrive.status import status_view
from kinematics import JOINT_NAMES, Joints, Pose


def taught(*calls, after=""):
    lines = TaughtLines.after(after)
    for name, *words in calls:
        more = words.pop() if words and isinstance(words[-1], dict) else {}
        getattr(lines, name)(*words, **more)
    return lines.text.splitlines()


HALF, LINE = {"speed": 0.5}, {"line": True, "speed": 0.5}
WRITTEN = {
    "speeds are written where they change": (
        [("go", "a"), ("go", "b", LINE), ("fingers", "open", HALF), ("go", "a")],
        ["move a", "speed 50%", "move_line b", "open_now", "speed 100%", "move a"]),
    "fingers and delays": (
        [("fingers", "grasp", HALF), ("fingers", 25.5), ("fingers", "close"), ("fingers", 0.0),
         ("delay", 1.5)],
        ["grasp", "open_now 25.5", "close_now", "close_now", "delay 1.5"]),
    "names that a program cannot have": (
        [("go", "pick-1"), ("go", "MOVE"), ("go", "pick_1"), ("go", "above")],
        ['move taught("pick-1")', 'move taught("MOVE")', "move pick_1", "move above"]),
}  # fmt: skip


@pytest.mark.parametrize("what", WRITTEN)
def test_what_is_taught_is_written_as_lines_of_a_program(what):
    calls, lines = WRITTEN[what]
    assert taught(*calls) == lines
    read_program("\n".join(lines))  # raises for a line that is none


@every_row(
    "program, lines",
    [
        ("speed 50%\nmove up\n", ["move_line b"]),
        ("speed 0.25\nspeed 50%\n", ["move_line b"]),
        ("move up\n", ["speed 50%", "move_line b"]),
        ("repeat 2\n  speed 50%\nend\n", ["speed 50%", "move_line b"]),
        ("x = 0.5\nspeed x\n", ["speed 50%", "move_line b"]),
        ("B = 3\nspeed 50%\n", ['move_line taught("b")']),
    ],
)
def test_lines_fit_the_program_that_they_follow(program, lines):
    assert taught(("go", "b", LINE), after=program) == lines


# Recording: a line wherever the arm comes to rest, for its fingers, and nothing in between.


MOVING = SeenPosture(None)


def at(base_deg, opening_mm=30.0, *, gripping=False):
    return SeenPosture(Joints.of(base_deg, 40.0, -80.0, -40.0, 0.0), opening_mm, gripping)


def recorded(*told, choices=None, end_s=100.0):
    recorder = ProgramRecorder("tour", choices or Choices())
    for now_s, seen in told:
        recorder.see(seen, now_s)
    recorder.end(end_s)
    return recorder


FIRST = ["move tour_1", "open_now 30"]
RECORDED = {
    "every place of rest is a point and the way there a line": (
        [(0, at(0)), (2, MOVING), (3, at(10)), (6, MOVING), (7, at(20))],
        [*FIRST, "move tour_2", "move tour_3"]),
    "a place that the arm only passed is not recorded": (
        [(0, at(0)), (2, MOVING), (3, at(5)), (3.4, MOVING), (4, at(10))], [*FIRST, "move tour_2"]),
    "the last place counts however short the arm has stood there": (
        [(0, at(0)), (2, MOVING), (99.9, at(10))], [*FIRST, "move tour_2"]),
    "a place that is come back to keeps its point": (
        [(0, at(0)), (2, MOVING), (3, at(10)), (5, MOVING), (6, at(0.01))],
        [*FIRST, "move tour_2", "move tour_1"]),
    "what the fingers do is a line and gripping is a grasp": (
        [(0, at(0, 60.0)), (2, at(0, 31.0, gripping=True)), (4, at(0, 30.0, gripping=True)),
         (6, MOVING), (7, at(10, 30.0, gripping=True)), (9, at(10, 50.0))],
        ["move tour_1", "open_now 60", "grasp", "move tour_2", "open_now 50"]),
    "an arm that rests and goes on where it was adds nothing": (
        [(0, at(0)), (2, MOVING), (3, at(0)), (5, MOVING), (6, at(0))], FIRST),
}  # fmt: skip


@every_row("what", RECORDED)
def test_which_motions_are_recorded(what):
    told, lines = RECORDED[what]
    made = recorded(*told)
    assert made.text.splitlines() == lines
    names = {line.split()[1] for line in lines if line.startswith("move")}
    assert set(made.points) == names
    bases_deg = [point.joints.deg["base"] for point in made.points.values()]
    assert bases_deg == pytest.approx([0.0, 10.0, 20.0][: len(bases_deg)])


def test_waits_ways_and_speeds_are_as_chosen():
    choices = Choices(line=True, speed=0.4, waits=True, rest_s=1.0)
    made = recorded((0, at(0, None)), (2.5, MOVING), (3, at(10, None)), choices=choices)
    wanted = ["speed 40%", "move_line tour_1", "delay 2.5", "move_line tour_2"]
    assert made.text.splitlines() == wanted


def test_a_recorded_program_repeats_the_motion():
    goals = [Pose.of(x_mm=220, y_mm=y, z_mm=120, pitch_deg=-90) for y in (0, 60, -40)]
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        for change in ({"trust": "suspect"}, {"trust": "unknown"}, {"joints": None}):
            with pytest.raises(NotReferenced, match="the arm has no trusted position"):
                seen_in(status_view(arm.status) | change, JOINT_NAMES)
        recorder, recorded_tips = ProgramRecorder("tour", Choices()), []
        for goal in goals:
            arm.move_to(goal)
            arm.gripper.open(20.0 + goal.y_mm / 10)
            recorded_tips.append((arm.twin.world.tip, arm.twin.world.motors))
            arm.sleep(1.0)
            recorder.see(seen_in(status_view(arm.status), JOINT_NAMES), arm.status.time_s)
        recorder.end(arm.status.time_s)
        arm.points.put_all(recorder.points)
        tips = []

        def ended(step, answer, took_s):
            if step.name == "Fingers":
                tips.append((arm.twin.world.tip, arm.twin.world.motors))

        source = ArmProgram(read_program(recorder.text), arm.config)
        plan = RunPlan(source.machine)
        ProgramRun(plan, Performer(arm, UnattendedPerson()), after=[ended]).carry_out()
        assert tips == recorded_tips
