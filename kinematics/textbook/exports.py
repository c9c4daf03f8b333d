"""The public names of the lecture notes, each from the module that defines it."""

from kinematics.textbook.accuracy import (
    MapPoint,
    StepRange,
    TipError,
    accuracy_map,
    explain_resolution,
    gearing_errors,
    length_errors,
    rounding_bound_mm,
    rounding_rms_mm,
    step_errors,
    step_ranges,
    zero_errors,
)
from kinematics.textbook.efficiency import (
    Efficiency,
    Ledger,
    Tally,
    Way,
    forward_ways,
    on_any_numbers,
)
from kinematics.textbook.notation import matrix_latex, matrix_text
from kinematics.textbook.symbolic_systems import symbolic_chain, symbolic_system
from kinematics.textbook.symbols import Symbol, coordinate, named
from kinematics.textbook.systems import SYSTEMS, system
from kinematics.textbook.systems.mini_movers import urdf_of_arm
from kinematics.textbook.systems.named import NamedBranch, System
from kinematics.textbook.worked_example import WorkedExample, work_chain, work_system

__all__ = [
    "SYSTEMS",
    "Efficiency",
    "Ledger",
    "MapPoint",
    "NamedBranch",
    "StepRange",
    "Symbol",
    "System",
    "Tally",
    "TipError",
    "Way",
    "WorkedExample",
    "accuracy_map",
    "coordinate",
    "explain_resolution",
    "forward_ways",
    "gearing_errors",
    "length_errors",
    "matrix_latex",
    "matrix_text",
    "named",
    "on_any_numbers",
    "rounding_bound_mm",
    "rounding_rms_mm",
    "step_errors",
    "step_ranges",
    "symbolic_chain",
    "symbolic_system",
    "system",
    "urdf_of_arm",
    "work_chain",
    "work_system",
    "zero_errors",
]
