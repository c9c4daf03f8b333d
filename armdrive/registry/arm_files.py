"""Arm files, read with the sections of the dialects that the registry knows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from armdrive.config.arm import ArmConfig, ConfigSource, DialectSections, load, parse
from armdrive.config.check import problems_of
from armdrive.config.sections import Connection
from armdrive.registry import DEFAULT, dialect


def sections() -> DialectSections:
    """Return the dialects that an arm file may name."""
    return DialectSections(DEFAULT, dialect)


def load_arm(path: Path) -> ArmConfig:
    """Read an arm file. Raises `ArmFileError` that names the file, the key and the mend."""
    return load(path, sections())


def parse_arm(table: Mapping[str, Any], *, name: str, folder: Path = Path()) -> ArmConfig:
    """Turn a parsed TOML document into an arm; a model file is looked for from `folder`."""
    return parse(table, sections(), name=name, folder=folder)


def arm_problems(table: dict[str, Any], name: str, folder: Path) -> list[str]:
    """Return a sentence for everything that is wrong with an arm file, as it is found."""
    return problems_of(table, sections(), name, folder)


def preset_arm(key: str, *, name: str, connection: Connection) -> ArmConfig:
    """Return an arm as it leaves the factory, on the given wire."""
    wire = {"dialect": connection.dialect, "baud": connection.baud}
    config = parse_arm({"model": key, "connection": wire}, name=name)
    return replace(config, connection=connection, source=ConfigSource({"model": key}))
