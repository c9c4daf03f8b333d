"""Runs pytest in forks of one process that has already imported pytest and other modules.

Importing them takes longer than most mutants' tests.

    python -P pytest_server.py numpy textual.app kinematics.frames

Each line of the standard input is a JSON list: a file for the output, a package that has changed
since it was imported (or nothing), then pytest's arguments. The run imports that package again. So
no module that stays may have imported it. The answer is one line: pytest's exit code, or minus the
number of the signal that ended the run.
"""

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


def main(modules: list[str]) -> int:
    """Answer requests until there are no more."""
    own = (f"_pytest.{name}" for name in default_plugins)
    for name in (*modules, *own):
        with contextlib.suppress(ImportError):  # an optional library, or one of another system
            importlib.import_module(name)
    gc.collect()
    gc.freeze()  # no fork searches the modules for garbage
    for line in sys.stdin:
        output, changed, *arguments = json.loads(line)
        child = os.fork()
        if child == 0:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            redirect(output)
            forget(changed)
            end(int(pytest.main(arguments)))
        signal.signal(signal.SIGALRM, lambda *_, child=child: os.kill(child, signal.SIGKILL))
        signal.alarm(RUN_LIMIT_S)
        _, status = os.waitpid(child, 0)
        signal.alarm(0)
        sys.stdout.write(f"{os.waitstatus_to_exitcode(status)}\n")
        sys.stdout.flush()
    return 0


def forget(package: str) -> None:
    """Have a package imported again."""
    for name in [*sys.modules]:
        if name.partition(".")[0] == package:
            del sys.modules[name]


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
