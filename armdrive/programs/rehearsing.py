"""The performer of a rehearsal: acts on the twin, and assumes what a twin cannot know."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING

from armdrive.lines import input_bits
from armdrive.programs.acts import AwaitInputs, Delay, Go, Grasp, Hold, ReadInput, Ready, Remember
from armdrive.programs.performing import Performer, place_of
from armdrive.sim.blocks import Block

if TYPE_CHECKING:
    from collections.abc import Callable

    from armdrive.arm import Arm
    from armdrive.programs.acts import Mark
    from kinematics.geometry import Point

WORDS = {True: "on", False: "off"}


NAP_S = 1.0
"""A twin sleeps no longer than this of a longer wait: nothing happens to it meanwhile."""


@dataclass(frozen=True, slots=True)
class Assumption:
    """Something that the twin could not know. `mark` is None of the arm itself.

    `matters` tells whether the program might go another way, or be refused elsewhere, if it is not
    so: a wait for a person only takes its time.
    """

    text: str
    mark: Mark | None = None
    matters: bool = True

    def __str__(self) -> str:
        return f"line {self.mark.line}: {self.text}" if self.mark is not None else self.text


class Assumptions:
    """What has been assumed, each thing once at each place of the program."""

    def __init__(self) -> None:
        self.found: list[Assumption] = []
        self.mark: Mark | None = None

    def note(self, text: str, *, matters: bool = True) -> None:
        """Note an assumption at the present place."""
        made = Assumption(text, self.mark, matters)
        if made not in self.found:
            self.found.append(made)


class Nobody:
    """The person of a rehearsal: hears nothing, and lets everything go on."""

    def say(self, text: str) -> None:
        """Hear nothing."""

    def hold(self, text: str, over: Callable[[], bool]) -> None:
        """Let it go on."""


class Things:
    """What the fingers find where nobody knows what is around the arm.

    Always something `width_mm` wide, or nothing. Where the world around is `known` it is as it is.
    """

    def __init__(self, assumptions: Assumptions, width_mm: float | None, *, known: bool) -> None:
        self._assumptions = assumptions
        self._width_mm = width_mm
        self._known = known
        self._names = count(1)

    def before_grasp(self, arm: Arm) -> None:
        """Have between the fingers of a twin what they are assumed to find, if it fits in there."""
        if self._known or arm.twin is None:
            return
        if self._width_mm is None:
            self._assumptions.note("the fingers find nothing")
            return
        self._assumptions.note(f"the fingers find something {self._width_mm:g} mm wide")
        world = arm.twin.world
        if world.scene.held is None and world.opening_mm > self._width_mm:
            x_mm, y_mm, z_mm = world.tip
            name = f"assumed-{next(self._names)}"
            high_mm = 2.0 * max(z_mm, self._width_mm / 2.0)
            world.put(Block(name, x_mm, y_mm, 0.0, self._width_mm, high_mm))


class Rehearser(Performer):
    """Carries out acts on a twin; with `traced` the path of the tip is kept."""

    def __init__(
        self,
        twin: Arm,
        assumptions: Assumptions,
        *,
        inputs: Mapping[int, bool],
        things: Things,
        traced: bool,
        outputs: int = 0,
    ) -> None:
        super().__init__(twin, Nobody(), outputs=outputs)
        self.path: list[Point] = []
        self._assumptions = assumptions
        self._inputs = inputs
        self._things = things
        self._traced = traced

    def _go(self, act: Go) -> None:
        if self._traced:
            seen = self.arm.preview(place_of(act, self.arm), line=act.line, speed=act.speed)
            self.path += seen.path
        super()._go(act)

    def _ready(self, act: Ready) -> None:
        if self._traced:
            self.path.append(tip_of(self.arm))
        super()._ready(act)
        if self._traced:
            self.path.append(tip_of(self.arm))

    def _grasp(self, act: Grasp) -> float:
        self._things.before_grasp(self.arm)
        return super()._grasp(act)

    def _read_input(self, act: ReadInput) -> bool:
        number = act.number
        input_bits(self.arm.core, number)  # the arm has to have it
        on = self._inputs.get(number, False)
        self._assumptions.note(f"input {number} is {WORDS[on]}", matters=number not in self._inputs)
        return on

    def _await_inputs(self, act: AwaitInputs) -> bool:
        """Take inputs to come at once, but for those that are said to be otherwise."""
        input_bits(self.arm.core, (*act.high, *act.low))
        wanted = {**dict.fromkeys(act.high, True), **dict.fromkeys(act.low, False)}
        comes = all(self._inputs.get(number, on) is on for number, on in wanted.items())
        what = " and ".join(f"input {number} is {WORDS[on]}" for number, on in wanted.items())
        if comes or act.within_s is None:
            self._assumptions.note(f"{what} at once")
            return True
        self._assumptions.note(f"it is not so within {act.within_s:g} s that {what}")
        self.arm.sleep(min(act.within_s, NAP_S))
        return False

    def _delay(self, act: Delay) -> None:
        self.arm.sleep(min(act.time_s, NAP_S))

    def _hold(self, act: Hold) -> None:  # noqa: ARG002 - as every hold
        self._assumptions.note("somebody lets it go on at once", matters=False)

    def _remember(self, act: Remember) -> None:
        """Leave the arm's points as they are."""


def tip_of(arm: Arm) -> Point:
    """Return where the tip is, in mm."""
    pose = arm.pose
    return pose.x_mm, pose.y_mm, pose.z_mm
