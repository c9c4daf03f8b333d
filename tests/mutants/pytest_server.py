"""Runs pytest in forks of one process that has already imported pytest and other modules.

Importing them takes longer than most mutants' tests.

    python -P pytest_server.py numpy textual.app kinematics.frames

Each line of the standard input is a JSON list: a file for the output, a module that has changed
since it was imported (or nothing), then pytest's arguments. The run imports that module again, and
every one that has imported it. The answer is one line: pytest's exit code, or minus the number of
the signal that ended the run.
"""

import atexit
import builtins
import contextlib
import gc
import importlib
import json
import os
import signal
import sys
from collections import defaultdict
from importlib.util import resolve_name
from typing import NoReturn

import pytest
from _pytest.config import default_plugins

RUN_LIMIT_S = 900
"""No run of a few tests takes longer; the tests have a limit of their own, which comes first."""


def main(modules: list[str]) -> int:
    """Answer requests until there are no more."""
    own = (f"_pytest.{name}" for name in default_plugins)
    importers = import_all([*own, *modules])
    gc.collect()
    gc.freeze()  # no fork searches the modules for garbage
    for line in sys.stdin:
        output, changed, *arguments = json.loads(line)
        child = os.fork()
        if child == 0:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            redirect(output)
            forget(changed, importers)
            end(int(pytest.main(arguments)))
        signal.signal(signal.SIGALRM, lambda *_, child=child: os.kill(child, signal.SIGKILL))
        signal.alarm(RUN_LIMIT_S)
        _, status = os.waitpid(child, 0)
        signal.alarm(0)
        sys.stdout.write(f"{os.waitstatus_to_exitcode(status)}\n")
        sys.stdout.flush()
    return 0


def import_all(names: list[str]) -> dict[str, set[str]]:
    """Import modules; return which modules have imported each one while they were imported."""
    importers = defaultdict(set)
    original = builtins.__import__

    def recorded(name, *how, **options):
        if len(how) == 4:  # as a statement imports
            scope, _, parts, level = how
            module = resolve_name("." * level + name, scope.get("__package__"))
            frame = sys._getframe(1)
            while frame and frame.f_code.co_name != "<module>":  # a module may call another's code
                frame = frame.f_back
            for each in (module, *(f"{module}.{part}" for part in parts or ())):
                importers[each].add(frame.f_globals["__name__"] if frame else "")
        return original(name, *how, **options)

    builtins.__import__ = recorded
    for name in names:
        with contextlib.suppress(ImportError):  # an optional library, or one of another system
            importlib.import_module(name)
    builtins.__import__ = original
    return importers


def forget(changed: str, importers: dict[str, set[str]]) -> None:
    """Have a module imported again, and all that have imported it, directly or by way of others.

    Each module in a package has imported the package.
    """
    rest, forgotten = {changed}, set()
    while rest:
        name = rest.pop()
        if name in sys.modules:
            forgotten.add(name)
            del sys.modules[name]
            rest |= importers.get(name, set())
            rest |= {each for each in sys.modules if each.rpartition(".")[0] == name}
    for name in forgotten:
        package, _, own = name.rpartition(".")
        if package in sys.modules:
            vars(sys.modules[package]).pop(own, None)  # where `from package import own` finds it


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
