"""What a run shows: one line that is rewritten, lines, or events."""

import contextlib

import pytest
from amounts import every_row
from program_acts import go
from running_bench import table_arm

from armdrive.cli.program.run_output import CLEAR_LINE, Display
from armdrive.cli.program.run_person import PromptLines, RunTerminal
from armdrive.programs.acts import RunStep
from armdrive.programs.problems import SourceMark, numbered_lines
from armdrive.programs.progress import RunProgress, Took, duration, line_words
from kinematics import Pose

GO = go(Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90))
LINES = numbered_lines(["# a program", "  move pick  ", "move put"], "t.arm")


def step(arm, line):
    return RunStep(arm, SourceMark(line, 3, "t.arm"), "Go", moves=True, act=GO)


@pytest.fixture
def arm():
    return table_arm()


def rehearsed():
    took = [Took(SourceMark(line, 3, "t.arm"), "Go", time_s) for line, time_s in ((2, 90), (3, 10))]
    return RunProgress([took])


def test_one_line_is_rewritten_and_wiped_for_words(arm, capsys, monkeypatch):
    monkeypatch.setattr("armdrive.cli.program.run_output.REDRAW_S", 1e3)
    with Display(LINES, as_json=False, rewrites=True).shown() as display:
        display.run.use(arm)
        display.run.follow(rehearsed())
        display.begins(step(arm, 2))
        display.say("hello")
        display.begins(step(arm, 3))
    shown = capsys.readouterr().out
    assert shown == (
        f"{CLEAR_LINE}  0%  line 2: move pick  1 min 40 s left"
        f"{CLEAR_LINE}hello\n"
        f"{CLEAR_LINE} 90%  line 3: move put  10 s left{CLEAR_LINE}"
    )


def test_no_line_is_drawn_over_a_question_and_a_pause_and_a_slower_pace_are_shown(arm, capsys):
    with Display(LINES, as_json=False, rewrites=True).shown() as display:
        display.run.use(arm)
        display.begins(RunStep(arm, SourceMark(3, 1, "t.arm"), "Home", moves=True))
        display._look_once()
    assert capsys.readouterr().out == "      line 3: move put\n"
    with Display(LINES, as_json=False, rewrites=True).shown() as display:
        display.run.use(arm)
        display.run.follow(rehearsed())
        display.begins(step(arm, 2))
        arm.pause()
        arm.speed_override = 0.5
        display._look_once()
    shown = capsys.readouterr().out
    assert "paused\n" in shown
    assert "3 min 20 s left  slowed  PAUSED" in shown
    assert arm.program() == display.run.view()
    assert display.run.view()["left_s"] == 200


def test_times_are_written_for_people():
    times = (0.0, 9.94, 10.0, 59.4, 60.0, 119.7, 3599.0, 3600.0, 7320.0)
    assert [*map(duration, times)] == [
        "0.0 s", "9.9 s", "10 s", "59 s", "1 min 0 s", "2 min 0 s", "59 min 59 s", "1 h 0 min",
        "2 h 2 min",
    ]  # fmt: skip


def test_a_hold_whose_input_has_ended_says_what_continues(arm):
    shown = []

    class Shown:
        say = shown.append

        @contextlib.contextmanager
        def paused(self, arm):
            arm.pause()
            yield

        def waits(self, text, *, enter=True):
            shown.append((text, enter))
            if len(shown) > 1:
                arm.resume()  # as `armdrive resume` does

    RunTerminal(arm, Shown(), PromptLines(None).keys).hold("turn it", lambda: False)
    assert shown == [("turn it", True), ("the input has ended", False)]


# -- lines and times as words ---------------------------------------------------------------------


@every_row(
    "text, shown",
    [
        ("approach pick, 60      # to 60 mm before it", "approach pick, 60"),
        ('type "no. #1", n  # says so', 'type "no. #1", n'),
        ('arm.points["it\'s #1"]', 'arm.points["it\'s #1"]'),
        ('type "never closed # here', 'type "never closed # here'),
    ],
)
def test_a_line_is_shown_without_its_comment(text, shown):
    assert line_words(3, text) == f"line 3: {shown}"
