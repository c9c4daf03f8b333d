"""Loads the module of a command only when the command is called.

The tables of commands and actions name their functions as `drive.move:move`, so that help and a
wrong option load nothing more. Every import is written out here, where readers and import-linter
see it.
"""

# ruff: noqa: F401 - `load` finds the imported modules in `sys.modules`

from __future__ import annotations

import sys
from typing import Any


def load(place: str) -> Any:
    """Return an object of a module of the command line, written `drive.move:move`."""
    name, _, function = place.partition(":")
    _import(name)
    return getattr(sys.modules[f"armdrive.cli.{name}"], function)


def _import(name: str) -> None:
    match name:
        case "drive.arguments":
            import armdrive.cli.drive.arguments
        case "drive.control_requests":
            import armdrive.cli.drive.control_requests
        case "drive.home":
            import armdrive.cli.drive.home
        case "drive.jog":
            import armdrive.cli.drive.jog
        case "drive.motors":
            import armdrive.cli.drive.motors
        case "drive.move":
            import armdrive.cli.drive.move
        case "drive.points":
            import armdrive.cli.drive.points
        case "program.arguments":
            import armdrive.cli.program.arguments
        case "program.demo":
            import armdrive.cli.program.demo
        case "program.pendant":
            import armdrive.cli.program.pendant
        case "program.run":
            import armdrive.cli.program.run
        case "program.shell":
            import armdrive.cli.program.shell
        case "program.teach":
            import armdrive.cli.program.teach
        case "look.arguments":
            import armdrive.cli.look.arguments
        case "look.recordings":
            import armdrive.cli.look.recordings
        case "look.status":
            import armdrive.cli.look.status
        case "learn.arguments":
            import armdrive.cli.learn.arguments
        case "learn.errors":
            import armdrive.cli.learn.errors
        case "learn.explain":
            import armdrive.cli.learn.explain
        case "learn.plot":
            import armdrive.cli.learn.plot
        case "learn.poses":
            import armdrive.cli.learn.poses
        case "set_up.arguments":
            import armdrive.cli.set_up.arguments
        case "set_up.can":
            import armdrive.cli.set_up.can
        case "set_up.completion":
            import armdrive.cli.set_up.completion
        case "set_up.config":
            import armdrive.cli.set_up.config
        case "set_up.config_new":
            import armdrive.cli.set_up.config_new
        case "set_up.doctor":
            import armdrive.cli.set_up.doctor
        case "set_up.ports":
            import armdrive.cli.set_up.ports
        case _:
            import armdrive.cli.set_up.sim
