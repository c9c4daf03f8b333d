"""A chain's forward kinematics and Jacobian as one straight-line Python function each.

The functions are generated from the link table, in either convention, for speed: no matrix is
multiplied at run time, constants are folded, and a run of parallel joints is one sum of angles. In
such a run the frame turns about one axis Z only, so that with the run's first frame (X, Y, Z at P)
and the angles phi summed up so far, the next frame is at P + X sum(a cos phi) + Y sum(a sin phi) +
Z sum(d): the trigonometric solution of McKerrow, chapter 4, section 5, inside any chain.

Values are floats in rad and mm and are not checked; `Chain.fk` checks its arguments.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.errors import KinematicsError
from kinematics.frames.numbers import cos_sin
from kinematics.frames.transforms import IN_PLACE, Transform
from kinematics.spaces import Jacobian

# Source under construction: sums of products, constants folded, nothing computed twice. What cannot
# stay a constant times a variable becomes an assignment, so that a zero in a link table costs
# nothing at run time. Only names made here and representations of floats enter the source.


class Term(NamedTuple):
    """A factor times a variable; a variable of no name is the number 1."""

    factor: float
    variable: str = ""

    def __neg__(self) -> Term:
        return Term(-self.factor, self.variable)

    def __str__(self) -> str:
        if self.variable and self.factor != 0.0:
            return _signed(self.factor, (self.variable,), first=True)
        return repr(self.factor + 0.0)


ZERO = Term(0.0)
ONE = Term(1.0)

Vector3 = tuple[Term, Term, Term]
Monomial = tuple[str, ...]


class Line(NamedTuple):
    """An assignment: the name that it gives a value, the expression, the variables it reads."""

    name: str
    source: str
    needs: Monomial


class CodeLines:
    """Assignments in order, each made once; `live` leaves out what nothing needs."""

    def __init__(self) -> None:
        self._lines: dict[str, Line] = {}

    def total(self, *products: tuple[Term, ...]) -> Term:
        """Return the sum of products of terms, as a term where it is one."""
        monomials = _collect(products)
        if not monomials:
            return ZERO
        if len(monomials) == 1:
            [(variables, factor)] = monomials.items()
            if len(variables) < 2:
                return Term(factor, *variables)
            return Term(factor, self._assign("*".join(variables), variables))
        if all(factor < 0.0 for factor in monomials.values()):
            return -self.total(*((Term(-1.0), *product) for product in products))
        # a positive term first saves the sign in front
        ordered = sorted(monomials.items(), key=lambda item: item[1] < 0.0)
        source = "".join(
            _signed(factor, variables, first=index == 0)
            for index, (variables, factor) in enumerate(ordered)
        )
        return Term(1.0, self._assign(source, [name for names in monomials for name in names]))

    def call(self, function: str, argument: Term) -> Term:
        """Return a function's value at a term."""
        return Term(1.0, self._assign(f"{function}({argument})", (argument.variable,)))

    def live(self, results: Iterable[Term]) -> list[str]:
        """Return the lines that these results need, in order."""
        wanted = {term.variable for term in results}
        kept = []
        for line in reversed(self._lines.values()):
            if line.name in wanted:
                wanted.update(line.needs)
                kept.append(f"{line.name} = {line.source}")
        return kept[::-1]

    def _assign(self, source: str, needs: Iterable[str]) -> str:
        """Return the name that holds an expression's value."""
        line = Line(f"v{len(self._lines)}", source, tuple(needs))
        return self._lines.setdefault(source, line).name


def functions_of(source: str, called: Mapping[str, object], what: str) -> dict[str, Any]:
    """Return the functions that our own source defines; `what` names it in tracebacks.

    `called` are the names that the source uses.
    """
    made = dict(called)
    exec(compile(source, f"<generated {what}>", "exec"), made)  # noqa: S102 - our own source
    return made


def _collect(products: Iterable[tuple[Term, ...]]) -> dict[Monomial, float]:
    """Return the factor of every monomial, those that cancel left out."""
    found: dict[Monomial, float] = {}
    for product in products:
        factor = math.prod(term.factor for term in product)
        variables = tuple(sorted(term.variable for term in product if term.variable))
        found[variables] = found.get(variables, 0.0) + factor
    return {variables: factor for variables, factor in found.items() if factor != 0.0}


def _signed(factor: float, variables: Monomial, *, first: bool) -> str:
    sign = "-" if factor < 0.0 else ("" if first else "+")
    size = abs(factor)
    factors = [repr(size), *variables] if size != 1.0 or not variables else list(variables)
    return sign + "*".join(factors)


# The walk along the chain.

_ROWS = range(3)
_NOTHING: Vector3 = (ZERO, ZERO, ZERO)


