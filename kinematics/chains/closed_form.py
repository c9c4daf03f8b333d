"""An arm's postures for a frame in closed form: all branches, within limits, each of them checked.

`branches` says of what class an arm is and finds its postures; here they are put on the turns that
the limits allow, and compared with the goal by forward kinematics. Whatever is returned meets the
goal. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from kinematics.chains.branches import BranchFinder, Posture, family_of
from kinematics.chains.chain import Chain
from kinematics.chains.descent import QUICK, Descent
from kinematics.chains.evaluation import evaluator
from kinematics.chains.goals import ALL_PARTS, HEADING_FREE, Goal, turned_to
from kinematics.frames.transforms import Transform
from kinematics.limits import SAME_POSTURE_RAD, all_fitted

# How far a posture's tip may be from the goal: a tenth of the tolerance for a met goal.
NEAR_MM = 1e-5

# How far the entries of the tool's rotation may be from the goal's.
NEAR_RAD = 1e-7

# How far off a posture may be, in mm and rad, to be improved numerically.
ROUGH = (0.1, 1e-3)


@dataclass(frozen=True, slots=True)
class ClosedForm:
    """The closed form of one chain, and its limits.

    `frees_heading` says whether it also finds postures for goals of any heading. In a singular
    posture some joints may take any value; they take it from the argument `near`.
    """

    chain: Chain
    finder: BranchFinder
    fk: Callable[[Sequence[float]], Transform]
    frees_heading: bool

    def solves(self, goal: Goal) -> bool:
        """Return whether the closed form solves this kind of goal: whole, or without heading."""
        return goal.parts == ALL_PARTS or (goal.parts == HEADING_FREE and self.frees_heading)

    def branches(self, goal: Goal, near: Sequence[float]) -> list[Posture]:
        """Return all postures that meet a goal, each joint on the allowed turn nearest to `near`.

        Joints may be beyond their limits. A goal that is met by infinitely many postures, in a
        singular one, has those with the free joints as in `near`.
        """
        found: list[Posture] = []
        for angles in self._postures(goal, near):
            sound = self.checked(goal, angles)
            if sound is not None and not any(_same(sound, one) for one in found):
                found.append(self.chain.turned(sound, near))
        return found

    def nearest(self, goal: Goal, near: Sequence[float]) -> Posture | None:
        """Return the posture within the limits that is nearest to another one, None without any."""
        limits = self.chain.limits
        ranked = []
        for angles in self._postures(goal, near):
            kept = all_fitted(angles, limits, near)
            if kept is not None:
                ranked.append((math.dist(kept, near), kept, angles))
        for _, kept, angles in sorted(ranked):
            sound = self.checked(goal, angles)
            if sound is angles:
                return kept
            if sound is not None and (kept := all_fitted(sound, limits, near)) is not None:
                return kept
        return None

    def checked(self, goal: Goal, angles: Posture) -> Posture | None:
        """Return a posture that meets the goal: the given one, or an improved one, or None.

        Postures miss the goal because of rounding near a singularity.
        """
        frame, target = self.fk(angles), goal.frame
        if goal.parts != ALL_PARTS:
            target = turned_to(target, frame)
        if _near(frame, target, NEAR_MM, NEAR_RAD):
            return angles
        if not _near(frame, target, *ROUGH):
            return None
        return Descent(self.chain, goal, limited=False).met(angles, QUICK)

    def _postures(self, goal: Goal, near: Sequence[float]) -> Iterator[Posture]:
        heading_free = goal.parts != ALL_PARTS
        return self.finder.postures(goal.frame, near, heading_free=heading_free)


@lru_cache(maxsize=64)
def closed_form(chain: Chain) -> ClosedForm | None:
    """Return the closed form of a chain, None for one that has none.

    Keep the result: looking it up takes as long as using it.
    """
    if not chain.is_plain:
        return None
    family = family_of(chain)
    if isinstance(family, str):
        return None
    first_axis = chain.axes(chain.zero)[0][1]
    frees_heading = len(chain) == 5 and math.hypot(*first_axis[:2]) <= NEAR_RAD
    finder = BranchFinder(chain, family)
    return ClosedForm(chain, finder, evaluator(chain).fk, frees_heading)


class HowSolved(NamedTuple):
    """What class of structure a chain is of, and what that means for its inverse kinematics."""

    structure: str
    solved: str


def how_solved(chain: Chain) -> HowSolved:
    """Describe the structure of a chain, or why it has none, and how its postures are found."""
    family = family_of(chain)
    if isinstance(family, str):
        return HowSolved(f"none: {family}", "numerically, from many starts: one posture")
    solved = "in closed form: all postures, each compared with the goal"
    return HowSolved(family.value, solved)


def _same(one: Posture, other: Posture) -> bool:
    """Whether two postures are one, but for whole turns."""
    return all(
        abs(math.remainder(a - b, math.tau)) < SAME_POSTURE_RAD
        for a, b in zip(one, other, strict=True)
    )


def _near(frame: Transform, goal: Transform, mm: float, rad: float) -> bool:
    """Whether two frames are this near to each other, entry by entry."""
    for (a, b, c, x), (d, e, f, y) in zip(frame, goal, strict=True):
        if not (
            -mm <= x - y <= mm
            and -rad <= a - d <= rad
            and -rad <= b - e <= rad
            and -rad <= c - f <= rad
        ):
            return False
    return True
