"""How much arithmetic each way of computing an arm takes, counted by running it.

Source: McKerrow, chapter 4, section 15. Forward: the system's closed form, the straight-line
function generated from its table, the frames turned and moved one joint at a time, and the
products of A matrices, affine and in full. Inverse: each branch by its formulas, and all of them
by the code that shares what they have in common. Nothing here is a stored number.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

from kinematics import closed_form
from kinematics.chains import Chain
from kinematics.counting import Ledger, Tally, on_any_numbers, plain
from kinematics.frames import Transform, compose
from kinematics.generated import generated
from kinematics.hand_frame import forward_frame
from kinematics.links import Convention, DHLink, JointKind, a_matrix
from kinematics.numbers import cos, sin
from kinematics.systems import spherical_wrist
from kinematics.systems.mini_build import MiniBuild
from kinematics.systems.named_system import System
from kinematics.systems.puma import Puma
from kinematics.vectors import Vector, add, scale, subtract

_POSTURE = (0.3, -0.5, 0.7, 0.4, -0.6, 0.9)
_TRAVEL_MM = (210.0, 170.0, 130.0)


@dataclass(frozen=True, slots=True)
class Way:
    """One way of computing: its name, what it does in a sentence, and what it takes."""

    name: str
    what: str
    tally: Tally


@dataclass(frozen=True, slots=True)
class Efficiency:
    """The ways to compute a system forward and back."""

    system: str
    forward: tuple[Way, ...]
    inverse: tuple[Way, ...]


def efficiency(system: System, joints: Sequence[float] | None = None) -> Efficiency:
    """Return the counts of a system at a posture (rad and mm; one of no account by default).

    Counts hardly depend on the posture: only branches in the code that a degenerate one takes
    differ.
    """
    chain = system.chain()
    posture = tuple(joints) if joints is not None else _general_posture(chain)
    return Efficiency(
        system.name,
        (
            Way("closed form", "the system's own formulas", _counted(system.fk, posture)),
            *_shared_forward(system, posture),
            *forward_ways(chain, posture),
        ),
        tuple(_inverse_ways(system, posture)),
    )


def forward_ways(chain: Chain, joints: Sequence[float]) -> tuple[Way, ...]:
    """Return the counts of every way from a chain's link table to its hand's frame."""
    posture = tuple(joints)
    straight = on_any_numbers(generated(chain).fk)
    return (
        Way(
            "straight line",
            "the function generated from the link table, constants folded",
            _counted(straight, posture),
        ),
        Way(
            "recursion",
            "one frame turned and moved from joint to joint, four moves a link",
            _of_table(chain, posture, recursion),
        ),
        Way(
            "affine products",
            "products of A matrices, the last row 0, 0, 0, 1 left out",
            _of_table(chain, posture, _affine),
        ),
        Way(
            "full products",
            "products of A matrices with all sixteen entries",
            _of_table(chain, posture, _full),
        ),
    )


Table = tuple[tuple[Any, Any, Any, Any], ...]
"""theta, d, a and alpha of each link, on any numbers."""


def recursion(table: Table, convention: Convention = Convention.STANDARD) -> Transform:
    """Return the frame of a link table by turning and moving one frame along the chain.

    A link turns the frame about its own z by theta, moves it along z by d and along x by a, and
    turns it about x by alpha; in Craig's convention x comes before z.
    """
    x: Vector = (1.0, 0.0, 0.0)
    y: Vector = (0.0, 1.0, 0.0)
    z: Vector = (0.0, 0.0, 1.0)
    p: Vector = (0.0, 0.0, 0.0)
    for theta, d, a, alpha in table:
        if convention is Convention.CRAIG:
            p = add(p, scale(a, x))
            y, z = _turn(y, z, alpha)
        x, y = _turn(x, y, theta)
        p = add(p, scale(d, z))
        if convention is Convention.STANDARD:
            p = add(p, scale(a, x))
            y, z = _turn(y, z, alpha)
    rows = zip(x, y, z, p, strict=True)
    first, second, third = rows
    return first, second, third, (0.0, 0.0, 0.0, 1.0)


def _turn(u: Vector, v: Vector, angle: Any) -> tuple[Vector, Vector]:
    """Turn two unit vectors of a frame about the third."""
    c, s = cos(angle), sin(angle)
    return add(scale(c, u), scale(s, v)), subtract(scale(c, v), scale(s, u))


def _affine(table: Table, convention: Convention) -> Transform:
    return compose(*(a_matrix(*row, convention) for row in table))


def _full(table: Table, convention: Convention) -> Transform:
    matrices = [a_matrix(*row, convention) for row in table]
    ledger = table[0][0].ledger
    product: Transform = reduce(_product, [ledger.numbers(_values(one)) for one in matrices])
    return product


def _product(left: Transform, right: Transform) -> Transform:
    """Return the product of two 4x4 matrices, entry by entry, nothing left out."""
    columns = tuple(zip(*right, strict=True))
    first, second, third, fourth = (
        tuple(a * e + b * f + c * g + d * h for e, f, g, h in columns) for a, b, c, d in left
    )
    return first, second, third, fourth  # type: ignore[return-value]


def _values(matrix: Transform) -> tuple[tuple[Any, ...], ...]:
    return tuple(tuple(plain(entry) for entry in row) for row in matrix)


def _of_table(
    chain: Chain,
    posture: tuple[float, ...],
    way: Callable[[Table, Convention], Transform],
) -> Tally:
    """Count a way that takes the link table as it comes, every parameter a number like any."""
    ledger = Ledger()
    table = tuple(
        ledger.numbers(_parameters(link, value))
        for link, value in zip(chain.links, posture, strict=True)
    )
    way(table, chain.convention)
    return _without_twists(ledger.tally(), chain)


def _parameters(link: DHLink, value: float) -> tuple[float, float, float, float]:
    return link.parameters(value)


def _without_twists(tally: Tally, chain: Chain) -> Tally:
    """Take away the sines of the twists (and of sliding joints): constants of the table."""
    turning = sum(link.kind is JointKind.REVOLUTE for link in chain.links)
    constant = 2 * (2 * len(chain.links) - turning)
    return Tally(
        tally.multiplications,
        tally.additions,
        tally.divisions,
        tally.roots,
        tally.sines - constant,
        tally.arcs,
    )


def _shared_forward(system: System, posture: tuple[float, ...]) -> list[Way]:
    """Return the count of the forward solution that the five-axis arms run on."""
    if not isinstance(system, MiniBuild):
        return []
    what = "the same formulas with their common factors taken out"
    lengths = system.arm.lengths
    fast = on_any_numbers(forward_frame)
    return [Way("closed form, shared", what, _counted(lambda q: fast(q, lengths), posture))]


def _inverse_ways(system: System, posture: tuple[float, ...]) -> list[Way]:
    frame = system.fk(posture)
    goal = system.goal_of(frame)
    ways = [
        Way(
            "all branches together",
            "the code that shares what the branches have in common",
            _shared_inverse(system, goal, frame),
        )
    ]
    ways += [
        Way(name, "this branch alone, by its formulas", _counted(_branch(system, name), goal))
        for name in system.signs
    ]
    return [way for way in ways if way.tally != Tally()]


def _branch(system: System, name: str) -> Callable[[tuple[Any, ...]], object]:
    return lambda goal: system.solution(goal, name)


def _shared_inverse(system: System, goal: tuple[float, ...], frame: Transform) -> Tally:
    """Count the system's own fast inverse; nothing where it has none."""
    ledger = Ledger()
    if isinstance(system, MiniBuild):
        inverse = on_any_numbers(closed_form.inverse)
        inverse(ledger.numbers(goal), system.arm.lengths, 0.0, (0.0,) * 5)
    elif isinstance(system, Puma):
        on_any_numbers(spherical_wrist.inverse)(ledger.numbers(frame), system.wrist_arm())
    return ledger.tally()


def _counted(way: Callable[[tuple[Any, ...]], object], numbers: Sequence[float]) -> Tally:
    ledger = Ledger()
    way(ledger.numbers(tuple(numbers)))
    return ledger.tally()


def _general_posture(chain: Chain) -> tuple[float, ...]:
    """Return a posture that is degenerate in no way: within the limits, and on no axis."""
    values = []
    for index, link in enumerate(chain.links):
        if link.kind is JointKind.PRISMATIC:
            value = _TRAVEL_MM[index % len(_TRAVEL_MM)]
        else:
            value = _POSTURE[index % len(_POSTURE)]
        if math.isfinite(link.low) and math.isfinite(link.high):
            middle, half = (link.low + link.high) / 2.0, (link.high - link.low) / 2.0
            value = middle + half * math.tanh(value)
        values.append(value)
    return tuple(values)
