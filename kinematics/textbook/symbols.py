"""Symbolic numbers that run through the same code as floats: sums of products of named atoms.

An atom is a name (a length, a joint variable), the cosine or sine of an angle, or a root,
quotient or arc function, which stay whole. Products are multiplied out, zeros and ones dropped,
and the addition theorems fold C1 C2 - S1 S2 into C12. Sums that depend on a
`coordinate` of a goal stay whole as factors, so that a solution keeps its shape.
`notation` writes symbols in the notation of the notes. Angles in rad, lengths in mm.

We weighed sympy and kept this module. Sympy folds the addition theorems as well and as quickly (a
Puma's hand in 0.1 s, after 0.2 s of import). But brackets, the C12 of the notes, the named steps
and the sums kept whole would still be ours, and so would a wrapper with the methods that
`frames.numbers` calls. In exchange `explain --symbolic` would need 85 MB of packages.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations
from types import MappingProxyType
from typing import Any

from kinematics.errors import KinematicsError
from kinematics.frames import numbers
from kinematics.frames.numbers import QUARTER_TOLERANCE_RAD

# What symbols are made of: atoms, products of their powers, and sums of those. An atom is a name,
# or a function of symbols that stays whole.

# A sum this small in proportion to its two terms is zero but for rounding.
CANCELLED = 1e-12


_DIGITS = re.compile(r"\d+")


@dataclass(frozen=True, slots=True)
class Atom:
    """A name, or a function of symbols; `key` identifies it, and sorts by name, then number.

    `of_goal` says that it is a coordinate of a goal, or made of one.
    """

    name: str
    arguments: tuple[Symbol, ...] = field(default=(), compare=False)
    of_goal: bool = field(default=False, compare=False)
    key: str = field(default="", repr=False)

    def __post_init__(self) -> None:
        made_of_one = any(argument.of_goal for argument in self.arguments)
        object.__setattr__(self, "of_goal", self.of_goal or made_of_one)
        name = _DIGITS.sub(lambda digits: f"{len(digits[0]):02d}{digits[0]}", self.name)
        inner = ";".join(argument.key for argument in self.arguments)
        if not self.arguments:
            key = f"{'0' if self.name.isidentifier() else '1'}{name}"
        else:
            key = f"2{inner}:{name}" if self.is_trig else f"1{name}({inner})"
        object.__setattr__(self, "key", key)

    @property
    def is_trig(self) -> bool:
        """Whether this is the cosine or the sine of an angle."""
        return self.name in ("cos", "sin") and bool(self.arguments)

    def value(self, values: Mapping[str, Any]) -> Any:
        """Return the number that this atom is for these values of the names."""
        if not self.arguments:
            if self.name not in values:
                raise KinematicsError(f"no value is given for {self.name}")
            return values[self.name]
        return FUNCTIONS[self.name](*(argument.value(values) for argument in self.arguments))


# Atoms with their powers (not zero), in the order of their keys.
Monomial = tuple[tuple[Atom, int], ...]

# Products with their factors (not zero).
Terms = dict[Monomial, float]


def collect(terms: Terms, monomial: Monomial, factor: float) -> None:
    """Add a term to others; terms that cancel go."""
    before = terms.pop(monomial, 0.0)
    after = before + factor
    if abs(after) > CANCELLED * max(abs(before), abs(factor)):
        terms[monomial] = after


def joined(*factors: tuple[Atom, int]) -> Monomial:
    """Return the product of powers of atoms."""
    powers: dict[Atom, int] = {}
    for atom, power in factors:
        powers[atom] = powers.get(atom, 0) + power
    kept = [(atom, power) for atom, power in powers.items() if power]
    return tuple(sorted(kept, key=lambda factor: factor[0].key))


def monomial_key(monomial: Monomial) -> str:
    """Return the key that identifies a product and sorts it."""
    return " ".join(f"{atom.key}^{power}" for atom, power in monomial)


def _divided(over: Any, under: Any) -> Any:
    return over / under


def _itself(total: Any) -> Any:
    return total


# The functions that stay whole, by name, for numbers of any kind.
FUNCTIONS: Mapping[str, Callable[..., Any]] = MappingProxyType(
    {
        "cos": numbers.cos,
        "sin": numbers.sin,
        "sqrt": numbers.sqrt,
        "atan2": numbers.atan2,
        "abs": abs,
        "quotient": _divided,
        "sum": _itself,
    }
)


# The addition theorems at work in a sum of products: C1 C2 - S1 S2 is C12.
#
# Source: the trigonometric formulas at the end of "Vectors and frames", and McKerrow, chapter 4,
# section 7. Of two terms that differ only in that a pair of cosines and sines is swapped, one is
# made: C C and S S give the cosine of the sum or the difference, S C and C S the sine. With one
# angle twice this is C^2 + S^2 = 1.

# Relative difference below which two factors are the same.
_SAME = 1e-12

Pair = tuple[Atom, Atom]


def folded(terms: Terms) -> Terms:
    """Return the sum with as many pairs of terms folded as there are; each fold saves a term."""
    while True:
        replaced = _fold_once(terms)
        if replaced is None:
            return terms
        terms = replaced


def _fold_once(terms: Terms) -> Terms | None:
    for monomial, factor in terms.items():
        for pair in _trig_pairs(monomial):
            swapped = (_swapped(pair[0]), _swapped(pair[1]))
            rest = joined(*monomial, (pair[0], -1), (pair[1], -1))
            partner = joined(*rest, (swapped[0], 1), (swapped[1], 1))
            other = terms.get(partner)
            if other is None or partner == monomial:
                continue
            if math.isclose(abs(other), abs(factor), rel_tol=_SAME):
                one = _of_pair(pair, subtracted=(factor < 0.0) == (other < 0.0))
                return _replaced(terms, (monomial, partner), rest, factor, one)
    return None


def _trig_pairs(monomial: Monomial) -> Iterator[Pair]:
    trig = [atom for atom, power in monomial if atom.is_trig for _ in range(min(power, 2))]
    yield from combinations(trig, 2)


def _swapped(atom: Atom) -> Atom:
    return Atom("sin" if atom.name == "cos" else "cos", atom.arguments)


def _of_pair(pair: Pair, *, subtracted: bool) -> Symbol:
    """Return what a pair and its swapped partner make, for the pair's factor 1.

    `subtracted` says that both have the same sign. Then C C + S S is the cosine of the
    difference, and S C + C S the sine of the sum; with opposite signs it is the other way round.
    """
    (one, other) = pair
    (first,), (second,) = one.arguments, other.arguments
    if one.name == other.name:
        even = first - second if subtracted else first + second
        sign = 1.0 if one.name == "cos" or subtracted else -1.0
        return sign * even.cos()
    if one.name == "cos":  # C S - S C is the sine of the second angle less the first
        first, second = second, first
    return (first + second if subtracted else first - second).sin()


def _replaced(
    terms: Terms, gone: tuple[Monomial, Monomial], rest: Monomial, factor: float, one: Symbol
) -> Terms:
    kept = {monomial: value for monomial, value in terms.items() if monomial not in gone}
    for monomial, value in one.terms:
        collect(kept, joined(*rest, *monomial), factor * value)
    return kept


QUARTER = math.pi / 2.0


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
    whole = round(constant / QUARTER)
    if abs(constant - whole * QUARTER) <= QUARTER_TOLERANCE_RAD:
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
