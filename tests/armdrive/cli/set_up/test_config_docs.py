"""The page about arm files says what there is: actions, templates, answers."""

from __future__ import annotations

import re
import tomllib

from cli_calls import Caller
from pages import page

from armdrive.cli.set_up.arguments import CONFIG_ACTIONS
from armdrive.registry.arm_files import load_arm
from armdrive.setup.questions import ROWS
from armdrive.setup.templates import PRINTED_SIX, TEMPLATES
from armdrive.storage import files as places

PAGE = page("describing-the-arm")


def test_every_action_template_and_length_is_on_the_page():
    for action in CONFIG_ACTIONS:
        assert f"armdrive config {action}" in PAGE
    for template in TEMPLATES:
        assert f"| `{template}` |" in PAGE
    for length in PRINTED_SIX.lengths:
        assert f"| `{length.key}` |" in PAGE


def test_every_answer_is_on_the_page():
    for row in ROWS:
        stem = row.key.replace(".{one}", ".")
        assert re.search(rf"(?m)(^|`|\[){re.escape(stem.rstrip('.'))}", PAGE), row.key


def test_the_answers_of_the_page_make_an_arm(capsys, tmp_path):
    shown = next(b for b in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if "lab3" in b)
    answers = tmp_path / "answers.toml"
    answers.write_text(shown, encoding="utf-8")
    Caller(capsys)("config", "new", "--answers", str(answers), code=0)
    path = places.arm_files() / "lab3.toml"
    assert load_arm(path).park.x_mm == 200
    assert tomllib.loads(path.read_text())["motor_signs"] == {"elbow": -1}
