"""Strategies and comparisons for the named systems."""

import math
from functools import cache

from chain_cases import gap
from hypothesis import strategies as st

from kinematics.chains.links import JointKind
from kinematics.textbook.study import subject_of_system
from kinematics.textbook.symbols import as_symbol
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.worked_example import symbolic_example


@cache
def symbolic_example_of(name):
    """A system in symbols; the Puma's takes half a second."""
    return symbolic_example(subject_of_system(SYSTEMS[name]))


QUARTERS = tuple(n * math.pi / 2 for n in range(-2, 3))
FURTHEST_MM = 300.0


def _values(low, high, kind):
    if kind is JointKind.REVOLUTE:
        low, high = max(low, -math.pi), min(high, math.pi)
        corners = [quarter for quarter in QUARTERS if low <= quarter <= high]
        return st.floats(low, high) | st.sampled_from(corners)
    return st.floats(max(low, 0.0), min(high, FURTHEST_MM)).map(lambda d: round(d, 6))


def postures(system):
    """Postures within a system's limits, right angles among them."""
    chain = system.chain()
    return st.tuples(
        *(_values(*limits, kind) for limits, kind in zip(chain.limits, chain.kinds, strict=True))
    )


def symbols_gap(symbolic, numeric, values):
    """The largest difference of a matrix of symbols, for these values of names, and of numbers."""
    return gap(
        tuple(tuple(as_symbol(entry).value(values) for entry in row) for row in symbolic), numeric
    )


def same_joints(system, a, b, rad=1e-6, mm=1e-4):
    return all(
        abs(math.remainder(x - y, math.tau)) <= rad
        if kind is JointKind.REVOLUTE
        else abs(x - y) <= mm
        for x, y, kind in zip(a, b, system.chain().kinds, strict=True)
    )


def same_goal(system, a, b, rad=1e-7, mm=1e-6):
    return all(
        abs(math.remainder(x - y, math.tau)) <= rad if name.endswith("_rad") else abs(x - y) <= mm
        for name, x, y in zip(system.coordinates, a, b, strict=True)
    )
