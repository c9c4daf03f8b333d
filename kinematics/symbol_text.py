"""Symbols in the notation of the notes: C1, S12, l2 C12, as plain text and as LaTeX.

Sums are written with common cosines and sines in front of a bracket, as S1 (L2 S2 + L3 S23) in
equation 2.35. Definitions give whole sub-expressions a name, so that a solution can be written
step by step.
"""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from kinematics.frames import Transform
from kinematics.symbols import Atom, Monomial, Symbol, as_symbol

ENTRY_NAMES = (
    ("x_x", "y_x", "z_x", "p_x"),
    ("x_y", "y_y", "z_y", "p_y"),
    ("x_z", "y_z", "z_z", "p_z"),
)
"""The general transformation matrix of section 8."""

WIDEST = 96
"""Columns that a matrix may take before its entries are listed instead."""

GREEK = frozenset({"theta", "phi", "psi", "alpha", "beta", "gamma"})

Term = tuple[Monomial, float]
Piece = tuple[bool, str]
"""Whether a minus stands before it, and what stands there."""

_JOINT = re.compile(r"theta([1-9])")
_NUMBERED = re.compile(r"([A-Za-z]+?)_?(\d*)")


@dataclass(frozen=True)
class Notation(ABC):
    """How to write symbols; `names` are the definitions, written instead of what they stand for."""

    names: Mapping[Symbol, str] = field(default_factory=dict)

    def write(self, symbol: Symbol | float) -> str:
        """Return a symbol, or a plain number, as text."""
        given = as_symbol(symbol)
        if given in self.names:
            return self.name(self.names[given])
        return self.expanded(given)

    def expanded(self, given: Symbol) -> str:
        """Return a symbol as text without its own name, the right side of its definition."""
        if -given in self.names:
            return f"-{self.name(self.names[-given])}"
        pieces = self._pieces(list(given.terms))
        if not pieces:
            return "0"
        ordered = sorted(pieces, key=lambda piece: piece[0])
        first, *more = ordered
        written = f"-{first[1]}" if first[0] else first[1]
        return written + "".join(f" {'-' if minus else '+'} {text}" for minus, text in more)

    def _pieces(self, terms: list[Term]) -> list[Piece]:
        """Return what a sum adds up, common cosines and sines in front of brackets."""
        common = _most_common(terms)
        if common is None:
            return [self._term(*term) for term in terms]
        within = [
            (_less(monomial, common), factor)
            for monomial, factor in terms
            if _has(monomial, common)
        ]
        others = [term for term in terms if not _has(term[0], common)]
        minus = all(factor < 0.0 for _, factor in within)
        if minus:
            within = [(monomial, -factor) for monomial, factor in within]
        inner = self.expanded(Symbol(tuple(within)))
        bracket = self.bracket(inner)
        return [(minus, f"{self._atom(common)} {bracket}"), *self._pieces(others)]

    def _term(self, monomial: Monomial, factor: float) -> Piece:
        size = abs(factor)
        alone = len(monomial) == 1 and monomial[0][1] == 1 and size == 1.0
        over = [self._power(atom, power, alone) for atom, power in monomial if power > 0]
        under = [self._power(atom, -power, False) for atom, power in monomial if power < 0]
        if size != 1.0 or not over:
            over.insert(0, f"{size:.6g}")
        return factor < 0.0, self.fraction(" ".join(over), " ".join(under), len(under) > 1)

    def _power(self, atom: Atom, power: int, alone: bool) -> str:
        written = self._atom(atom)
        if atom.name == "quotient" and _whole(atom) not in self.names and not alone:
            written = self.bracket(written)
        return written if power == 1 else self.raised(written, power)

    def _atom(self, atom: Atom) -> str:
        whole = _whole(atom)
        if whole in self.names:
            return self.name(self.names[whole])
        if not atom.arguments:
            return self.name(atom.name)
        if atom.is_trig:
            return self.trig("C" if atom.name == "cos" else "S", *self._angle(atom.arguments[0]))
        return self.call(atom.name, [self.write(argument) for argument in atom.arguments])

    def _angle(self, angle: Symbol) -> tuple[str, bool]:
        """Return an angle's text, and whether it is a run of joint numbers as in C12."""
        numbers = []
        for monomial, factor in angle.terms:
            atom = monomial[0][0] if len(monomial) == 1 and monomial[0][1] == 1 else None
            joint = _JOINT.fullmatch(atom.name) if atom and not atom.arguments else None
            if joint is None or factor != 1.0:
                break
            numbers.append(joint[1])
        else:
            return "".join(numbers), True
        turned = dict(angle.terms).get((), 0.0)
        if turned == 0.0:
            return self.write(angle), False
        sign = "-" if turned < 0.0 else "+"
        return f"{self.write(angle - turned)} {sign} {self.degrees(abs(turned))}", False

    @abstractmethod
    def name(self, name: str) -> str:
        """Write a name."""

    @abstractmethod
    def trig(self, letter: str, angle: str, numbered: bool) -> str:
        """Write C or S of an angle."""

    @abstractmethod
    def call(self, function: str, arguments: Sequence[str]) -> str:
        """Write a function that stays whole."""

    @abstractmethod
    def bracket(self, inner: str) -> str:
        """Write brackets around a sum."""

    @abstractmethod
    def raised(self, base: str, power: int) -> str:
        """Write a power."""

    @abstractmethod
    def fraction(self, over: str, under: str, several: bool) -> str:
        """Write a quotient of products; `under` may be empty."""

    @abstractmethod
    def degrees(self, angle_rad: float) -> str:
        """Write a constant angle."""