@dataclass(frozen=True, slots=True)
class Generated:
    """The functions generated for a chain, and their source, which people can read."""

    fk: Callable[[Sequence[float]], Transform]
    jacobian: Callable[[Sequence[float]], Jacobian]
    fk_and_jacobian: Callable[[Sequence[float]], tuple[Transform, Jacobian]]
    source: str


@lru_cache(maxsize=64)
def generated(chain: Chain) -> Generated:
    """Return the functions of a chain; they are generated once for each chain.

    Keep the result: looking it up costs more than calling it. Raises `KinematicsError` for a
    chain whose parameters are not plain numbers.
    """
    walk = _walk(chain)
    frame, jacobian = walk.frame_rows(), walk.jacobian_rows()
    source = "\n\n".join(
        (
            _function("fk", chain, walk.lines, [frame]),
            _function("jacobian", chain, walk.lines, [jacobian]),
            _function("fk_and_jacobian", chain, walk.lines, [frame, jacobian]),
        )
    )
    made = functions_of(source, {"sin": math.sin, "cos": math.cos}, "kinematics")
    return Generated(made["fk"], made["jacobian"], made["fk_and_jacobian"], source)


def place_source(chain: Chain) -> str:
    """Return the source of `place`, which computes the tool's x, y and z without its orientation.

    Raises as `generated` does.
    """
    walk = _walk(chain)
    return _function("place", chain, walk.lines, [[[row[3] for row in walk.frame_rows()[:3]]]])


def _walk(chain: Chain) -> _Walk:
    if not chain.is_plain:
        raise KinematicsError("functions are generated of plain numbers; use Chain.fk for others")
    return _Walk(chain)


@dataclass(slots=True)
class _Axis:
    """A joint's axis: its direction, and (u, v) of its place in the run that it belongs to."""

    kind: JointKind
    sign: float
    u: Term
    v: Term
    run: int


