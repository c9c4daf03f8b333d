"""A worked example as plain data, for `armdrive explain --json`: mm and degrees."""

from __future__ import annotations

import math
from typing import Any

from armdrive.cli.learn.chains import solution_view
from armdrive.cli.learn.models import shown, shown_joints
from kinematics.chains.tables import rows_of
from kinematics.frames.transforms import IN_PLACE, Transform, position_of
from kinematics.textbook.notation import Latex, SymbolText
from kinematics.textbook.symbols import as_symbol
from kinematics.textbook.worked_example import (
    SymbolicExample,
    WorkedBranch,
    WorkedExample,
    violation_text,
)


def example_view(example: WorkedExample) -> dict[str, Any]:
    """Return a worked example."""
    angles = example.orientation.first
    degeneracy = example.orientation.degeneracy
    view: dict[str, Any] = {
        "name": example.name,
        "title": example.title,
        "source": example.source,
        "figure": example.figure,
        "convention": example.chain.convention.value,
        "links": list(rows_of(example.chain)),
        "joints": shown_joints(example.chain, example.joints),
        "violations": list(map(violation_text, example.violations)),
        "matrices": [_rows(matrix) for matrix in example.matrices],
        "frame": _rows(example.frame),
        "position_mm": list(position_of(example.frame)),
        "rpy_deg": [
            math.degrees(each) for each in (angles.phi_rad, angles.theta_rad, angles.psi_rad)
        ],
        "rpy_degenerate": degeneracy.value if degeneracy else "",
        "condition": example.condition,
        "derivation": [
            {"title": step.title, "formula": step.formula, "why": step.why}
            for step in example.derivation
        ],
        "goal": _goal(example, example.goal),
    }
    if example.solution is None:
        view["branches"] = [_branch(example, each) for each in example.branches]
    else:
        view["solution"] = solution_view(example.chain, example.solution)
    return view


def symbolic_view(example: SymbolicExample, *, latex: bool) -> dict[str, Any]:
    """Return a symbolic example, its entries as text or as LaTeX."""
    writer = Latex() if latex else SymbolText()

    def written(matrix: Transform) -> list[list[str]]:
        return [[writer.write(as_symbol(entry)) for entry in row] for row in matrix]

    view: dict[str, Any] = {"matrices": [written(matrix) for matrix in example.matrices]}
    for name, frame in (("base", example.base), ("tool", example.tool)):
        if frame != IN_PLACE:
            view[name] = written(frame)
    view["product"] = written(example.product)
    view["solutions"] = {
        branch.name: {step.name: writer.write(step.symbol) for step in branch.steps}
        for branch in example.branches
    }
    return view


def _branch(example: WorkedExample, worked: WorkedBranch) -> dict[str, Any]:
    branch = worked.branch
    return {
        "name": branch.name,
        "joints": shown_joints(example.chain, branch.joints),
        "workings": {
            one.symbol: math.degrees(one.value) if one.unit == "rad" else one.value
            for one in branch.workings
        },
        "comes_to": _goal(example, worked.comes_to),
        "free": list(branch.free),
        "degenerate": branch.degenerate,
        "within_limits": branch.within_limits,
        "violations": list(map(violation_text, branch.violations)),
    }


def _goal(example: WorkedExample, values: tuple[float, ...]) -> dict[str, float]:
    return dict(map(shown, example.coordinates, values))


def _rows(matrix: Transform) -> list[list[float]]:
    return [list(row) for row in matrix]
