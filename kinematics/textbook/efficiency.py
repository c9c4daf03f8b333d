"""The arithmetic that each way of computing an arm takes, counted by numbers that count.

Source: McKerrow, chapter 4, section 15 (efficiency of the kinematic solutions), whose counts of
multiplications, additions and trigonometric calls come here from running the very code. A `Count`
has a value, so that branches are taken as with floats, and a ledger that all numbers of one run
share. Negations, comparisons and copies are free; so is what is done with constants alone, which a
program does once, and what a constant 0, 1 or -1 makes unnecessary.

Sympy's `count_ops` is no substitute: it counts an expression, and knows neither the branches that
the running code takes nor what it computes once and uses twice, which is what is compared here.
"""

from __future__ import annotations

import math
import operator
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any

from kinematics.chains.chain import Chain
from kinematics.chains.links import JointKind, a_matrix
from kinematics.frames.transforms import Transform, compose
from kinematics.textbook.study import example_posture
from kinematics.textbook.systems.named import System


@dataclass(frozen=True, slots=True)
class Tally:
    """How many operations of each kind a computation takes."""

    multiplications: int = 0
    additions: int = 0
    divisions: int = 0
    roots: int = 0
    sines: int = 0
    arcs: int = 0
    """Sines and cosines; arc tangents."""

    @property
    def trigonometric(self) -> int:
        """Sines, cosines and their inverses together."""
        return self.sines + self.arcs


@dataclass(slots=True)
class Ledger:
    """The count of operations that all numbers of one run share, by the fields of `Tally`."""

    counts: Counter[str] = field(default_factory=Counter)

    def number(self, value: float) -> Count:
        """Return a number that counts in this ledger."""
        made = Count(value)
        made.ledger = self
        return made

    def numbers(self, values: Any) -> Any:
        """Return nested tuples of numbers (what a frame or a link table is) as counting ones."""
        if isinstance(values, tuple):
            return tuple(self.numbers(value) for value in values)
        return self.number(values)

    def tally(self) -> Tally:
        """Return what has been counted so far."""
        return Tally(**self.counts)


def _operation(
    kind: str, operate: Callable[[float, float], float], *, turned: bool = False
) -> Callable[[Count, float], float]:
    """Return the method for a counted operation of two numbers; `turned` exchanges them."""

    def method(self: Count, other: float) -> float:
        if type(other) is float:  # a constant of the arm
            if kind == "additions" and other == 0.0:
                return -self if turned else self
            if kind == "multiplications" and other == 0.0:
                return 0.0
            if kind == "multiplications" and abs(other) == 1.0:
                return self if other > 0.0 else -self
        pair = (float(other), float(self)) if turned else (float(self), float(other))
        return self.made(kind, operate(*pair))

    return method


def _function(kind: str, evaluate: Callable[[float], float]) -> Callable[[Count], Count]:
    """Return the method for a function of one number that is counted."""
    return lambda self: self.made(kind, evaluate(float(self)))


class Count(float):
    """A number that counts what is done with it in its ledger."""

    ledger: Ledger

    def made(self, kind: str, value: float) -> Count:
        """Return the result of an operation, and count it."""
        self.ledger.counts[kind] += 1
        return self.ledger.number(value)

    __add__ = __radd__ = _operation("additions", operator.add)
    __sub__ = _operation("additions", operator.sub)
    __rsub__ = _operation("additions", operator.sub, turned=True)
    __mul__ = __rmul__ = _operation("multiplications", operator.mul)
    __truediv__ = _operation("divisions", operator.truediv)
    __rtruediv__ = _operation("divisions", operator.truediv, turned=True)
    atan2 = _operation("arcs", math.atan2)
    atan2_of = _operation("arcs", math.atan2, turned=True)
    sin = _function("sines", math.sin)
    cos = _function("sines", math.cos)
    sqrt = _function("roots", math.sqrt)

    def __neg__(self) -> Count:
        return self.ledger.number(-float(self))

    def __abs__(self) -> Count:
        return self.ledger.number(abs(float(self)))


