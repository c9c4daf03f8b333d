"""Python source under construction: sums of products, constants folded, nothing computed twice.

A `Term` is a constant times at most one variable; what cannot stay a term becomes an assignment.
Vectors and matrices of terms are multiplied here as ordinary ones are, and a zero in a link table
costs nothing at run time. Only the names made here and the representations of floats enter the
source.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple


class Term(NamedTuple):
    """A factor times a variable; a variable of no name is the number 1."""

    factor: float
    variable: str = ""

    def __neg__(self) -> Term:
        return Term(-self.factor, self.variable)


ZERO = Term(0.0)
ONE = Term(1.0)

Vector3 = tuple[Term, Term, Term]
# A matrix as its rows.
Rows3 = tuple[Vector3, Vector3, Vector3]

X: Vector3 = (ONE, ZERO, ZERO)
Z: Vector3 = (ZERO, ZERO, ONE)

Monomial = tuple[str, ...]

INDENT = "    "


class Line(NamedTuple):
    """A line of source, the variables that it reads, and the one that it gives a value.

    A line without `always` is left out if no other line needs its value.
    """

    depth: int
    source: str
    needs: tuple[str, ...]
    name: str = ""
    always: bool = False


def functions_of(source: str, called: Mapping[str, object], what: str) -> dict[str, Any]:
    """Return the functions that our own source defines; `what` names it in tracebacks.

    `called` are the names that the source uses.
    """
    made = dict(called)
    exec(compile(source, f"<generated {what}>", "exec"), made)  # noqa: S102 - our own source
    return made


@dataclass(slots=True)
class CodeLines:
    """Assignments in order, each made once, and blocks; `live` leaves out what nothing needs."""

    _lines: list[Line] = field(default_factory=list)
    _blocks: list[dict[str, str]] = field(default_factory=lambda: [{}])
    """The names of expressions in the whole function, then in each open block."""
    _names: int = 0

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
        if all(factor < 0.0 for factor in monomials.values()):
            return -self.total(*((Term(-1.0), *product) for product in products))
        # a positive term first saves the sign in front
        ordered = sorted(monomials.items(), key=lambda item: item[1] < 0.0)
        source = "".join(
            _signed(factor, variables, first=index == 0)
            for index, (variables, factor) in enumerate(ordered)
        )
        return Term(1.0, self.assign(source, [name for names in monomials for name in names]))

    def dot(self, u: Sequence[Term], v: Sequence[Term], *others: tuple[Term, ...]) -> Term:
        """Return the scalar product of two vectors, with other products added."""
        return self.total(*zip(u, v, strict=True), *others)

    def times(self, rows: Rows3, v: Vector3) -> Vector3:
        """Return a matrix times a vector."""
        x, y, z = (self.dot(row, v) for row in rows)
        return x, y, z

    def plus(self, u: Vector3, v: Vector3) -> Vector3:
        """Return the sum of two vectors."""
        x, y, z = (self.total((a,), (b,)) for a, b in zip(u, v, strict=True))
        return x, y, z

    def minus(self, u: Vector3, v: Vector3) -> Vector3:
        """Return the first vector less the second."""
        return self.plus(u, (-v[0], -v[1], -v[2]))

    def call(self, function: str, *arguments: Term) -> Term:
        """Return a function's value at terms."""
        source = f"{function}({', '.join(map(text, arguments))})"
        return Term(1.0, self.assign(source, _variables(arguments)))

    def reciprocal(self, term: Term) -> Term:
        """Return 1 / a term, or 0 if the term is 0: the caller must not rely on it then."""
        if not term.variable:
            return Term(1.0 / term.factor) if term.factor else ZERO
        source = f"1.0/{term.variable} if {term.variable} else 0.0"
        return Term(1.0 / term.factor, self.assign(source, (term.variable,)))

    def assign(self, source: str, needs: Iterable[str]) -> str:
        """Return the name that holds an expression's value."""
        for known in reversed(self._blocks):
            if source in known:
                return known[source]
        name = self.variable().variable
        self._blocks[-1][source] = name
        self._lines.append(Line(self._depth, f"{name} = {source}", tuple(needs), name))
        return name

    def variable(self) -> Term:
        """Return a variable of a name that nothing has yet."""
        self._names += 1
        return Term(1.0, f"v{self._names - 1}")

    def write(self, source: str, *needs: Term) -> None:
        """Add a line that is always kept; each {} in it stands for the next of the terms."""
        line = source.format(*map(text, needs))
        self._write(line, needs)

    def set(self, variable: Term, source: str, *needs: Term) -> None:
        """Add a line that sets a variable, written as for `write`; each branch may set it."""
        line = f"{variable.variable} = {source.format(*map(text, needs))}"
        self._write(line, needs, variable.variable)

    def open(self, header: str, *needs: Term) -> None:
        """Begin a block whose header is written as for `write`."""
        self.write(header, *needs)
        self._blocks.append({})

    def loop(self, values: Term, variable: Term) -> None:
        """Begin a loop of a variable over values."""
        self.open("for {} in {}:", variable, values)

    def close(self) -> None:
        """End the innermost block."""
        self._blocks.pop()

    def live(self, results: Iterable[Term] = ()) -> list[str]:
        """Return the lines that these results and the lines always kept need, in order."""
        wanted, kept = {term.variable for term in results}, list[Line]()
        for line in reversed(self._lines):
            if line.always or line.name in wanted:
                wanted.update(line.needs)
                kept.append(line)
        return [INDENT * line.depth + line.source for line in reversed(kept)]

    @property
    def _depth(self) -> int:
        return len(self._blocks) - 1

    def _write(self, source: str, needs: Sequence[Term], name: str = "") -> None:
        needed = tuple(_variables(needs))
        self._lines.append(Line(self._depth, source, needed, name, always=True))


def text(term: Term) -> str:
    """Return the source of a term."""
    if term.variable and term.factor != 0.0:
        return _signed(term.factor, (term.variable,), first=True)
    return repr(term.factor + 0.0)


def transposed(rows: Rows3) -> Rows3:
    """Return a matrix with rows and columns exchanged; of a rotation, its inverse."""
    x, y, z = zip(*rows, strict=True)
    return x, y, z


def _variables(terms: Iterable[Term]) -> list[str]:
    return [term.variable for term in terms if term.variable]


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
