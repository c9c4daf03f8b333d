"""The addition theorems at work in a sum of products: C1 C2 - S1 S2 is C12.

Source: the trigonometric formulas at the end of "Vectors and frames", and McKerrow, chapter 4,
section 7. Of two terms that differ only in that a pair of cosines and sines is swapped, one is
made: C C and S S give the cosine of the sum or the difference, S C and C S the sine. With one
angle twice this is C^2 + S^2 = 1.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

from kinematics.symbol_terms import Atom, Monomial, Terms, collect, joined

if TYPE_CHECKING:
    from kinematics.symbols import Symbol

_SAME = 1e-12
"""Relative difference below which two factors are the same."""

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
