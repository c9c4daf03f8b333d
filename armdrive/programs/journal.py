"""The journal of a running program, from which it can be resumed.

Before every act the journal is written: the program, its state, and where the arm stood. There is
one small file for each arm. It survives a power cut, and is deleted when the program ends well.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, cast

from armdrive.arm import Arm
from armdrive.arm.moving import ground_of
from armdrive.errors import ArmError, Refused, StateFileError
from armdrive.errors.printable import reason_of
from armdrive.motion.preview import postures_along
from armdrive.motion.resolve import prepare
from armdrive.moves import GraspMove, MoveSequence, SingleMove
from armdrive.programs.acts import (
    Act,
    Home,
    ProgramMove,
    RunStep,
)
from armdrive.programs.program import ArmProgram, Machine
from armdrive.programs.running import Performer, RunPlan, joints_of
from armdrive.runtime.position import ArmCoordinates
from armdrive.storage import files as places
from armdrive.storage.files import DISK, remove_durably, replace_durably
from armdrive.storage.record import sealed, unsealed
from armdrive.text.json_forms import (
    Form,
    as_table,
    move_form,
    optional,
    record,
)
from kinematics.errors import KinematicsError
from kinematics.spaces import Joints
from kinematics.text import deg_text, mm_text

# The format of a journal. One of another number was written by another version, and is refused.
FORMAT = 4

# Bytes. What is longer is not even read.
LONGEST_JOURNAL = 8_000_000


@dataclass(frozen=True, slots=True)
class JournalEntry:
    """A program that was interrupted, or is running.

    A machine restored from `snapshot` gives the interrupted act again. `began` is where the arm
    stood when that act began, None if that was unknown; `move` is its resolved move, None if it had
    none or was refused. `loop` counts from 1 and `loops` is how many were asked for.
    """

    arm: str
    program: str
    sha256: str
    line: int
    snapshot: dict[str, Any]
    began: ArmCoordinates | None
    move: ProgramMove | None = None
    loop: int = 1
    loops: int = 1
    outputs: int = 0


class Journal:
    """Writes the journal of one run: `begins` is called before each act.

    After an act nothing is written: until the next one begins, a resumed program repeats it.
    """

    def __init__(
        self, arm: Arm, performer: Performer, program: Path, sha256: str, loops: int
    ) -> None:
        self.path = journal_file(arm.config.name)
        self._arm = arm
        self._performer = performer
        self._program = str(program)
        self._sha256 = sha256
        self._loops = loops

    def begins(self, step: RunStep, machine: Machine) -> None:
        """Write down where the program is. After a `StateFileError` the act does not begin."""
        entry = JournalEntry(
            self._arm.config.name,
            self._program,
            self._sha256,
            step.mark.line,
            machine.snapshot(),
            standing(self._arm),
            step.move,
            step.loop,
            self._loops,
            self._performer.outputs,
        )
        try:
            replace_durably(DISK, self.path, sealed(_ENTRY.write(entry), FORMAT))
        except OSError as error:
            raise StateFileError(
                f"the program could not be resumed after an interruption, so nothing moves: "
                f"{self.path} cannot be written ({reason_of(error)})"
            ) from None

    def finish(self) -> None:
        """Forget the program, which has ended well. Raises `StateFileError` if that fails."""
        try:
            remove_durably(DISK, self.path)
        except OSError as error:
            raise StateFileError(
                f"the program has ended, but {self.path} cannot be removed ({reason_of(error)}): "
                "remove it, or the program could be resumed once more"
            ) from None


def journal_file(arm: str) -> Path:
    """Return the file of the program that an arm was last at work on."""
    return places.states() / f"{places.file_name(arm)}.program.json"


def standing(arm: Arm) -> ArmCoordinates | None:
    """Return where an arm stands, or None if that is unknown."""
    with arm.parts.pace.lock:
        return arm.parts.core.position.coordinates if arm.parts.core.position_known else None


def interrupted(arm: str) -> JournalEntry:
    """Return the program that an arm was interrupted in.

    Raises `Refused` where there is none, and `StateFileError` for a file that cannot be used.
    """
    path = journal_file(arm)
    try:
        text = DISK.read(path, LONGEST_JOURNAL + 1)
    except FileNotFoundError:
        raise Refused(f"no program of {arm} was interrupted: there is nothing to resume") from None
    except OSError as error:
        raise StateFileError(f"the journal {path} cannot be read: {reason_of(error)}") from None
    try:
        return _ENTRY.read(unsealed(text, FORMAT, LONGEST_JOURNAL), "the journal")
    except ArmError as error:
        raise StateFileError(
            f"the journal {path} cannot be used: {error}; start the program again"
        ) from None


_ENTRY = record(JournalEntry, snapshot=Form(dict, as_table, {}), move=optional(move_form()))


# Whether an interrupted program may be resumed: only if the arm is still where it was.
#
# The interrupted act is finished from where the arm is. So the arm must stand where that act began,
# on its path, or at its end, and its position must be trusted.

# How far every joint may be from a posture on the path: motors deviate between bursts.
NEAR_RAD = math.radians(3.0)

# How far the fingers may be from where they should be.
NEAR_MM = 2.0


def resumed_plan(
    plan: RunPlan, source: ArmProgram, path: Path, arm: Arm | None, *, how: str, move: str
) -> RunPlan:
    """Return the plan of a program that resumes where it was interrupted. Raises `Refused`.

    Without `arm` nothing is known about where it stands. `how` is the command that resumes the
    program, `move` the one that moves this arm.
    """
    entry = interrupted(source.config.name)
    require_same_program(entry, source.program.digest, str(path.resolve()))
    stage, left = source.restored(entry.snapshot).next(), entry.move
    if arm is not None and stage is not None:
        left = require_place(arm, entry, stage.act, how, move=move)
    return replace(
        plan,
        loops=entry.loops,
        loop=entry.loop,
        machine=partial(source.restored, entry.snapshot),
        left=left,
        outputs=entry.outputs,
    )


def require_same_program(entry: JournalEntry, sha256: str, path: str) -> None:
    """Raise `Refused` if a program is not the interrupted one."""
    if entry.sha256 != sha256:
        changed = entry.program == path
        raise Refused(
            f"{path} was changed since it was interrupted in line {entry.line}: start it again"
            if changed
            else f"the program that was interrupted is {entry.program}, in line {entry.line}, and "
            f"not {path}: resume that one, or start this one again"
        )


def require_place(
    arm: Arm, entry: JournalEntry, act: Act, how: str, *, move: str = "armdrive move"
) -> ProgramMove | None:
    """Return the rest of the interrupted move, or None to repeat the whole act.

    Raises `Refused` unless the arm stands where the act began, on its path or at its end, and
    `NotReferenced` for a position that is not trusted. `how` is the command that resumes the
    program, `move` the one that moves this arm. Sends nothing.
    """
    if isinstance(act, Home):
        return None
    arm.parts.core.require_reference()
    if entry.began is None:
        return None  # without a position only looks and texts can have come before
    with arm.parts.pace.lock:
        here = arm.parts.core.position.coordinates
    began = replace(entry.began, joints=joints_of(entry.began.joints.deg, arm))
    moves = _single_moves(entry.move)
    last = _move_under_way(arm, here, began, moves)
    if last is None:
        raise Refused(_elsewhere(here, began, how, move))
    return cast(ProgramMove, MoveSequence(moves[last:])) if len(moves) > 1 else entry.move


def _single_moves(move: ProgramMove | None) -> Sequence[SingleMove]:
    if move is None:
        return ()
    return move.moves if isinstance(move, MoveSequence) else (move,)


def _move_under_way(
    arm: Arm, here: ArmCoordinates, began: ArmCoordinates, moves: Sequence[SingleMove]
) -> int | None:
    """Return the index of the latest move that passes through where the arm stands.

    The latest, because what an earlier one did, such as a grasp, is not done twice. The first move
    begins where the act `began`; without any move the arm has to stand there.
    """
    ground, found = ground_of(arm.parts, arm.points, began), None
    for index, move in enumerate(moves or [None]):
        start, way = ground.here, [ground.here.joints]
        end_mm = 0.0 if isinstance(move, GraspMove) else start.opening_mm
        refused = move is None
        try:
            plan = None if move is None else prepare(move, ground).plan
        except (ArmError, KinematicsError):
            refused = True  # the arm cannot have come further
        else:
            if plan is not None:
                way += postures_along(arm.model.arm, plan)
                end_mm = plan.end.opening_mm
                ground = ground.at(plan.end)
        if _fits(arm, here, way, (start.opening_mm, end_mm)):
            found = index
        if refused:
            break
    return found


def _fits(
    arm: Arm, here: ArmCoordinates, way: Sequence[Joints], openings_mm: tuple[float, float]
) -> bool:
    least_mm, most_mm = min(openings_mm) - NEAR_MM, max(openings_mm) + NEAR_MM
    # a servo reports no opening
    fingers = not arm.parts.core.transmission.has_gripper or least_mm <= here.opening_mm <= most_mm
    return fingers and any(
        all(abs(a - b) <= NEAR_RAD for a, b in zip(here.joints, posture, strict=True))
        for posture in way
    )


def _elsewhere(here: ArmCoordinates, began: ArmCoordinates, how: str, move: str) -> str:
    now, then = here.joints.deg, began.joints.deg
    apart = [
        f"{name} {deg_text(now[name])} instead of {deg_text(angle)}"
        for name, angle in then.items()
        if abs(now[name] - angle) > math.degrees(NEAR_RAD)
    ]
    if abs(here.opening_mm - began.opening_mm) > NEAR_MM:
        apart.append(f"fingers {mm_text(here.opening_mm)} instead of {mm_text(began.opening_mm)}")
    joints = " ".join(f"--joint {name}={angle:.2f}" for name, angle in then.items())
    return (
        f"the arm does not stand where the program was interrupted ({', '.join(apart)}): bring it "
        f"back with `{move} {joints} --gripper {began.opening_mm:.1f}`, check that the fingers "
        f"still hold what they held, then run `{how}`; or start the program again"
    )
