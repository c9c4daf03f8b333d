"""Straight-line code under construction: sums of products, constants folded, nothing twice.

A `Term` is a constant times at most one variable; what cannot stay a term becomes an assignment.
Only the names made here and the representations of floats enter the source.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple


class Term(NamedTuple):
    """A factor times a variable; a variable of no name is the number 1."""

    factor: float
    variable: str = ""

    def __neg__(self) -> Term:
        return Term(-self.factor, self.variable)


ZERO = Term(0.0)
ONE = Term(1.0)

Monomial = tuple[str, ...]


@dataclass(slots=True)
class Lines:
    """Assignments in order, each made once; `live` leaves out those that nothing needs."""

    _assigned: dict[str, str] = field(default_factory=dict)
    """Expression to name."""
    _needs: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Name to the names in its expression."""

    def total(self, *products: tuple[Term, ...]) -> Term:
        """Return the sum of products of terms, as a term where it is one."""
        monomials = _collect(products)
        if not monomials:
            return ZERO
        if len(monomials) == 1:
            [(variables, factor)] = monomials.items()
            if len(variables) < 2:
                return Term(factor, *variables)
            return Term(factor, self.assign("*".join(variables), variables))
        # a positive term first saves the sign in front
        ordered = sorted(monomials.items(), key=lambda item: item[1] < 0.0)
        source = "".join(
            _signed(factor, variables, first=index == 0)
            for index, (variables, factor) in enumerate(ordered)
        )
        return Term(1.0, self.assign(source, [name for names in monomials for name in names]))

    def call(self, function: str, argument: Term) -> Term:
        """Return a function's value at a term."""
        source = f"{function}({text(argument)})"
        return Term(1.0, self.assign(source, (argument.variable,)))

    def assign(self, source: str, needs: Iterable[str]) -> str:
        """Return the name that holds an expression's value."""
        name = self._assigned.get(source)
        if name is None:
            name = f"v{len(self._assigned)}"
            self._assigned[source] = name
            self._needs[name] = tuple(needs)
        return name

    def live(self, results: Iterable[Term]) -> list[str]:
        """Return the assignments that these results need, in order."""
        wanted = {term.variable for term in results}
        kept = []
        for source, name in reversed(self._assigned.items()):
            if name in wanted:
                wanted.update(self._needs[name])
                kept.append(f"{name} = {source}")
        return kept[::-1]


def text(term: Term) -> str:
    """Return the source of a term."""
    if term.variable and term.factor != 0.0:
        return _signed(term.factor, (term.variable,), first=True)
    return repr(term.factor + 0.0)


def _collect(products: Iterable[tuple[Term, ...]]) -> dict[Monomial, float]:
    """Return the factor of every monomial, those that cancel left out."""
    found: dict[Monomial, float] = {}
    for product in products:
        factor = 1.0
        for term in product:
            factor *= term.factor
        variables = tuple(sorted(term.variable for term in product if term.variable))
        found[variables] = found.get(variables, 0.0) + factor
    return {variables: factor for variables, factor in found.items() if factor != 0.0}


def _signed(factor: float, variables: Monomial, *, first: bool) -> str:
    sign = "-" if factor < 0.0 else ("" if first else "+")
    size = abs(factor)
    factors = [repr(size), *variables] if size != 1.0 or not variables else list(variables)
    return sign + "*".join(factors)
