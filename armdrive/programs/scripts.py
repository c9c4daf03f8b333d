"""Runs Python scripts as `python SCRIPT` does, but on the arm that the command names.

`Arm.connect()` without a target connects to that arm; with a target it connects as the script says.
In a check every arm is simulated, and no port is opened.
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
from pathlib import Path
from types import FrameType
from typing import Any

from armdrive.arm import Arm, override_connections
from armdrive.connect.parts import ConnectOptions
from armdrive.connect.target import FORCE_SIM
from armdrive.errors import BadRequest
from armdrive.errors.printable import printable_lines
from armdrive.programs.problems import SourceMark
from armdrive.text.reading import read_bytes
from armdrive.trace import recorder as recorded

# The calls that a script makes of its arms, and the line of each. They are seen where the flight
# recorder sees them. A call inside another call, as `park` calls `move_to`, does not count.

# The most frames searched for a line of the script.
DEEPEST = 1000


def _listener(
    arm: Arm, script: str, called: Callable[[Arm, str, int], object]
) -> recorded.CallListener:
    """Return what reports those calls of an arm that are the script's own."""

    def begins(name: str, _: tuple[Any, ...], __: dict[str, Any]) -> None:
        line = script_line(sys._getframe(), script)  # noqa: SLF001 - who has called it
        if line is not None:
            called(arm, name, line)

    return begins


def script_line(listener: FrameType, script: str) -> int | None:
    """Return the line of the script that made a recorded call, 0 if none did.

    Returns None for a call inside another one: then the recorder has wrapped two calls.
    """
    line, calls = 0, 0
    for frame, number in itertools.islice(traceback.walk_stack(listener), DEEPEST):
        code = frame.f_code
        calls += code.co_filename == recorded.__file__ and code.co_name in recorded.WRAPPERS
        if calls > 1:
            return None
        if code.co_filename == script:
            line = line or number
    return line


# Bytes. A script may contain a table.
LARGEST_SCRIPT = 4_000_000


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


def carry_out(
    path: Path,
    words: Sequence[str],
    connect: Callable[[str | None, ConnectOptions], Arm],
    called: Callable[[Arm, str, int], object],
    arms: list[Arm],
) -> int:
    """Run a script to its end, with `words` as its arguments; return its exit code.

    `connect` makes its connections, which are added to `arms`. `called` is told the name of each
    call of an arm and its line, 0 if another file or thread made it, and may raise to refuse it.
    Raises what the script raises, except `SystemExit`. Closes the arms that it leaves open.
    """

    def connected(target: str | None, options: ConnectOptions) -> Arm:
        arm = connect(target, options)
        arms.append(arm)
        arm.parts.tracer.on_call = _listener(arm, str(path), called)
        return arm

    with contextlib.ExitStack() as closing, _as_main(path, words), override_connections(connected):
        closing.callback(_close, arms)
        try:
            runpy.run_path(str(path), run_name="__main__")
        except SystemExit as end:
            return _exit_code(end.code)
    return 0


def _close(arms: list[Arm]) -> None:
    with contextlib.ExitStack() as stack:  # each is closed, even if another one raises
        for arm in arms:
            if not arm.closed:
                stack.callback(arm.close)


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
