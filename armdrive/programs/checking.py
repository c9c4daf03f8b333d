"""Checking a program as a whole before any of it runs: all that is wrong, at once."""

from __future__ import annotations

from armdrive.programs.problems import Problem
from armdrive.programs.syntax import Tree


def check(tree: Tree) -> list[Problem]:
    """Return everything that is wrong with a program."""
    return []
