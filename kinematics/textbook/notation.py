"""How symbols are written down, as plain text and as LaTeX: the order of terms, brackets, C12.

Sums are written with common cosines and sines in front of a bracket, as S1 (L2 S2 + L3 S23) in
equation 2.35. `PLAIN` and `LATEX` say what each part looks like; `definitions` names the steps
of a solution.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from kinematics.frames.numbers import QUARTER_TOLERANCE_RAD
from kinematics.frames.transforms import Transform
from kinematics.text import aligned
from kinematics.textbook.symbols import (
    QUARTER,
    Atom,
    Monomial,
    Symbol,
    Terms,
    as_symbol,
    function,
    named,
)

Term = tuple[Monomial, float]
# Whether a minus stands before it, whether it turns with a joint, and what stands there.
Piece = tuple[bool, bool, str]

_JOINT = re.compile(r"theta([1-9])")
_PLAIN_NAME = re.compile(r"\w+")


@dataclass(frozen=True, slots=True)
class Notation:
    """How to write symbols: how to write a name, and a template for everything else."""

    name: Callable[[str], str]
    """Write a name."""

    numbered: str
    """C or S of the sum of joint angles with some numbers."""

    bracket: str
    raised: str
    """A base and its power."""

    quotient: str
    quotient_of_several: str
    """A quotient of products, and one whose divisor has several factors."""

    degrees: str
    function: str
    """A function that stays whole: its name and its arguments."""

    functions: Mapping[str, str]
    """The functions that are written in another way: of their first argument and the second."""

    def write(self, symbol: Symbol | float) -> str:
        """Return a symbol, or a plain number, as text."""
        pieces = self._pieces(as_symbol(symbol).terms) or [(False, False, "0")]
        first, *more = sorted(pieces, key=lambda piece: piece[:2])
        written = f"-{first[2]}" if first[0] else first[2]
        return written + "".join(f" {'-' if minus else '+'} {text}" for minus, _, text in more)

    def _pieces(self, terms: Sequence[Term]) -> list[Piece]:
        """Return what a sum adds up, common cosines and sines in front of brackets."""
        common = _most_common(terms)
        if common is None:
            return [self._term(*term) for term in terms]
        inside = [term for term in terms if _has(term[0], common)]
        others = [term for term in terms if not _has(term[0], common)]
        minus = all(factor < 0.0 for _, factor in inside)
        inner = Symbol(
            tuple(
                (_less(monomial, common), -factor if minus else factor)
                for monomial, factor in inside
            )
        )
        bracket = self.bracket.format(self.write(inner))
        return [(minus, True, f"{self._atom(common)} {bracket}"), *self._pieces(others)]

    def _term(self, monomial: Monomial, factor: float) -> Piece:
        size = abs(factor)
        alone = size == 1.0 and len(monomial) == 1 and monomial[0][1] == 1
        over = [self._power(atom, power, alone) for atom, power in monomial if power > 0]
        under = [self._power(atom, -power, False) for atom, power in monomial if power < 0]
        if size != 1.0 or not over:
            over.insert(0, self._constant(size))
        turns = any(atom.is_trig for atom, _ in monomial)
        written = " ".join(over)
        if under:
            template = self.quotient_of_several if len(under) > 1 else self.quotient
            written = template.format(written, " ".join(under))
        return factor < 0.0, turns, written

    def _constant(self, size: float) -> str:
        """Write a number; quarter turns, which only angles add, by their name."""
        quarters = round(size / QUARTER)
        if not quarters or abs(size - quarters * QUARTER) > QUARTER_TOLERANCE_RAD:
            return f"{size:.6g}"
        over, under = (quarters, "/2") if quarters % 2 else (quarters // 2, "")
        return f"{over} {self.name('pi')}{under}".removeprefix("1 ")

    def _power(self, atom: Atom, power: int, alone: bool) -> str:
        written = self._atom(atom)
        compound = atom.name in ("quotient", "sum") and atom.arguments
        unclear = not atom.arguments and not _PLAIN_NAME.fullmatch(atom.name)
        if (compound and not alone) or (unclear and power > 1 and " " in atom.name):
            written = self.bracket.format(written)
        return written if power == 1 else self.raised.format(written, power)

    def _atom(self, atom: Atom) -> str:
        if not atom.arguments:
            return self.name(atom.name)
        if atom.is_trig:
            return self.trig("C" if atom.name == "cos" else "S", atom.arguments[0])
        return self.call(atom.name, [self.write(argument) for argument in atom.arguments])

    def trig(self, letter: str, angle: Symbol) -> str:
        """Write C or S of an angle: C12 of theta1 + theta2, C(phi) of others."""
        numbers = _joint_numbers(angle)
        if numbers:
            return self.numbered.format(letter, numbers)
        turned = dict(angle.terms).get((), 0.0)
        written = self.write(angle - turned)
        if turned:
            constant = self.degrees.format(f"{math.degrees(abs(turned)):.6g}")
            written += f" {'-' if turned < 0.0 else '+'} {constant}"
        return f"{letter}{self.bracket.format(written)}"

    def call(self, function: str, arguments: Sequence[str]) -> str:
        """Write a function that stays whole."""
        template = self.functions.get(function)
        if template is None:
            return self.function.format(function, ", ".join(arguments))
        return template.format(*arguments)


def _joint_numbers(angle: Symbol) -> str:
    """Return the numbers of the joint angles that an angle adds up, or nothing."""
    numbers = []
    for monomial, factor in angle.terms:
        plain = len(monomial) == 1 and monomial[0][1] == 1 and factor == 1.0
        atom = monomial[0][0] if plain else None
        joint = _JOINT.fullmatch(atom.name) if atom and not atom.arguments else None
        if joint is None:
            return ""
        numbers.append(joint[1])
    return "".join(numbers)


def _most_common(terms: Sequence[Term]) -> Atom | None:
    """Return the cosine or sine that the most terms share, the first of them in order."""
    counted = Counter(
        atom for monomial, _ in terms for atom, power in monomial if atom.is_trig and power > 0
    )
    shared = [(-count, atom.key, atom) for atom, count in counted.items() if count > 1]
    return min(shared)[2] if shared else None


def _has(monomial: Monomial, atom: Atom) -> bool:
    return any(one == atom and power > 0 for one, power in monomial)


def _less(monomial: Monomial, atom: Atom) -> Monomial:
    """Return the monomial without one power of an atom."""
    lowered = ((one, power - (one == atom)) for one, power in monomial)
    return tuple((one, power) for one, power in lowered if power)


# Symbols and matrices of them as plain text and as LaTeX: C1, S12, l2 C12.

# The general transformation matrix of McKerrow, chapter 4, section 8.
ENTRY_NAMES = (
    ("x_x", "y_x", "z_x", "p_x"),
    ("x_y", "y_y", "z_y", "p_y"),
    ("x_z", "y_z", "z_z", "p_z"),
)

# Columns that a matrix may take before its entries are listed instead.
WIDEST = 96

GREEK = frozenset({"theta", "phi", "psi", "alpha", "beta", "gamma", "rho", "pi"})

_NUMBERED = re.compile(r"([A-Za-z]+?)_?(\d*)")
_FUNCTION = re.compile(r"(cos|sin)\((\w+)\)")


def _latex_name(name: str) -> str:
    r"""Write theta1 as \theta_{1}, l2 as l_{2}, words in upright letters."""
    function = _FUNCTION.fullmatch(name)
    if function:
        return rf"\{function[1]}({_latex_name(function[2])})"
    if " " in name:
        return " ".join(map(_latex_name, name.split()))
    found = _NUMBERED.fullmatch(name)
    if found is None:
        return rf"\mathrm{{{_escaped(name)}}}"
    letters, digits = found.groups()
    if letters in GREEK:
        letters = rf"\{letters}"
    elif len(letters) > 1:
        letters = rf"\mathrm{{{letters}}}"
    return f"{letters}_{{{digits}}}" if digits else letters


# Plain characters: l2 C12, x^2, sqrt(x^2 + y^2).
PLAIN = Notation(
    name=str,
    numbered="{}{}",
    bracket="({})",
    raised="{}^{}",
    quotient="{} / {}",
    quotient_of_several="{} / ({})",
    degrees="{}°",
    function="{}({})",
    functions=MappingProxyType({"quotient": "({}) / ({})", "abs": "|{}|", "sum": "{}"}),
)

# LaTeX's mathematics: l_{2} C_{12}, x^{2}.
LATEX = Notation(
    name=_latex_name,
    numbered="{}_{{{}}}",
    bracket=r"\left({}\right)",
    raised="{}^{{{}}}",
    quotient=r"\frac{{{}}}{{{}}}",
    quotient_of_several=r"\frac{{{}}}{{{}}}",
    degrees=r"{}^{{\circ}}",
    function=r"\operatorname{{{}}}\left({}\right)",
    functions=MappingProxyType(
        {
            "quotient": r"\frac{{{}}}{{{}}}",
            "sqrt": r"\sqrt{{{}}}",
            "abs": r"\left|{}\right|",
            "sum": "{}",
        }
    ),
)


def notation(*, latex: bool) -> Notation:
    """Return LaTeX's notation, or the one in plain characters."""
    return LATEX if latex else PLAIN


