"""Lists arm files, shows and checks one, and chooses the default arm."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from armdrive.cli.arm_files import choose_default, default_arm, path_of
from armdrive.cli.commands import USAGE
from armdrive.cli.presenter import Result
from armdrive.config.arm import ArmConfig, read_arm_table, remarks_on
from armdrive.config.write import complete
from armdrive.connect.target import SIM, simulated_config
from armdrive.errors import ArmFileError, BadRequest
from armdrive.registry import dialect
from armdrive.registry.arm_files import ENDING, arm_of, arm_paths, arm_problems, load_arm
from armdrive.runtime.stop_bounds import homing_bound, stop_bound
from armdrive.status import rounded_up
from armdrive.storage import files as places
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
        "usb_serial": config.connection.usb_serial,
    }


def _port_words(view: Mapping[str, Any]) -> str:
    """Return the port as its arm file names it."""
    by_number = f"USB adapter {view['usb_serial']}" if view["usb_serial"] else ""
    return view["port"] or by_number or "(no port: only simulated)"


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
            yield f"{'*' if row['default'] else ' '} {cells}  {_port_words(row)}"
    yield f"without a name, commands use {default}"


def show(options: argparse.Namespace) -> Result:
    """Show an arm as armdrive reads its file: every key with its value, and how the arm stops."""
    path = path_of(options.name)
    table = read_arm_table(path)
    try:
        config = arm_of(table, path)
    except ArmFileError as error:
        raise ArmFileError(f"{error}; `armdrive config check` shows every problem") from None
    text, stopping = complete(config, table), _stopping(config)
    lines = (*text.split("\n"), *(f"# {line}" for line in _stop_lines(stopping)))
    view = {"arm": config.name, "toml": text, "stopping": stopping}
    return Result(view, lines, verbatim=True)


def check(options: argparse.Namespace) -> Iterator[Result]:
    """Report every problem of each file; nothing is opened, nothing moves."""
    names = options.arms or [str(path) for path in arm_paths()]
    yield from map(_checked, names)
    if not names:
        yield Result(None, "no arm files to check; `armdrive config new` writes one")


def _checked(name: str) -> Result:
    remarks: list[str] = []
    try:
        path = path_of(name)
        table = read_arm_table(path)
    except ArmFileError as error:
        called, problems = name, [str(error)]
    else:
        called = path.stem
        problems = arm_problems(table, path.stem, path.parent)
        if not problems:
            remarks += remarks_on(arm_of(table, path))
    view = {"arm": called, "ok": not problems, "problems": problems, "remarks": remarks}
    verdict = counted(len(problems), "problem") if problems else "fine"
    lines = (
        f"{called}: {verdict}",
        *(f"  ! {sentence}" for sentence in problems),
        *(f"  - {sentence}" for sentence in remarks),
    )
    return Result(view, lines, USAGE if problems else 0)


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
    if name.endswith(ENDING):
        raise BadRequest(f"the name of an arm file, not its path: {name!r}")
    load_arm(path_of(name))


# How an arm stops, stretched out.


def _stopping(config: ArmConfig) -> dict[str, dict[str, float]]:
    """Return the stop bounds with the arm stretched out: jogging, moving as planned, homing.

    A template without motor steps moves nothing.
    """
    if config.model.transmission is None:
        return {}
    controller, motion = dialect(config.connection.dialect).controller(config), config.motion
    found = {
        "jog": stop_bound(config, controller, motion.jog_burst_s),
        "planned": stop_bound(config, controller, motion.planned_burst_s),
    }
    if (homing := homing_bound(config, controller)) is not None:
        found["homing"] = homing
    return {
        name: {
            "time_s": rounded_up(bound.time_s, 3),
            "distance_mm": rounded_up(bound.distance_mm, 1),
            "silent_time_s": rounded_up(bound.silent_time_s, 3),
            "silent_distance_mm": rounded_up(bound.silent_distance_mm, 1),
        }
        for name, bound in found.items()
    }


_WHILE = {"jog": "jogging", "planned": "moving as planned", "homing": "homing by its switches"}


def _stop_lines(stopping: Mapping[str, Mapping[str, float]]) -> Iterator[str]:
    for what, bound in stopping.items():
        yield (
            f"a stop while {_WHILE[what]} takes at most {bound['time_s']:g} s and "
            f"{bound['distance_mm']:g} mm (this program dying: {bound['silent_time_s']:g} s, "
            f"{bound['silent_distance_mm']:g} mm)"
        )
