"""Forward and numerical inverse kinematics of any model on the command line.

A model is a built-in arm, a named system, a model file, or the arm of an arm file. People type and
read degrees and mm.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from armdrive.cli.learn.joint_values import (
    BranchRow,
    branch_table,
    frame_view,
    require_values,
)
from armdrive.cli.presenter import Result
from armdrive.config.arm import ArmConfig
from armdrive.config.link_model import Model, read_model
from armdrive.config.sections import is_model_file, is_urdf
from armdrive.errors import ArmFileError, BadRequest, Refused
from armdrive.registry.arm_files import arm_of
from armdrive.text.reading import read_toml
from kinematics.chains.arm import ChainArm
from kinematics.chains.chain import Chain
from kinematics.chains.closed_form import how_solved
from kinematics.chains.goals import ALL_PARTS, Goal, HandTask, Part, goal_of
from kinematics.chains.inverse import Solution, solve_goal
from kinematics.chains.links import JointKind
from kinematics.errors import OutOfReach, UnknownSystem
from kinematics.five_axis import FiveAxisArm
from kinematics.frames.transforms import Transform, compose, position_of, translation
from kinematics.frames.vectors import distance, norm
from kinematics.spaces import Pose
from kinematics.text import counted, joint_text
from kinematics.textbook.study import (
    FRAME_COORDINATES,
    Subject,
    subject_of_chain,
    subject_of_system,
    table_branches,
)
from kinematics.textbook.systems import MODEL_NAMES, system
from kinematics.textbook.systems.mini_movers import MINI_MOVER, with_arm
from kinematics.textbook.systems.named import NamedBranch, System, frame_coordinates
from kinematics.textbook.worked_example import (
    coordinates_text,
    frame_text,
    joints_text,
)


def find_subject(word: str) -> Subject:
    """Return a named system, a model file or the arm of an arm file as a subject of study.

    Raises `BadRequest` for an unknown name, with the nearest one, and `ArmFileError` for a file
    that cannot be used.
    """
    if not is_model_file(word):
        return subject_of_system(_system(word))
    model = _model_of_file(Path(word))
    subject = subject_of_chain(model.name, model.title, model.source, model.chain)
    return replace(subject, axes=model.zero, angles=model.angles, unused=model.unused)


def _model_of_file(path: Path) -> Model:
    """Return what a model file describes, or the arm of an arm file."""
    if not is_urdf(path.name):
        table = read_toml(path, "the model file", ArmFileError)
        if "model" in table:
            return _model_of_arm(arm_of(table, path), path)
    return read_model(path)


def _model_of_arm(config: ArmConfig, path: Path) -> Model:
    """Return the arm that an arm file describes, with its corrections and its tool."""
    arm, bare = config.model.arm, config.bare.arm
    source, unused = f"arm file {path.name}", config.model.unused
    if isinstance(bare, FiveAxisArm):
        chain, point = with_arm(MINI_MOVER, bare).chain(), translation(*config.tool.offset_mm)
        held = replace(chain, tool=compose(chain.tool, point), name=config.name)
        return Model(config.name, config.title, source, held, angles=MINI_MOVER.notes.angles)
    if not isinstance(arm, ChainArm):
        raise BadRequest(f"{path}: this arm has no link table")
    return Model(config.name, config.title, source, arm.chain, unused=unused)


def _system(word: str) -> System:
    """Return a named system or a built-in arm; raises `BadRequest` with the nearest name."""
    try:
        return system(word)
    except UnknownSystem as error:
        hint = f"; did you mean {error.nearest!r}?" if error.nearest else ""
        raise BadRequest(
            f"no model is named {word!r}{hint} (there are {', '.join(MODEL_NAMES)}, .toml files "
            "with a link table or an arm, and .urdf files)"
        ) from None


# People type and read degrees and mm; kinematics takes rad and mm.


def given_joints(chain: Chain, typed: Sequence[float]) -> tuple[float, ...]:
    """Return joint values in rad and mm. Raises `BadRequest` for too few or too many."""
    require_values(chain.joint_names, typed)
    return tuple(
        math.radians(value) if kind is JointKind.REVOLUTE else value
        for value, kind in zip(typed, chain.kinds, strict=True)
    )


def given_goal(
    coordinates: Sequence[str], typed: Sequence[float], *, least: int | None = None
) -> tuple[float, ...]:
    """Return the coordinates of a goal in rad and mm.

    All are needed, or only the first `least`. Raises `BadRequest` for any other number.
    """
    if len(typed) not in (len(coordinates), least):
        names = [typed_name(name) for name in coordinates]
        fewer = f", or {', '.join(names[:least])} alone" if least else ""
        raise BadRequest(
            f"a goal is {', '.join(names)}{fewer}, not {counted(len(typed), 'number')}"
        )
    return tuple(
        math.radians(value) if name.endswith("_rad") else value
        for name, value in zip(coordinates, typed, strict=False)
    )


def typed_name(name: str) -> str:
    """Return a coordinate's name with the unit that a person types: pitch_deg for pitch_rad."""
    return f"{name.removesuffix('_rad')}_deg" if name.endswith("_rad") else name


