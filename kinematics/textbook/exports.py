"""The public names of the lecture notes, each from the module that defines it.

A name is imported as itself to be public (what type checkers call a re-export): no second list.
"""

from kinematics.textbook.accuracy import StepRange as StepRange
from kinematics.textbook.accuracy import TipError as TipError
from kinematics.textbook.accuracy import explain_resolution as explain_resolution
from kinematics.textbook.accuracy import gearing_errors as gearing_errors
from kinematics.textbook.accuracy import length_errors as length_errors
from kinematics.textbook.accuracy import rounding_bound_mm as rounding_bound_mm
from kinematics.textbook.accuracy import rounding_rms_mm as rounding_rms_mm
from kinematics.textbook.accuracy import step_errors as step_errors
from kinematics.textbook.accuracy import step_ranges as step_ranges
from kinematics.textbook.accuracy import zero_errors as zero_errors
from kinematics.textbook.efficiency import Efficiency as Efficiency
from kinematics.textbook.efficiency import Tally as Tally
from kinematics.textbook.efficiency import Way as Way
from kinematics.textbook.efficiency import forward_ways as forward_ways
from kinematics.textbook.notation import matrix_latex as matrix_latex
from kinematics.textbook.notation import matrix_text as matrix_text
from kinematics.textbook.study import Study as Study
from kinematics.textbook.study import subject_of_chain as subject_of_chain
from kinematics.textbook.study import subject_of_system as subject_of_system
from kinematics.textbook.symbols import Symbol as Symbol
from kinematics.textbook.symbols import coordinate as coordinate
from kinematics.textbook.symbols import named as named
from kinematics.textbook.systems import SYSTEMS as SYSTEMS
from kinematics.textbook.systems import system as system
from kinematics.textbook.systems.named import NamedBranch as NamedBranch
from kinematics.textbook.systems.named import System as System
from kinematics.textbook.worked_example import symbolic_chain as symbolic_chain
from kinematics.textbook.worked_example import symbolic_system as symbolic_system
from kinematics.textbook.worked_example import work as work
