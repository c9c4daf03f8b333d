"""List the arm files: model, dialect, port, and which one is the default."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from armdrive.cli.arm_files import arm_paths, default_arm
from armdrive.cli.presenter import emit, say
from armdrive.errors import ArmFileError
from armdrive.registry.arm_files import load_arm
from armdrive.storage import files as places

NO_PORT = "(no port)"


def run(options: argparse.Namespace) -> int:
    """Print a line for each arm."""
    default = default_arm()
    arms = [_row(path, default) for path in arm_paths()]
    if options.json:
        emit({"folder": str(places.arm_files()), "default": default, "arms": arms})
        return 0
    if not arms:
        say(f"no arm files in {places.arm_files()}; `armdrive config new` writes one")
    widths = {key: max((len(row[key]) for row in arms), default=0) for key in _COLUMNS}
    for row in arms:
        mark = "*" if row["default"] else " "
        cells = "  ".join(row[key].ljust(widths[key]) for key in _COLUMNS)
        say(f"{mark} {cells}  {row['port'] or NO_PORT}" if not row["error"] else f"! {row['name']}")
        if row["error"]:
            say(f"    {row['error']}")
    say(f"without a name, commands use {default}")
    return 0


_COLUMNS = ("name", "model", "dialect")


def _row(path: Path, default: str) -> dict[str, Any]:
    row = {"name": path.stem, "default": path.stem == default, "error": ""}
    try:
        config = load_arm(path)
    except ArmFileError as error:
        return row | {"model": "", "title": "", "dialect": "", "port": "", "error": str(error)}
    return row | {
        "model": config.model.key,
        "title": config.title,
        "dialect": config.connection.dialect,
        "port": config.connection.port,
    }
