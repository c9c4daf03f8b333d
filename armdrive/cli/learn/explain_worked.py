"""Pages of `armdrive explain` about a system or an arm.

They are its worked example, the same in symbols, its frames found from its joint axes, its URDF,
and the studies of efficiency and accuracy. A page is a list of sections, which are printed as text
or as JSON.
"""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

from armdrive.cli.learn.arguments import ACCURACY, EFFICIENCY
from armdrive.cli.learn.joint_values import frame_view, require_values
from armdrive.cli.learn.models import (
    branch_view,
    find_subject,
    given_goal,
    given_joints,
    shown_joints,
)
from armdrive.cli.presenter import Outcome, Result
from armdrive.errors import BadRequest, Refused
from armdrive.render.canvas import draws_braille
from armdrive.render.frame_steps import StepDrawing
from armdrive.text.numbers import number
from kinematics.chains.assignment import Assignment, assign_frames
from kinematics.chains.chain import rows_of
from kinematics.chains.links import Convention
from kinematics.chains.urdf import urdf_of_chain
from kinematics.errors import OutOfReach
from kinematics.presets import ArmPreset, preset
from kinematics.spaces import JOINT_NAMES, Joints
from kinematics.textbook.accuracy import (
    TipError,
    gearing_errors,
    length_errors,
    rounding_bound_mm,
    rounding_rms_mm,
    step_errors,
    zero_errors,
)
from kinematics.textbook.efficiency import Efficiency, Tally, Way, efficiency, forward_ways
from kinematics.textbook.study import FRAME_COORDINATES, Study, Subject, example_posture
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.thirteen_steps import (
    AssignmentStep,
    assignment_steps,
    axes_lines,
    result_lines,
)
from kinematics.textbook.worked_example import (
    ExampleSection,
    coordinates_text,
    number_text,
    sections,
    symbolic_example,
    symbolic_sections,
    work,
)
from kinematics.transmission import Transmission


def explain_system(options: argparse.Namespace, page: str) -> Outcome:
    """Return the page that the command line asks for; without an option, the worked example."""
    if page == EFFICIENCY:
        return _efficiency(options.joints)
    if page == ACCURACY:
        return _accuracy(options.joints)
    if page == "--urdf":
        return _urdf(options.system)
    subject = find_subject(options.system)
    if page == "--axes":
        return _axes(subject, options.convention)
    if page:
        return _symbolic(subject, latex=page == "--latex")
    example = _example(subject, _numbers(options.joints) or None, options.goal)
    return Result(example_view(example), (*_heading(subject), *_lines_of(sections(example))))


def _urdf(word: str) -> Result:
    text = urdf_of_chain(find_subject(word).chain)
    return Result({"urdf": text}, text.rstrip().split("\n"), verbatim=True)


# A goal this near to a reachable one counts as that one, since pages print two decimals of a mm.
TYPED_MM = 0.01


def _example(
    subject: Subject, joints: Sequence[float] | None, goal: Sequence[float] | None
) -> Study:
    system = subject.system
    given = joints and given_joints(subject.chain, joints)
    asked = goal and (
        given_goal(FRAME_COORDINATES, goal, least=3)
        if system is None
        else given_goal(system.coordinates, goal)
    )
    try:
        return work(subject, given, asked)
    except OutOfReach as error:
        if error.away_mm <= TYPED_MM:
            return work(subject, given, error.nearest)
        instead = coordinates_text(error.coordinates, error.nearest)
        away = number_text(error.away_mm, "mm")
        raise Refused(
            f"{error.system} cannot reach this goal, only to {away} from it; a goal that it "
            f"reaches: {instead}"
        ) from None


def _symbolic(subject: Subject, *, latex: bool) -> Result:
    found = tuple(symbolic_sections(symbolic_example(subject), latex=latex))
    heading = (f"% {subject.title}; {subject.source}",) if latex else _heading(subject)
    lines = _lines_of(found, comment=latex)
    about = {"title": subject.title, "source": subject.source}
    view = {**about, "sections": _sections_view(found)}
    return Result(view, (*heading, *lines), verbatim=latex)


def _heading(subject: Subject) -> tuple[str, ...]:
    facts = (("source", subject.source), ("angles", subject.angles))
    stated = (f"{name}: {words}" for name, words in facts if words)
    return (subject.title, *stated, *(f"note: {sentence}" for sentence in subject.unused))


def _lines_of(sections: Iterable[ExampleSection], *, comment: bool = False) -> Iterator[str]:
    for section in sections:
        yield ""
        yield f"% {section.title}" if comment else f"== {section.title}"
        yield from section.lines


def _numbers(words: Sequence[str]) -> list[float]:
    try:
        return [number(word) for word in words]
    except BadRequest as error:
        raise BadRequest(f"a joint's value: {error}") from None


def _sections_view(sections: Iterable[ExampleSection]) -> list[dict[str, Any]]:
    return [{"title": each.title, "lines": list(each.lines)} for each in sections]


def example_view(example: Study) -> dict[str, Any]:
    """Return a worked example as plain data: its numbers as `fk` and `ik` give them, its page."""
    subject = example.subject
    return {
        "name": subject.name,
        "title": subject.title,
        "source": subject.source,
        "angles": subject.angles,
        "convention": subject.chain.convention.value,
        "links": list(rows_of(subject.chain)),
        "joints": shown_joints(subject.chain, example.values),
        "violations": list(map(str, example.violations)),
        **frame_view(example.frame),
        "branches": [branch_view(subject.chain, each) for each in example.branches],
        "sections": _sections_view(sections(example)),
    }


# `explain --axes`: frames and link table found from an arm's joint axes, in drawn steps.

MOST_COLUMNS, PICTURE_ROWS = 78, 20


