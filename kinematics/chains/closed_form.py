"""An arm's postures for a frame in closed form: all branches, within limits, each of them checked.

`structure` says what kind of arm it is and `branches` finds its postures; here they are put on the
turns that the limits allow, and compared with the goal by forward kinematics. Whatever is returned
meets the goal. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from kinematics.chains.branches import BranchFinder, Posture, branch_code
from kinematics.chains.chain import Chain
from kinematics.chains.generated import generated
from kinematics.chains.goals import ALL_PARTS, HEADING_FREE, Goal, turned_to
from kinematics.chains.structure import Family, Structure, structures
from kinematics.frames.numbers import is_own_kind
from kinematics.frames.transforms import Transform
from kinematics.limits import LIMIT_TOLERANCE_RAD, fitted, turn_into

NEAR_MM = 1e-5
"""How far a posture's tip may be from where the goal has it: a hundredth of what counts as met."""

NEAR_RAD = 1e-7
"""How far the entries of the tool's rotation may be from the goal's."""

PROOFS = 6
"""Random postures that a structure's code has to find again before it is used."""

SWEEP_RAD = math.radians(7.5)
"""By how much the fixed joint of seven is moved on where no posture of the others serves."""


Fit = Callable[[Sequence[float], Sequence[float]], Posture | None]
"""Return a posture with each joint on the turn within its limits nearest to another, or None."""


def fit_code(limits: Sequence[tuple[float, float]]) -> Fit:
    """Return the function for joints of these limits, whose angles come from -pi to pi.

    Most postures are within the limits or far beyond one: one comparison a joint decides that, and
    only what is left is worth a call.
    """
    lines = []
    for index, (low, high) in enumerate(limits):
        q, n = f"q{index}", f"n{index}"
        least, most = low - LIMIT_TOLERANCE_RAD, high + LIMIT_TOLERANCE_RAD
        elsewhere = [f"    {q} = fitted({q}, {low!r}, {high!r}, {n})"]
        elsewhere += [f"    if {q} == inf:", "        return None"]
        if -math.pi <= least and most <= math.pi:  # no other turn is within the range
            lines += [f"if not {low!r} <= {q} <= {high!r}:"]
            lines += [f"    if {q} < {least!r} or {q} > {most!r}:", "        return None"]
            lines += elsewhere
        else:
            within = f"{low!r} <= {q} <= {high!r}"
            lines += [f"if not ({within} and -3.14 < {q} - {n} < 3.14):", *elsewhere]
    names = [", ".join(f"{letter}{index}" for index in range(len(limits))) for letter in "qn"]
    body = [f"{names[0]} = angles", f"{names[1]} = near", *lines, f"return {names[0]}"]
    source = "def fit(angles, near):\n" + "\n".join(f"    {line}" for line in body)
    made: dict[str, object] = {"fitted": fitted, "inf": math.inf}
    exec(compile(source, "<generated limits>", "exec"), made)  # noqa: S102 - our own source
    return made["fit"]  # type: ignore[return-value]


Check = Callable[[Transform, Transform], bool]


@dataclass(frozen=True, slots=True)
class Finder:
    """A function that finds postures for a frame, and how a posture's frame is compared with it."""

    find: BranchFinder
    meets: Check


@dataclass(frozen=True, slots=True)
class Solver:
    """What is made once for a link table, whatever its limits."""

    structure: Structure
    fk: Callable[[Sequence[float]], Transform]
    frames: Finder
    headings: Finder | None


