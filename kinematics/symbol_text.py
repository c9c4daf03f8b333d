"""Symbols and matrices of them as plain text and as LaTeX: C1, S12, l2 C12."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence

from kinematics.frames import Transform
from kinematics.symbol_notation import Notation

ENTRY_NAMES = (
    ("x_x", "y_x", "z_x", "p_x"),
    ("x_y", "y_y", "z_y", "p_y"),
    ("x_z", "y_z", "z_z", "p_z"),
)
"""The general transformation matrix of McKerrow, chapter 4, section 8."""

WIDEST = 96
"""Columns that a matrix may take before its entries are listed instead."""

GREEK = frozenset({"theta", "phi", "psi", "alpha", "beta", "gamma", "rho", "pi"})

_NUMBERED = re.compile(r"([A-Za-z]+?)_?(\d*)")
_FUNCTION = re.compile(r"(cos|sin)\((\w+)\)")


class Text(Notation):
    """Plain characters: l2 C12, x^2, sqrt(x^2 + y^2)."""

    def name(self, name: str) -> str:
        """Write the name as it is."""
        return name

    def numbered(self, letter: str, numbers: str) -> str:
        """Write C12."""
        return f"{letter}{numbers}"

    def call(self, function: str, arguments: Sequence[str]) -> str:
        """Write f(a, b), a quotient with a slash, an absolute value with bars."""
        inner = ", ".join(arguments)
        match function:
            case "quotient":
                return f"({arguments[0]}) / ({arguments[1]})"
            case "abs":
                return f"|{inner}|"
            case "sum":
                return inner
        return f"{function}({inner})"

    def bracket(self, inner: str) -> str:
        """Write (inner)."""
        return f"({inner})"

    def raised(self, base: str, power: int) -> str:
        """Write base^power."""
        return f"{base}^{power}"

    def fraction(self, over: str, under: str, *, several: bool) -> str:
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
        r"""Write theta1 as \theta_{1}, l2 as l_{2}, words in upright letters."""
        function = _FUNCTION.fullmatch(name)
        if function:
            return rf"\{function[1]}({self.name(function[2])})"
        if " " in name:
            return " ".join(map(self.name, name.split()))
        found = _NUMBERED.fullmatch(name)
        if found is None:
            return rf"\mathrm{{{_escaped(name)}}}"
        letters, digits = found.groups()
        if letters in GREEK:
            letters = rf"\{letters}"
        elif len(letters) > 1:
            letters = rf"\mathrm{{{letters}}}"
        return f"{letters}_{{{digits}}}" if digits else letters

    def numbered(self, letter: str, numbers: str) -> str:
        """Write C_{12}."""
        return f"{letter}_{{{numbers}}}"

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
            case "sum":
                return inner
        return rf"\operatorname{{{function}}}\left({inner}\right)"

    def bracket(self, inner: str) -> str:
        """Write brackets that grow with what is in them."""
        return rf"\left({inner}\right)"

    def raised(self, base: str, power: int) -> str:
        """Write the power after the base."""
        return f"{base}^{{{power}}}"

    def fraction(self, over: str, under: str, *, several: bool) -> str:  # noqa: ARG002
        """Write a fraction, which needs no brackets."""
        return rf"\frac{{{over}}}{{{under}}}" if under else over

    def degrees(self, angle_rad: float) -> str:
        r"""Write 30^\circ."""
        return rf"{math.degrees(angle_rad):.6g}^{{\circ}}"


def matrix_text(matrix: Transform) -> str:
    """Return a matrix as text; where it would be too wide, its entries listed by their names."""
    cells = [[Text().write(entry) for entry in row] for row in matrix]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    if sum(widths) + 2 * len(widths) + 2 > WIDEST:
        return "\n".join(
            f"{name} = {cell}"
            for names, column in zip(_columns(ENTRY_NAMES), _columns(cells[:3]), strict=True)
            for name, cell in zip(names, column, strict=True)
        )
    return "\n".join(f"[ {'  '.join(map(str.ljust, row, widths))} ]" for row in cells)


def matrix_latex(matrix: Transform) -> str:
    """Return a matrix as LaTeX, for use in a formula."""
    rows = (" & ".join(map(Latex().write, row)) for row in matrix)
    inner = " \\\\\n".join(rows)
    return f"\\begin{{bmatrix}}\n{inner}\n\\end{{bmatrix}}"


def _columns(rows: Iterable[Sequence[str]]) -> list[tuple[str, ...]]:
    return list(zip(*rows, strict=True))


def _escaped(name: str) -> str:
    return re.sub(r"([_|^%&#$])", r"\\\1", name)