def matrix_text(matrix: Transform) -> str:
    """Return a matrix as text; where it would be too wide, its entries listed by their names."""
    cells = [[PLAIN.write(entry) for entry in row] for row in matrix]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    if sum(widths) + 2 * len(widths) + 2 > WIDEST:
        return "\n".join(
            f"{name} = {cell}"
            for names, column in zip(_columns(ENTRY_NAMES), _columns(cells[:3]), strict=True)
            for name, cell in zip(names, column, strict=True)
        )
    return "\n".join(f"[ {row} ]" for row in aligned(cells, left=4))


def matrix_latex(matrix: Transform) -> str:
    """Return a matrix as LaTeX, for use in a formula."""
    rows = (" & ".join(map(LATEX.write, row)) for row in matrix)
    inner = " \\\\\n".join(rows)
    return f"\\begin{{bmatrix}}\n{inner}\n\\end{{bmatrix}}"


def _columns(rows: Iterable[Sequence[str]]) -> list[tuple[str, ...]]:
    return list(zip(*rows, strict=True))


def _escaped(name: str) -> str:
    return re.sub(r"([_|^%&#$])", r"\\\1", name)


# A solution written step by step: what has a name is written by it wherever it occurs again. The
# steps come from running the code once; which expression is part of which is found afterwards, so
# that theta4 = P - theta2 - theta3 is written although the code added up other sums.


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
