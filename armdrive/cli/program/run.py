"""Run a program, or rehearse it: a program file (.arm) or a Python script (.py).

A script runs on the arm that the command names, and what it asks of its arms is shown. It is
rehearsed with --check alone, and not before each run: whatever else it does besides
moving arms would be done twice.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from armdrive.arm import Arm
from armdrive.cli.presenter import as_json, put_error
from armdrive.cli.program.arguments import SCRIPT
from armdrive.cli.program.run_arm import (
    connect_to_run,
    keep_recording,
    require_recordable,
    slow_down,
    stands_at,
)
from armdrive.cli.program.run_output import Display, RunOutput, script_words
from armdrive.cli.program.run_person import RunTerminal, standard_input, stopped_by_interrupt
from armdrive.connect.parts import ConnectOptions, connect
from armdrive.errors import ArmError, BadRequest, Stopped
from armdrive.programs.acts import RunStep
from armdrive.programs.language import ENDING
from armdrive.programs.problems import SourceLines, SourceMark, numbered_lines
from armdrive.programs.progress import line_words
from armdrive.programs.scripts import (
    Connections,
    ScriptCall,
    carry_out,
    own_traceback,
    place_of,
    read_script,
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

NO_RESUME = (
    "a Python script cannot be resumed: its variables are gone. Start it again, or write it as a "
    "program file (.arm)"
)
NO_LOOPS = "--loops is for program files; a Python script has loops of its own"
NOT_REHEARSED = "--input and --assume-width are for a rehearsal: add --check"


def run_script(options: argparse.Namespace) -> int:
    """Run or rehearse a script."""
    if options.resume:
        raise BadRequest(NO_RESUME)
    if options.loops is not None:
        raise BadRequest(NO_LOOPS)
    if not options.check and (options.input or options.assume_width is not None):
        raise BadRequest(NOT_REHEARSED)
    text = read_script(options.program).decode("utf-8", "replace")
    lines = numbered_lines(text.splitlines(), str(options.program))
    if options.check:
        # loads the simulation and the parser of programs, which a real run does not need
        from armdrive.cli.program.run_program import check_script

        return check_script(options, lines)
    return _RunningScript(options, lines).run()


class _RunningScript:
    """One run of a script, and the stage for its arms."""

    def __init__(self, options: argparse.Namespace, lines: SourceLines) -> None:
        self._options = options
        self._display = Display(RunOutput(as_json=as_json(options)), lines)
        self._keys = standard_input()
        self._calls = 0
        self._last: SourceMark | None = None
        self._connections = Connections(options.program, self)

    def run(self) -> int:
        """Run it to its end, and say how it ended."""
        program, arms = self._options.program, self._connections.arms
        stopped = stopped_by_interrupt(lambda: list(arms), as_json=as_json(self._options))
        with self._display.shown() as display, stopped:
            display.tell({"event": "begin", "program": str(program)}, str(program))
            try:
                code = self._carry_out()
            except BaseException as error:
                mark = place_of(error, program) or self._last
                display.failed(mark, error, f"ended early: {self._how_far()}")
                refused = isinstance(error, ArmError | KinematicsError)
                if refused or not isinstance(error, Exception):  # such as a signal that ends it
                    raise
                put_error(own_traceback(error, program))
                return 1
            took_s = max((arm.parts.pace.now_s() for arm in arms), default=0.0)
            arm = arms[-1] if arms else None
            display.finished(arm, self._calls, took_s, self._how_far(), code=code)
            return code

    def _carry_out(self) -> int:
        with script_words(self._options):
            return carry_out(self._options.program, self._options.words, self._connections)

    def _how_far(self) -> str:
        arms = self._connections.arms
        stands = (f"; {arm.config.name}: {stands_at(arm)}" for arm in arms)
        return f"{counted(self._calls, 'call')}{''.join(stands)}"

    # -- the script's arms --------------------------------------------------------------------

    def own(self, options: ConnectOptions) -> Arm:
        """Connect to the arm of the command, with the script's options of the connection."""
        arm = connect_to_run(self._options, pace=options.simulated_pace)
        if options.allow_restored:
            arm.parts.core.allow_restored = True
        if options.operator is not None:
            arm.operator = options.operator
        return arm

    def given(self, target: str, options: ConnectOptions) -> Arm:
        """Connect as the script says, and slow that arm down too as the person asked."""
        arm = Arm(connect(target, options))
        slow_down(arm, self._options)
        return arm

    def made(self, arm: Arm) -> None:
        """Show where the script is to those who ask this arm, and keep its recording."""
        self._display.run.use(arm)
        arm.parts.connection.closers.append(lambda: keep_recording(arm, self._options))

    def called(self, arm: Arm, call: ScriptCall) -> None:
        """Show a call, and wait for the person before a motion if that is wanted."""
        self._calls += 1
        mark = SourceMark(call.line, 1, str(self._options.program))
        self._last = mark if call.line else None
        waiting = "waiting for inputs" if call.name == WAITING else ""
        step = RunStep(arm, mark, call.name, moves=call.name in MOVING, waiting=waiting)
        if self._options.step and step.moves:
            stops = arm.stops
            text = line_words(call.line, self._display.run.line_at(mark) or call.name)
            RunTerminal(arm, self._display, self._keys.keys).hold(text, lambda: arm.stops != stops)
            if arm.stops != stops:
                raise Stopped("the script was stopped")
        self._display.begins(step)


# The command, for both kinds of programs.


def run(options: argparse.Namespace) -> int:
    """Run or rehearse the program."""
    if options.plot is not None:
        options.check = True
        _check_plot(options)
    if options.record is not None:
        require_recordable(options.record, overwrite=options.force)
    ending = options.program.suffix.lower()
    if ending == ENDING:
        if options.words:
            raise BadRequest(f"a program file takes no arguments: {' '.join(options.words)}")
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
