"""Print the lecture's worked example of an arm, with the user's own numbers.

This module decides which page is meant; `explain_worked` prints every page but the list of systems.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from types import MappingProxyType

from armdrive.cli.learn.arguments import ACCURACY, EFFICIENCY, STUDIES
from armdrive.cli.presenter import Outcome, Result
from armdrive.errors import BadRequest
from kinematics.presets import PRESETS
from kinematics.textbook.systems import SYSTEMS

EXAMPLE, LIST = "", "--list"
# Every page, and what may be typed for it.
PAGES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        EXAMPLE: ("system", "joints", "goal"),
        LIST: (),
        "--urdf": ("system",),
        "--symbolic": ("system",),
        "--latex": ("system",),
        "--axes": ("system", "convention"),
        EFFICIENCY: ("system", "joints"),
        ACCURACY: ("system", "joints"),
    }
)

TYPED: Mapping[str, str] = MappingProxyType(
    {"joints": "a joint's value", "goal": "--goal", "convention": "--convention"}
)


def explain(options: argparse.Namespace) -> Outcome:
    """Explain a system, or list the systems."""
    page = _page(options)
    if page != LIST:
        # loads solvers and symbols, which the list does not need
        from armdrive.cli.learn.explain_worked import explain_system

        return explain_system(options, page)
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


def _page(options: argparse.Namespace) -> str:
    """Return the page that is meant. Raises `BadRequest` for what does not go with it."""
    given = [name for name in (*PAGES[EXAMPLE], "convention") if getattr(options, name)]
    chosen = [page for page in PAGES if page and getattr(options, page.strip("-"), False)]
    study = options.system if options.system in STUDIES else ""
    page = chosen[0] if chosen else study or (EXAMPLE if given else LIST)
    for name in given:
        if name not in PAGES[page]:
            what = options.system if name == "system" else TYPED[name]
            fits = [_called(each) for each, takes in PAGES.items() if name in takes]
            raise BadRequest(f"{what} goes with {' or '.join(fits)}, not with {_called(page)}")
    if "system" in PAGES[page] and (options.system is None or (chosen and study)):
        what = _called(page) if page else TYPED[given[0]]
        instead = f", not {study}" if study else ": armdrive explain puma ..."
        raise BadRequest(f"{what} needs a system or a model file{instead}")
    return page


def _called(page: str) -> str:
    return page or "a worked example"


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
        "a model to move by key:      armdrive jog --model puma",
        "the notes, section by section, and their exercises: docs/textbook/textbook.md",
    )
