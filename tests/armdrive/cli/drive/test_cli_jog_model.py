"""`armdrive jog --model`: which names there are, what is refused, and that no arm is opened."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from armdrive.cli import screens
from armdrive.cli.drive.jog import find_subject
from armdrive.errors import BadRequest
from kinematics.textbook.study import subject_names


@pytest.fixture
def opened(monkeypatch):
    """A terminal, and a model's desk that somebody leaves at once; returns what it is given."""
    terminal = SimpleNamespace(isatty=lambda: True)
    monkeypatch.setattr(screens, "sys", SimpleNamespace(stdin=terminal, stdout=terminal))
    monkeypatch.setenv("TERM", "xterm-256color")
    shown = []

    def run_model(subject, *, ascii_only, keys):
        shown.append((subject.name, ascii_only))
        return 0

    monkeypatch.setattr("armdrive.cli.drive.jog.run_model", run_model)
    return shown


def no_arm(*args, **more):
    raise AssertionError("an arm was asked for")


def test_without_a_name_all_are_listed(call):
    called = call("jog", "--model", code=0)
    assert all(f"{name} " in called.out for name in subject_names())
    listed = call("jog", "--model", "--json", code=0).json["models"]
    assert [one["name"] for one in listed] == list(subject_names())


def test_an_unknown_name_is_answered_with_the_nearest(call):
    called = call("jog", "--model", "scra.toml", code=None)
    assert "scra.toml" in called.err
    called = call("jog", "--model", "minimover", code=2)
    assert "did you mean 'minimover5'" in called.err
    assert "two-link-1" in called.err


def test_an_unknown_name_is_answered_with_all_that_could_be_meant():
    with pytest.raises(BadRequest, match="did you mean 'puma'") as said:
        find_subject("pumma")
    assert all(name in str(said.value) for name in subject_names())


def test_a_model_and_an_arm_are_not_both_jogged(call):
    called = call("jog", "--model", "puma", "--sim", "teachmover", code=2)
    assert "a model has no arm" in called.err
    called = call("jog", "--model", "puma", "--gamepad", code=2)
    assert "leave out --gamepad" in called.err


def test_without_a_terminal_the_other_command_is_named(call):
    assert "armdrive explain" in call("jog", "--model", "puma", code=2).err


def test_a_model_is_shown_and_no_arm_is_opened(call, opened, monkeypatch):
    monkeypatch.setattr("armdrive.cli.drive.jog.connect_chosen", no_arm)
    call("jog", "--model", "puma", "--ascii", code=0)
    assert opened == [("puma", True)]
