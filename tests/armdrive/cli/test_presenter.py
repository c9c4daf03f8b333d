"""What commands return, printed for people or for programs."""

from __future__ import annotations

import argparse

import pytest

from armdrive.cli.presenter import Result, present, tell

STATE, NAME = Result({"state": "standby"}, "it stands"), Result({"name": "a"}, ("its name:", "a"))


def lines_that_are_never_made():
    raise AssertionError("lines were made that nobody reads")
    yield


@pytest.mark.parametrize(
    ("outcome", "as_text", "as_json", "code"),
    [
        (STATE, "it stands\n", '{"state": "standby"}\n', 0),
        ([STATE, NAME], "it stands\nits name:\na\n", '{"state": "standby"}\n{"name": "a"}\n', 0),
        (Result(None, "for people"), "for people\n", "", 0),
        (Result({"a": 1}), "", '{"a": 1}\n', 0),
        (Result({}, "a\x1b[31m\nb"), "a\\x1b[31m\\nb\n", "{}\n", 0),
        ([Result({}, "", 2), Result({}, "", 1)], "\n\n", "{}\n{}\n", 2),
        (5, "", "", 5),
        ([], "", "", 0),
    ],
)
def test_a_result_has_two_forms_and_the_options_choose(capsys, outcome, as_text, as_json, code):
    for options, said in (({}, as_text), ({"json": False}, as_text), ({"json": True}, as_json)):
        assert present(outcome, argparse.Namespace(**options)) == code
        assert capsys.readouterr().out == said


def test_lines_are_made_only_where_they_are_printed(capsys):
    result = Result({"a": 1}, lines_that_are_never_made())
    assert present(result, argparse.Namespace(json=True)) == 0
    with pytest.raises(AssertionError):
        present(Result({}, lines_that_are_never_made()), argparse.Namespace(json=False))


def test_progress_is_told_to_people_alone(capsys):
    tell(argparse.Namespace(json=True), "moving")
    assert capsys.readouterr().out == ""
    tell(argparse.Namespace(json=False), "moving")
    assert capsys.readouterr().out == "moving\n"
