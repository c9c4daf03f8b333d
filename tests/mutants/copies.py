"""Copies of the project, and pytest run in one of them, as if it were the only one there is."""

from __future__ import annotations

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
RUN_LIMIT_S = 900.0
"""No run of a few tests takes longer; the tests have a limit of their own, which comes first."""
PASSED, FAILED = 0, 1
"""Exit codes of pytest; the others say that no test was run, or not the one that was meant."""
_FAILURE = re.compile(r"^(?:FAILED|ERROR) (\S+?\.py(?:::.*?)?)(?: - .*)?$", re.MULTILINE)
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
    return {**kept, "PYTHONPATH": str(folder)}


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


def run_tests(folder: Path, tests: Sequence[str], *, workers: int = 0, first: bool = True) -> Run:
    """Run tests in a copy; `first` ends the run at the first failure."""
    words = [sys.executable, "-m", "pytest", "-q", "-rfE", "--tb=line", "-p", "no:cacheprovider"]
    words += ["--color=no", "-n", str(workers), *(["-x"] if first else []), *tests]
    began_s = time.monotonic()
    try:
        told = subprocess.run(
            words,
            cwd=folder,
            env=environment(folder),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            check=False,
            timeout=RUN_LIMIT_S,
        )
    except subprocess.TimeoutExpired:
        return Run(-1, (), f"pytest had not ended after {RUN_LIMIT_S:.0f} s", RUN_LIMIT_S)
    failed = tuple(dict.fromkeys(_FAILURE.findall(told.stdout)))
    if _TIMEOUT.search(told.stdout):
        failed = failed or ("a test that hung",)
    return Run(told.returncode, failed, told.stdout[-2000:], time.monotonic() - began_s)
