"""Commissioning practised on a simulated arm: hands that plug in, eyes that see."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from armdrive.commissioning.acts import About, Ask
from armdrive.commissioning.plan import MM, Plan, Planned
from armdrive.commissioning.trying import AS_SAID, MORE, NUDGE, amount
from armdrive.interview.sight import Sight, sight
from armdrive.interview.signs import NOTHING, OTHER
from armdrive.sim.drives import DrivesOnBus
from armdrive.sim.twin import Twin

MUCH = 2.5
"""So many times as far as announced is "more"."""
_SEEN = frozenset({About.SEEN, About.WAY, About.ROLL, About.AMOUNT})


class Practice:
    """A person beside a simulated arm, who does and sees what one would beside a real one.

    Without `ask` he answers everything himself; with it a person does, and is told what was seen.
    """

    def __init__(
        self,
        twin: Twin,
        plan: Plan,
        tell: Callable[[str], None],
        ask: Callable[[Ask], Any] | None = None,
    ) -> None:
        """Begin with every drive's CAN cable pulled."""
        self.tell = tell
        self._ask = ask
        self._twin = twin
        self._plan = plan
        self._before = (twin.world.joints, twin.world.opening_mm)
        for motor in range(len(plan.drives)):
            self._plug(motor, on=False)

    def watch(self, motor: int) -> None:  # noqa: ARG002 - the eyes are on the whole arm
        """Look how the arm stands."""
        self._before = (self._twin.world.joints, self._twin.world.opening_mm)

    def answer(self, asked: Ask) -> Any:
        """Do what a question is about, then answer it or have it answered."""
        if asked.about is About.CONNECT:
            self._plug(asked.motor, on=True)
        seen = self._seen(asked) if asked.about in _SEEN else ""
        if self._ask is None:
            word = seen or asked.question.default or "yes"
            self.tell(f"{asked.question.words} {word}")
            return asked.question.read(word)
        if seen:
            self.tell(f"  (seen on the simulated arm: {seen})")
            asked = replace(asked, question=replace(asked.question, default=seen))
        return self._ask(asked)

    def _plug(self, motor: int, *, on: bool) -> None:
        device: Any = self._twin.device
        if isinstance(device, DrivesOnBus):
            device.plug_drive(motor, on)

    def _seen(self, asked: Ask) -> str:
        drive = self._plan.drives[asked.motor]
        if asked.about is About.AMOUNT:
            return f"{self._moved(drive):.3g}"
        if asked.about is About.SEEN:
            return MORE if self._moved(drive) > MUCH * amount(drive) / NUDGE else AS_SAID
        seen = self._sight()
        if asked.about is About.ROLL:
            return seen.word("roll") if "roll" in seen.visible() else NOTHING
        ways = [way for way in seen.visible() if way in drive.trial.ways]
        if ways:
            return seen.word(ways[0])
        return OTHER if seen.visible() else NOTHING

    def _sight(self) -> Sight:
        world, (joints, opening_mm) = self._twin.world, self._before
        return sight(world.body.arm, joints, world.joints, world.opening_mm - opening_mm)

    def _moved(self, drive: Planned) -> float:
        world, (joints, opening_mm) = self._twin.world, self._before
        if drive.unit == MM:
            return abs(world.opening_mm - opening_mm)
        at = joints.names.index(drive.moves.replace(" ", "_"))
        return abs(math.degrees(world.joints[at] - joints[at]))
