"""Runs Python scripts as `python SCRIPT` does, but on the arm that the command names.

`Arm.connect()` without a target connects to that arm; with a target it connects as the script says.
In a rehearsal every arm is a simulated twin, and no port is opened.
"""

from __future__ import annotations

import ast
import contextlib
import itertools
import os
import runpy
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any, Protocol

from armdrive.arm import Arm, override_connections
from armdrive.connect.parts import ConnectOptions
from armdrive.connect.target import FORCE_SIM
from armdrive.errors import BadRequest
from armdrive.errors.printable import printable_lines
from armdrive.moves import GraspMove, MoveSequence
from armdrive.programs.problems import SourceMark
from armdrive.text.reading import read_bytes
from armdrive.trace import recorder as recorded

# The calls that a script makes of its arms, and the line of each. They are seen where the flight
# recorder sees them. A call inside another call, as `park` calls `move_to`, does not count.

# The most frames searched for a line of the script.
DEEPEST = 1000


@dataclass(frozen=True, slots=True)
class ScriptCall:
    """A call of a script. `line` is 0 if another file or another thread made it."""

    name: str
    line: int
    grasps: bool = False
    """Whether the fingers close on an object."""


# The call that closes the gripper on an object.
GRASP = "gripper.grasp"


def _feels(argument: object) -> bool:
    """Return whether an argument of a call is a move that ends with a grasp."""
    last = argument.moves[-1] if isinstance(argument, MoveSequence) else argument
    return isinstance(last, GraspMove)


def _listener(
    arm: Arm, script: str, on_call: Callable[[Arm, ScriptCall], object]
) -> recorded.CallListener:
    """Return what reports those calls of an arm that are the script's own."""

    def begins(name: str, words: tuple[Any, ...], named: dict[str, Any]) -> None:
        line = script_line(sys._getframe(2), script)  # noqa: SLF001 - the noted call's own
        if line is not None:
            grasps = name == GRASP or any(map(_feels, (*words, *named.values())))
            on_call(arm, ScriptCall(name, line, grasps))

    return begins


def script_line(traced: FrameType, script: str) -> int | None:
    """Return the line of the script that made a traced call, 0 if none did.

    Returns None for a call inside another one: then the recorder is on the stack twice.
    """
    line = 0
    for frame, number in itertools.islice(traceback.walk_stack(traced.f_back), DEEPEST):
        if frame.f_code.co_filename == recorded.__file__:
            return None
        if frame.f_code.co_filename == script:
            line = line or number
    return line


# Bytes. A script may contain a table.
LARGEST_SCRIPT = 4_000_000


class ScriptStage(Protocol):
    """Gives a script its arms, and receives a report of each call."""

    def own(self, options: ConnectOptions) -> Arm:
        """Connect to the arm that the command names, with the options of the script's call."""
        ...

    def given(self, target: str, options: ConnectOptions) -> Arm:
        """Connect to an arm that the script names."""
        ...

    def made(self, arm: Arm) -> None:
        """Take note of a new arm."""

    def called(self, arm: Arm, call: ScriptCall) -> None:
        """Take note of a call of the script; may raise to refuse it."""


class Connections:
    """Every arm that a script connects to while it runs."""

    def __init__(self, script: Path, stage: ScriptStage) -> None:
        self.arms: list[Arm] = []
        self._script = str(script)
        self._stage = stage

    def __call__(self, target: str | None, options: ConnectOptions) -> Arm:
        """Connect as `armdrive.arm.ConnectionOverride` says."""
        stage = self._stage
        arm = stage.own(options) if target is None else stage.given(target, options)
        self.arms.append(arm)
        stage.made(arm)
        arm.parts.tracer.on_call = _listener(arm, self._script, stage.called)
        return arm

    def close(self) -> None:
        """Stop and close the arms that the script has left open."""
        with contextlib.ExitStack() as stack:  # each is closed, even if another one raises
            for arm in self.arms:
                if not arm.closed:
                    stack.callback(arm.close)


def read_script(path: Path) -> bytes:
    """Return a script's bytes, read once to see that it is Python. Raises `BadRequest`."""
    source = read_bytes(path, "the script", BadRequest, most_bytes=LARGEST_SCRIPT)
    try:
        ast.parse(source, str(path))
    except (RecursionError, MemoryError):  # Python's parser raises both for this reason
        raise BadRequest(f"{path} is nested too deeply") from None
    except (SyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None)
        where = f"{path}: line {line}" if line else str(path)
        raise BadRequest(f"{where}: {getattr(error, 'msg', error)}") from None
    return source


def carry_out(path: Path, words: Sequence[str], connections: Connections) -> int:
    """Run a script to its end, with `words` as its arguments; return its exit code.

    Raises what the script raises, except `SystemExit`. Closes the arms that it leaves open.
    """
    with _as_main(path, words), override_connections(connections):
        try:
            runpy.run_path(str(path), run_name="__main__")
        except SystemExit as end:
            return _exit_code(end.code)
        finally:
            connections.close()
    return 0


@contextlib.contextmanager
def simulation_only() -> Iterator[None]:
    """Make every connection a simulated one, also in programs that the script starts.

    This is a second safeguard against opening a port.
    """
    before = os.environ.get(FORCE_SIM)
    os.environ[FORCE_SIM] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[FORCE_SIM]
        else:
            os.environ[FORCE_SIM] = before


def place_of(error: BaseException, script: Path) -> SourceMark | None:
    """Return the place in a script that raised an error, None if the error came from elsewhere."""
    for entry in reversed(traceback.extract_tb(error.__traceback__)):
        if entry.filename == str(script):
            return SourceMark(entry.lineno or 0, (entry.colno or 0) + 1, str(script))
    return None


def own_traceback(error: BaseException, script: Path) -> str:
    """Return the traceback of a script's error, beginning with the script's own line."""
    trace = error.__traceback__
    while trace is not None and trace.tb_frame.f_code.co_filename != str(script):
        trace = trace.tb_next
    return "".join(traceback.format_exception(type(error), error, trace or error.__traceback__))


@contextlib.contextmanager
def _as_main(path: Path, words: Sequence[str]) -> Iterator[None]:
    """Set the script's arguments, and let it import from its own folder."""
    arguments, folders = sys.argv, list(sys.path)
    sys.argv = [str(path), *words]
    sys.path.insert(0, str(path.resolve().parent))
    try:
        yield
    finally:
        sys.argv = arguments
        sys.path[:] = folders


def _exit_code(code: object) -> int:
    if code is None or isinstance(code, int):
        return code or 0
    sys.stderr.write(f"{printable_lines(str(code))}\n")
    return 1
