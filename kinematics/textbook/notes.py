"""The texts of the lecture notes, from `notes.toml`: what they say of a system, and their rules."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from kinematics.chains.links import Convention


@dataclass(frozen=True, slots=True)
class NamedStep:
    """One step of a derivation: what is done, the formula in the notes' notation, and why."""

    title: str
    formula: str
    why: str = ""


@dataclass(frozen=True, slots=True)
class SystemNotes:
    """What the notes say of a system: its figure, and how it is solved, step by step.

    `angles` says how its joint angles count, where other arms of its build count them otherwise.
    """

    title: str
    source: str
    drawing: str
    derivation: tuple[NamedStep, ...]
    angles: str = ""


@cache
def notes_of(name: str) -> SystemNotes:
    """Return what the notes say of a system."""
    entry = _texts()[name]
    return SystemNotes(**entry | {"derivation": tuple(_steps(entry["derivation"]))})


@cache
def _texts() -> dict[str, dict[str, Any]]:
    return tomllib.loads(resources.files(__package__).joinpath("notes.toml").read_text("utf-8"))


def assignment_rules(convention: Convention) -> tuple[str, ...]:
    """Return what each of the thirteen steps does, for frame or link {k}.

    Craig's six rules are in the second list.
    """
    return tuple(_texts()["thirteen-steps"][convention.value])


def _steps(text: str) -> Iterator[NamedStep]:
    """Yield the steps of a derivation as `notes.toml` has them."""
    for step in re.split(r"\n(?=\S)", text.strip()):
        first, *others = step.split("\n")
        title, _, formula = first.partition(": ")
        more = [line.strip() for line in others if not line.startswith("    ")]
        why = [line.strip() for line in others if line.startswith("    ")]
        yield NamedStep(title, "  ".join((formula, *more)), " ".join(why))
