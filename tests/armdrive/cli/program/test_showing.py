"""What a run shows: one line that is rewritten, lines, or events."""

import contextlib
import threading

import pytest
from amounts import every_row
from program_acts import go
from running_bench import table_arm

from armdrive.cli.program.run_output import CLEAR_LINE, Display, RunOutput
from armdrive.cli.program.run_person import PromptLines, RunTerminal
from armdrive.connect.control_socket import _lasting, _shown
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
    return RunProgress(
        [[Took(SourceMark(2, 3, "t.arm"), "Go", 90.0), Took(SourceMark(3, 3, "t.arm"), "Go", 10.0)]]
    )


def test_one_line_is_rewritten_and_wiped_for_words(arm, capsys, monkeypatch):
    monkeypatch.setattr("armdrive.cli.program.run_output.REDRAW_S", 1e3)
    with Display(RunOutput(as_json=False, rewrites=True), LINES).shown() as display:
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


def test_no_line_is_drawn_over_a_question(arm, capsys):
    with Display(RunOutput(as_json=False, rewrites=True), LINES).shown() as display:
        display.run.use(arm)
        display.begins(RunStep(arm, SourceMark(3, 1, "t.arm"), "Home", moves=True))
        display._look_once()
    assert capsys.readouterr().out == "      line 3: move put\n"


def test_a_pause_and_a_slower_pace_are_shown(arm, capsys):
    with Display(RunOutput(as_json=False, rewrites=True), LINES).shown() as display:
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


def test_the_status_thread_ends_quietly_when_its_reader_has_gone(arm, monkeypatch):
    monkeypatch.setattr("armdrive.cli.program.run_output.REDRAW_S", 1e-3)

    class Gone(RunOutput):
        def tell(self, event, text):
            if event["event"] == "paused":
                raise OSError(5, "the terminal is gone")

    with Display(Gone(as_json=True), LINES).shown() as display:
        display.run.use(arm)
        display.begins(step(arm, 2))
        (looking,) = (each for each in threading.enumerate() if each.name == "progress")
        arm.pause()
        looking.join(timeout=10)
        assert not looking.is_alive()


def test_no_progress_is_shown_before_the_run_began(arm, capsys):
    with Display(RunOutput(as_json=False, rewrites=False), LINES).shown() as display:
        display.run.use(arm)
        display._look_once()
        assert arm.program() == {}
        assert display.run.line_at(SourceMark(4, 1, "t.arm")) == ""
    assert capsys.readouterr().out == ""


@every_row(
    "time_s, words",
    [
        (0.0, "0.0 s"),
        (9.94, "9.9 s"),
        (10.0, "10 s"),
        (59.4, "59 s"),
        (60.0, "1 min 0 s"),
        (119.7, "2 min 0 s"),
        (3599.0, "59 min 59 s"),
        (3600.0, "1 h 0 min"),
        (7320.0, "2 h 2 min"),
    ],
)
def test_times_are_written_for_people(time_s, words):
    assert duration(time_s) == words


def test_lines_that_were_typed_before_are_no_answer_from_a_person(tmp_path, monkeypatch):
    path = tmp_path / "typed"
    path.write_text("\n\n", encoding="utf-8")
    with path.open() as file:
        lines = PromptLines(file.fileno())
        while not lines.take():
            pass
        monkeypatch.setattr("os.isatty", lambda _: True)
        while lines._lines.empty():
            pass
        lines.forget()
        with contextlib.suppress(EOFError):
            assert not lines.take()
        for each in threading.enumerate():  # none may read on in a number that is used again
            if each.name == "lines":
                each.join()


def test_the_end_of_the_input_is_reported_and_a_terminal_stays_readable(tmp_path):
    path = tmp_path / "typed"
    path.write_text("\n", encoding="utf-8")
    with path.open() as file:
        lines = PromptLines(file.fileno())

        def taken(lines: PromptLines) -> bool:
            while not (line := lines.take()):
                pass
            return line

        assert taken(lines)
        with pytest.raises(EOFError):
            taken(lines)
        path.write_text("\n\n", encoding="utf-8")  # as Enter after Ctrl-D
        assert taken(lines)
        with pytest.raises(EOFError):
            taken(lines)
    with pytest.raises(EOFError):
        taken(PromptLines(None))


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


def test_what_waits_for_a_person_ends_with_the_run(arm):
    shown = []

    class Shown:
        def say(self, text, **_):
            shown.append(text)

        waits = say

        @contextlib.contextmanager
        def paused(self, arm):
            arm.pause()
            yield

    person = RunTerminal(arm, Shown(), PromptLines(None).keys)
    person.say("hello")
    person.hold("turn it", lambda: True)
    assert shown == ["hello", "turn it"]
    assert arm.status.paused  # whoever ended the run says what becomes of the arm


def test_a_display_is_updated_at_each_percent_and_each_second():
    view = {"state": "moving", "trust_for_s": 3, "program": {"line": 2, "percent": 3.0}}

    def after(**more):
        return {**view, "trust_for_s": 4, "program": {**view["program"], **more}}

    assert _shown(view) == _shown(after(percent=3.4)) != _shown(after(percent=3.6))
    assert _shown(view) != _shown(after(left_s=8.0)) == _shown(after(left_s=8.2))
    assert _shown({"state": "moving", "program": None})["state"] == "moving"


def test_watchers_are_updated_at_a_new_line_and_not_as_time_passes():
    view = {"state": "moving", "program": {"line": 2, "percent": 3.0, "left_s": 9.0}}
    later = {**view, "program": {**view["program"], "percent": 4.0, "left_s": 8.0}}
    further = {**view, "program": {**view["program"], "line": 3}}
    assert _lasting(view) == _lasting(later) != _lasting(further)
    assert _lasting({"state": "moving", "trust_for_s": 3}) == {"state": "moving"}


# -- lines and times as words ---------------------------------------------------------------------


@every_row(
    "text, shown",
    [
        ("approach pick, 60      # to 60 mm before it", "approach pick, 60"),
        ('type "no. #1", n  # says so', 'type "no. #1", n'),
        ('arm.points["it\'s #1"]', 'arm.points["it\'s #1"]'),
        ("name = 'a#b'  # one", "name = 'a#b'"),
        ('type "never closed # here', 'type "never closed # here'),
        ("ready", "ready"),
    ],
)
def test_a_line_is_shown_without_its_comment(text, shown):
    assert line_words(3, text) == f"line 3: {shown}"


def test_a_hold_does_not_say_twice_that_the_arm_is_paused(arm, capsys):
    with Display(RunOutput(as_json=False, rewrites=False), LINES).shown() as display:
        display.run.use(arm)
        display.begins(step(arm, 2))

        def over():
            display._look_once()
            if (said := capsys.readouterr().out) and "turn it" in said:
                assert "paused" not in said
                arm.resume()
            return False

        RunTerminal(arm, display, None).hold("turn it", over)
    assert "going on" in capsys.readouterr().out