# The ways of computing an arm. Forward: the products of A matrices, without the zeros and ones of
# the link table, affine, and in full. Inverse: each branch by its formulas. All counts come from
# running the code.


@dataclass(frozen=True, slots=True)
class Way:
    """One way of computing: its name, a description, and its count of operations."""

    name: str
    what: str
    tally: Tally


@dataclass(frozen=True, slots=True)
class Efficiency:
    """The ways to compute a system forward and back."""

    system: str
    forward: tuple[Way, ...]
    inverse: tuple[Way, ...]


def efficiency(system: System) -> Efficiency:
    """Return the counts of a system at its example posture.

    Counts hardly depend on the posture: only branches in the code that a degenerate one takes
    differ.
    """
    chain = system.chain()
    posture = example_posture(chain)
    return Efficiency(
        system.name,
        forward_ways(chain, posture),
        tuple(_inverse_ways(system, posture)),
    )


def forward_ways(chain: Chain, joints: Sequence[float]) -> tuple[Way, ...]:
    """Return the counts of every way from a chain's link table to its hand's frame."""
    posture = tuple(joints)
    return (
        Way(
            "own products",
            "products of A matrices, the zeros and ones of the link table left out",
            _counted(chain.fk, posture),
        ),
        Way(
            "affine products",
            "products of A matrices, the last row 0, 0, 0, 1 left out",
            _of_table(chain, posture, _affine),
        ),
        Way(
            "full products",
            "products of A matrices with all sixteen entries",
            _of_table(chain, posture, _full),
        ),
    )


def _affine(matrices: list[Transform]) -> Transform:
    return compose(*matrices)


def _full(matrices: list[Transform]) -> Transform:
    return reduce(_product, matrices)


def _product(left: Transform, right: Transform) -> Transform:
    """Return the product of two 4x4 matrices, entry by entry, nothing left out."""
    columns = tuple(zip(*right, strict=True))
    first, second, third, fourth = (
        tuple(a * e + b * f + c * g + d * h for e, f, g, h in columns) for a, b, c, d in left
    )
    return first, second, third, fourth  # type: ignore[return-value]


def _of_table(
    chain: Chain,
    posture: tuple[float, ...],
    way: Callable[[list[Transform]], Transform],
) -> Tally:
    """Count a product of the A matrices without simplification: zeros and ones count too."""
    ledger = Ledger()
    matrices = []
    for link, value in zip(chain.links, posture, strict=True):
        theta, d, a, alpha = ledger.numbers(link.parameters(value))
        matrix = a_matrix(theta, d, a, alpha, chain.convention)
        matrices.append(ledger.numbers(tuple(tuple(map(float, line)) for line in matrix)))
    way(matrices)
    return _without_twists(ledger.tally(), chain)


def _without_twists(tally: Tally, chain: Chain) -> Tally:
    """Subtract the sines of the twists (and of sliding joints), which are constants."""
    turning = sum(link.kind is JointKind.REVOLUTE for link in chain.links)
    constant = 2 * (2 * len(chain.links) - turning)
    return replace(tally, sines=tally.sines - constant)


def _inverse_ways(system: System, posture: tuple[float, ...]) -> list[Way]:
    goal = system.goal_of(system.fk(posture))
    ways = [
        Way(name, "this branch alone, by its formulas", _counted(_branch(system, name), goal))
        for name in system.signs
    ]
    return [way for way in ways if way.tally != Tally()]


def _branch(system: System, name: str) -> Callable[[tuple[Any, ...]], object]:
    return lambda goal: system.solution(goal, name)


def _counted(way: Callable[[tuple[Any, ...]], object], numbers: Sequence[float]) -> Tally:
    ledger = Ledger()
    way(ledger.numbers(tuple(numbers)))
    return ledger.tally()
