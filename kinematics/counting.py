"""Numbers that count what is done with them, and functions made to run on such numbers.

Source: McKerrow, chapter 4, section 15 (efficiency of the kinematic solutions), whose counts of
multiplications, additions and trigonometric calls come here from running the very code. A
`Count` has a value, so that branches are taken as with floats, and a ledger that all numbers of
one run share. Negations, comparisons and copies are free; so is what is done with constants
alone, which a program does once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from types import CodeType, FunctionType, SimpleNamespace
from typing import Any, TypeVar

from kinematics import numbers

Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True, slots=True)
class Tally:
    """How many operations of each kind a computation takes."""

    multiplications: int = 0
    additions: int = 0
    divisions: int = 0
    roots: int = 0
    sines: int = 0
    arcs: int = 0
    """Sines and cosines; arc tangents and arc cosines."""

    @property
    def trigonometric(self) -> int:
        """Sines, cosines and their inverses together."""
        return self.sines + self.arcs

    def __str__(self) -> str:
        return ", ".join(
            f"{getattr(self, entry.name)} {entry.name}"
            for entry in fields(self)
            if getattr(self, entry.name)
        )


@dataclass(slots=True)
class Ledger:
    """What the numbers of one run write their operations into."""

    counts: dict[str, int] = field(default_factory=dict)

    def number(self, value: float) -> Count:
        """Return a number that counts in this ledger."""
        return Count(value, self)

    def numbers(self, values: Any) -> Any:
        """Return nested tuples of numbers (what a frame or a link table is) as counting ones."""
        if isinstance(values, tuple):
            return tuple(self.numbers(value) for value in values)
        return self.number(values)

    def note(self, kind: str, times: int = 1) -> None:
        """Count operations of a kind, one of the fields of `Tally`."""
        self.counts[kind] = self.counts.get(kind, 0) + times

    def tally(self) -> Tally:
        """Return what has been counted so far."""
        return Tally(**self.counts)


class Count:
    """A number that counts; anything that would need it as a plain float fails loudly."""

    __slots__ = ("ledger", "value")

    def __init__(self, value: float, ledger: Ledger) -> None:
        self.value = value
        self.ledger = ledger

    def __repr__(self) -> str:
        return f"Count({self.value!r})"

    def _made(self, kind: str, value: float) -> Count:
        self.ledger.note(kind)
        return Count(value, self.ledger)

    def __add__(self, other: Any) -> Count:
        return self._made("additions", self.value + plain(other))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Count:
        return self._made("additions", self.value - plain(other))

    def __rsub__(self, other: Any) -> Count:
        return self._made("additions", plain(other) - self.value)

    def __mul__(self, other: Any) -> Count:
        return self._made("multiplications", self.value * plain(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Count:
        return self._made("divisions", self.value / plain(other))

    def __rtruediv__(self, other: Any) -> Count:
        return self._made("divisions", plain(other) / self.value)

    def __neg__(self) -> Count:
        return Count(-self.value, self.ledger)

    def __abs__(self) -> Count:
        return Count(abs(self.value), self.ledger)

    def __eq__(self, other: object) -> bool:
        return bool(self.value == plain(other))

    def __lt__(self, other: Any) -> bool:
        return bool(self.value < plain(other))

    def __le__(self, other: Any) -> bool:
        return bool(self.value <= plain(other))

    def __gt__(self, other: Any) -> bool:
        return bool(self.value > plain(other))

    def __ge__(self, other: Any) -> bool:
        return bool(self.value >= plain(other))

    __hash__ = None  # type: ignore[assignment] # equal to plain numbers, and not one of them

    def __bool__(self) -> bool:
        return self.value != 0.0

    def sin(self) -> Count:
        """Return the sine."""
        return self._made("sines", math.sin(self.value))

    def cos(self) -> Count:
        """Return the cosine."""
        return self._made("sines", math.cos(self.value))

    def sqrt(self) -> Count:
        """Return the square root."""
        return self._made("roots", math.sqrt(self.value))

    def acos(self) -> Count:
        """Return the arc cosine."""
        return self._made("arcs", math.acos(self.value))

    def atan2(self, x: Any) -> Count:
        """Return the direction of (x, this)."""
        return self._made("arcs", math.atan2(self.value, plain(x)))

    def atan2_of(self, y: Any) -> Count:
        """Return the direction of (this, y)."""
        return self._made("arcs", math.atan2(plain(y), self.value))


def plain(number: Any) -> Any:
    """Return the value of a counting number, and any other number as it is."""
    return number.value if isinstance(number, Count) else number


def _hypot(x: Any, y: Any) -> Any:
    """Return the length of (x, y) as a formula does: two products, a sum and a root."""
    return numbers.sqrt(x * x + y * y)


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": numbers.sin,
    "cos": numbers.cos,
    "sqrt": numbers.sqrt,
    "acos": numbers.acos,
    "atan2": numbers.atan2,
    "hypot": _hypot,
}
"""What takes the place of `math`'s functions where a function is to run on counting numbers."""

_MATH = SimpleNamespace(**{**vars(math), **_FUNCTIONS})


def on_any_numbers(function: Function) -> Function:
    """Return the same code with `math`'s functions replaced by those of `kinematics.numbers`.

    For the fast paths, which call `math` directly. Functions of this package that it calls by
    name are replaced in the same way. The code object itself is shared, not copied or rewritten:
    what is counted is what runs.
    """
    made: Function = _rebound(function, {})
    return made


def _rebound(function: Any, done: dict[Any, Any]) -> Any:
    if function in done:
        return done[function]
    scope = dict(function.__globals__)
    made = FunctionType(
        function.__code__, scope, function.__name__, function.__defaults__, function.__closure__
    )
    made.__kwdefaults__ = function.__kwdefaults__
    done[function] = made
    for name in _names(function.__code__):
        value = scope.get(name)
        if value is math:
            scope[name] = _MATH
        elif isinstance(value, FunctionType) and _is_ours(value):
            scope[name] = _rebound(value, done)
        elif name in _FUNCTIONS and value is getattr(math, name):
            scope[name] = _FUNCTIONS[name]
    return made


def _names(code: CodeType) -> set[str]:
    """Return the global names that a piece of code may look up, its inner functions' included."""
    found = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            found |= _names(constant)
    return found


def _is_ours(function: FunctionType) -> bool:
    module: str = function.__module__ or ""
    return module.split(".")[0] == __name__.split(".")[0] and module != numbers.__name__
