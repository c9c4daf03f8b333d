"""Runs pytest in forks of one process that has already imported pytest and the libraries.

Importing them takes longer than most mutants' tests. Of the project nothing is imported before the
fork, so that each run imports the copy's code as it is at that moment.

    python -P pytest_server.py numpy textual.app

Each line of the standard input is a JSON list: a file for the output, then pytest's arguments. The
answer is one line: pytest's exit code, or minus the number of the signal that ended the run.
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import importlib
import json
import os
import signal
import sys
from typing import NoReturn

import pytest
from _pytest.config import default_plugins

RUN_LIMIT_S = 900
"""No run of a few tests takes longer; the tests have a limit of their own, which comes first."""


def main(libraries: list[str]) -> int:
    """Answer requests until there are no more."""
    own = (f"_pytest.{name}" for name in default_plugins)
    for name in (*libraries, *own):
        with contextlib.suppress(ImportError):  # an optional library, or one of another system
            importlib.import_module(name)
    gc.collect()
    gc.freeze()  # no fork searches the libraries for garbage
    for line in sys.stdin:
        output, *arguments = json.loads(line)
        child = os.fork()
        if child == 0:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            redirect(output)
            end(int(pytest.main(arguments)))
        signal.signal(signal.SIGALRM, lambda *_, child=child: os.kill(child, signal.SIGKILL))
        signal.alarm(RUN_LIMIT_S)
        _, status = os.waitpid(child, 0)
        signal.alarm(0)
        sys.stdout.write(f"{os.waitstatus_to_exitcode(status)}\n")
        sys.stdout.flush()
    return 0


def end(code: int) -> NoReturn:
    """End a fork. To take its modules apart, as Python does at its end, costs a tenth of a run."""
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def redirect(output: str) -> None:
    """Read nothing, and write everything into a file."""
    for path, flags, *descriptors in (
        (os.devnull, os.O_RDONLY, 0),
        (output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 1, 2),
    ):
        opened = os.open(path, flags, 0o600)
        for descriptor in descriptors:
            os.dup2(opened, descriptor)
        os.close(opened)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