class _Walk:
    """Walks the chain from the base to the tool and writes the code for each frame."""

    def __init__(self, chain: Chain) -> None:
        self.lines = CodeLines()
        self.axes: list[_Axis] = []
        self.runs: list[tuple[Vector3, Vector3, Vector3, Vector3]] = []
        self.hops: list[tuple[Vector3, Term, Term]] = []
        self._enter(*_columns(chain.base))
        for index, link in enumerate(chain.links):
            if chain.convention is Convention.STANDARD:
                self._along_z(index, link)
                self._along_x(link)
            else:
                self._along_x(link)
                self._along_z(index, link)
        self._leave(1.0, 0.0)
        if chain.tool != IN_PLACE:
            self._hop(_columns(chain.tool))
        self.hops.append((_NOTHING, ZERO, ZERO))

    def frame_rows(self) -> list[list[Term]]:
        """Return the rows of the tool's frame."""
        columns = self.runs[-1]
        return [*([column[row] for column in columns] for row in _ROWS), [ZERO, ZERO, ZERO, ONE]]

    def jacobian_rows(self) -> list[list[Term]]:
        """Return the six rows of the geometric Jacobian."""
        columns = [self._velocity(axis) for axis in self.axes]
        return [[column[row] for column in columns] for row in range(6)]

    def _enter(self, x: Vector3, y: Vector3, z: Vector3, p: Vector3) -> None:
        """Begin a run of parallel joints."""
        self.runs.append((x, y, z, p))
        self._u = self._v = self._w = self._angle = ZERO
        self._turn_rad = 0.0
        self._sign = 1.0

    def _along_z(self, index: int, link: DHLink) -> None:
        """Turn about and move along the joint's axis."""
        value = Term(self._sign, f"q{index}")
        self.axes.append(_Axis(link.kind, self._sign, self._u, self._v, len(self.runs) - 1))
        theta, distance, _, _ = link.parameters(0.0)
        shift = (self._w,), (Term(self._sign * distance),)
        if link.kind is JointKind.REVOLUTE:
            self._angle = self.lines.total((self._angle,), (value,))
            self._w = self.lines.total(*shift)
        else:
            self._w = self.lines.total(*shift, (value,))
        self._turn_rad += self._sign * theta

    def _along_x(self, link: DHLink) -> None:
        """Move along the common normal and twist about it; a twist of 0 or 180° ends no run."""
        if link.a_mm != 0.0:
            length = Term(link.a_mm)
            cosine, sine = self._heading()
            self._u = self.lines.total((self._u,), (length, cosine))
            self._v = self.lines.total((self._v,), (length, sine))
        twist_cosine, twist_sine = cos_sin(link.alpha_rad)
        if twist_sine != 0.0:
            self._leave(twist_cosine, twist_sine)
        else:
            self._sign *= twist_cosine

    def _heading(self) -> tuple[Term, Term]:
        """Return cosine and sine of the angle summed up in this run."""
        turn_cosine, turn_sine = (Term(one) for one in cos_sin(self._turn_rad))
        if not self._angle.variable:
            return turn_cosine, turn_sine
        if turn_cosine.factor != 0.0 and turn_sine.factor != 0.0:  # no quarter turn: add it first
            angle = self.lines.total((self._angle,), (Term(self._turn_rad),))
            return self.lines.call("cos", angle), self.lines.call("sin", angle)
        angle = Term(1.0, self._angle.variable)
        cosine = self.lines.call("cos", angle)
        sine = self.lines.call("sin", angle)
        if self._angle.factor < 0.0:
            sine = -sine
        total = self.lines.total
        return (
            total((turn_cosine, cosine), (-turn_sine, sine)),
            total((turn_sine, cosine), (turn_cosine, sine)),
        )

    def _leave(self, twist_cosine: float, twist_sine: float) -> None:
        """End a run with a twist: write the code of the frame there, and begin the next run."""
        cosine, sine = self._heading()
        across = Term(self._sign)
        ca, sa = Term(twist_cosine), Term(twist_sine)
        x = (cosine, sine, ZERO)
        y = (-sine, cosine, ZERO)
        local = (
            x,
            self._combined((across, ca), y, (across, sa), (ZERO, ZERO, ONE)),
            self._combined((across, -sa), y, (across, ca), (ZERO, ZERO, ONE)),
            (self._u, self._v, self._w),
        )
        self._hop(local)

    def _combined(
        self, f: tuple[Term, ...], u: Vector3, g: tuple[Term, ...], v: Vector3
    ) -> Vector3:
        """Return f u + g v."""
        one, two, three = (self.lines.total((*f, u[i]), (*g, v[i])) for i in _ROWS)
        return one, two, three

    def _hop(self, local: tuple[Vector3, Vector3, Vector3, Vector3]) -> None:
        """Go to a frame given in the present run's first one, and begin the next run there."""
        origin = self.runs[-1][3]
        self.hops.append((self._turned(local[3]), local[3][0], local[3][1]))
        x, y, z = (self._turned(column) for column in local[:3])
        self._enter(x, y, z, self._turned(local[3], origin))

    def _turned(self, column: Vector3, *origin: Vector3) -> Vector3:
        """Return a vector given in the present run's first frame, in the world; from an origin."""
        axes = self.runs[-1][:3]
        one, two, three = (
            self.lines.total(
                *((place[i],) for place in origin),
                *((axis[i], part) for axis, part in zip(axes, column, strict=True)),
            )
            for i in _ROWS
        )
        return one, two, three

    def _velocity(self, axis: _Axis) -> list[Term]:
        """Return a joint's column: what a unit rate of it makes the tip do.

        Of a revolute joint at (u, v) of a run that ends at (U, V), the tip being `rest` further:
        Z x (X (U - u) + Y (V - v) + rest) = Y (U - u) - X (V - v) + Z x rest.
        """
        x, y, z, _ = self.runs[axis.run]
        total, sign = self.lines.total, Term(axis.sign)
        direction = [total((sign, part)) for part in z]
        if axis.kind is JointKind.PRISMATIC:
            return [*direction, ZERO, ZERO, ZERO]
        _, u_end, v_end = self.hops[axis.run]
        across, along = total((u_end,), (-axis.u,)), total((axis.v,), (-v_end,))
        rest = [total(*((hop[i],) for hop, _, _ in self.hops[axis.run + 1 :])) for i in _ROWS]
        swing = [total((z[j], rest[k]), (-z[k], rest[j])) for j, k in ((1, 2), (2, 0), (0, 1))]
        velocity = [
            total((sign, swing[i]), (sign, across, y[i]), (sign, along, x[i])) for i in _ROWS
        ]
        return [*velocity, *direction]


def _columns(frame: Transform) -> tuple[Vector3, Vector3, Vector3, Vector3]:
    x, y, z, p = (
        (Term(frame[0][column]), Term(frame[1][column]), Term(frame[2][column]))
        for column in range(4)
    )
    return x, y, z, p


def _function(name: str, chain: Chain, lines: CodeLines, results: list[list[list[Term]]]) -> str:
    """Return the source of a function of the joints' values."""
    values = [f"q{index}" for index in range(len(chain.links))]
    needed = lines.live(term for rows in results for row in rows for term in row)
    matrices = [_tuple([_tuple([str(term) for term in row]) for row in rows]) for rows in results]
    returned = matrices[0] if len(matrices) == 1 else _tuple(matrices)
    body = [f"{_tuple(values)} = q", *needed, f"return {returned}"]
    return f"def {name}(q):\n" + "\n".join(f"    {line}" for line in body)


def _tuple(parts: Sequence[str]) -> str:
    return f"({', '.join(parts)}{',' if len(parts) == 1 else ''})"
