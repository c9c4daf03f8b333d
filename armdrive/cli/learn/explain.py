"""Print the lecture's worked example of an arm, with the user's own numbers."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from armdrive.cli.presenter import Outcome, Result
from armdrive.errors import BadRequest
from kinematics.presets import PRESETS
from kinematics.textbook.systems import SYSTEMS


def explain(options: argparse.Namespace) -> Outcome:
    """Explain a system, or list the systems."""
    if not options.list and options.system is not None:
        # loads solvers and symbols, which the list does not need
        from armdrive.cli.learn.explain_worked import explain_system

        return explain_system(options)
    if options.axes or options.convention:
        raise BadRequest("--axes needs a system or a model file: armdrive explain --axes puma")
    systems = [
        {
            "name": each.name,
            "title": each.title,
            "source": each.notes.source,
            "joints": list(each.joint_names),
            "goal": list(each.coordinates),
        }
        for each in SYSTEMS.values()
    ]
    return Result({"systems": systems}, _listed())


def _listed() -> Iterator[str]:
    width = max(map(len, SYSTEMS)) + 2
    for name, each in SYSTEMS.items():
        yield f"{name:<{width}}{each.title}"
        yield f"{'':<{width}}{each.notes.source}"
    others = ", ".join(key for key in PRESETS if key not in SYSTEMS)
    yield from (
        "",
        f"or an arm of the Mini-mover's build: {others}",
        "or an arm of your own, by its link table, arm file or URDF: armdrive explain FILE",
        "the cost of computing them:  armdrive explain efficiency",
        "the accuracy of an arm:      armdrive explain accuracy",
    )
