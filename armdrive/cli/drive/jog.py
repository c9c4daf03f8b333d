"""Drive an arm from the keyboard, or jog a model with no arm: `armdrive jog --model NAME`."""

from __future__ import annotations

import argparse
import contextlib
from pathlib import Path

import tui
from armdrive.cli.arm_files import chosen_target, default_arm
from armdrive.cli.chosen_arm import connect_chosen, enable_if_settled
from armdrive.cli.holders import held_name
from armdrive.cli.learn.models import find_subject
from armdrive.cli.look.status import watch_on_screen
from armdrive.cli.options import names_arm
from armdrive.cli.presenter import Outcome, Result, require_screen, say
from armdrive.cli.terminal_operator import confirm_simulated
from armdrive.connect.target import DEFAULT_TARGET
from armdrive.errors import ArmInUse, BadRequest
from armdrive.programs.language import ENDING
from armdrive.registry.arm_files import arm_paths
from armdrive.status import State, coded
from armdrive.storage.lock_client import is_held
from armdrive.text.reading import read_text
from tui.keys.keyboard import Keyboard, as_rows, as_text, keyboard_of
from tui.model_desk import run_model
from tui.settings import chosen_layout


def jog(options: argparse.Namespace) -> Outcome:
    """Open the desk."""
    keys = keyboard_of(chosen_layout(options.keys))
    if options.program is not None:
        _check_program(options.program)
    if options.show_keys:
        return Result({"keys": as_rows(keys)}, as_text(keys))
    if options.model is not None:
        return jog_model(options, keys)
    require_screen("jogging", "`armdrive shell` and `armdrive move` need none")
    first = "setup" if options.setup else "program" if options.program is not None else ""
    return _desk(options, keys, first, _hint(options, keys))


def _check_program(path: Path) -> None:
    """Refuse what is no program file, or cannot be read. Its mistakes are shown on the screen."""
    if path.suffix.lower() != ENDING:
        raise BadRequest(f"{path} is no program file ({ENDING}); `armdrive run` runs scripts")
    read_text(path, "the program", BadRequest)


def _desk(options: argparse.Namespace, keys: Keyboard, first: str, hint: str) -> int:
    """Connect the arm, and show its desk until the user leaves it."""
    # in real time, also for the simulated twin of an arm on a port
    try:
        arm = connect_chosen(options, pace="real", reconnect=options.reconnect)
    except ArmInUse as error:
        return _watch_instead(error, options)
    with contextlib.closing(arm):
        confirm_simulated(arm)
        enable_if_settled(arm)
        code = tui.run_desk(
            arm,
            ascii_only=options.ascii,
            keys=keys,
            first=first,
            hint=hint,
            program=None if options.program is None else options.program.absolute(),
        )
        last = arm.status
    if last.error and last.state is State.DISCONNECTED and not code:
        say(f"the connection was lost when you left: {coded(last.error, last.error_code)}")
    return code


def _hint(options: argparse.Namespace, keys: Keyboard) -> str:
    """Return a hint to set an arm up, if none was named and there is no arm file."""
    if names_arm(options) or default_arm() != DEFAULT_TARGET or arm_paths():
        return ""
    key = keys.label("screen-setup")
    return f"you have no arm file yet, so this arm is simulated: {key} sets up a real one"


def _watch_instead(error: ArmInUse, options: argparse.Namespace) -> int:
    """Watch an arm that another program drives: that moves nothing, and needs no question.

    Raises the error if that program cannot be asked, as while it is connecting.
    """
    name = held_name(options)
    if not is_held(name):
        raise error
    end = watch_on_screen(name, chosen_target(options).config, ascii_only=options.ascii)
    say(f"the arm was watched, not driven: {error}")
    return end


# A model with no arm.


def jog_model(options: argparse.Namespace, keys: Keyboard) -> int:
    """Open the desk of a model."""
    if names_arm(options):
        raise BadRequest("--model has no arm: leave out --arm, --sim and --port, or --model")
    if options.setup or options.program is not None:
        raise BadRequest("a model has no set-up and runs no programs: leave them out, or --model")
    subject = find_subject(options.model)
    require_screen("jogging", "`armdrive explain` prints the same for one posture")
    return run_model(subject, ascii_only=options.ascii, keys=keys)
