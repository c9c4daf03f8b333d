"""Arm files on the command line: one by its name, the default arm, and the chosen arm."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from armdrive.config.arm import ArmConfig
from armdrive.connect.target import DEFAULT_TARGET, SIM, Target, find
from armdrive.errors import ArmFileError, BadRequest
from armdrive.registry.arm_files import ENDING, arm_path, arm_paths
from armdrive.storage import files as places
from armdrive.storage.files import replace_file
from armdrive.storage.point_file import Points, points_of
from armdrive.text.reading import read_text
from kinematics.errors import suggestion

# The most bytes that are read of the file with the default arm's name.
LARGEST_BYTES = 4096


def path_of(name: str) -> Path:
    """Return the file of an arm's name, or of a path. Raises `ArmFileError` if there is none."""
    path = arm_path(name)
    if os.path.lexists(path):  # anything but a plain file is refused as it is read
        return path
    known = [each.stem for each in arm_paths()]
    hint = suggestion(name.removesuffix(ENDING), known)
    there = f"known: {', '.join(known)}" if known else "there is none yet: armdrive config new"
    raise ArmFileError(f"no arm file is called {name!r} ({there}){hint}")


def _default_path() -> Path:
    return places.arm_files().parent / "default-arm"


def default_arm() -> str:
    """Return the default arm: ARMDRIVE_ARM, the chosen one, or a simulated one."""
    return os.environ.get("ARMDRIVE_ARM") or chosen_default() or DEFAULT_TARGET


def chosen_default() -> str | None:
    """Return the arm that was chosen as default, or None."""
    try:
        text = read_text(_default_path(), "the chosen arm", ArmFileError, most_bytes=LARGEST_BYTES)
        return text.strip() or None
    except ArmFileError:
        return None


def choose_default(name: str | None) -> None:
    """Choose the default arm, or none."""
    if name is None:
        _default_path().unlink(missing_ok=True)
    else:
        replace_file(_default_path(), name)


def chosen_target(options: argparse.Namespace) -> Target:
    """Return the arm that the options name."""
    named = [word for word in (options.arm, options.sim, options.port) if word]
    if len(named) > 1:
        raise BadRequest("name one arm: --arm, --sim or --port")
    if (options.dialect or options.baud) and not options.port:
        raise BadRequest(
            "--dialect and --baud say how the arm on a --port is reached: name the port, or leave "
            "them out (--sim DIALECT is a simulated arm)"
        )
    if options.port:
        return find(options.port, dialect_name=options.dialect, baud=options.baud)
    if options.sim:
        return find(f"{SIM}{options.sim}")
    return find(options.arm or default_arm())


def chosen_points(options: argparse.Namespace) -> tuple[ArmConfig, Points]:
    """Return the arm that the options name and its points, without connecting to it."""
    config = chosen_target(options).config
    return config, points_of(config.name, config.model.arm)