def shown_joints(chain: Chain, values: Sequence[float]) -> dict[str, float]:
    """Return joint values in degrees and mm, by names that say so."""
    shown = {}
    for name, kind, value in zip(chain.joint_names, chain.kinds, values, strict=True):
        if kind is JointKind.REVOLUTE:
            shown[f"{name}_deg"] = math.degrees(value)
        else:
            shown[f"{name}_mm"] = value
    return shown


# Forward and inverse.


def fk(options: argparse.Namespace) -> Result:
    """Return the pose of the tip for joint values, and the limits that they violate."""
    subject = find_subject(options.model)
    chain = subject.chain
    values = given_joints(chain, options.joints)
    frame = chain.fk(values)
    broken = [str(each) for each in chain.violations(values)]
    view = {
        "model": subject.name,
        "joints": shown_joints(chain, values),
        **frame_view(frame),
        "violations": broken,
    }
    lines = [
        f"{subject.title}: {joints_text(chain, values)}",
        f"tip {coordinates_text(FRAME_COORDINATES, frame_coordinates(frame))}",
        *frame_text(frame),
        *(f"but: {sentence}" for sentence in broken),
    ]
    return Result(view, lines)


# Joints of an arm that can place its tip and keep its hand in the plane of base axis and tip.
LEAST_TO_HOLD_A_PLANE = 5

# Joints of an arm that can turn its hand about the vertical without moving the tip.
JOINTS_TO_CHOOSE_YAW = 6

# A closed form's solution this near to the goal meets it.
SAME_MM, SAME_RAD = 1e-6, 1e-7


def ik(options: argparse.Namespace) -> Iterator[Result]:
    """Yield every known solution of the goal, then the posture that the numerical solver found.

    A pitch or roll that is not given is free: the solver chooses it, and the solutions are those of
    the frame that it chose. Without a yaw, the hand stays in the plane of the base axis and the
    tip.

    Raises `Refused` if no posture meets the goal, after yielding the nearest one.
    """
    subject = find_subject(options.model)
    chain = subject.chain
    goal = _goal(chain, options)
    solution = solve_goal(chain, goal)
    branches = _branches(subject, goal, solution)
    found = how_solved(chain)
    shows_structure = bool(branches) and subject.system is None
    view = {
        "model": subject.name,
        "structure": found.structure,
        **solution_view(chain, solution),
        "branches": [branch_view(chain, branch) for branch in branches],
    }
    lines = (
        f"{subject.title}, {_count_text(goal, branches)}",
        *([f"solved in closed form: {found.structure}"] if shows_structure else []),
        *branch_table(chain.joint_names, [_branch_row(chain, branch) for branch in branches]),
        *(f"{one.name}: {one.degenerate}" for one in branches if one.degenerate),
        f"{'joints' if solution.ok else 'nearest'}: {joints_text(chain, solution.joints)}",
        f"tip {coordinates_text(FRAME_COORDINATES, frame_coordinates(solution.frame))}",
        solution.sentence,
    )
    yield Result(view, lines)
    if not solution.ok:
        raise Refused(f"the goal is not met: {solution.sentence}")


