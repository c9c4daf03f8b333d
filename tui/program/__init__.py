"""The program screen: a program is chosen, checked, rehearsed, and run with its lines in view."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical

from armdrive.errors import BadRequest
from armdrive.errors.printable import command_line, printable
from armdrive.programs.progress import RunView, duration
from armdrive.programs.rehearsal import Rehearsal
from armdrive.render.scene import Moment
from armdrive.status import Status
from kinematics.text import counted
from tui.arm_view import SpaceView
from tui.desk import DeskScreen
from tui.keys.keyboard import Keyboard, bindings
from tui.keys.table import PAUSE, STOP, Needs
from tui.move.planned import going_text, progress_bar
from tui.program.running import DeskRun, ProgramFiles, ProgramRehearsal, reason
from tui.widgets import ChoiceList, ProgramLines, Span, panels

WARN = "$text-warning"
WRONG = "$text-error"


def file_name(path: Path, folder: Path) -> str:
    """Return the name of a file, with its folder if that is another one."""
    return path.name if path.parent == folder else str(path)


def rehearsed_lines(
    found: Rehearsal, keys: Keyboard, again: str, spoken: Callable[[str], str]
) -> Iterator[Span]:
    """Say what a rehearsal found; `again` asks for the second press of the key that runs it.

    `spoken` puts a sentence into the words of the desk.
    """
    if found.refusal is not None:
        where = "" if found.at is None else f" IN LINE {found.at.line}"
        yield f"REFUSED{where}: {spoken(reason(found.refusal))}", WRONG
    else:
        acts = counted(sum(map(len, found.loops)), "act")
        yield f"rehearsed: {duration(found.took_s)}, {acts}{found.end_words}", "$text-success"
        if again:
            yield again, WARN
        else:
            yield f"{keys.label('program-go')} twice runs it: THE ARM MOVES", ""
    for each in found.assumptions:
        yield spoken(f"assumed: {each}"), "dim"


def running_lines(
    run: RunView, asks: str, keys: Keyboard, *, paused: bool, stepping: bool
) -> Iterator[Span]:
    """Say where a running program is, what it waits for, and how it is stopped."""
    view = run.view()
    percent, left_s = view.get("percent"), view.get("left_s")
    if percent is not None:
        left = "" if left_s is None else f", {duration(left_s)} left"
        yield f"{progress_bar(percent / 100)}{left}", "$text-primary"
    forward, pause, stop = map(keys.label, ("program-forward", PAUSE, STOP))
    if asks:
        yield f"WAITS FOR YOU: {asks}", WARN
        yield f"{forward} or {pause} continues, {stop} ends it", ""
        return
    if view.get("waiting"):
        yield f"{view['waiting']} ({duration(run.under_way_s)} so far)", WARN
    yield going_text(keys, paused=paused), WARN if paused else ""
    if stepping:
        yield "STEPPING: waits for you before the next motion", ""


def ended_lines(outcome: str, file: str, *, failed: bool) -> Iterator[Span]:
    """Say how the last run ended, and how to resume one that ended early."""
    yield outcome, WRONG if failed else "$text-success"
    if failed:
        resume = command_line("run", file, "--resume")
        yield f"`{resume}`, on the same arm, continues from there", ""


# Lines by which a page key scrolls the program.
PAGE = 8

# Printed lines that are shown, the newest last.
PRINTS_SHOWN = 4


class ProgramScreen(DeskScreen):
    """The list, the lines of the chosen program, and what its run or rehearsal says."""

    place = "program"
    go = "program-go"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        desk = self.desk
        self.run = DeskRun(desk)
        self.files = ProgramFiles(desk, desk.programs, desk.program, self._forget)
        self.rehearsal = ProgramRehearsal(desk)
        self._top = 0

    def _forget(self) -> None:
        """Forget the rehearsal and the last run: another program is shown."""
        self.desk.confirmation.forget()
        self.rehearsal.forget()
        self.run.forget()
        self._top = 0

    @property
    def says(self) -> str:
        """The action that the running program needs from the user."""
        stop = self.desk.keys.label(STOP)
        return f"a program moves the arm: {stop} stops it" if self.run.busy else super().says

    @property
    def works(self) -> Mapping[str, bool]:
        """A program with mistakes does not run; a running one is not chosen or rehearsed."""
        checked, busy = self.files.checked, self.run.busy
        runs = checked is not None and checked.program is not None
        return {
            "program-go": runs,
            "next": bool(self.files.paths) and not busy,
            "program-rehearse": runs and not busy,
            "program-stepping": bool(self.files.paths),
            "program-forward": bool(self.run.asks),
        }

    def first_keys(self, status: Status) -> tuple[str, ...]:
        """Return the key that a waiting program needs, or those that every screen needs."""
        return ("program-forward",) if self.run.asks else super().first_keys(status)

    def disarm(self, reason: str) -> None:
        """Let a running program begin no further act."""
        self.run.disarm(reason)

    def compose_body(self) -> ComposeResult:
        """Lay the middle out."""
        with Horizontal():
            yield from self.arm_panel()
            with Vertical(id="panels"):
                programs = ChoiceList("choose", id="programs")
                programs.border_title = "Programs"
                yield programs
                yield ProgramLines(id="program")
                yield from panels(run="Run", printed="Printed")

    def on_screen_resume(self) -> None:
        """List the programs again: files may have come meanwhile."""
        self.files.look()

    def show_body(self, status: Status) -> None:
        """Show the programs, the chosen one's lines, and what becomes of it."""
        if not self.run.busy:
            self.files.follow()
        run, files = self.run, self.files
        self.query_one(SpaceView).show(Moment(status.joints, status.gripper_mm))
        programs = self.query_one(ChoiceList)
        names = [file_name(each, files.folder) for each in files.paths]
        programs.show_rows(names, files.at if names else None)
        programs.display = bool(files.paths) and not run.busy
        self._show_lines()
        self.text("run").show_lines(self._run_lines(status))
        printed = [printable(each) for each in [*run.printed][-PRINTS_SHOWN:]]
        self.show_panel("printed", "\n".join(printed))

    def _show_lines(self) -> None:
        panel, checked, run = self.query_one(ProgramLines), self.files.checked, self.run
        if checked is None:
            panel.show_program()
            return
        wrong = frozenset({run.failed_in}) if run.failed_in is not None else checked.wrong
        lit = run.line if run.line is not None else min(checked.wrong, default=None)
        if self._top and not run.busy:
            lit = None  # a page key has scrolled away from it
        panel.border_title = printable(checked.path.name)
        panel.show_program(checked.lines, lit, wrong, self._top)

    def _run_lines(self, status: Status) -> Iterator[Span]:
        run, keys, checked = self.run, self.desk.keys, self.files.checked
        if run.busy:
            yield from running_lines(
                run.view, run.asks, keys, paused=status.paused, stepping=run.stepping
            )
            return
        if checked is None:
            folder = self.files.folder
            yield f"no program (.arm) in {folder}: `armdrive jog --program FILE` names one", ""
        elif checked.program is None:
            # without the name of its file in each line; not `spoken`: it quotes lines of the file
            yield keys.presented(checked.error.replace(f"{checked.path}: ", "")), WRONG
        else:
            if run.outcome:
                file, failed = file_name(checked.path, self.files.folder), run.failed
                yield from ended_lines(self.desk.spoken(run.outcome), file, failed=failed)
            found = self.rehearsal.fresh(checked.program, status)
            if self.rehearsal.job.busy:
                yield "REHEARSING: nothing moves", "$text-primary"
            elif found is not None:
                again = self.desk.confirmation.again
                yield from rehearsed_lines(found, keys, again, self.desk.spoken)
            elif not run.outcome:
                yield "checked: no mistakes", "$text-success"
                yield f"{keys.label('program-rehearse')} rehearses it: nothing moves", ""
        if run.stepping:
            yield f"{keys.label('program-stepping')}: STEPPING, waits before each motion", ""

    # -- keys ---------------------------------------------------------------------------------

    def action_choose(self, by: int) -> None:
        """Choose another program."""
        self.run.require_idle()
        self.files.choose(self.files.at + by)

    def action_turn_page(self, by: int) -> None:
        """Scroll the lines of the program."""
        checked = self.files.checked
        last = 0 if checked is None else max(len(checked.lines) - PAGE, 0)
        self._top = min(max(self._top + by * PAGE, 0), last)

    def action_rehearse(self) -> None:
        """Rehearse the chosen program from where the arm stands. Nothing moves."""
        self.run.require_idle()
        program = self.files.require_program()
        self.desk.link.require_standing()
        self.run.forget()
        self.rehearsal.begin(program)

    def action_press_go(self) -> None:
        """Take one press of the two that run the program, or rehearse it first."""
        try:
            rehearsed = self._rehearsed() is not None
        except BadRequest:
            self.desk.confirmation.refuse()  # it may still be held when there is something to run
            raise
        if rehearsed:
            self.desk.confirmation.press("RUNS IT", self._begin, row="program-go")
            return
        self.desk.confirmation.refuse()
        self.action_rehearse()
        self.desk.message = "it is rehearsed first; then pressed twice, this key runs it"

    def _rehearsed(self) -> Rehearsal | None:
        """Return the rehearsal by which the program can run now; None if it has to be rehearsed.

        Raises `BadRequest` where it cannot run.
        """
        self.run.require_idle()
        program, link = self.files.require_program(), self.desk.link
        link.require(Needs.MOTORS)
        link.require_standing()
        if self.rehearsal.job.busy:
            raise BadRequest("it is being rehearsed: wait until that is done")
        found = self.rehearsal.fresh(program, link.status)
        if found is not None and found.refusal is not None:
            raise BadRequest(str(found.refusal))
        return found

    def _begin(self) -> None:
        """Run the program as two presses have confirmed, unless something has changed."""
        found = None
        with contextlib.suppress(BadRequest):
            found = self._rehearsed()
        if found is None or self.files.chosen is None:
            raise BadRequest("the program or the arm has changed: rehearse it, and confirm again")
        self.rehearsal.forget()  # what it found does not hold once the arm has moved
        self.run.begin(self.files.chosen, self.files.require_program(), found)
