"""Symbolic numbers that run through the same code as floats: sums of products of named atoms.

An atom is a name (a length, a joint variable), the cosine or sine of an angle, or a root,
quotient or arc function, which stay whole. Products are multiplied out, zeros and ones dropped,
and the addition theorems fold C1 C2 - S1 S2 into C12 (`symbol_folding`). Sums that depend on a
`coordinate` of a goal stay whole as factors, so that a solution keeps its shape.
`symbol_text` writes symbols in the notation of the notes. Angles in rad, lengths in mm.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from kinematics.numbers import QUARTER_TOLERANCE_RAD
from kinematics.symbol_folding import folded
from kinematics.symbol_terms import FUNCTIONS, Atom, Monomial, Terms, collect, joined, monomial_key

_QUARTER = math.pi / 2.0


@dataclass(frozen=True, slots=True)
class Symbol:
    """A sum of products of atoms, each with a factor; what has no terms is zero.

    Two symbols are equal where their terms are, which is sure to mean equal values; unequal ones
    may have equal values too. Symbols have no order: code that compares them ends in TypeError.
    """

    terms: tuple[tuple[Monomial, float], ...]
    key: str = field(default="", repr=False, compare=False)

    def __post_init__(self) -> None:
        key = "+".join(f"{factor!r}*{monomial_key(monomial)}" for monomial, factor in self.terms)
        object.__setattr__(self, "key", key)

    @property
    def number(self) -> float | None:
        """The plain number that this is, or None."""
        if not self.terms:
            return 0.0
        (monomial, factor), *more = self.terms
        return None if monomial or more else factor

    @property
    def of_goal(self) -> bool:
        """Whether the coordinates of a goal enter into this."""
        return any(atom.of_goal for monomial, _ in self.terms for atom, _ in monomial)

    def names(self) -> frozenset[str]:
        """Return the names that this symbol's value depends on."""
        found: set[str] = set()
        for monomial, _ in self.terms:
            for atom, _ in monomial:
                found.update(*(argument.names() for argument in atom.arguments))
                if not atom.arguments:
                    found.add(atom.name)
        return frozenset(found)

    def value(self, values: Mapping[str, Any]) -> Any:
        """Return the value for these values of the names, numbers of any kind.

        Raises `KinematicsError` for a name without a value.
        """
        total: Any = 0.0
        for monomial, factor in self.terms:
            product: Any = factor
            for atom, power in monomial:
                base = atom.value(values)
                for _ in range(abs(power)):
                    product = product * base if power > 0 else product / base
            total = total + product
        return total

    def __add__(self, other: Symbol | float) -> Symbol:
        return total_of((*self.terms, *as_symbol(other).terms))

    __radd__ = __add__

    def __neg__(self) -> Symbol:
        return Symbol(tuple((monomial, -factor) for monomial, factor in self.terms))

    def __pos__(self) -> Symbol:
        return self

    def __sub__(self, other: Symbol | float) -> Symbol:
        return self + (-as_symbol(other))

    def __rsub__(self, other: Symbol | float) -> Symbol:
        return (-self) + other

    def __mul__(self, other: Symbol | float) -> Symbol:
        return _product(self, as_symbol(other))

    __rmul__ = __mul__

    def __pow__(self, power: int) -> Symbol:
        product = ONE
        for _ in range(abs(power)):
            product = product * self
        return product if power >= 0 else ONE / product

    def __truediv__(self, other: Symbol | float) -> Symbol:
        return _quotient(self, as_symbol(other))

    def __rtruediv__(self, other: Symbol | float) -> Symbol:
        return _quotient(as_symbol(other), self)

    def __abs__(self) -> Symbol:
        if len(self.terms) != 1:
            return function("abs", self)
        ((monomial, factor),) = self.terms
        sizes = ((Atom("abs", (_of_atom(atom),)), power) for atom, power in monomial)
        return total_of([(joined(*sizes), abs(factor))])

    def cos(self) -> Symbol:
        """Return the cosine; whole quarter turns within the angle turn it into another one."""
        return _turned(self, 0)

    def sin(self) -> Symbol:
        """Return the sine: the cosine of a quarter turn less."""
        return _turned(self, 3)

    def sqrt(self) -> Symbol:
        """Return the square root: of one square, its absolute value."""
        if len(self.terms) == 1:
            ((monomial, factor),) = self.terms
            if factor > 0.0 and all(power % 2 == 0 for _, power in monomial):
                halves = tuple((atom, power // 2) for atom, power in monomial)
                return abs(Symbol(((halves, math.sqrt(factor)),)))
        return function("sqrt", self)

    def acos(self) -> Symbol:
        """Return the arc cosine, from 0 to pi."""
        return function("acos", self)

    def atan2(self, along: Symbol | float) -> Symbol:
        """Return the angle of the direction `along` along and this across."""
        return function("atan2", self, as_symbol(along))

    def atan2_of(self, across: Symbol | float) -> Symbol:
        """Return the angle of the direction this along and `across` across."""
        return function("atan2", as_symbol(across), self)


def named(name: str) -> Symbol:
    """Return the symbol of a length or a joint variable."""
    return _of_atom(Atom(name))


def coordinate(name: str) -> Symbol:
    """Return the symbol of a coordinate of a goal, which keeps sums whole."""
    return _of_atom(Atom(name, of_goal=True))


def as_symbol(value: Symbol | float) -> Symbol:
    """Return a plain number as a symbol, a symbol as it is."""
    if isinstance(value, Symbol):
        return value
    return Symbol((((), float(value)),)) if value != 0.0 else ZERO


def function(name: str, *arguments: Symbol) -> Symbol:
    """Return a function that stays whole; of plain numbers, its value."""
    plain = [argument.number for argument in arguments]
    if None not in plain:
        return as_symbol(FUNCTIONS[name](*plain))
    return _of_atom(Atom(name, arguments))


def total_of(terms: Iterable[tuple[Monomial, float]]) -> Symbol:
    """Return a sum, like terms collected and the addition theorems applied."""
    collected: Terms = {}
    for monomial, factor in terms:
        collect(collected, monomial, factor)
    kept = folded(collected)
    return Symbol(tuple(sorted(kept.items(), key=lambda term: monomial_key(term[0]))))


def _of_atom(atom: Atom) -> Symbol:
    return Symbol(((((atom, 1),), 1.0),))


def _product(left: Symbol, right: Symbol) -> Symbol:
    if len(left.terms) > 1 and len(right.terms) > 1 and (left.of_goal or right.of_goal):
        left, right = _kept_whole(left), _kept_whole(right)
    terms: list[tuple[Monomial, float]] = []
    for one, factor in left.terms:
        for other, more in right.terms:
            terms += _simplified(joined(*one, *other), factor * more)
    return total_of(terms)


def _kept_whole(total: Symbol) -> Symbol:
    """Return a sum as a single factor, written with its first term positive."""
    if total.terms[0][1] < 0.0:
        return -_of_atom(Atom("sum", (-total,)))
    return _of_atom(Atom("sum", (total,)))


def _simplified(monomial: Monomial, factor: float) -> Iterable[tuple[Monomial, float]]:
    """Return a term's terms with squared roots and squared absolute values taken out."""
    for atom, power in monomial:
        if atom.name in ("sqrt", "abs") and atom.arguments and power >= 2:
            rest = Symbol(((joined(*monomial, (atom, -2)), factor),))
            (inner,) = atom.arguments
            return (rest * inner if atom.name == "sqrt" else rest * inner * inner).terms
    return ((monomial, factor),)


def _quotient(over: Symbol, under: Symbol) -> Symbol:
    """Return a quotient: of single terms by their powers, of sums as a whole."""
    divisor = under.number
    if divisor is not None:
        return over * (1.0 / divisor)  # ZeroDivisionError, as of floats
    if not over.terms:
        return ZERO
    if over == under:
        return ONE
    if len(over.terms) == 1 and len(under.terms) == 1:
        (monomial, factor), (other, divided) = over.terms[0], under.terms[0]
        inverse = ((atom, -power) for atom, power in other)
        return total_of([(joined(*monomial, *inverse), factor / divided)])
    return function("quotient", over, under)


def _turned(angle: Symbol, quarters: int) -> Symbol:
    """Return the cosine of an angle and some quarter turns."""
    constant = dict(angle.terms).get((), 0.0)
    whole = round(constant / _QUARTER)
    if abs(constant - whole * _QUARTER) <= QUARTER_TOLERANCE_RAD:
        angle, quarters = angle - constant, quarters + whole
    if angle.number is not None:
        cosine, sine = as_symbol(math.cos(angle.number)), as_symbol(math.sin(angle.number))
    else:
        mirrored = _leading_factor(angle) < 0.0
        positive = -angle if mirrored else angle
        cosine, sine = function("cos", positive), function("sin", positive)
        sine = -sine if mirrored else sine
    return (cosine, -sine, -cosine, sine)[quarters % 4]


def _leading_factor(angle: Symbol) -> float:
    """Return the factor of the first term that is no constant."""
    return next(factor for monomial, factor in angle.terms if monomial)


ZERO = Symbol(())
ONE = Symbol((((), 1.0),))
