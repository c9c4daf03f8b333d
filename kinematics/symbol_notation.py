"""How symbols are written down, whatever the characters: the order of terms, brackets, C12.

Sums are written with common cosines and sines in front of a bracket, as S1 (L2 S2 + L3 S23) in
equation 2.35. `Text` and `Latex` (`symbol_text`) say what each part looks like.
"""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Sequence

from kinematics.numbers import QUARTER_TOLERANCE_RAD
from kinematics.symbol_terms import Atom, Monomial
from kinematics.symbols import Symbol, as_symbol

Term = tuple[Monomial, float]
Piece = tuple[bool, bool, str]
"""Whether a minus stands before it, whether it turns with a joint, and what stands there."""

_QUARTER = math.pi / 2.0
_JOINT = re.compile(r"theta([1-9])")
_PLAIN_NAME = re.compile(r"\w+")


class Notation(ABC):
    """How to write symbols."""

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
        bracket = self.bracket(self.write(inner))
        return [(minus, True, f"{self._atom(common)} {bracket}"), *self._pieces(others)]

    def _term(self, monomial: Monomial, factor: float) -> Piece:
        size = abs(factor)
        alone = size == 1.0 and len(monomial) == 1 and monomial[0][1] == 1
        over = [self._power(atom, power, alone) for atom, power in monomial if power > 0]
        under = [self._power(atom, -power, False) for atom, power in monomial if power < 0]
        if size != 1.0 or not over:
            over.insert(0, self._constant(size))
        turns = any(atom.is_trig for atom, _ in monomial)
        written = self.fraction(" ".join(over), " ".join(under), several=len(under) > 1)
        return factor < 0.0, turns, written

    def _constant(self, size: float) -> str:
        """Write a number; quarter turns, which only angles add, by their name."""
        quarters = round(size / _QUARTER)
        if not quarters or abs(size - quarters * _QUARTER) > QUARTER_TOLERANCE_RAD:
            return f"{size:.6g}"
        over, under = (quarters, "/2") if quarters % 2 else (quarters // 2, "")
        return f"{over} {self.name('pi')}{under}".removeprefix("1 ")

    def _power(self, atom: Atom, power: int, alone: bool) -> str:
        written = self._atom(atom)
        compound = atom.name in ("quotient", "sum") and atom.arguments
        unclear = not atom.arguments and not _PLAIN_NAME.fullmatch(atom.name)
        if (compound and not alone) or (unclear and power > 1 and " " in atom.name):
            written = self.bracket(written)
        return written if power == 1 else self.raised(written, power)

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
            return self.numbered(letter, numbers)
        turned = dict(angle.terms).get((), 0.0)
        written = self.write(angle - turned)
        if turned:
            written += f" {'-' if turned < 0.0 else '+'} {self.degrees(abs(turned))}"
        return f"{letter}{self.bracket(written)}"

    @abstractmethod
    def name(self, name: str) -> str:
        """Write a name."""

    @abstractmethod
    def numbered(self, letter: str, numbers: str) -> str:
        """Write C or S of the sum of joint angles with these numbers."""

    @abstractmethod
    def call(self, function: str, arguments: Sequence[str]) -> str:
        """Write a function that stays whole."""

    @abstractmethod
    def bracket(self, inner: str) -> str:
        """Write brackets around something."""

    @abstractmethod
    def raised(self, base: str, power: int) -> str:
        """Write a power."""

    @abstractmethod
    def fraction(self, over: str, under: str, *, several: bool) -> str:
        """Write a quotient of products; `under` may be empty, or have `several` factors."""

    @abstractmethod
    def degrees(self, angle_rad: float) -> str:
        """Write a constant angle."""


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
