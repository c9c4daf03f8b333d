"""The run of a program: its machine gives acts, a performer carries them out, others look on.

Whatever goes wrong is raised as it is; `at` is the step at which it did.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from armdrive.programs.acts import MOTIONS, Answer, Machine, Stage

if TYPE_CHECKING:
    from armdrive.programs.performing import Performer

FOR_EVER = 0
"""So many loops have no end."""


class Source(Protocol):
    """Where the machines of a program come from: one for each loop."""

    def machine(self) -> Machine:
        """Return a machine that stands at the beginning."""
        ...


@dataclass(frozen=True, slots=True)
class Step:
    """One act of a run: `number` counts the acts of this run from 1, `loop` its loops."""

    stage: Stage
    number: int
    loop: int

    @property
    def moves(self) -> bool:
        """Whether the act moves the arm."""
        return isinstance(self.stage.act, MOTIONS)


class Onlooker(Protocol):
    """Somebody who hears of every act before it begins and when it has ended."""

    def begins(self, step: Step, machine: Machine) -> None:
        """Hear of an act that is about to begin. What this raises ends the run before it."""

    def ended(self, step: Step, answer: Answer, took_s: float) -> None:
        """Hear of an act that has ended well, and how long it took on the arm's own clock."""


class Run:
    """One run of a program, from its beginning or from where a machine stands."""

    def __init__(
        self,
        source: Source,
        performer: Performer,
        onlookers: Sequence[Onlooker] = (),
        *,
        loops: int = 1,
        loop: int = 1,
        machine: Machine | None = None,
    ) -> None:
        """Run `loops` times, `FOR_EVER` for no end; `machine` stands in loop number `loop`."""
        self._source = source
        self._performer = performer
        self._onlookers = onlookers
        self._loops = loops
        self.loop = loop
        self.done = 0
        self.at: Step | None = None
        self._machine = machine

    def carry_out(self) -> int:
        """Carry out everything that is left; return how many acts that was."""
        while self._loops == FOR_EVER or self.loop <= self._loops:
            machine, self._machine = self._machine or self._source.machine(), None
            while (stage := machine.next()) is not None:
                self._carry_out(Step(stage, self.done + 1, self.loop), machine)
            self.loop += 1
        self.at = None
        return self.done

    def _carry_out(self, step: Step, machine: Machine) -> None:
        self.at = step
        self._performer.require_no_stop()
        for onlooker in self._onlookers:
            onlooker.begins(step, machine)
        now_s = self._performer.arm.pace.now_s
        began_s = now_s()
        answer = self._performer.perform(step.stage.act)
        machine.answer(answer)
        self.done += 1
        for onlooker in self._onlookers:
            onlooker.ended(step, answer, now_s() - began_s)
