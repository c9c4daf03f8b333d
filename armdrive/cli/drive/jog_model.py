"""Jog a model with no arm: `armdrive jog --model NAME`."""

from __future__ import annotations

import argparse

from armdrive.cli.presenter import emit, say
from armdrive.cli.screens import require_screen
from armdrive.config.link_model import is_model_file, read_model
from armdrive.errors import BadRequest
from kinematics.errors import suggestion
from kinematics.textbook.study import Subject, named_subject, subject_names, subject_of_chain
from tui.keys.keyboard import Keyboard
from tui.theory.model import run_model


def jog_model(options: argparse.Namespace, keys: Keyboard) -> int:
    """Open the desk of a model, or list the names where none is given."""
    if options.arm or options.sim or options.port:
        raise BadRequest("a model has no arm: leave out --arm, --sim and --port, or --model")
    if options.gamepad is not None:
        raise BadRequest("a model is moved in steps, by keys: leave out --gamepad, or --model")
    if not options.model:
        _list(as_json=options.json)
        return 0
    subject = find_subject(options.model)
    if not options.served:
        require_screen("jogging", "`armdrive explain` prints the same of one posture")
    return run_model(subject, ascii_only=options.ascii, keys=keys)


def find_subject(word: str) -> Subject:
    """Return what a name or the path of a model file stands for.

    Raises `BadRequest` for a name that nothing has, with the nearest one, and `ArmFileError` for
    a file that cannot be used.
    """
    if is_model_file(word):
        model = read_model(word)
        return subject_of_chain(model.name, model.title, model.source, model.chain)
    names = subject_names()
    if word not in names:
        raise BadRequest(
            f"no model is named {word!r}{suggestion(word, names)} "
            f"(there are {', '.join(names)}, and .toml files with a link table)"
        )
    return named_subject(word)


def _list(*, as_json: bool) -> None:
    found = [(name, named_subject(name).title) for name in subject_names()]
    if as_json:
        emit({"models": [{"name": name, "title": title} for name, title in found]})
        return
    width = max(len(name) for name, _ in found) + 2
    for name, title in found:
        say(f"{name:<{width}}{title}")
    say("or a link table of your own: armdrive jog --model FILE.toml")
