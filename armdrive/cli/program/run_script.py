"""Runs a Python script on the arm that the command names, and shows what it asks of its arms.

A script is rehearsed with --check alone, and not before each run: whatever else it does besides
moving arms would be done twice.
"""

from __future__ import annotations

import argparse
import contextlib
import sys

from armdrive.arm import Arm
from armdrive.cli.presenter import put_error
from armdrive.cli.program.run_common import (
    connect_to_run,
    display_for,
    ended_view,
    failed_view,
    keep_recording,
    show_place,
    slow_down,
    stands_at,
)
from armdrive.cli.program.run_display import Display, line_words
from armdrive.cli.program.run_input import RunTerminal, standard_input, stopped_by_interrupt
from armdrive.connect.parts import ConnectOptions
from armdrive.errors import ArmError, BadRequest, Stopped
from armdrive.programs.problems import SourceMark
from armdrive.programs.scripts import (
    Connections,
    ScriptCall,
    as_it_says,
    carry_out,
    line_of,
    own_traceback,
    read_script,
)
from kinematics.errors import KinematicsError

MOVING = frozenset(
    {
        "run", "start", "move_j", "move_to", "move_l", "move_c", "move_path", "move_motors",
        "move_gripper", "park", "home", "jog_j", "jog_l", "hold", "nudge", "grasp", "feel",
        "verify",
    }
)  # fmt: skip
"""The calls before which --step waits, and which are worth a line."""

NO_RESUME = (
    "a Python script cannot be taken up where it was interrupted: what it knew is gone with it. "
    "Begin it anew, or write it as a program file (.arm)"
)
NO_LOOPS = "--loops is of program files; a Python script has loops of its own"


def run_script(options: argparse.Namespace) -> int:
    """Run or rehearse a script."""
    if options.resume:
        raise BadRequest(NO_RESUME)
    if options.loops is not None:
        raise BadRequest(NO_LOOPS)
    lines = read_script(options.program).decode("utf-8", "replace").splitlines()
    if options.check:
        # all that rehearses: a run for good does without
        from armdrive.cli.program.run_check import check_script

        return check_script(options, lines)
    return _RunningScript(options, lines).run()


class _RunningScript:
    """One run of a script."""

    def __init__(self, options: argparse.Namespace, lines: list[str]) -> None:
        self._options = options
        self._lines = lines
        self._display: Display = display_for(options, lines)
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
        output = contextlib.redirect_stdout(sys.stderr) if self._options.json else None
        with output or contextlib.nullcontext():
            return carry_out(self._options.program, self._options.words, self.connections)

    # -- the script's arms --------------------------------------------------------------------

    def _own(self, wanted: ConnectOptions) -> Arm:
        """Connect to the arm of the command, with what the script says of the connection."""
        arm = connect_to_run(self._options, pace=wanted.simulated_pace)
        arm.core.allow_restored |= wanted.allow_restored
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
            RunTerminal(arm, self._display, self._keys).hold(text, lambda: arm.stops != stops)
            if arm.stops != stops:
                raise Stopped("the script was stopped")
        self._display.at(arm, self._last, call.name, loud=moves)

    # -- the end ------------------------------------------------------------------------------

    def _ended(self, code: int) -> None:
        arms = self.connections.arms
        stands = "".join(f"; {arm.config.name}: {stands_at(arm)}" for arm in arms)
        arm = arms[-1] if arms else None
        event = {**ended_view(arm, self._calls, self._took_s()), "code": code}
        self._display.tell(event, f"done: {self._calls} calls{stands}")

    def _took_s(self) -> float:
        return max((arm.pace.now_s() for arm in self.connections.arms), default=0.0)

    def _failed(self, error: BaseException) -> None:
        line = line_of(error, self._options.program)
        known = self._last if self._last is not None and self._last.line else None
        mark = known if line is None else SourceMark(line, 1, str(self._options.program))
        if self._options.json:
            self._display.tell(failed_view(mark, error, ""), "")
            return
        stands = "".join(f"; {arm.config.name}: {stands_at(arm)}" for arm in self.connections.arms)
        self._display.tell({}, f"ended early: {self._calls} calls{stands}")
        if isinstance(error, ArmError | KinematicsError):
            show_place(mark, self._lines, error)
