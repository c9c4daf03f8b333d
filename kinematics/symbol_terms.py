"""What symbols are made of: atoms, products of their powers, and sums of those.

An atom is a name, or a function of symbols that stays whole.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from kinematics import numbers
from kinematics.errors import KinematicsError

if TYPE_CHECKING:
    from kinematics.symbols import Symbol

CANCELLED = 1e-12
"""A sum this small beside its two terms is the rounding of zero."""


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


Monomial = tuple[tuple[Atom, int], ...]
"""Atoms with their powers (not zero), in the order of their keys."""

Terms = dict[Monomial, float]
"""Products with their factors (not zero)."""


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
    """Return what products are told apart and sorted by."""
    return " ".join(f"{atom.key}^{power}" for atom, power in monomial)


def _divided(over: Any, under: Any) -> Any:
    return over / under


def _itself(total: Any) -> Any:
    return total


FUNCTIONS: Mapping[str, Callable[..., Any]] = MappingProxyType(
    {
        "cos": numbers.cos,
        "sin": numbers.sin,
        "sqrt": numbers.sqrt,
        "acos": numbers.acos,
        "atan2": numbers.atan2,
        "abs": abs,
        "quotient": _divided,
        "sum": _itself,
    }
)
"""The functions that stay whole, by name, for numbers of any kind."""
