"""All mutants, by subject."""

from __future__ import annotations

from . import (
    devices,
    jogs,
    motions,
    positions,
    remembering,
    stops,
)
from .mutant import Mutant

MUTANTS: tuple[Mutant, ...] = (
    *stops.MUTANTS,
    *jogs.MUTANTS,
    *positions.MUTANTS,
    *motions.MUTANTS,
    *remembering.MUTANTS,
    *devices.MUTANTS,
)
