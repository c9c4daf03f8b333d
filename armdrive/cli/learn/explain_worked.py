"""The worked example of one system or arm: its numbers in sections, and as plain data."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from armdrive.cli.learn.chains import solution_view
from armdrive.cli.learn.explain_accuracy import explain_accuracy
from armdrive.cli.learn.explain_efficiency import explain_efficiency
from armdrive.cli.learn.models import (
    coordinates_text,
    given_goal,
    given_joints,
    shown,
    shown_joints,
)
from armdrive.cli.options import number
from armdrive.cli.presenter import emit, say, say_lines
from armdrive.config.link_model import is_model_file, read_model
from armdrive.errors import BadRequest, Refused
from kinematics.chains.tables import rows_of
from kinematics.chains.urdf import urdf_of_chain
from kinematics.errors import OutOfReach, UnknownSystem
from kinematics.frames.transforms import IN_PLACE, Transform, position_of
from kinematics.presets import PRESETS, preset
from kinematics.textbook.notation import notation
from kinematics.textbook.symbolic_systems import (
    SymbolicExample,
    symbolic_chain_example,
    symbolic_sections,
    symbolic_system_example,
)
from kinematics.textbook.symbols import as_symbol
from kinematics.textbook.systems import SYSTEMS, system
from kinematics.textbook.systems.mini_movers import MINI_MOVER, with_arm
from kinematics.textbook.systems.named import System
from kinematics.textbook.worked_example import (
    FRAME_COORDINATES,
    ExampleSection,
    WorkedBranch,
    WorkedExample,
    sections,
    violation_text,
    work_chain,
    work_system,
)

EFFICIENCY = "efficiency"
ACCURACY = "accuracy"


def explain_system(options: argparse.Namespace) -> None:
    """Print the example of a system, or a study of several."""
    if options.system == EFFICIENCY:
        explain_efficiency(options.joints, as_json=options.json)
        return
    if options.system == ACCURACY:
        explain_accuracy(options.joints, as_json=options.json)
        return
    if options.urdf:
        _say_urdf(options.system)
        return
    joints = _numbers(options.joints)
    if options.symbolic or options.latex:
        if joints or options.goal:
            raise BadRequest(
                "--symbolic and --latex hold for any numbers; leave joints and goal out"
            )
        _say_symbolic(options)
        return
    example = _example(options.system, joints or None, options.goal)
    if options.json:
        emit(example_view(example))
    else:
        _say_heading(example.title or example.name, example.source)
        _say_sections(sections(example))


def _say_urdf(word: str) -> None:
    chain = read_model(word).chain if is_model_file(word) else _system(word).chain()
    name = word if not is_model_file(word) else ""
    say_lines(urdf_of_chain(chain, name=name).rstrip())


def _example(
    word: str, joints: Sequence[float] | None, goal: Sequence[float] | None
) -> WorkedExample:
    if is_model_file(word):
        model = read_model(word)
        chain = model.chain
        return work_chain(
            chain,
            model.title,
            model.source,
            joints and given_joints(chain, joints),
            goal and given_goal(FRAME_COORDINATES, goal, least=3),
        )
    named = _system(word)
    try:
        example = work_system(
            named,
            joints and given_joints(named.chain(), joints),
            goal and given_goal(named.coordinates, goal),
        )
    except OutOfReach as error:  # again, in degrees
        instead = coordinates_text(error.coordinates, error.nearest)
        raise Refused(
            f"{error.system} cannot reach this goal: {error.quantity} would be {error.value:.6g} "
            f"mm, {error.excess:.3g} mm beyond {error.bound:.6g} mm; a goal that it reaches: "
            f"{instead}"
        ) from None
    chain = replace(example.chain, name=word)
    return replace(example, name=word, title=_title(word, named), chain=chain)


def _system(word: str) -> System:
    """Return a named system, or a built-in arm as one of the Mini-mover's build."""
    if word in PRESETS and word not in SYSTEMS:
        return with_arm(MINI_MOVER, preset(word).arm)
    try:
        return system(word)
    except UnknownSystem as error:
        raise BadRequest(str(error)) from None


def _title(word: str, named: System) -> str:
    return named.title if word in SYSTEMS else preset(word).title


def _say_symbolic(options: argparse.Namespace) -> None:
    if is_model_file(options.system):
        model = read_model(options.system)
        title, source = model.title, model.source
        example: SymbolicExample = symbolic_chain_example(model.chain)
    else:
        named = _system(options.system)
        title, source = _title(options.system, named), named.source
        example = symbolic_system_example(named)
    if options.json:
        emit({"title": title, "source": source, **symbolic_view(example, latex=options.latex)})
        return
    if options.latex:
        say(f"% {title}; {source}")
    else:
        _say_heading(title, source)
    _say_sections(symbolic_sections(example, latex=options.latex), comment=options.latex)


def _say_heading(title: str, source: str) -> None:
    say(title)
    if source:
        say(f"source: {source}")


def _say_sections(sections: Iterable[ExampleSection], *, comment: bool = False) -> None:
    for section in sections:
        say("")
        say(f"% {section.title}" if comment else f"== {section.title}")
        for line in section.lines:
            say(line)


def _numbers(words: Sequence[str]) -> list[float]:
    try:
        return [number(word) for word in words]
    except argparse.ArgumentTypeError as error:
        raise BadRequest(f"a joint's value: {error}") from None


# As plain data, for `--json`: mm and degrees.


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
    writer = notation(latex=latex)

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
