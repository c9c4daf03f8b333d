"""All mutants, by subject."""

from __future__ import annotations

from . import (
    bounds,
    devices,
    edges,
    jogs,
    mathematics,
    motions,
    positions,
    remembering,
    simulated,
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
    *mathematics.MUTANTS,
    *simulated.MUTANTS,
    *edges.MUTANTS,
    *bounds.MUTANTS,
)
