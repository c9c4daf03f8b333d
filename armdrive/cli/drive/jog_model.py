"""Jog a model with no arm: `armdrive jog --model NAME`."""

from __future__ import annotations

import argparse

from armdrive.cli.presenter import emit, say
from armdrive.cli.screens import require_screen
from armdrive.errors import BadRequest
from kinematics.textbook.study import find_subject, subject_names
from tui import model_desk
from tui.keyboard import Keyboard


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
    return model_desk.run_model(subject, ascii_only=options.ascii, keys=keys)


def _list(*, as_json: bool) -> None:
    found = [(name, find_subject(name).title) for name in subject_names()]
    if as_json:
        emit({"models": [{"name": name, "title": title} for name, title in found]})
        return
    width = max(len(name) for name, _ in found) + 2
    for name, title in found:
        say(f"{name:<{width}}{title}")
    say("or a link table of your own: armdrive jog --model FILE.toml")
