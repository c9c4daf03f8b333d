"""A solution written step by step: what has a name is written by it wherever it occurs again.

The steps come from running the code once; which expression is part of which is found afterwards,
so that theta4 = P - theta2 - theta3 is written although the code added up other sums.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from kinematics.symbol_terms import Atom, Terms
from kinematics.symbols import Symbol, as_symbol, function, named


@dataclass(frozen=True, slots=True)
class Definition:
    """A name and what it stands for, in terms of the names defined before it."""

    name: str
    symbol: Symbol


def definitions(pairs: Iterable[tuple[str, Symbol | float]]) -> tuple[Definition, ...]:
    """Return named values as steps, each one after those that it uses, without repetition.

    A second value under the same name is another one, and gets a prime.
    """
    listed: dict[str, Symbol] = {}
    for name, value in pairs:
        symbol = as_symbol(value)
        while listed.get(name, symbol) != symbol:
            name += "'"
        listed[name] = symbol
    names: dict[Symbol, str] = {}
    for name, symbol in listed.items():
        if not _is_plain(symbol):
            names.setdefault(symbol, name)
    steps = []
    for name, symbol in listed.items():
        others = {one: called for one, called in names.items() if called != name}
        steps.append(Definition(name, renamed(symbol, others)))
    return _in_order(steps)


def renamed(symbol: Symbol, names: Mapping[Symbol, str]) -> Symbol:
    """Return a symbol with every part that has a name, or whose negative has one, replaced."""
    rest: Terms = dict(symbol.terms)
    total = as_symbol(0.0)
    for known in sorted(names, key=lambda one: -len(one.terms)):
        for sign in (1.0, -1.0):
            wanted = {monomial: sign * factor for monomial, factor in known.terms}
            if wanted.items() <= rest.items():
                total = total + sign * named(names[known])
                rest = {term: factor for term, factor in rest.items() if term not in wanted}
                break
    for monomial, factor in rest.items():
        product = as_symbol(factor)
        for atom, power in monomial:
            product = product * _atom(atom, names) ** power
        total = total + product
    return total


def _atom(atom: Atom, names: Mapping[Symbol, str]) -> Symbol:
    whole = Symbol(((((atom, 1),), 1.0),))
    if whole in names:
        return named(names[whole])
    if not atom.arguments:
        return whole
    inner = [renamed(argument, names) for argument in atom.arguments]
    match atom.name:
        case "cos":
            return inner[0].cos()
        case "sin":
            return inner[0].sin()
        case "sum" if len(inner[0].terms) == 1:
            return inner[0]
    return function(atom.name, *inner)


def _is_plain(symbol: Symbol) -> bool:
    """Whether this is a number, or a name itself, and needs no other name."""
    if len(symbol.terms) != 1:
        return not symbol.terms
    ((monomial, _),) = symbol.terms
    return not monomial or (len(monomial) == 1 and not monomial[0][0].arguments)


def _in_order(steps: list[Definition]) -> tuple[Definition, ...]:
    """Return the steps with each after those it uses, otherwise in the order given."""
    waiting, done = list(steps), []
    while waiting:
        later = {step.name for step in waiting}
        ready = next(
            (step for step in waiting if not step.symbol.names() & (later - {step.name})),
            waiting[0],
        )
        waiting.remove(ready)
        done.append(ready)
    return tuple(done)