@dataclass(frozen=True, slots=True)
class ClosedForm:
    """The closed form of one chain, within its limits.

    Its functions take the joint values that serve where any value would.
    """

    solver: Solver
    limits: tuple[tuple[float, float], ...]
    _fit: Fit

    @property
    def structure(self) -> Structure:
        """The class of the arm."""
        return self.solver.structure

    @property
    def complete(self) -> bool:
        """Whether no posture is left out: seven joints have infinitely many."""
        return self.structure.fixed is None

    def solves(self, goal: Goal) -> bool:
        """Whether a goal asks what the closed form gives: a whole frame, or all but the heading."""
        return goal.parts == ALL_PARTS or (
            goal.parts == HEADING_FREE and self.solver.headings is not None
        )

    def branches(self, goal: Goal, near: Sequence[float]) -> list[Posture]:
        """Return all postures that meet a goal, each joint on the allowed turn nearest to `near`.

        Joints may be beyond their limits. A goal that is met by infinitely many postures, in a
        singular one, has those with the free joints as in `near`.
        """
        finder = self._finder(goal)
        return [self._turned(angles, near) for angles in self._checked(finder, goal.frame, near)]

    def postures(self, frame: Transform, near: Sequence[float]) -> list[Posture]:
        """Return what `branches` does for a frame, with every angle from -pi to pi."""
        return self._checked(self.solver.frames, frame, near)

    def _checked(self, finder: Finder, frame: Transform, near: Sequence[float]) -> list[Posture]:
        found, fk = finder.find(frame, near), self.solver.fk
        return [angles for angles in found if finder.meets(fk(angles), frame)]

    def nearest(self, goal: Goal, near: Sequence[float]) -> Posture | None:
        """Return the posture within the limits that is nearest to another one, None without any.

        A seven-joint arm's fixed joint stays if it can, and moves as little as it must.
        """
        finder, fk, fit = self._finder(goal), self.solver.fk, self._fit
        for values in self._sweep(near):
            inside = []
            for angles in finder.find(goal.frame, values):
                fitting = fit(angles, near)
                if fitting is not None:
                    inside.append((math.dist(fitting, near), fitting, angles))
            for _, fitting, angles in sorted(inside):
                if finder.meets(fk(angles), goal.frame):
                    return fitting
        return None

    def _finder(self, goal: Goal) -> Finder:
        if goal.parts == ALL_PARTS or self.solver.headings is None:
            return self.solver.frames
        return self.solver.headings

    def _turned(self, angles: Sequence[float], near: Sequence[float]) -> Posture:
        """Return each angle on its allowed turn nearest to that of another posture."""
        return tuple(
            [
                turn_into(angle, low, high, seed)
                for angle, (low, high), seed in zip(angles, self.limits, near, strict=True)
            ]
        )

    def _sweep(self, near: Sequence[float]) -> Iterator[Sequence[float]]:
        """Yield the posture, and with seven joints others with the fixed joint ever further off."""
        yield near
        fixed = self.structure.fixed
        if fixed is None:
            return
        low, high = self.limits[fixed]
        low, high = max(low, near[fixed] - math.pi), min(high, near[fixed] + math.pi)
        for step in range(1, math.ceil(math.tau / SWEEP_RAD)):
            for side in (SWEEP_RAD, -SWEEP_RAD):
                value = near[fixed] + side * step
                if low <= value <= high:
                    yield (*near[:fixed], value, *near[fixed + 1 :])


@lru_cache(maxsize=64)
def closed_form(chain: Chain) -> ClosedForm | None:
    """Return the closed form of a chain, None for one that has none.

    Keep the result: looking it up costs as much as using it.
    """
    if any(is_own_kind(one) for link in chain.links for one in link.parameters(0.0)):
        return None
    solver = _solver(chain.within())
    return None if solver is None else ClosedForm(solver, chain.limits, fit_code(chain.limits))


@lru_cache(maxsize=64)
def _solver(chain: Chain) -> Solver | None:
    """Return what solves a chain without limits; its code has found some postures again."""
    fk = generated(chain).fk
    draw = random.Random(1)  # noqa: S311 - any postures will do
    samples = [tuple(draw.uniform(-3.0, 3.0) for _ in chain.links) for _ in range(PROOFS)]
    for structure in structures(chain):
        find = branch_code(chain, structure).find
        if all(_found_again(find(fk(one), one), one) for one in samples):
            headings = _headings(chain, structure)
            turned = None if headings is None else Finder(headings, _meets_turned)
            return Solver(structure, fk, Finder(find, _meets), turned)
    return None


def _headings(chain: Chain, structure: Structure) -> BranchFinder | None:
    """Return the function for goals of any heading, of five joints on a vertical axis."""
    parallel = structure.family is Family.THREE_PARALLEL and not structure.from_hand
    if len(chain) != 5 or not parallel or math.hypot(*_first_axis(chain)[:2]) > NEAR_RAD:
        return None
    return branch_code(chain, structure, heading_free=True).find


def _first_axis(chain: Chain) -> Sequence[float]:
    return chain.axes(chain.zero)[0][1]


def _found_again(found: Sequence[Posture], values: Posture) -> bool:
    return any(
        max(abs(math.remainder(a - b, math.tau)) for a, b in zip(one, values, strict=True)) < 1e-4
        for one in found
    )


def _meets(frame: Transform, goal: Transform) -> bool:
    """Whether a frame is a goal's, but for rounding."""
    for (a, b, c, x), (d, e, f, y) in zip(frame, goal, strict=True):
        if not (
            -NEAR_MM <= x - y <= NEAR_MM
            and -NEAR_RAD <= a - d <= NEAR_RAD
            and -NEAR_RAD <= b - e <= NEAR_RAD
            and -NEAR_RAD <= c - f <= NEAR_RAD
        ):
            return False
    return True


def _meets_turned(frame: Transform, goal: Transform) -> bool:
    """Whether a frame is a goal's, turned about z through its origin."""
    return _meets(frame, turned_to(goal, frame))
