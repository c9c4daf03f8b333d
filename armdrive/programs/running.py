"""The run of a program: its machine gives acts, a performer carries them out, others look on.

Whatever goes wrong is raised as it is; `at` is the step at which it did.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

from armdrive.programs.acts import (
    MOTIONS,
    Answer,
    Go,
    ProgramMove,
    RunStage,
    act_name,
)
from armdrive.programs.performing import Performer
from armdrive.programs.program import Machine
from armdrive.programs.progress import FOR_EVER
from armdrive.text.json_forms import move_to_json


class MachineSource(Protocol):
    """Where the machines of a program come from: one for each loop."""

    def machine(self) -> Machine:
        """Return a machine that stands at the beginning."""
        ...


@dataclass(frozen=True, slots=True)
class RunStep:
    """One act of a run: `number` counts the acts of this run from 1, `loop` its loops.

    `move` is what the arm is to do, resolved from where it stands; None where it does not move, or
    will refuse to.
    """

    stage: RunStage
    number: int
    loop: int
    move: ProgramMove | None = None

    @property
    def act_name(self) -> str:
        """What people are told that the act is."""
        return act_name(self.stage.act)

    def view(self) -> dict[str, Any]:
        """Return its line, its act and its move as plain data."""
        return {
            "line": self.stage.mark.line,
            "act": self.act_name,
            "move": None if self.move is None else move_to_json(self.move),
        }

    @property
    def moves(self) -> bool:
        """Whether the act moves the arm."""
        return isinstance(self.stage.act, MOTIONS)


class Onlooker(Protocol):
    """Somebody who hears of every act before it begins and when it has ended."""

    def begins(self, step: RunStep, machine: Machine) -> None:
        """Hear of an act that is about to begin. What this raises ends the run before it."""

    def ended(self, step: RunStep, answer: Answer, took_s: float) -> None:
        """Hear of an act that has ended well, and how long it took on the arm's own clock."""


class ProgramRun:
    """One run of a program, from its beginning or from where a machine stands."""

    def __init__(
        self,
        source: MachineSource,
        performer: Performer,
        onlookers: Sequence[Onlooker] = (),
        *,
        loops: int = 1,
        loop: int = 1,
        machine: Machine | None = None,
        left: ProgramMove | None = None,
    ) -> None:
        """Run `loops` times, `FOR_EVER` for no end; `machine` stands in loop number `loop`.

        `left` is what is left of its first move, where that was interrupted.
        """
        self._source = source
        self._performer = performer
        self._onlookers = onlookers
        self._loops = loops
        self.loop = loop
        self.done = 0
        self.at: RunStep | None = None
        self._machine = machine
        self._left = left

    def carry_out(self) -> int:
        """Carry out everything that is left; return how many acts that was."""
        while self._loops == FOR_EVER or self.loop <= self._loops:
            machine, self._machine = self._machine or self._source.machine(), None
            while (stage := machine.next()) is not None:
                self._carry_out(self._step(stage), machine)
            self.loop += 1
        self.at = None
        return self.done

    def _step(self, stage: RunStage) -> RunStep:
        """Return the next step, its move resolved from where the arm stands."""
        self._performer.require_no_stop()
        left, self._left = self._left, None
        act = stage.act
        move = left if isinstance(act, Go) and left else self._performer.resolved(act)
        if isinstance(act, Go) and move is not None:
            stage = replace(stage, act=replace(act, move=move))
        return RunStep(stage, self.done + 1, self.loop, move)

    def _carry_out(self, step: RunStep, machine: Machine) -> None:
        self.at = step
        for onlooker in self._onlookers:
            onlooker.begins(step, machine)
        now_s = self._performer.arm.pace.now_s
        began_s = now_s()
        answer = self._performer.perform(step.stage.act)
        machine.answer(answer)
        self.done += 1
        for onlooker in self._onlookers:
            onlooker.ended(step, answer, now_s() - began_s)
