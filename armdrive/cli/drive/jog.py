"""Drive an arm from the keyboard, joint by joint or in Cartesian space."""

from __future__ import annotations

import argparse
from pathlib import Path

import tui
from armdrive.cli.arm_files import DEFAULT_SIM, arm_paths, chosen_target, default_arm
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.drive.jog_model import jog_model
from armdrive.cli.drive.web_desk import jog_web
from armdrive.cli.look.watch import watch_on_screen
from armdrive.cli.presenter import emit, say
from armdrive.cli.screens import agreed, require_screen
from armdrive.cli.terminal_person import confirm_simulated
from armdrive.errors import ArmInUse
from armdrive.status import State, coded
from armdrive.storage import files as places
from tui.gamepad.evdev import check_gamepads
from tui.keys.keyboard import Keyboard, as_rows, as_text
from tui.keys.remap import load_keys


def run(options: argparse.Namespace) -> int:
    """Open the desk."""
    keys = load_keys(options.keys)  # what is wrong with it is said before anything is opened
    if options.show_keys:
        return _show_keys(keys, json=options.json)
    if options.web:
        return jog_web(options)
    if options.model is not None:
        return jog_model(options, keys)
    if not options.served:
        require_screen("jogging", "`armdrive shell` and `armdrive move` need none")
    if options.gamepad is not None:
        check_gamepads()
    end = _desk(options, keys, "setup" if options.setup else "", _hint(options, keys))
    while end.opens is not None:  # an arm file that was written there
        options = _on_file(options, end.opens)
        hint = f"this is {options.arm}: nothing was moved; reference it, then check its motors"
        end = _desk(options, keys, "setup", hint)
    return end.code


def _desk(options: argparse.Namespace, keys: Keyboard, first: str, hint: str) -> tui.DeskEnd:
    """Connect the arm, and show its desk until that is left."""
    # in real time also the simulated twin of a port's arm
    try:
        arm = connect_chosen(options, pace="real", reconnect=options.reconnect)
    except ArmInUse as error:
        return tui.DeskEnd(_watch_instead(error, options))
    with arm:
        confirm_simulated(arm)
        end = tui.run_desk(
            arm,
            ascii_only=options.ascii,
            keys=keys,
            first=first,
            hint=hint,
            reopens=not options.served,
            gamepad=options.gamepad,
        )
        last = arm.status
    if last.error and last.state is State.DISCONNECTED and not end.code:
        say(f"left while the link was lost: {coded(last.error, last.error_code)}")
    return end


def _on_file(options: argparse.Namespace, path: Path) -> argparse.Namespace:
    """Return the options of the same desk on the arm of a file."""
    named = path.stem if path.parent == places.arm_files() else str(path)
    return argparse.Namespace(
        **vars(options)
        | {"arm": named, "sim": None, "port": None, "dialect": None, "baud": None, "fresh": False}
    )


def _hint(options: argparse.Namespace, keys: Keyboard) -> str:
    """Offer to set an arm up where none was named and no arm file is there."""
    if options.arm or options.sim or options.port or default_arm() != DEFAULT_SIM:
        return ""
    if arm_paths():
        return ""
    key = keys.label("screen-setup")
    return f"no arm of yours is described yet, so this one is simulated: {key} sets one up"


def _watch_instead(error: ArmInUse, options: argparse.Namespace) -> int:
    """Offer to watch an arm that another program drives. Raises the error where nobody wants to."""
    if options.served:
        raise error
    say(str(error))
    if not agreed("Watch it instead, with a key to stop it? Type yes: "):
        raise error
    return watch_on_screen(chosen_target(options).config.name, ascii_only=options.ascii)


def _show_keys(keys: Keyboard, *, json: bool) -> int:
    if json:
        emit({"keys": as_rows(keys)})
    else:
        for line in as_text(keys):
            say(line)
    return 0
