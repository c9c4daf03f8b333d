"""Run a program, or only check it: a program file (.arm) or a Python script (.py).

A script runs on the arm that the command names, and what it asks of its arms is shown. It is not
rehearsed before a run: whatever else it does besides moving arms would be done twice. A check of a
script is a run on simulated arms.
"""

from __future__ import annotations

import argparse
import contextlib
from pathlib import Path

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.presenter import as_json, put_error, tell
from armdrive.cli.program.arguments import SCRIPT
from armdrive.cli.program.run_arm import (
    connect_to_run,
    keep_recording,
    put_blocks,
    require_recordable,
    slow_down,
    stands_at,
)
from armdrive.cli.program.run_output import Display, script_words
from armdrive.cli.program.run_person import RunTerminal, standard_input, stopped_by_interrupt
from armdrive.connect.parts import ConnectOptions, connect
from armdrive.connect.target import find
from armdrive.errors import ArmError, BadRequest, Stopped
from armdrive.programs.acts import RunStep
from armdrive.programs.language import ENDING
from armdrive.programs.problems import SourceLines, SourceMark, numbered_lines
from armdrive.programs.progress import duration, line_words
from armdrive.programs.scripts import (
    carry_out,
    own_traceback,
    place_of,
    read_script,
    simulation_only,
)
from armdrive.render.sketch import check_output
from armdrive.storage.files import require_free
from kinematics.errors import KinematicsError
from kinematics.text import counted

# The calls before which --step waits, and which are worth a line.
MOVING = frozenset(
    {
        "run", "start", "move_j", "move_to", "move_l", "move_c", "move_path", "move_motors",
        "park", "home", "jog_j", "jog_l", "jogging.hold", "jogging.nudge",
        "gripper.open", "gripper.close", "gripper.grasp", "reference.verify",
    }
)  # fmt: skip

# The call that waits for inputs, and says so.
WAITING = "io.wait"

FOR_PROGRAM_FILES = (
    "{} is for program files (.arm): a Python script is not rehearsed, has loops of its own, and "
    "begins anew"
)


def run_script(options: argparse.Namespace) -> int:
    """Run a script, or check it: a run on simulated arms."""
    for name in ("resume", "loops", "input", "assume_width", "plot"):
        if getattr(options, name) not in (None, False, []):
            raise BadRequest(FOR_PROGRAM_FILES.format(f"--{name.replace('_', '-')}"))
    text = read_script(options.program).decode("utf-8", "replace")
    lines = numbered_lines(text.splitlines(), str(options.program))
    with simulation_only() if options.check else contextlib.nullcontext():
        return _RunningScript(options, lines).run()


class _RunningScript:
    """One run of a script. `arms` are those that it has connected to."""

    def __init__(self, options: argparse.Namespace, lines: SourceLines) -> None:
        self.arms: list[Arm] = []
        self._options = options
        self._display = Display(lines, as_json=as_json(options))
        self._keys = standard_input()
        self._calls = 0
        self._last: SourceMark | None = None

    def run(self) -> int:
        """Run it to its end, and say how it ended."""
        options, program = self._options, self._options.program
        stopped = stopped_by_interrupt(lambda: list(self.arms), as_json=as_json(options))
        with self._display.shown() as display, stopped:
            display.tell({"event": "begin", "program": str(program)}, str(program))
            try:
                with script_words(options):
                    code = carry_out(program, options.words, self._connect, self._called, self.arms)
            except BaseException as error:
                mark = place_of(error, program) or self._last
                display.failed(mark, error, f"ended early: {counted(self._calls, 'call')}")
                refused = isinstance(error, ArmError | KinematicsError)
                if refused or not isinstance(error, Exception):  # such as a signal that ends it
                    raise
                put_error(own_traceback(error, program))
                return 1
            took_s = max((arm.parts.pace.now_s() for arm in self.arms), default=0.0)
            stands = "".join(f"; {arm.config.name}: {stands_at(arm)}" for arm in self.arms)
            text = f"{counted(self._calls, 'call')} in {duration(took_s)}{stands}"
            arm = self.arms[-1] if self.arms else None
            display.finished(arm, self._calls, took_s, text, code=code)
            return code

    def _connect(self, target: str | None, options: ConnectOptions) -> Arm:
        """Connect to the arm that the script names, or to that of the command."""
        if self._options.check and options.twin is None:
            arm = self._simulated(target, options)
        elif target is None:
            arm = connect_to_run(self._options, pace=options.simulated_pace)
            arm.parts.core.allow_restored |= options.allow_restored
        else:
            arm = Arm(connect(target, options))
            slow_down(arm, self._options)
        if target is None and options.operator is not None:
            arm.operator = options.operator
        self._display.run.use(arm)
        arm.parts.connection.closers.append(lambda: keep_recording(arm, self._options))
        return arm

    def _simulated(self, target: str | None, options: ConnectOptions) -> Arm:
        """Return a new simulated arm, which stands in its reference posture."""
        # loads the simulation and the parser of programs, which a real run does not need
        from armdrive.programs.rehearsal import SeenArm, rehearsing_arm

        found = chosen_target(self._options)
        if target is not None:
            found = find(target, dialect_name=options.dialect, baud=options.baud)
        real = isinstance(options.pace, str | int | float)
        clock = options.clock if real else options.simulated_pace
        arm = rehearsing_arm(SeenArm.unasked(found), lambda _: None, clock)
        put_blocks(arm, self._options.put)
        slow_down(arm, self._options)
        tell(self._options, f"{arm.status.which}, in its reference posture")
        return arm

    def _called(self, arm: Arm, name: str, line: int) -> None:
        """Show a call, and wait for the person before a motion if that is wanted."""
        self._calls += 1
        mark = SourceMark(line, 1, str(self._options.program))
        self._last = mark if line else None
        waiting = "waiting for inputs" if name == WAITING else ""
        step = RunStep(arm, mark, name, moves=name in MOVING, waiting=waiting)
        if self._options.step and step.moves:
            stops = arm.stops
            text = line_words(line, self._display.run.line_at(mark) or name)
            RunTerminal(arm, self._display, self._keys.keys).hold(text, lambda: arm.stops != stops)
            if arm.stops != stops:
                raise Stopped("the script was stopped")
        self._display.begins(step)


# The command, for both kinds of programs.


def run(options: argparse.Namespace) -> int:
    """Run or rehearse the program."""
    if options.record is not None:
        require_recordable(options.record, overwrite=options.force)
    ending = options.program.suffix.lower()
    if ending == ENDING:
        if options.words:
            raise BadRequest(f"a program file takes no arguments: {' '.join(options.words)}")
        if options.plot is not None:
            options.check = True
            _check_plot(options)
        # the language's parser takes as long to import as all that a script needs
        from armdrive.cli.program.run_program import run_program

        return run_program(options)
    if ending == SCRIPT:
        return run_script(options)
    raise BadRequest(
        f"{options.program} is not a program: its name must end in {ENDING} or {SCRIPT}"
    )


def _check_plot(options: argparse.Namespace) -> None:
    if options.plot:
        check_output(Path(options.plot))
        require_free(Path(options.plot), overwrite=options.force)
