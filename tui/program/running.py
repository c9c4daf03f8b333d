"""Lists, reads, rehearses and runs programs from the desk, and knows what a run waits for.

A rehearsal happens on a simulated copy of the arm, in a thread; nothing moves. The program itself
runs in a thread as well. It ends as other motion of the desk does: a stop ends it at once. Leaving
the screen, a dialog, or a lost focus or link let a motion that is under way come to its end, begin
no other one, and end a wait.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from armdrive.config.arm import ArmConfig
from armdrive.errors import ArmError, BadRequest, LinkLost, Stopped
from armdrive.errors.printable import reason_of
from armdrive.programs.acts import RunStep
from armdrive.programs.journal import Journal
from armdrive.programs.language import ENDING
from armdrive.programs.problems import ProgramError, lines_of, mark_of
from armdrive.programs.program import ArmProgram, Machine, Program, read_program
from armdrive.programs.progress import RunView, duration, line_words
from armdrive.programs.rehearsal import (
    CHECK_S,
    Rehearsal,
    SeenArm,
    rehearse,
    time_limit,
)
from armdrive.programs.running import BREATH_S, Performer, ProgramRun, RunPlan
from armdrive.status import Status
from armdrive.storage.files import stamp_of
from armdrive.text.reading import read_text
from kinematics.errors import KinematicsError
from kinematics.text import counted
from tui.app import Job
from tui.desk import Desk


@dataclass(frozen=True, slots=True)
class CheckedProgram:
    """A program file as it was read. `error` says what is wrong, in the lines `wrong` (from 1)."""

    path: Path
    lines: tuple[str, ...] = ()
    program: Program | None = None
    error: str = ""
    wrong: frozenset[int] = frozenset()


def check_file(path: Path, config: ArmConfig) -> CheckedProgram:
    """Read a program file, and check it for this arm and its points."""
    lines: tuple[str, ...] = ()
    try:
        text = read_text(path, "the program", BadRequest)
        lines = tuple(lines_of(text.rstrip("\r\n")))
        program = read_program(text, str(path))
        ArmProgram(program, config).machine()  # raises for a point that this arm does not have
    except ProgramError as error:
        wrong = frozenset(each.mark.line for each in error.problems)
        return CheckedProgram(path, lines, None, str(error), wrong)
    except ArmError as error:
        return CheckedProgram(path, lines, None, str(error))
    return CheckedProgram(path, lines, program)


class ProgramFiles:
    """Lists the programs of a folder, and reads the chosen one again whenever it has changed."""

    def __init__(
        self, desk: Desk, folder: Path, named: Path | None, changed: Callable[[], None]
    ) -> None:
        """`named` is chosen at first. `changed` is called when another program is shown."""
        self.folder = folder
        self.paths: tuple[Path, ...] = ()
        self.checked: CheckedProgram | None = None
        """The chosen program; None if there is none."""
        self._desk = desk
        self._named = named
        self._chosen = named
        self._changed = changed
        self._read_as: object = None

    @property
    def at(self) -> int:
        """The chosen row; the first one if the chosen file is gone."""
        return self.paths.index(self._chosen) if self._chosen in self.paths else 0

    @property
    def chosen(self) -> Path | None:
        """The chosen file; None if there is no program file."""
        return self.paths[self.at] if self.paths else None

    def require_program(self) -> Program:
        """Return the chosen program. Raises `BadRequest` where there is none to rehearse or run."""
        if self.checked is None:
            raise BadRequest("there is no program to run")
        if self.checked.program is None:
            raise BadRequest("the program has mistakes: correct its file first")
        return self.checked.program

    def look(self) -> None:
        """List the files again."""
        try:
            found = sorted(each for each in self.folder.iterdir() if each.suffix == ENDING)
        except OSError as error:
            self._desk.message = f"{self.folder} cannot be read: {reason_of(error)}"
            found = []
        named = [] if self._named is None or self._named in found else [self._named]
        self.paths = (*named, *found)

    def choose(self, row: int) -> None:
        """Choose a row; after the last one comes the first."""
        if self.paths:
            self._chosen = self.paths[row % len(self.paths)]
            self.follow()

    def follow(self) -> None:
        """Read the chosen file again if it, or the arm's points, have changed."""
        path = self.chosen
        stamp = None if path is None else (path, stamp_of(path), self._desk.arm.points.stamp)
        if stamp != self._read_as:
            self._read_as = stamp
            self._changed()
            self.checked = None if path is None else check_file(path, self._desk.arm.config)


