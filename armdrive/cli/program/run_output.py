"""What a run prints: results as they come, and where the program is.

On a terminal one line is rewritten in place; elsewhere each motion and each wait is a line; with
`--json` each event is a document. Other programs see the same view (`armdrive status`, `watch`).

Two threads print: that of the program, at each act and each text, and one that looks five times a
second for a pause, a resume and the time that is left. The lock of `Display` keeps one from
writing into a line of the other.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shutil
import sys
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Self

from armdrive.arm import Arm
from armdrive.cli.presenter import (
    ERROR_LABEL,
    as_json,
    complain,
    fit,
    put,
    put_error,
)
from armdrive.errors import ArmError, Stopped
from armdrive.errors.actions import COMMAND_LINE, Words, presented
from armdrive.errors.printable import printable
from armdrive.errors.table import error_view, tagged
from armdrive.moves import GraspMove
from armdrive.programs.acts import Answer, RunStep
from armdrive.programs.problems import SourceLines, SourceMark, excerpt
from armdrive.programs.progress import RunView, place_words
from armdrive.programs.scripts import own_traceback, place_of
from armdrive.status import pose_view
from kinematics.errors import KinematicsError
from kinematics.text import mm_text

CLEAR_LINE = "\r\x1b[K"
STANDARD_OUTPUT = 1  # the file number: Python flushes its stream once more as it ends


REDRAW_S = 0.2  # a pause is seen at once, and a terminal over a slow line is not flooded
# Acts and calls that may ask the person something, in small letters.
ASKING = ("home",)


class Display:
    """Shows one run. `lines` are the program's, of which the present one is shown.

    `words` are those of the interface: the command line's or the shell's. `rewrites` says whether
    there is a status line, by default on a terminal. At a `prompt` the person has just typed the
    lines, so a motion is not worth a line of its own. Every method may be called from any thread.
    """

    def __init__(
        self,
        lines: SourceLines,
        *,
        as_json: bool,
        rewrites: bool | None = None,
        words: Words = COMMAND_LINE,
        prompt: bool = False,
    ) -> None:
        self.lines = lines
        self.run = RunView(lines)
        self._stdout = sys.stdout  # kept, because the prints of a script may be redirected
        self._as_json = as_json
        terminal = self._stdout.isatty() if rewrites is None else rewrites
        self._rewrites = terminal and not as_json
        self._words = words
        self._prompt = prompt
        self._drawn = False
        self._paused = False
        self._lock = threading.RLock()
        self._over = threading.Event()

    @contextlib.contextmanager
    def shown(self) -> Iterator[Self]:
        """Keep the status line up to date until the run is over."""
        thread = threading.Thread(target=self._look, name="progress", daemon=True)
        thread.start()
        try:
            yield self
        finally:
            self._over.set()
            thread.join()
            self._put("", wipes=True)

    def tell(self, event: Mapping[str, Any] | None, text: str) -> None:
        """Show an event: a document for programs, lines for people.

        Raises `Stopped` if the output was closed.
        """
        if not self._as_json:
            self._put(f"{text}\n" if text else "", wipes=True)
        elif event is not None:
            self._put(f"{json.dumps(dict(event))}\n")

    def _put(self, text: str, *, wipes: bool = False, draws: bool = False) -> None:
        """Print lines, or draw the status line over the one that was drawn before."""
        with self._lock:
            control = CLEAR_LINE if draws or (wipes and self._drawn) else ""
            self._drawn = draws
            if not (text or control):
                return
            shown = presented(text, self._words)
            if not (draws or self._as_json):
                shown = fit(shown, self._stdout)
            try:
                put(shown, control=control, output=self._stdout)
            except BrokenPipeError:  # a program whose reader has gone must not seem to end well
                os.dup2(os.open(os.devnull, os.O_WRONLY), STANDARD_OUTPUT)
                words = "the program was ended: its output was closed"
                raise Stopped(words) from None

    # -- what happens -------------------------------------------------------------------------

    def begins(self, step: RunStep, _: object = None) -> None:
        """Show a step, on a line of its own if it moves the arm or waits."""
        with self._lock:
            self.run.at(step)
            view = self.run.view()
            if self._as_json:
                self.tell({"event": "act", **view}, "")
                if step.waiting:
                    self.tell({"event": "wait", **view}, "")
            elif self._draws:
                self._draw(view)
            elif step.waiting and self._prompt:
                self.tell(None, step.waiting)
            elif step.waiting or (step.moves and not self._prompt):
                self.tell(None, place_words(view))

    def ended(self, step: RunStep, answer: Answer, took_s: float) -> None:
        """Tell programs the answer to an act; at a prompt, tell people what a grasp found."""
        if self._as_json:
            brought = answer if isinstance(answer, bool | float | int) else None
            took = {"answer": brought, "took_s": round(took_s, 3)}
            self.tell({"event": "done", **step.view(), **took}, "")
        elif self._prompt and isinstance(step.move, GraspMove) and isinstance(answer, float):
            self.say(f"grasped: {mm_text(answer)} wide" if answer else "grasped nothing")

    def finished(self, arm: Arm | None, count: int, took_s: float, text: str, **more: int) -> None:
        """Show the end of a run that went well."""
        pose = None if arm is None else pose_view(arm.status.pose)
        event = {"event": "end", "acts": count, "took_s": round(took_s, 3), "pose": pose}
        self.tell({**event, **more}, f"done: {text}")

    def failed(
        self, mark: SourceMark | None, error: BaseException, text: str, resume: str = ""
    ) -> None:
        """Show where and why a run ended early, and the command that resumes it."""
        event = {
            "event": "failed",
            "line": None if mark is None else mark.line,
            "column": None if mark is None else mark.column,
            "error": error_view(error),
            "resume": resume or None,
        }
        self.tell(event, text)
        if not self._as_json:
            show_place(mark, self.lines, error)
        if resume and not self._as_json:
            put_error(f"to continue from there: {resume}\n")

    def say(self, text: str) -> None:
        """Show what the program says."""
        if self._as_json:
            self.tell({"event": "say", "text": text}, "")
        else:
            self._put(f"{text}\n", wipes=True)

    @contextlib.contextmanager
    def paused(self, arm: Arm) -> Iterator[None]:
        """Pause an arm for a wait whose own words say so, and tell at its end that it goes on."""
        with self._lock:
            arm.pause()
            self._paused = True
        yield
        with self._lock:
            self._look_once()

    def waits(self, text: str, *, enter: bool = True) -> None:
        """Show that the program waits for a person, and how that person answers."""
        words = f"{text}: " * bool(text)
        how = "press Enter or run `armdrive resume`" if enter else "run `armdrive resume`"
        self.tell({"event": "hold", "text": text}, f"{words}{how} to continue")

    @property
    def _draws(self) -> bool:
        """Whether the status line may be rewritten now: not over a question."""
        asks = self.run.step is not None and self.run.step.name.lower() in ASKING
        return self._rewrites and not asks

    def _look(self) -> None:
        """Show what changes between two acts, until the output is closed."""
        with contextlib.suppress(OSError, Stopped):
            while not self._over.wait(REDRAW_S):
                with self._lock:
                    self._look_once()

    def _look_once(self) -> None:
        if self.run.step is None:
            return
        arm = self.run.step.arm
        if arm.status.paused is not self._paused:
            self._paused = not self._paused
            word = "paused" if self._paused else "going on"
            self.tell({"event": word.replace(" ", "-"), **self.run.view()}, word)
        if self._draws:
            self._draw(self.run.view())

    def _draw(self, view: Mapping[str, Any]) -> None:
        step = self.run.step
        slowed = step is not None and step.arm.speed_override < 1.0
        words = place_words(view) + "  slowed" * slowed + "  PAUSED" * self._paused
        self._put(printable(words)[: shutil.get_terminal_size().columns - 1], draws=True)


def show_place(mark: SourceMark | None, lines: SourceLines, error: BaseException) -> None:
    """Show people a line with a caret under the place, unless the error itself does so."""
    if mark is not None and getattr(error, "mark", None) is None:
        line = lines.get((mark.file, mark.line))
        put_error(f"{mark}\n" if line is None else f"{mark}\n{excerpt(line, mark.column)}\n")


# What a script says besides its calls.


@contextlib.contextmanager
def script_words(options: argparse.Namespace) -> Iterator[None]:
    """Keep what a script prints apart from JSON, and show the errors of its threads as its own."""
    # what a script prints is no JSON: it goes where the words for people go
    prints = contextlib.redirect_stdout(sys.stderr) if as_json(options) else None
    before = threading.excepthook
    threading.excepthook = lambda found: _thread_failed(options.program, found.exc_value)
    try:
        with prints or contextlib.nullcontext():
            yield
    finally:
        threading.excepthook = before


def _thread_failed(script: Path, error: BaseException | None) -> None:
    """Show what ended a thread of a script: the rest of the script goes on, as in Python."""
    if isinstance(error, ArmError | KinematicsError):
        mark = place_of(error, script)
        where = "" if mark is None else f"{mark}: "
        complain(f"{ERROR_LABEL} {where}{tagged(error)}")
    elif error is not None and not isinstance(error, SystemExit):
        put_error(own_traceback(error, script))
