"""The hand on a model: its posture, and what each key makes of it. Pure: it knows no screen."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from kinematics.textbook.stepping import axes_of, axis_unit, has_inverse, step_axis, step_joint
from kinematics.textbook.study import Study, Subject, study
from kinematics.textbook.worked_example import example_posture
from tui.keys import JogPair
from tui.model_keys import model_pairs
from tui.settings import INCREMENTS

FIRST_INCREMENT = INCREMENTS.index(5.0)


@dataclass(slots=True)
class ModelHand:
    """A model in a posture, the mode of its keys, and one increment in degrees or mm."""

    subject: Subject
    values: tuple[float, ...] = ()
    cartesian: bool = False
    increment_index: int = FIRST_INCREMENT
    pairs: tuple[JogPair, ...] = field(init=False)
    axes: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        self.values = self.values or example_posture(self.subject.chain)
        self.axes = axes_of(self.subject)
        self.pairs = model_pairs(self.subject.chain.joint_names, self.axes)

    @property
    def increment(self) -> float:
        """One increment, in degrees or mm."""
        return INCREMENTS[self.increment_index]

    @property
    def study(self) -> Study:
        """What follows from the present posture."""
        return study(self.subject, self.values)

    @property
    def way(self) -> str:
        """Say what the keys move, and how."""
        if not self.cartesian:
            return "joints"
        return "the hand, by closed form" if has_inverse(self.subject) else "the hand, by Jacobian"

    def press(self, key: str) -> str:
        """Make the step of a jog key; return what it could not do."""
        pair = next((each for each in self.pairs if key in (each.plus, each.minus)), None)
        name = "" if pair is None else pair.axis(cartesian=self.cartesian)
        if pair is None or not name:
            return "no axis of this model is moved by that key"
        sign = 1.0 if key == pair.plus else -1.0
        if self.cartesian:
            by = sign * self._amount(axis_unit(name))
            stepped = step_axis(self.subject, self.values, self.axes.index(name), by)
        else:
            chain = self.subject.chain
            joint = chain.joint_names.index(name)
            by = sign * self._amount(chain.kinds[joint].unit)
            stepped = step_joint(self.subject, self.values, joint, by)
        self.values = stepped.values
        return stepped.said

    def next_solution(self) -> str:
        """Go on to the next solution within the limits; return its name, or why there is none."""
        of = self.study
        if of.refusal:
            return of.refusal
        after = -1 if of.here is None else of.here
        order = [*of.branches[after + 1 :], *of.branches[: max(after, 0)]]
        taken = next((branch for branch in order if branch.within_limits), None)
        if taken is None:
            return "no other solution is within the limits"
        self.values = taken.joints
        return f"the same place of the hand by {taken.name}"

    def zero(self) -> str:
        """Put every joint at zero, or at the limit nearest to it."""
        chain = self.subject.chain
        self.values = chain.clamp(chain.zero)
        moved = "" if self.values == chain.zero else ", or at the limit nearest to it"
        return f"every joint at zero{moved}"

    def coarser(self, steps: int) -> None:
        """Make the increment larger by so many sizes."""
        self.increment_index = min(max(self.increment_index + steps, 0), len(INCREMENTS) - 1)

    def _amount(self, unit: str) -> float:
        return math.radians(self.increment) if unit == "rad" else self.increment