class Text(Notation):
    """Plain characters: l2 C12, x^2, sqrt(x^2 + y^2)."""

    def name(self, name: str) -> str:
        """Write the name as it is."""
        return name

    def trig(self, letter: str, angle: str, numbered: bool) -> str:
        """Write C12, or C(phi)."""
        return f"{letter}{angle}" if numbered else f"{letter}({angle})"

    def call(self, function: str, arguments: Sequence[str]) -> str:
        """Write f(a, b), and a quotient with a slash."""
        if function == "quotient":
            over, under = arguments
            return f"({over}) / ({under})"
        return f"{function}({', '.join(arguments)})"

    def bracket(self, inner: str) -> str:
        """Write (inner)."""
        return f"({inner})"

    def raised(self, base: str, power: int) -> str:
        """Write base^power."""
        return f"{base}^{power}"

    def fraction(self, over: str, under: str, several: bool) -> str:
        """Write over / under."""
        if not under:
            return over
        return f"{over} / ({under})" if several else f"{over} / {under}"

    def degrees(self, angle_rad: float) -> str:
        """Write 30°."""
        return f"{math.degrees(angle_rad):.6g}°"


class Latex(Notation):
    """LaTeX's mathematics: l_{2} C_{12}, x^{2}."""

    def name(self, name: str) -> str:
        r"""Write theta1 as \theta_{1}, l2 as l_{2}, a word in upright letters."""
        found = _NUMBERED.fullmatch(name)
        if found is None:
            return rf"\mathrm{{{_escaped(name)}}}"
        letters, digits = found.groups()
        if letters in GREEK:
            letters = rf"\{letters}"
        elif len(letters) > 1:
            letters = rf"\mathrm{{{letters}}}"
        return f"{letters}_{{{digits}}}" if digits else letters

    def trig(self, letter: str, angle: str, numbered: bool) -> str:
        """Write C_{12}, or C(angle)."""
        return f"{letter}_{{{angle}}}" if numbered else f"{letter}({angle})"

    def call(self, function: str, arguments: Sequence[str]) -> str:
        """Write roots and fractions as such, other functions in upright letters."""
        inner = ", ".join(arguments)
        match function:
            case "quotient":
                return rf"\frac{{{arguments[0]}}}{{{arguments[1]}}}"
            case "sqrt":
                return rf"\sqrt{{{inner}}}"
            case "abs":
                return rf"\left|{inner}\right|"
        return rf"\operatorname{{{function}}}\left({inner}\right)"

    def bracket(self, inner: str) -> str:
        """Write brackets that grow with what is in them."""
        return rf"\left({inner}\right)"

    def raised(self, base: str, power: int) -> str:
        """Write the power after the base."""
        return f"{base}^{{{power}}}"

    def fraction(self, over: str, under: str, several: bool) -> str:  # noqa: ARG002
        """Write a fraction."""
        return rf"\frac{{{over}}}{{{under}}}" if under else over

    def degrees(self, angle_rad: float) -> str:
        r"""Write 30^\circ."""
        return rf"{math.degrees(angle_rad):.6g}^{{\circ}}"


def matrix_text(matrix: Transform, notation: Notation | None = None) -> str:
    """Return a matrix as text, its entries listed by name where it would be too wide."""
    writer = notation or Text()
    cells = [[writer.write(entry) for entry in row] for row in matrix]
    widths = [max(len(row[column]) for row in cells) for column in range(len(cells[0]))]
    if sum(widths) + 2 * len(widths) + 2 <= WIDEST:
        return "\n".join(f"[ {'  '.join(map(str.ljust, row, widths))} ]" for row in cells)
    return "\n".join(
        f"{name} = {cell}"
        for names, row in zip(_by_column(ENTRY_NAMES), _by_column(cells[:3]), strict=True)
        for name, cell in zip(names, row, strict=True)
    )


def matrix_latex(matrix: Transform, notation: Notation | None = None) -> str:
    """Return a matrix as LaTeX."""
    writer = notation or Latex()
    rows = (" & ".join(writer.write(entry) for entry in row) for row in matrix)
    inner = " \\\\\n".join(rows)
    return f"\\begin{{bmatrix}}\n{inner}\n\\end{{bmatrix}}"


def _by_column(rows: Iterable[Sequence[str]]) -> list[tuple[str, ...]]:
    return list(zip(*rows, strict=True))


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


def _whole(atom: Atom) -> Symbol:
    return Symbol(((((atom, 1),), 1.0),))


def _escaped(name: str) -> str:
    return name.replace("_", r"\_")
