"""Checking a program as a whole before any of it runs: all that is wrong, at once."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from armdrive.programs.compiling import Code, compiled
from armdrive.programs.fitting import Fitting
from armdrive.programs.kinds import Kinds
from armdrive.programs.naming import scoped
from armdrive.programs.problems import Problem
from armdrive.programs.settled import unsettled
from armdrive.programs.shape import shape_problems
from armdrive.programs.syntax import Tree
from armdrive.programs.vocabulary import Kind


def checked(
    tree: Tree, known: Mapping[str, Kind] = MappingProxyType({})
) -> tuple[Code | None, list[Problem]]:
    """Return a program's code, and everything that is wrong with it.

    `known` are the kinds of the names that have a value already. There is no code where it does
    not hold together, nor where a value does not fit.
    """
    problems = list(shape_problems(tree, frozenset(known)))
    kinds = Kinds(tree, known)
    for define, line in scoped(tree):
        problems += Fitting(kinds, define).line(line)
    if problems:
        return None, problems
    code = compiled(tree, frozenset(known))
    return code, unsettled(code, frozenset(known))
