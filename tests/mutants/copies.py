"""Copies of the project, and pytest run in one of them, as if it were the only one there is."""

import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

PACKAGES = ("armdrive", "firmware_protocol", "kinematics", "tui")
LEFT_OUT = {".git", ".venv", "__pycache__", ".pytest_cache", ".mypy_cache", ".ruff_cache"}
LIBRARIES = (
    "can",
    "code",
    "execnet.gateway",
    "filelock",
    "hypothesis.strategies",
    "lark",
    "multiprocessing.connection",
    "numpy.random",
    "pdb",
    "platformdirs.pytest_plugin",
    "pytest_asyncio.plugin",
    "pytest_textual_snapshot",
    "pytest_timeout",
    "serial",
    "syrupy",
    "textual.app",
    "textual.pilot",
    "textual.widgets",
    "tomlkit",
    "tomllib",
    "unittest.mock",
    "xdist.looponfail",
    "xdist.plugin",
)
"""What many tests import and no mutant is in: imported once for all of them."""
SERVER = Path(__file__).with_name("pytest_server.py")
HUNG = "a test that hung"
"""In place of a test's name, which pytest does not tell then."""
PASSED, FAILED = 0, 1
"""Exit codes of pytest; the others say that no test was run, or not the one that was meant."""
_FAILURE = re.compile(
    r"^(?:FAILED|ERROR) (\S+?\.py(?:::[^\[\n]*?(?:\[.*?\])?)?)(?: - .*)?$", re.MULTILINE
)
_TIMEOUT = re.compile(r"^\++ Timeout \++$", re.MULTILINE)


class CopyError(Exception):
    """The copy is not what the tests would import, or cannot be made."""


@dataclass(frozen=True, slots=True)
class Run:
    """What pytest said: its exit code, the tests that failed, its last words, and its time in s."""

    code: int
    failed: tuple[str, ...]
    words: str
    took_s: float


def project_files(root: Path) -> list[Path]:
    """Return the project's files, relative to its root: git's, or all of them without git.

    Files that git does not know yet belong to it, unless they are ignored.
    """
    words = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        told = subprocess.run(words, cwd=root, capture_output=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return sorted(_walked(root))
    names = sorted(set(told.stdout.decode("utf-8", "surrogateescape").split("\0")) - {""})
    return [Path(name) for name in names if (root / name).is_file()]


def _walked(root: Path) -> Iterable[Path]:
    for folder, folders, files in os.walk(root):
        folders[:] = [name for name in folders if name not in LEFT_OUT]
        yield from (Path(folder, name).relative_to(root) for name in files)


def copy_project(root: Path, folder: Path) -> None:
    """Copy the project's files into an empty folder, with their times."""
    for name in project_files(root):
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(root / name, target)


def environment(folder: Path) -> dict[str, str]:
    """Return the environment in which Python imports this copy, ahead of any installed one."""
    dropped = {"PYTHONPYCACHEPREFIX", "PYTHONDONTWRITEBYTECODE", "PYTEST_ADDOPTS"}
    dropped |= {name for name in os.environ if name.startswith(("PYTEST_XDIST", "GIT_"))}
    kept = {name: value for name, value in os.environ.items() if name not in dropped}
    return {**kept, "PYTHONPATH": str(folder), "HYPOTHESIS_PROFILE": "unshrunk"}


def module_of(path: Path | str) -> str:
    """Return the name of the module that is in a file, relative to the project's root."""
    return ".".join(Path(path).with_suffix("").parts).removesuffix(".__init__")


def modules_of(folder: Path, package: str) -> list[str]:
    """Return the names of a package's modules, but for those that do something when imported."""
    names = (module_of(path.relative_to(folder)) for path in folder.glob(f"{package}/**/*.py"))
    return sorted(name for name in names if not name.endswith("__main__"))


def require_imported(folder: Path, packages: Sequence[str]) -> None:
    """Raise `CopyError` unless the product's packages are imported from this copy."""
    code = "import importlib,sys\nfor n in sys.argv[1:]: print(importlib.import_module(n).__file__)"
    words = [sys.executable, "-c", code, *packages]
    told = subprocess.run(
        words, cwd=folder, env=environment(folder), capture_output=True, text=True, check=False
    )
    if told.returncode:
        raise CopyError(f"the copy cannot be imported: {told.stderr.strip()[-500:]}")
    for line in told.stdout.splitlines():
        if folder.resolve() not in Path(line).resolve().parents:
            raise CopyError(f"{line} would be tested instead of the copy in {folder}")


class Copy:
    """A copy of the project with a process of its own that runs pytest in it."""

    def __init__(self, folder: Path, packages: Sequence[str]) -> None:
        require_imported(folder, packages)
        self.folder = folder
        self._output = folder.with_name(f"{folder.name}.txt")
        self._temporary = folder.with_name(f"{folder.name}-temporary")
        modules = [name for package in packages for name in modules_of(folder, package)]
        self._server = subprocess.Popen(
            [sys.executable, "-P", str(SERVER), *LIBRARIES, *modules],
            cwd=folder,
            env=environment(folder),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def close(self) -> None:
        """End the process."""
        self._server.communicate()

    def run_tests(
        self, tests: Sequence[str], *, changed: str = "", workers: int = 0, first: bool = True
    ) -> Run:
        """Run tests in this copy, of which one module may have `changed` since it was made.

        `first` ends the run at the first failure.
        """
        words = ["-q", "-rfE", "--tb=line", "--color=no", "-p", "no:cacheprovider"]
        # the libraries are plugins too, and pytest warns that it cannot rewrite their assertions
        words += ["-W", "ignore::pytest.PytestAssertRewriteWarning", "-n", str(workers)]
        words += [f"--basetemp={self._temporary}"]  # emptied by the next run
        words += [*(["-x"] if first else []), *tests]
        began_s = time.monotonic()
        assert self._server.stdin is not None
        assert self._server.stdout is not None
        self._server.stdin.write(json.dumps([str(self._output), changed, *words]) + "\n")
        self._server.stdin.flush()
        code = int(self._server.stdout.readline())
        told = self._output.read_text(encoding="utf-8", errors="replace")
        failed = tuple(dict.fromkeys(_FAILURE.findall(told)))
        if _TIMEOUT.search(told):
            failed = failed or (HUNG,)
        return Run(code, failed, told[-2000:], time.monotonic() - began_s)
