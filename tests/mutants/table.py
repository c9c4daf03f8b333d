"""All mutants: the rows of the TOML files beside this one, by subject, and scaled stop bounds."""

import tomllib
from pathlib import Path

from . import bounds
from .mutant import Mutant

SUBJECTS = (
    "stops",
    "jogs",
    "positions",
    "motions",
    "remembering",
    "devices",
    "mathematics",
    "simulated",
    "edges",
)


def read(subject: str) -> tuple[Mutant, ...]:
    """Return the rows of a file, each of which has the fields of a `Mutant`."""
    text = Path(__file__).with_name(f"{subject}.toml").read_text(encoding="utf-8")
    rows = tomllib.loads(text)["mutant"]
    return tuple(Mutant(**{**row, "tests": tuple(row["tests"])}) for row in rows)


MUTANTS = (*(row for subject in SUBJECTS for row in read(subject)), *bounds.MUTANTS)
