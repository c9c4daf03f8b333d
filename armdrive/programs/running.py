"""The run of a program: its machine gives acts, a performer carries them out, others look on.

Whatever goes wrong is raised as it is; `at` is the step at which it did.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, chain
from typing import Protocol

from armdrive.programs.acts import MOTIONS, Answer, ProgramMachine, RunStage
from armdrive.programs.performing import Performer
from armdrive.programs.problems import SourceMark

FOR_EVER = 0
"""So many loops have no end."""


class MachineSource(Protocol):
    """Where the machines of a program come from: one for each loop."""

    def machine(self) -> ProgramMachine:
        """Return a machine that stands at the beginning."""
        ...


@dataclass(frozen=True, slots=True)
class RunStep:
    """One act of a run: `number` counts the acts of this run from 1, `loop` its loops."""

    stage: RunStage
    number: int
    loop: int

    @property
    def moves(self) -> bool:
        """Whether the act moves the arm."""
        return isinstance(self.stage.act, MOTIONS)


class Onlooker(Protocol):
    """Somebody who hears of every act before it begins and when it has ended."""

    def begins(self, step: RunStep, machine: ProgramMachine) -> None:
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
        machine: ProgramMachine | None = None,
    ) -> None:
        """Run `loops` times, `FOR_EVER` for no end; `machine` stands in loop number `loop`."""
        self._source = source
        self._performer = performer
        self._onlookers = onlookers
        self._loops = loops
        self.loop = loop
        self.done = 0
        self.at: RunStep | None = None
        self._machine = machine

    def carry_out(self) -> int:
        """Carry out everything that is left; return how many acts that was."""
        while self._loops == FOR_EVER or self.loop <= self._loops:
            machine, self._machine = self._machine or self._source.machine(), None
            while (stage := machine.next()) is not None:
                self._carry_out(RunStep(stage, self.done + 1, self.loop), machine)
            self.loop += 1
        self.at = None
        return self.done

    def _carry_out(self, step: RunStep, machine: ProgramMachine) -> None:
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


# How far a run has come, and what is left of it, by what its rehearsal took.
#
# A run may go another way than its rehearsal, an input may be on that was taken to be off: it is
# looked for where it is again, by its place in the program. Units: s on the arm's own clock.

LOOPS_REHEARSED = 2
"""The second loop begins where the first has ended, and so do all that follow."""


@dataclass(frozen=True, slots=True)
class Took:
    """What one act of a rehearsal took, and where it stands in the program."""

    mark: SourceMark
    what: str
    took_s: float


@dataclass(frozen=True, slots=True)
class Estimate:
    """How far a run has come. `percent` and `left_s` are None where nobody knows.

    Of a run without an end, both are of its present loop.
    """

    percent: float | None = None
    left_s: float | None = None


UNKNOWN = Estimate()


class RunProgress:
    """Follows a run along its rehearsal."""

    def __init__(self, loops: Sequence[Sequence[Took]], *, repeated: int = 1) -> None:
        """Take the rehearsed loops, of which the last stands for all that follow.

        `repeated` is how many loops the run has, `FOR_EVER` for no end. Without any rehearsed
        loop, nothing is known.
        """
        self._loops = [list(loop) for loop in loops]
        self._ends_s = [list(accumulate(each.took_s for each in loop)) for loop in self._loops]
        self._repeated = repeated
        self._loop = 0
        self._index: int | None = None

    @property
    def total_s(self) -> float | None:
        """How long the whole run takes; None of one without an end, or that nobody knows."""
        if self._repeated == FOR_EVER or not self._loops:
            return None
        return sum(self._loop_s(number) for number in range(1, self._repeated + 1))

    def begins(self, mark: SourceMark, loop: int = 1) -> None:
        """Note where the run is now."""
        fresh, self._loop = loop != self._loop, loop
        marks = [each.mark for each in self._rehearsed(loop)]
        expected = 0 if fresh or self._index is None else self._index + 1
        self._index = nearest(marks, mark, expected)

    def estimate(self, under_way_s: float, share: float = 1.0) -> Estimate:
        """Return how far the run has come, `under_way_s` after the present act began.

        `share` is how fast the arm goes now, of the speed that it was rehearsed with.
        """
        if self._index is None or not self._loops:
            return UNKNOWN
        took_s = self._rehearsed(self._loop)[self._index].took_s
        done_s = self._ends(self._loop)[self._index] - took_s + min(under_way_s * share, took_s)
        whole_s = self._loop_s(self._loop)
        if self._repeated != FOR_EVER:
            done_s += sum(self._loop_s(number) for number in range(1, self._loop))
            whole_s = sum(self._loop_s(number) for number in range(1, self._repeated + 1))
        percent = 100.0 * done_s / whole_s if whole_s > 0.0 else 0.0
        return Estimate(min(percent, 100.0), max(whole_s - done_s, 0.0) / share)

    def _rehearsed(self, loop: int) -> list[Took]:
        return self._loops[min(loop, len(self._loops)) - 1] if self._loops else []

    def _ends(self, loop: int) -> list[float]:
        return self._ends_s[min(loop, len(self._loops)) - 1]

    def _loop_s(self, loop: int) -> float:
        return (self._ends(loop) or [0.0])[-1]


def nearest(marks: Sequence[SourceMark], mark: SourceMark, expected: int) -> int | None:
    """Return the index of a mark: the first from where it is expected on, else the last before.

    None where it is nowhere.
    """
    ahead = range(expected, len(marks))
    behind = range(min(expected, len(marks)) - 1, -1, -1)
    return next((index for index in chain(ahead, behind) if marks[index] == mark), None)
