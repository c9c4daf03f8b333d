"""Loads the modules of a command only when the command is called.

The tables of commands and actions name their functions as `drive.move:move`, so that help and a
wrong option load nothing more. Every import is written out here, where readers and import-linter
see it; modules that need the same libraries are loaded together.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any


def load(place: str) -> Any:
    """Return an object of a module of the command line, written `drive.move:move`."""
    group, _, rest = place.partition(".")
    module, _, name = rest.partition(":")
    return getattr(_GROUPS[group](module), name)


def _drive(module: str) -> ModuleType:
    match module:
        case "arguments":
            from armdrive.cli.drive import arguments

            return arguments
        case "control_requests":
            from armdrive.cli.drive import control_requests

            return control_requests
        case "jog":
            from armdrive.cli.drive import jog

            return jog
        case "points":
            from armdrive.cli.drive import points

            return points
        case "points_driving":
            from armdrive.cli.drive import points_driving

            return points_driving
        case _:
            from armdrive.cli.drive import home, motors, move

            return {"home": home, "motors": motors, "move": move}[module]


def _program(module: str) -> ModuleType:
    match module:
        case "arguments":
            from armdrive.cli.program import arguments

            return arguments
        case "run":
            from armdrive.cli.program import run

            return run
        case "shell":
            from armdrive.cli.program import shell

            return shell
        case _:
            from armdrive.cli.program import demo, pendant, teach

            return {"demo": demo, "pendant": pendant, "teach": teach}[module]


def _look(module: str) -> ModuleType:
    match module:
        case "arguments":
            from armdrive.cli.look import arguments

            return arguments
        case "recordings":
            from armdrive.cli.look import recordings

            return recordings
        case _:
            from armdrive.cli.look import status

            return status


def _learn(module: str) -> ModuleType:
    match module:
        case "arguments":
            from armdrive.cli.learn import arguments

            return arguments
        case "errors":
            from armdrive.cli.learn import errors

            return errors
        case "explain":
            from armdrive.cli.learn import explain

            return explain
        case "plot":
            from armdrive.cli.learn import plot

            return plot
        case _:
            from armdrive.cli.learn import poses

            return poses


def _set_up(module: str) -> ModuleType:
    match module:
        case "arguments":
            from armdrive.cli.set_up import arguments

            return arguments
        case "can_monitor" | "can_setup":
            from armdrive.cli.set_up import can_monitor, can_setup

            return {"can_monitor": can_monitor, "can_setup": can_setup}[module]
        case "completion":
            from armdrive.cli.set_up import completion

            return completion
        case "config":
            from armdrive.cli.set_up import config

            return config
        case "config_new":
            from armdrive.cli.set_up import config_new

            return config_new
        case "doctor":
            from armdrive.cli.set_up import doctor

            return doctor
        case "ports":
            from armdrive.cli.set_up import ports

            return ports
        case _:
            from armdrive.cli.set_up import sim

            return sim


_GROUPS = {
    "drive": _drive,
    "program": _program,
    "look": _look,
    "learn": _learn,
    "set_up": _set_up,
}
