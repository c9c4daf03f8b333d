"""The page about programs: its programs run, its tables and its error are the real ones."""

import re

import pytest
from pages import page
from program_bench import acts

from armdrive.programs import read_program
from armdrive.programs.acts import act_name
from armdrive.programs.problems import ProgramError
from armdrive.programs.program import DEEPEST_CALL, MOST_STEPS

PAGE = page("programs")
SHOWN = re.findall(r"```arm\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("text", SHOWN)
def test_every_shown_program_runs(text):
    assert acts(text, inputs=(1, 4))


def test_the_first_shown_program_does_what_the_page_says():
    kinds = [act_name(act) for act in acts(SHOWN[0])]
    there = ["Go", "Fingers", "Go", "Grasp", "Look", "Go"]
    assert kinds == [*there, "Go", "Go", "Fingers", "Look", "Go", "Ready"]


def test_the_shown_mistake_is_what_a_person_sees():
    text = 'grasp into width\nexpect widht > 5, "there is no block"\n'
    with pytest.raises(ProgramError) as caught:
        read_program(text, "stack.arm")
    assert f"```text\n{caught.value}\n```" in PAGE


def test_the_bounds_that_the_page_names_are_the_real_ones():
    assert f"{MOST_STEPS:,} steps".replace(",", " ") in PAGE
    assert f"{DEEPEST_CALL} deep" in PAGE


def test_the_shown_python_runs(capsys):
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(code, {})
    assert capsys.readouterr().out.count("ParkMove(speed=1.0, goal=None)") == 2
