"""A program under way: it gives acts one at a time, takes their answers, and can be written down.

Pure: it knows no arm and no clock. See acts.Machine for what each call promises. A snapshot holds
the state before the act that is to be carried out now, so that a machine restored from it gives the
same act again, and the same rest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.errors import ArmError, ProgramError
from armdrive.programs.acts import MOTIONS, Act, Answer, Home, Mark, Seen, Stage
from armdrive.programs.context import Context
from armdrive.programs.instructions import Instruction, Op
from armdrive.programs.operations import World, step
from armdrive.programs.problems import Problem, program_error
from armdrive.programs.state import State, state_from_json, state_to_json, table
from armdrive.programs.syntax import Define
from armdrive.programs.values import (
    ForwardKinematics,
    Place,
    Trouble,
    Value,
    from_json,
    number,
    to_json,
    truth,
)
from kinematics.errors import KinematicsError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from armdrive.programs.program import Program

MOST_STEPS = 200_000
"""So many instructions may be carried out between two acts: some tenths of a second."""

FORMAT = 1
"""The form of a snapshot."""


class Machine:
    """One run of a program; made by `Program.machine` and `Program.restored`."""

    def __init__(self, program: Program, world: World, state: State | None = None) -> None:
        self.program = program
        self._world = world
        self._state = State() if state is None else state
        self._stage: Stage | None = None
        self._error: ProgramError | None = None

    @classmethod
    def restored(
        cls,
        program: Program,
        snapshot: Mapping[str, object],
        *,
        fk: ForwardKinematics | None = None,
    ) -> Machine:
        """Take a run up again where its snapshot was made, with the points that it had then.

        Raises `ProgramError` for a snapshot of another program, or of another form.
        """
        if snapshot.get("format") != FORMAT:
            raise ProgramError("this state of a program was written by another version of armdrive")
        digests = (snapshot.get("program"), snapshot.get("code"))
        if digests != (program.digest, program.code_digest):
            raise ProgramError("the program has been changed since: begin it anew")
        try:
            places = {name: _place(data) for name, data in table(snapshot["points"]).items()}
            state = state_from_json(table(snapshot["state"]))
            machine = cls(program, World(places, fk), state)
            machine._row()  # a state that stands nowhere is none
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise ProgramError(f"this state of a program cannot be used: {error}") from None
        return machine

    @property
    def mark(self) -> Mark:
        """Where in the program it stands."""
        return self._row().mark

    @property
    def ended_by_stop(self) -> bool:
        """Whether it ended at a `stop`, and not behind its last line."""
        return self._state.ended and self._row().op is Op.END

    @property
    def context(self) -> Context:
        """What it has brought so far, for a program that is read with it: see `read_program`."""
        known, state = self.program.context, self._state
        own = tuple(line for line in self.program.tree.body if isinstance(line, Define))
        return Context(known.but(own), dict(state.variables), state.speed, state.opening)

    def next(self) -> Stage | None:
        """Return the act to be carried out now, the same until it is answered; None at the end.

        Raises `ProgramError` where a line cannot be carried out; asked again, it raises again.
        """
        if self._error is not None:
            raise self._error
        if self._stage is None and not self._state.ended:
            act = self._run_on()
            if act is not None:
                calls = tuple(frame.mark for frame in self._state.frames if frame.mark is not None)
                self._stage = Stage(act, self._row().mark, calls)
        return self._stage

    def answer(self, answer: Answer) -> None:
        """Say what the act brought, and go on behind it. Raises `ProgramError` for a wrong kind."""
        stage = self.next()
        if stage is None:
            raise ProgramError("the program has ended: nothing is to be answered")
        row, state = self._row(), self._state
        try:
            pushed = _pushed(row, answer)
        except Trouble as error:
            raise self._failure(f"the answer does not fit: {error}") from None
        if row.op in (Op.ACT, Op.INPUT):
            del state.stack[len(state.stack) - row.count :]
        if isinstance(stage.act, MOTIONS) and not isinstance(stage.act, Home):
            state.opening = None  # it went along, or something else was done with the fingers
        state.stack.extend(pushed)
        state.at += 1
        self._stage = None

    def snapshot(self) -> dict[str, object]:
        """Return all that the program knows at this point, as plain JSON data."""
        return {
            "format": FORMAT,
            "program": self.program.digest,
            "code": self.program.code_digest,
            "points": {name: to_json(place) for name, place in self._world.points.items()},
            "state": state_to_json(self._state),
        }

    def _row(self) -> Instruction:
        if self._state.at < 0:
            raise IndexError("before the program")
        return self.program.code.instructions[self._state.at]

    def _run_on(self) -> Act | None:
        """Go on to the next act. Where that fails, the state stays what it was after the last."""
        before = state_to_json(self._state)
        try:
            return self._run()
        except (Trouble, ArmError, KinematicsError) as error:
            self._error = self._failure(str(error))
        self._state = state_from_json(before)
        raise self._error

    def _run(self) -> Act | None:
        for _ in range(MOST_STEPS):
            act = step(self._state, self._row(), self._world)
            if act is not None or self._state.ended:
                return act
        raise Trouble("the program goes round here without ever asking anything of the arm")

    def _failure(self, text: str) -> ProgramError:
        calls = [frame.mark for frame in self._state.frames if frame.mark is not None]
        led = "".join(f", called in line {mark.line}" for mark in reversed(calls[-3:]))
        return program_error(
            [Problem(self._row().mark, text + led)], self.program.text, self.program.file
        )


def _place(data: object) -> Place:
    found = from_json(data)
    if not isinstance(found, Place):
        raise TypeError(f"{data!r} is no place")
    return found


def _pushed(row: Instruction, answer: Answer) -> tuple[Value, ...]:
    """Return what an answer leaves for the lines after it."""
    if row.op is Op.LOOK:
        if not isinstance(answer, Seen):
            raise Trouble("where the arm stands is needed")
        return (Place(answer.pose, dict(answer.joints_deg), answer.opening_mm),)
    if row.op is Op.INPUT:
        return (truth(answer),)
    if not row.value:
        return ()
    if row.name == "grasp":
        return (number(answer),)
    return (True,) if row.name == "wait" else (truth(answer),)
