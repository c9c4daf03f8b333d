"""Lists arm files, and reads them with the sections of the dialects in the registry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from armdrive.config.arm import ArmConfig, ConfigSource, read_arm, read_arm_table, unusable
from armdrive.config.sections import Connection
from armdrive.dialects import Dialect
from armdrive.errors import ArmFileError, BadRequest
from armdrive.registry import DEFAULT, dialect
from armdrive.storage import files as places
from armdrive.text.toml import Problems, TomlTable, require_format
from armdrive.transports.address import CanAddress, is_can
from kinematics.errors import KinematicsError

ENDING = ".toml"


def arm_paths() -> list[Path]:
    """Return the user's arm files, sorted by name, without the model files that lie among them."""
    return [path for path in sorted(places.arm_files().glob(f"*{ENDING}")) if not _is_model(path)]


def _is_model(path: Path) -> bool:
    """Return whether a file describes a link table rather than an arm."""
    try:
        table = read_arm_table(path)
        require_format(table)
    except ArmFileError:
        return False  # listed, so that the user sees what is wrong with it
    return "links" in table and "model" not in table


def arm_path(name: str) -> Path:
    """Return where an arm's file is, or would be written; a path is returned unchanged."""
    return Path(name) if name.endswith(ENDING) else places.arm_files() / f"{name}{ENDING}"


def require_name(name: str) -> None:
    """Raise `BadRequest` unless a new arm file may have this name.

    The name is also typed after options, and some file systems ignore case.
    """
    if places.file_name(name) != name or name.startswith("-"):
        raise BadRequest(
            f"{name!r} cannot name a file: use up to {places.LONGEST_NAME} small letters, digits, "
            "- and _, and begin with a letter or a digit"
        )


def _find(name: str | None) -> Dialect:
    return dialect(DEFAULT if name is None else name)


def load_arm(path: Path) -> ArmConfig:
    """Read an arm file. Raises `ArmFileError`, which names the file, the key and the remedy."""
    return arm_of(read_arm_table(path), path)


def arm_of(table: Mapping[str, Any], path: Path) -> ArmConfig:
    """Return the arm of a file that has been read. Raises as `load_arm` does."""
    try:
        return parse_arm(table, name=path.stem, folder=path.parent)
    except (ArmFileError, KinematicsError) as error:
        raise ArmFileError(f"{path}: {error}") from None


def parse_arm(table: Mapping[str, Any], *, name: str, folder: Path = Path()) -> ArmConfig:
    """Turn a parsed TOML document into an arm; a model file is looked for from `folder`.

    Raises `ArmFileError` for the first problem.
    """
    problems = Problems()
    return problems.required(
        read_arm(TomlTable(table, "", problems), _find, name=name, folder=folder)
    )


def arm_problems(table: dict[str, Any], name: str, folder: Path) -> list[str]:
    """Return a sentence for each problem of an arm file, in the order in which they are found."""
    problems = Problems()
    config = read_arm(TomlTable(table, "", problems), _find, name=name, folder=folder)
    if config is not None:
        problems.found += unusable(config, dialect(config.connection.dialect))
        problems.found += filter(None, (port_problem(config.connection),))
    return problems.found


def port_problem(connection: Connection) -> str:
    """Return what is wrong with the port of an arm file: empty, as also if it names none."""
    if not is_can(connection.port):
        return ""
    if dialect(connection.dialect).bus is None:
        return (
            f"{connection.port} is a CAN bus, but a controller that speaks "
            f"{connection.dialect} is not on a bus: correct the port or the dialect"
        )
    try:
        CanAddress.parse(connection.port)
    except BadRequest as error:
        return str(error)
    return ""


def preset_arm(name: str, connection: Connection) -> ArmConfig:
    """Return the usual arm of a connection's dialect."""
    key = dialect(connection.dialect).preset
    table = {"dialect": connection.dialect, "baud": connection.baud}
    config = parse_arm({"model": key, "connection": table}, name=name)
    return replace(config, connection=connection, source=ConfigSource({"model": key}))
