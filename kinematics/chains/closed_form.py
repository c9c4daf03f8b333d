"""An arm's postures for a frame in closed form: all branches, within limits, each of them checked.

`structure` says of what class an arm is and `branches` finds its postures; here they are put on the
turns that the limits allow, and compared with the goal by forward kinematics. Whatever is returned
meets the goal. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

from kinematics.chains.branches import BranchFinder, Posture, branch_finder
from kinematics.chains.chain import Chain
from kinematics.chains.descent import QUICK, Descent
from kinematics.chains.generated import generated
from kinematics.chains.goals import ALL_PARTS, HEADING_FREE, Goal, frame_goal, turned_to
from kinematics.chains.structure import Family, family_of, why_no_family
from kinematics.frames.transforms import Transform
from kinematics.limits import SAME_POSTURE_RAD, all_fitted

# How far a posture's tip may be from the goal: a tenth of the tolerance for a met goal.
NEAR_MM = 1e-5

# How far the entries of the tool's rotation may be from the goal's.
NEAR_RAD = 1e-7

# How far off a posture may be, in mm and rad, to be improved numerically.
ROUGH = (0.1, 1e-3)

# Before a chain's code is used, it must find this many random postures again.
PROOFS = 6

# The value of a joint that the code leaves free, while the code is tested.
ELSEWHERE_RAD = 0.123


@dataclass(frozen=True, slots=True)
class ClosedForm:
    """The closed form of one chain: the code generated for its link table, and its limits.

    `headings` finds postures for goals of any heading. In a singular posture some joints may take
    any value; they take it from the argument `near`.
    """

    chain: Chain
    family: Family
    fk: Callable[[Sequence[float]], Transform]
    frames: BranchFinder
    headings: BranchFinder | None

    def solves(self, goal: Goal) -> bool:
        """Return whether the closed form solves this kind of goal: whole, or without heading."""
        return goal.parts == ALL_PARTS or (goal.parts == HEADING_FREE and self.headings is not None)

    def branches(self, goal: Goal, near: Sequence[float]) -> list[Posture]:
        """Return all postures that meet a goal, each joint on the allowed turn nearest to `near`.

        Joints may be beyond their limits. A goal that is met by infinitely many postures, in a
        singular one, has those with the free joints as in `near`.
        """
        raw = self._find(goal)(goal.frame, near)
        checked = [self.checked(goal, angles) for angles in raw]
        return [self.chain.turned(angles, near) for angles in checked if angles is not None]

    def nearest(self, goal: Goal, near: Sequence[float]) -> Posture | None:
        """Return the posture within the limits that is nearest to another one, None without any."""
        limits = self.chain.limits
        ranked = []
        for angles in self._find(goal)(goal.frame, near):
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

    def _find(self, goal: Goal) -> BranchFinder:
        if goal.parts == ALL_PARTS or self.headings is None:
            return self.frames
        return self.headings


@lru_cache(maxsize=64)
def closed_form(chain: Chain) -> ClosedForm | None:
    """Return the closed form of a chain, None for one that has none.

    Keep the result: looking it up costs as much as using it.
    """
    if not chain.is_plain:
        return None
    form = _without_limits(chain.within())
    return None if form is None else replace(form, chain=chain)


class HowSolved(NamedTuple):
    """What class of structure a chain is of, and what that means for its inverse kinematics."""

    structure: str
    solved: str


def how_solved(chain: Chain) -> HowSolved:
    """Describe the structure of a chain, or why it has none, and how its postures are found."""
    form = closed_form(chain)
    if form is None:
        return HowSolved(
            f"none: {why_no_family(chain)}", "numerically, from many starts: one posture"
        )
    solved = "in closed form: all postures, each compared with the goal"
    return HowSolved(form.family.value, solved)


@lru_cache(maxsize=64)
def _without_limits(chain: Chain) -> ClosedForm | None:
    """Return the closed form of a chain without limits, tested on random postures.

    Limits change nothing about the code: all chains of one link table share it.
    """
    family = family_of(chain)
    if family is None:
        return None
    fk = generated(chain).fk
    draw = random.Random(1)  # noqa: S311 - any postures will do
    samples = [tuple(draw.uniform(-3.0, 3.0) for _ in chain.links) for _ in range(PROOFS)]
    form = ClosedForm(chain, family, fk, branch_finder(chain, family), _headings(chain, family))
    return form if all(_found_again(form, one) for one in samples) else None


def _headings(chain: Chain, family: Family) -> BranchFinder | None:
    """Return the function for goals of any heading, of five joints on a vertical axis."""
    if len(chain) != 5 or math.hypot(*_first_axis(chain)[:2]) > NEAR_RAD:
        return None
    return branch_finder(chain, family, heading_free=True)


def _first_axis(chain: Chain) -> Sequence[float]:
    return chain.axes(chain.zero)[0][1]


def _found_again(form: ClosedForm, values: Posture) -> bool:
    """Whether a posture is found for its frame, with other values for joints that may be free."""
    goal, near = frame_goal(form.fk(values)), [ELSEWHERE_RAD] * len(values)
    checked = (form.checked(goal, angles) for angles in form.frames(goal.frame, near))
    return any(one is not None and _same(one, values) for one in checked)


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