def _goal(chain: Chain, options: argparse.Namespace) -> Goal:
    """Return what the options ask of the hand. Raises `BadRequest` for a yaw it cannot choose."""
    if options.yaw is not None and len(chain) < JOINTS_TO_CHOOSE_YAW:
        raise BadRequest(
            f"--yaw is for a model with six joints, and {chain.name} has {len(chain)}; "
            "`armdrive explain MODEL --goal` takes a named system's own coordinates"
        )
    pose = Pose.of(
        x_mm=options.x,
        y_mm=options.y,
        z_mm=options.z,
        pitch_deg=options.pitch or 0.0,
        roll_deg=options.roll or 0.0,
        yaw_deg=options.yaw,
    )
    task = HandTask.IN_PLANE if options.yaw is None else HandTask.WHOLE
    free = {
        Part.PITCH: options.pitch is None,
        Part.ROLL: options.roll is None,
        Part.HEADING: options.yaw is None and len(chain) < LEAST_TO_HOLD_A_PLANE,
    }
    goal = goal_of(pose, task, position_of(chain.base))
    return replace(goal, parts=goal.parts - {part for part in free if free[part]})


def _branches(subject: Subject, goal: Goal, solution: Solution) -> tuple[NamedBranch, ...]:
    """Return the solutions that closed forms give: a named system's own, or its link table's.

    If the goal leaves an angle free, they are those of the frame that the solver found.
    """
    whole = goal.parts == ALL_PARTS
    if not (whole or solution.ok):
        return ()
    frame = goal.frame if whole else solution.frame
    named = subject.system
    if named is None:
        return table_branches(subject.chain, frame, solution.joints)
    try:
        found = named.ik(named.goal_of(frame), solution.joints)
    except OutOfReach:
        return ()
    return tuple(branch for branch in found if _meets(goal, named.fk(branch.joints)))


def _meets(goal: Goal, frame: Transform) -> bool:
    """Return whether a hand's frame has everything that the goal asks for."""
    missed_mm = distance(position_of(frame), position_of(goal.frame))
    return missed_mm <= SAME_MM and norm(goal.turn(frame)[0]) <= SAME_RAD


def _count_text(goal: Goal, branches: Sequence[NamedBranch]) -> str:
    if not branches:
        return "solved numerically"
    count = counted(len(branches), "solution")
    return count if goal.parts == ALL_PARTS else f"{count} with the free angles as found below"


def _branch_row(chain: Chain, branch: NamedBranch) -> BranchRow:
    values = tuple(
        joint_text(value, kind.unit) for value, kind in zip(branch.joints, chain.kinds, strict=True)
    )
    return BranchRow(branch.name, values, tuple(map(str, branch.violations)))


def branch_view(chain: Chain, branch: NamedBranch) -> dict[str, Any]:
    """Return a solution as plain data, in mm and degrees."""
    return {
        "name": branch.name,
        "joints": shown_joints(chain, branch.joints),
        "within_limits": branch.within_limits,
        "violations": list(map(str, branch.violations)),
    }


def solution_view(chain: Chain, solution: Solution) -> dict[str, Any]:
    """Return a numerical solution as plain data, in mm and degrees."""
    return {
        "joints": shown_joints(chain, solution.joints),
        "frame": [list(row) for row in solution.frame],
        "ok": solution.ok,
        "met": sorted(part.value for part in solution.met),
        "missed": sorted(part.value for part in solution.missed),
        "residual_mm": solution.residual_mm,
        "residual_deg": math.degrees(solution.residual_rad),
        "at_limit": list(solution.at_limit),
        "sentence": solution.sentence,
    }
