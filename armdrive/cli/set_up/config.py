"""Lists arm files, shows and checks one, and chooses the default arm."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from armdrive.cli.arm_files import choose_default, default_arm, path_of, read
from armdrive.cli.presenter import Result
from armdrive.config.arm import remarks_on
from armdrive.config.write import complete
from armdrive.connect.target import SIM, simulated_config
from armdrive.errors import ArmFileError, BadRequest
from armdrive.registry.arm_files import arm_paths, arm_problems, load_arm, parse_arm
from armdrive.setup.arm_checks import limit_remarks
from armdrive.setup.arm_view import arm_lines, arm_view
from armdrive.storage import files as places
from kinematics.errors import KinematicsError
from kinematics.text import counted


def list_arms(options: argparse.Namespace) -> Result:  # noqa: ARG001
    """List the arm files: model, dialect, port, and which one is the default."""
    default = default_arm()
    arms = [_row(path, default) for path in arm_paths()]
    view = {"folder": str(places.arm_files()), "default": default, "arms": arms}
    return Result(view, _listed(arms, default))


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


def _listed(arms: Sequence[Mapping[str, Any]], default: str) -> Iterator[str]:
    if not arms:
        yield f"no arm files in {places.arm_files()}; `armdrive config new` writes one"
    columns = ("name", "model", "dialect")
    widths = {key: max((len(row[key]) for row in arms), default=0) for key in columns}
    for row in arms:
        if row["error"]:
            yield f"! {row['name']}"
            yield f"    {row['error']}"
        else:
            cells = "  ".join(row[key].ljust(widths[key]) for key in columns)
            yield f"{'*' if row['default'] else ' '} {cells}  {row['port'] or '(no port)'}"
    yield f"without a name, commands use {default}"


def show(options: argparse.Namespace) -> Result:
    """Show an arm as armdrive reads its file."""
    arm = read(options.name)
    try:
        config = parse_arm(arm.table, name=arm.name, folder=arm.path.parent)
    except (ArmFileError, KinematicsError) as error:
        raise ArmFileError(f"{arm.path}: {error}; `armdrive config check` tells all") from None
    if options.toml:
        text = complete(config, arm.table)
        return Result({"toml": text}, text.rstrip("\n").split("\n"), verbatim=True)
    view = arm_view(config)
    return Result(view, arm_lines(view))


WRONG = 2


def check(options: argparse.Namespace) -> Iterator[Result]:
    """Report every problem of each file; nothing is opened, nothing moves."""
    names = options.arms or [str(path) for path in arm_paths()]
    yield from map(_checked, names)
    if not names:
        yield Result(None, "no arm files to check; `armdrive config new` writes one")


def _checked(name: str) -> Result:
    remarks: list[str] = []
    try:
        arm = read(name)
    except ArmFileError as error:
        called, problems = name, [str(error)]
    else:
        called = arm.name
        problems = arm_problems(arm.table, arm.name, arm.path.parent)
        if not problems:
            config = load_arm(arm.path)
            remarks += [*remarks_on(config), *limit_remarks(config)]
    view = {"arm": called, "ok": not problems, "problems": problems, "remarks": remarks}
    verdict = counted(len(problems), "problem") if problems else "fine"
    lines = (
        f"{called}: {verdict}",
        *(f"  ! {sentence}" for sentence in problems),
        *(f"  - {sentence}" for sentence in remarks),
    )
    return Result(view, lines, WRONG if problems else 0)


def set_default(options: argparse.Namespace) -> Result:
    """Choose the arm that commands use if none is named."""
    if (options.name is None) != options.none:
        raise BadRequest("give the name of an arm, or --none")
    if options.name is not None:
        _require_usable(options.name)
    choose_default(options.name)
    used = default_arm()
    before = () if options.name in (None, used) else ("ARMDRIVE_ARM is set and takes precedence",)
    return Result({"default": used}, (f"commands that name no arm use {used}", *before))


def _require_usable(name: str) -> None:
    """Raise an error for an arm that cannot be used."""
    if name.startswith(SIM):
        simulated_config(name.removeprefix(SIM))
        return
    if name.endswith(".toml"):
        raise BadRequest(f"the name of an arm file, not its path: {name!r}")
    load_arm(path_of(name))