def _axes(subject: Subject, convention: str | None) -> Result:
    """Return the steps from the joint axes to frames and link table, with their pictures."""
    chain, zero = subject.chain, subject.zero
    kind = chain.convention if convention is None else Convention(convention)
    found = assign_frames(zero.axes, zero.tool, kind, subject.name)
    steps = assignment_steps(found)
    heading = (*_heading(subject), f"convention: {found.chain.convention.value}")
    return Result(axes_view(found, steps), _axes_lines(found, steps, heading))


def _axes_lines(
    found: Assignment, steps: Sequence[AssignmentStep], heading: Sequence[str]
) -> Iterator[str]:
    drawing = StepDrawing(found)
    braille = draws_braille()
    width = min(shutil.get_terminal_size().columns - 1, MOST_COLUMNS)
    yield from heading
    yield from ("", "== Given: every joint at zero, in mm")
    yield from axes_lines(found)
    for index, step in enumerate(steps):
        before = steps[index - 1].stage if index else ""
        if step.stage != before:
            yield from ("", f"== {step.stage}")
        yield from step.lines
        last = index + 1 == len(steps) or steps[index + 1].stage != step.stage
        if last and step.number > 1:
            yield from drawing.rows(
                step.index, width, PICTURE_ROWS, linked=step.is_of_link, braille=braille
            )
    yield from ("", "== Link table")
    yield from result_lines(found)


def axes_view(found: Assignment, steps: Sequence[AssignmentStep]) -> dict[str, Any]:
    """Return an assignment as plain data, in mm and degrees."""
    return {
        "name": found.chain.name,
        "convention": found.chain.convention.value,
        "links": list(rows_of(found.chain)),
        "steps": [
            {
                "step": step.number,
                "stage": step.stage,
                "text": [line.strip() for line in step.lines],
            }
            for step in steps
        ],
    }


# What each way of computing an arm costs, counted by running it (McKerrow, chapter 4, section 15).

COUNTED = ("minimover5", "puma")


def _efficiency(names: Sequence[str]) -> Result:
    """Count the operations of these models, or of the Mini-mover and the Puma."""
    subjects = [find_subject(name) for name in names or COUNTED]
    found = [
        ExampleSection(subject.title, tuple(_efficiency_lines(_counted(subject))))
        for subject in subjects
    ]
    heading = ["counted by running the code on counting numbers; an arm's constants cost nothing"]
    if not names:
        others = ", ".join(name for name in SYSTEMS if name not in COUNTED)
        heading.append(
            f"`armdrive explain efficiency MODEL ...` counts others: {others}, or a file"
        )
    return Result({"sections": _sections_view(found)}, (*heading, *_lines_of(found)))


def _counted(subject: Subject) -> Efficiency:
    """Count every way of a named system, and those from a link table to the hand's frame."""
    if subject.system is not None:
        return efficiency(subject.system)
    chain = subject.chain
    return Efficiency(subject.name, forward_ways(chain, example_posture(chain)), ())


def _efficiency_lines(counted: Efficiency) -> Iterator[str]:
    for title, ways in (("forward", counted.forward), ("inverse", counted.inverse)):
        if ways:
            yield from _way_lines(title, ways)


def _way_lines(title: str, ways: Sequence[Way]) -> Iterator[str]:
    kinds = [each.name for each in fields(Tally)]
    width = max(len(way.name) for way in ways)
    yield f"  {title:<{width}}  " + "  ".join(kinds)
    for way in ways:
        counts = (f"{getattr(way.tally, kind):>{len(kind)}}" for kind in kinds)
        yield f"  {way.name:<{width}}  {'  '.join(counts)}"
    for what in dict.fromkeys(way.what for way in ways):
        names = [way.name for way in ways if way.what == what]
        yield f"    {names[0] if len(names) == 1 else 'each branch'}: {what}"


# How exact an arm is at a posture, and why (McKerrow, chapter 4, section 14).

DEFAULT_ARM = "minimover5"
DEFAULT_DEG = (0.0, 40.0, -60.0, -70.0, 0.0)


def _accuracy(words: Sequence[str]) -> Result:
    """Return how far a motor step and errors of lengths, zeros and gearing move an arm's tip."""
    model = preset(words[0] if words else DEFAULT_ARM)
    transmission = model.transmission
    if transmission is None:
        raise Refused(f"the motor steps of the {model.title} are not known")
    joints = _posture(words[1:])
    found = [
        ExampleSection(
            f"what {group} does to the tip",
            tuple(f"  {each.cause:<16}{each.distance_mm:8.3f} mm" for each in errors),
        )
        for group, errors in _errors(model, transmission, joints).items()
    ]
    bound_mm = rounding_bound_mm(model.arm, transmission, joints)
    rms_mm = rounding_rms_mm(model.arm, transmission, joints)
    rounding = f"  {rms_mm:.3f} mm on average (RMS), {bound_mm:.3f} mm at most"
    found.append(ExampleSection("rounding to whole steps", (rounding,)))
    view = {"arm": model.key, "sections": _sections_view(found)}
    return Result(view, (f"{model.title} at {joints}", *_lines_of(found)))


def _posture(words: Sequence[str]) -> Joints:
    if not words:
        return Joints.of(*DEFAULT_DEG)
    require_values(JOINT_NAMES, words)
    return Joints.of(*map(number, words))


def _errors(
    model: ArmPreset, transmission: Transmission, joints: Joints
) -> Mapping[str, Sequence[TipError]]:
    """Return the tip's errors, grouped by their cause."""
    arm = model.arm
    return {
        "a motor step": step_errors(arm, transmission, joints),
        "1 mm of a length": length_errors(arm, joints),
        "0.1 degrees of a zero": zero_errors(arm, joints),
        "1 % of a gearing": gearing_errors(arm, transmission, joints),
    }