def reason(error: Exception) -> str:
    """Return what went wrong, without the lines of the program, which the screen shows."""
    problems = error.problems if isinstance(error, ProgramError) else ()
    return problems[0].text if problems else str(error)


def plan_of(program: Program, desk: Desk) -> RunPlan:
    """Return the plan of one run of a program on the desk's arm."""
    return RunPlan(ArmProgram(program, desk.arm.config).machine)


class ProgramRehearsal:
    """The rehearsal of the chosen program. It holds as long as the arm stands where it stood."""

    def __init__(self, desk: Desk) -> None:
        self.job = Job()
        """The rehearsal under way."""
        self._desk = desk
        self._number = 0  # of the rehearsal that counts: earlier ones end, and are dropped
        self._found: Rehearsal | None = None
        self._of: object = None

    def fresh(self, program: Program, status: Status) -> Rehearsal | None:
        """Return what was found, if program and arm are still as they were rehearsed."""
        return self._found if self._of == _seen(program, status) else None

    def forget(self) -> None:
        """Drop what was found, and end a rehearsal that is under way."""
        self._number += 1
        self.job, self._found, self._of = Job(), None, None

    def begin(self, program: Program) -> None:
        """Rehearse a program from where the arm stands."""
        self.forget()
        number, seen = self._number, _seen(program, self._desk.link.status)
        self.job = self._desk.calls.work_out(
            partial(self._rehearse, program, number), partial(self._keep, number, seen)
        )

    def _rehearse(self, program: Program, number: int) -> Rehearsal:
        late = time_limit(CHECK_S)
        # one that does not count any more ends
        return rehearse(
            SeenArm.of(self._desk.arm),
            plan_of(program, self._desk),
            lambda: late() or number != self._number,
        )

    def _keep(self, number: int, seen: object, found: Rehearsal | None) -> None:
        if number == self._number:
            self._found, self._of = found, seen


def _seen(program: Program, status: Status) -> object:
    return program.digest, status.acknowledged, status.trust


# Lines that a program has printed and that are kept for the screen.
PRINTS_KEPT = 50


