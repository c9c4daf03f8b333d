"""The programs on the pages about Python and about testing run as they stand there."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from pages import blocks, page

pytest_plugins = ["pytester"]

PYTHON, TESTING = (blocks(page(name), "python") for name in ("python", "testing-scripts"))


@pytest.mark.parametrize("number", range(len(PYTHON)))
def test_a_program_of_the_python_page_runs(number, tmp_path):
    program = PYTHON[number]
    ended = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120.0,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (0, "")


def test_the_tests_of_the_testing_page_pass(pytester, monkeypatch):
    named = {re.match(r"# (\w+)\.py\n", block)[1]: block for block in TESTING}
    assert set(named) == {"pick", "test_pick"}
    pytester.makepyfile(**named)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    ended = pytester.runpytest_inprocess("-parmdrive.testing.plugin", "--strict-markers")
    ended.assert_outcomes(passed=named["test_pick"].count("def test_"))
