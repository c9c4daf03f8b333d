"""Print the lecture's worked example of an arm, for the reader's own numbers."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import replace

from armdrive.cli.learn.explain_accuracy import explain_accuracy
from armdrive.cli.learn.explain_efficiency import explain_efficiency
from armdrive.cli.learn.explain_view import example_view, symbolic_view
from armdrive.cli.learn.models import coordinates_text, given_goal, given_joints
from armdrive.cli.options import number
from armdrive.cli.presenter import emit, say, say_lines
from armdrive.config.link_model import is_model_file, read_model
from armdrive.errors import BadRequest, Refused
from kinematics.chains.urdf import urdf_of_chain
from kinematics.errors import OutOfReach, UnknownSystem
from kinematics.presets import PRESETS, preset
from kinematics.textbook.systems import SYSTEMS, MiniMover, System, system
from kinematics.textbook.worked_example import (
    FRAME_COORDINATES,
    ExampleSection,
    SymbolicExample,
    WorkedExample,
    sections,
    symbolic_chain_example,
    symbolic_sections,
    symbolic_system_example,
    work_chain,
    work_system,
)

EFFICIENCY = "efficiency"
ACCURACY = "accuracy"


def run(options: argparse.Namespace) -> int:
    """Print it."""
    if options.list or options.system is None:
        _list(as_json=options.json)
        return 0
    if options.system == EFFICIENCY:
        explain_efficiency(options.joints, as_json=options.json)
        return 0
    if options.system == ACCURACY:
        explain_accuracy(options.joints, as_json=options.json)
        return 0
    if options.urdf:
        _say_urdf(options.system)
        return 0
    joints = _numbers(options.joints)
    if options.symbolic or options.latex:
        if joints or options.goal:
            raise BadRequest(
                "--symbolic and --latex hold for any numbers; leave joints and goal out"
            )
        _say_symbolic(options)
        return 0
    example = _example(options.system, joints or None, options.goal)
    if options.json:
        emit(example_view(example))
    else:
        _say_heading(example.title or example.name, example.source)
        _say_sections(sections(example))
    return 0


def _say_urdf(word: str) -> None:
    chain = read_model(word).chain if is_model_file(word) else _system(word).chain()
    name = word if not is_model_file(word) else ""
    say_lines(urdf_of_chain(chain, name=name).rstrip())


def _list(*, as_json: bool) -> None:
    if as_json:
        emit(
            {
                "systems": [
                    {
                        "name": each.name,
                        "title": each.title,
                        "source": each.source,
                        "joints": list(each.joint_names),
                        "goal": list(each.coordinates),
                    }
                    for each in SYSTEMS.values()
                ]
            }
        )
        return
    width = max(map(len, SYSTEMS)) + 2
    for name, each in SYSTEMS.items():
        say(f"{name:<{width}}{each.title}")
        say(f"{'':<{width}}{each.source}")
    say("")
    others = ", ".join(key for key in PRESETS if key not in SYSTEMS)
    say(f"or an arm of the Mini-mover's build: {others}")
    say("or a link table of your own: armdrive explain FILE.toml")
    say(f"what computing them costs:   armdrive explain {EFFICIENCY}")
    say(f"how exact an arm is:         armdrive explain {ACCURACY}")


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
        return MiniMover(preset(word).arm)
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
