"""Rehearses a program for the desk: on the arm's simulated twin, in a thread; nothing moves."""

from __future__ import annotations

import math
import time
from functools import partial
from typing import cast

from armdrive import Arm
from armdrive.errors import ArmError
from armdrive.programs.program import ArmProgram, Program
from armdrive.programs.rehearsal import (
    CHECK_S,
    Patience,
    Rehearsal,
    RehearsedSoFar,
    SeenArm,
    rehearse,
)
from armdrive.programs.running import RunPlan
from armdrive.status import Status
from tui.screens import ScreenHost


def plan_of(program: Program, desk: ScreenHost) -> RunPlan:
    """Return the plan of one run of a program on the desk's arm."""
    return RunPlan(ArmProgram(program, desk.arm.config).machine)


def arm_of(desk: ScreenHost) -> Arm:
    """Return the desk's arm, of which a program needs more than the screens do."""
    return cast("Arm", desk.arm)


class ProgramRehearsal:
    """The rehearsal of the chosen program. It holds as long as the arm stands where it stood."""

    def __init__(self, desk: ScreenHost) -> None:
        self.far: RehearsedSoFar | None = None
        """How far the rehearsal under way has come, after its first second."""
        self._desk = desk
        self._number = 0  # of the rehearsal that counts: earlier ones end, and are dropped
        self._working = False
        self._found: Rehearsal | None = None
        self._of: object = None

    @property
    def working(self) -> bool:
        """Whether a rehearsal is under way."""
        return self._working

    def fresh(self, program: Program, status: Status) -> Rehearsal | None:
        """Return what was found, if program and arm are still as they were rehearsed."""
        return self._found if self._of == _seen(program, status) else None

    def forget(self) -> None:
        """Drop what was found, and end a rehearsal that is under way."""
        self._number += 1
        self._working, self._found, self._of, self.far = False, None, None, None

    def begin(self, program: Program) -> None:
        """Rehearse a program from where the arm stands."""
        self.forget()
        self._working, seen = True, _seen(program, self._desk.link.status)
        self._desk.in_thread(partial(self._rehearse, program, seen, self._number))

    def _rehearse(self, program: Program, seen: object, number: int) -> None:
        found, message = None, ""
        patience = Patience(CHECK_S, partial(self._note, number), partial(self._now_s, number))
        try:
            plan = plan_of(program, self._desk)
            found = rehearse(SeenArm.of(arm_of(self._desk)), plan, patience)
        except ArmError as error:
            message = str(error)
        finally:
            self._desk.call_from_thread(self._keep, number, seen, found, message)

    def _now_s(self, number: int) -> float:
        """Return the time; a rehearsal that does not count any more has run out of it."""
        return time.monotonic() if number == self._number else math.inf

    def _note(self, number: int, far: RehearsedSoFar) -> None:
        if number == self._number:
            self.far = far

    def _keep(self, number: int, seen: object, found: Rehearsal | None, message: str) -> None:
        if number != self._number:
            return
        self._working, self.far = False, None
        self._found, self._of = found, seen
        if message:
            self._desk.message = message
        self._desk.show()


def _seen(program: Program, status: Status) -> object:
    return program.digest, status.acknowledged, status.trust
