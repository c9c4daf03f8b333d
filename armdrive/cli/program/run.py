"""Run a program, or rehearse it: a program file (.arm) or a Python script (.py).

A script runs on the arm that the command names, and what it asks of its arms is shown. It is
rehearsed with --check alone, and not before each run: whatever else it does besides
moving arms would be done twice.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from pathlib import Path

from armdrive.arm import Arm
from armdrive.cli.presenter import as_json, put_error
from armdrive.cli.program.arguments import PROGRAM, SCRIPT
from armdrive.cli.program.run_common import (
    RunTerminal,
    connect_to_run,
    ended_view,
    keep_recording,
    show_place,
    slow_down,
    standard_input,
    stands_at,
    stopped_by_interrupt,
    tell_failure,
)
from armdrive.cli.program.run_output import Display, RunOutput
from armdrive.connect.parts import ConnectOptions
from armdrive.errors import ArmError, BadRequest, Stopped
from armdrive.programs.arm_access import accept_restored, time_s
from armdrive.programs.problems import SourceMark
from armdrive.programs.run_view import line_words
from armdrive.programs.scripts import (
    Connections,
    ScriptCall,
    as_it_says,
    carry_out,
    line_of,
    own_traceback,
    read_script,
)
from armdrive.render.sketch import check_output
from kinematics.errors import KinematicsError

MOVING = frozenset(
    {
        "run", "start", "move_j", "move_to", "move_l", "move_c", "move_path", "move_motors",
        "move_gripper", "park", "home", "jog_j", "jog_l", "hold", "nudge", "grasp", "feel",
        "verify",
    }
)  # fmt: skip
"""The calls before which --step waits, and which are worth a line."""

WAITING = "wait_inputs"
"""The call that waits for inputs, and says so."""

NO_RESUME = (
    "a Python script cannot be resumed: its variables are gone. Start it again, or write it as a "
    "program file (.arm)"
)
NO_LOOPS = "--loops is for program files; a Python script has loops of its own"


def run_script(options: argparse.Namespace) -> int:
    """Run or rehearse a script."""
    if options.resume:
        raise BadRequest(NO_RESUME)
    if options.loops is not None:
        raise BadRequest(NO_LOOPS)
    lines = read_script(options.program).decode("utf-8", "replace").splitlines()
    if options.check:
        # all that rehearses: a run for good does without
        from armdrive.cli.program.run_report import check_script

        return check_script(options, lines)
    return _RunningScript(options, lines).run()


class _RunningScript:
    """One run of a script."""

    def __init__(self, options: argparse.Namespace, lines: list[str]) -> None:
        self._options = options
        self._lines = lines
        self._display = Display(lines, RunOutput(as_json=as_json(options)))
        self._keys = standard_input()
        self._calls = 0
        self._last: SourceMark | None = None
        self.connections = Connections(
            options.program, self._own, self._told, self._made, as_it_says
        )

    def run(self) -> int:
        """Run it to its end, and say how it ended."""
        with self._display as display, stopped_by_interrupt(lambda: list(self.connections.arms)):
            event = {"event": "begin", "program": str(self._options.program)}
            display.tell(event, str(self._options.program))
            try:
                code = self._carry_out()
            except (ArmError, KinematicsError, KeyboardInterrupt) as error:
                self._failed(error)
                raise
            except Exception as error:  # the script's own
                self._failed(error)
                put_error(own_traceback(error, self._options.program))
                return 1
            self._ended(code)
            return code

    def _carry_out(self) -> int:
        # what a script prints is no JSON: it goes where the words for people go
        output = contextlib.redirect_stdout(sys.stderr) if as_json(self._options) else None
        with output or contextlib.nullcontext():
            return carry_out(self._options.program, self._options.words, self.connections)

    # -- the script's arms --------------------------------------------------------------------

    def _own(self, wanted: ConnectOptions) -> Arm:
        """Connect to the arm of the command, with what the script says of the connection."""
        arm = connect_to_run(self._options, pace=wanted.simulated_pace)
        if wanted.allow_restored:
            accept_restored(arm)
        if wanted.operator is not None:
            arm.operator = wanted.operator
        return arm

    def _made(self, arm: Arm) -> None:
        slow_down(arm, self._options)
        self._display.use(arm)
        arm.connection.on_close(lambda: keep_recording(arm, self._options))

    def _told(self, arm: Arm, call: ScriptCall) -> None:
        """Show a call, and wait for the person before a motion where that is wanted."""
        self._calls += 1
        self._last = SourceMark(call.line, 1, str(self._options.program))
        moves = call.name in MOVING
        if self._options.step and moves:
            stops = arm.stops
            text = line_words(call.line, self._display.source(call.line) or call.name)
            RunTerminal(arm, self._display, self._keys.keys).hold(text, lambda: arm.stops != stops)
            if arm.stops != stops:
                raise Stopped("the script was stopped")
        waiting = "waiting for inputs" if call.name == WAITING else ""
        self._display.at(arm, self._last, call.name, loud=moves, waiting=waiting)

    # -- the end ------------------------------------------------------------------------------

    def _ended(self, code: int) -> None:
        arms = self.connections.arms
        arm, took_s = arms[-1] if arms else None, max(map(time_s, arms), default=0.0)
        event = {**ended_view(arm, self._calls, took_s), "code": code}
        self._display.tell(event, f"done: {self._how_far()}")

    def _failed(self, error: BaseException) -> None:
        line = line_of(error, self._options.program)
        known = self._last if self._last is not None and self._last.line else None
        mark = known if line is None else SourceMark(line, 1, str(self._options.program))
        tell_failure(self._display, mark, error, self._how_far())
        if isinstance(error, ArmError | KinematicsError) and not as_json(self._options):
            show_place(mark, self._lines, error)

    def _how_far(self) -> str:
        stands = (f"; {arm.config.name}: {stands_at(arm)}" for arm in self.connections.arms)
        return f"{self._calls} calls{''.join(stands)}"


# The command, for both kinds of programs.


def run(options: argparse.Namespace) -> int:
    """Run or rehearse the program."""
    if options.plot is not None:
        options.check = True
        _check_plot(options.plot)
    ending = options.program.suffix.lower()
    if ending == PROGRAM:
        if options.words:
            raise BadRequest(f"a program file takes no arguments: {' '.join(options.words)}")
        # the language's parser takes as long to import as all that a script needs
        from armdrive.cli.program.run_program import run_program

        return run_program(options)
    if ending == SCRIPT:
        return run_script(options)
    raise BadRequest(f"{options.program} is no program: one ends in {PROGRAM} or {SCRIPT}")


def _check_plot(output: str) -> None:
    if output:
        check_output(Path(output))