class DeskRun:
    """The run of a program, or how the last one ended."""

    def __init__(self, desk: Desk) -> None:
        self.stepping = False
        """Whether the program waits for the person before each motion."""
        self.asks = ""
        """The question on which the program waits for the user; empty if it does not wait."""
        self.printed: deque[str] = deque(maxlen=PRINTS_KEPT)
        """The output of the program."""
        self.outcome = ""
        """How the last run ended; empty before the first one."""
        self.failed = False
        """Whether the last run ended early."""
        self.failed_in: int | None = None
        """The line in which the last run ended early; None if it came to its end."""
        self.view = RunView({})
        self._desk = desk
        self._performer: Performer | None = None
        self._step: RunStep | None = None
        self._halted = ""
        self._job = Job()

    @property
    def busy(self) -> bool:
        """Whether a program is running."""
        return self._job.busy

    @property
    def line(self) -> int | None:
        """The line that runs, or in which the last run ended early."""
        if self.busy:
            return None if self.view.step is None else self.view.step.mark.line
        return self.failed_in

    def forget(self) -> None:
        """Forget how the last run ended."""
        self.outcome, self.failed, self.failed_in = "", False, None
        self.printed.clear()

    def require_idle(self) -> None:
        """Raise `BadRequest` while a program is running."""
        if self.busy:
            stop = self._desk.keys.label("stop")
            raise BadRequest(f"the program is running: {stop} stops it")

    def begin(self, path: Path, program: Program, rehearsal: Rehearsal) -> None:
        """Run the program of a file as it was rehearsed."""
        self.forget()
        self._step, self._halted = None, ""
        self.view = RunView(program.lines)
        self.view.follow(rehearsal.progress(1), share=rehearsal.share)
        carry_out = partial(self._carry_out, path, program, self._desk.arm.stops)
        self._job = self._desk.calls.make(carry_out)

    def disarm(self, reason: str) -> None:
        """Let the program begin no further act; a wait that is under way ends now."""
        if self.busy:
            self._halted = self._halted or reason  # the first reason is the cause of the others
            if self._step is None or not self._step.moves:
                self._desk.arm.request_stop()

    # -- keys ---------------------------------------------------------------------------------

    def switch_stepping(self) -> None:
        """Make the program wait before each motion, or no longer."""
        self.stepping = not self.stepping

    def forward(self) -> None:
        """Let a program go on that waits for the person; a key that is held does not count."""
        confirmation = self._desk.confirmation
        if not self.asks:
            confirmation.refuse()  # it may still be held when the program waits
            raise BadRequest("the program does not wait for you")
        confirmation.press("goes on", self._go_on, needed=1)

    def _go_on(self) -> None:
        if self.asks:  # another program may have let it go on meanwhile
            self._desk.arm.resume()

    # -- the run, in its thread ---------------------------------------------------------------

    def _carry_out(self, path: Path, program: Program, stops: int) -> str:
        arm = self._desk.arm
        try:
            self.view.use(arm)
            plan = plan_of(program, self._desk)
            self._performer = Performer(arm, self, since=stops)
            journal = Journal(arm, self._performer, path.resolve(), program.digest, plan.loops)
            run = ProgramRun(plan, self._performer, before=[journal.begins, self._begins])
            try:
                run.carry_out()
                journal.finish()
            except (ArmError, KinematicsError) as error:
                self._failed(error, run)
            else:
                self.outcome = f"DONE: {counted(run.done, 'act')} in {duration(run.took_s)}"
        finally:
            self.asks, self._performer = "", None
            arm.program = None
        return self._end_words()

    def _failed(self, error: Exception, run: ProgramRun) -> None:
        mark = mark_of(error, None if run.at is None else run.at.mark)
        why = self._halted if self._halted and isinstance(error, Stopped) else reason(error)
        if isinstance(error, LinkLost):
            why = "the link was lost"  # the safety panel says all about it
        self.failed, self.failed_in = True, None if mark is None else mark.line
        where = "" if mark is None else f" IN LINE {mark.line}"
        self.outcome = f"ENDED{where}, after {counted(run.done, 'act')}: {why}"

    def _end_words(self) -> str:
        """Say on whatever screen is shown that the program has ended."""
        where = "" if self.failed_in is None else f" in line {self.failed_in}"
        return f"the program ended early{where}" if self.failed else "the program is done"

    def _begins(self, step: RunStep, _: Machine) -> None:
        """Note the act that begins; begin none once the screen was left."""
        self.view.at(step)
        if step.moves and self.stepping and self._performer is not None:
            self._take(None)
            self._performer.hold(
                f"next, {line_words(step.mark.line, self.view.line_at(step.mark))}"
            )
        self._take(step)

    def _take(self, step: RunStep | None) -> None:
        """Note the act under way, then look whether the run was halted; `disarm` does the reverse.

        So one of the two always sees the other.
        """
        self._step = step
        if self._halted:
            raise Stopped("the program was stopped")

    # -- the person at the desk ---------------------------------------------------------------

    def say(self, text: str) -> None:
        """Show what the program prints."""
        self.printed.extend(text.splitlines() or [""])

    def hold(self, text: str, over: Callable[[], bool]) -> None:
        """Pause the arm until a key or another program resumes it, or until `over()`."""
        arm = self._desk.arm
        arm.pause()
        self.asks = text or "the program waits for you"
        try:
            while arm.status.paused and not over():
                time.sleep(BREATH_S)
        finally:
            self.asks = ""
