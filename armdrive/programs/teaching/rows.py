"""A program as rows for an arm's own memory, so that its pendant can run it alone, and back."""

from __future__ import annotations

from contextlib import closing
from typing import Any

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.errors import ArmError, Refused
from armdrive.moves import GripperMove, JointMove, MoveSequence, PoseMove
from armdrive.programs.acts import Act, Answer, Go, Look
from armdrive.programs.problems import ProgramError
from armdrive.programs.program import ArmProgram, Program
from armdrive.programs.rehearsal import SeenArm, UnattendedPerson, rehearsing_arm
from armdrive.programs.running import Performer, ProgramRun, RunPlan
from armdrive.programs.teaching.recording import TaughtLines
from armdrive.registry import pendant_of
from armdrive.registry.pendant import PendantProgram
from armdrive.storage.points import SAME_OPENING_MM, Point
from firmware_protocol.errors import BadField
from kinematics.errors import KinematicsError


def rows_of(arm: Arm, program: Program, origin: tuple[int, ...] | None) -> PendantProgram:
    """Return a program as rows. Raises `Refused` with the line that cannot be one.

    Rows are absolute in the registers of an arm with this `origin`. They are made on a twin that
    stands where the arm stands, so every motion is audited here: the pendant audits none.
    """
    if origin is None:
        raise Refused("the origin of the arm's registers is unknown: home it first")
    with closing(rehearsing_arm(SeenArm.of(arm), None)) as twin:
        maker = RowMaker(twin, origin)
        run = ProgramRun(RunPlan(ArmProgram(program, arm.config).machine), maker)
        try:
            run.carry_out()
        except ProgramError:
            raise
        except (ArmError, KinematicsError, BadField) as error:
            line = "" if run.at is None else f"line {run.at.mark.line} "
            raise Refused(f"{line}cannot be a row: {error}") from error
    if not maker.rows:
        raise Refused("the program has no `move`: there is nothing to make rows of")
    return PendantProgram(tuple(maker.rows), origin)


class RowMaker(Performer):
    """Carries a program out on a twin, and writes a row down wherever a motion ends."""

    def __init__(self, twin: Arm, origin: tuple[int, ...]) -> None:
        super().__init__(twin, UnattendedPerson())
        self.rows: list[Any] = []
        self._origin = origin
        self._pendant = pendant_of(twin.config)

    def perform(self, act: Act) -> Answer:
        """Carry out an act; refuse one that the arm's memory cannot hold."""
        if isinstance(act, Look):
            return super().perform(act)
        if not isinstance(act, Go):
            raise Refused("the arm's memory has motions only")
        parts = act.move.moves if isinstance(act.move, MoveSequence) else (act.move,)
        for move in parts:
            self._add(move)
        return None

    def _add(self, move: object) -> None:
        if not isinstance(move, JointMove | PoseMove | GripperMove):
            raise Refused("the arm's memory has joint motions and openings of the fingers only")
        most = self.arm.abilities.program_rows
        if len(self.rows) >= most:
            raise Refused(f"the arm's memory holds {most} rows")
        self.arm.start(move, stops=self.waits.stops).wait()
        if isinstance(move, GripperMove) and not self.rows:
            return  # a row is a posture of the whole arm: the first one opens the fingers as well
        steps = self.arm.parts.core.position.acknowledged
        registers = tuple(at - zero for at, zero in zip(steps, self._origin, strict=True))
        number = len(self.rows) + 1
        self.rows.append(self._pendant.row(self.arm.config, number, move.speed, registers))


def program_of(
    config: ArmConfig, program: PendantProgram, name: str
) -> tuple[dict[str, Point], str]:
    """Return points, and a program that does the same as the rows with them.

    The points are called `NAME_ROW`. A row that moves only the fingers becomes a line for the
    fingers; for a row that moves both, the arm moves first. Raises `Refused` if the meaning of the
    rows is unknown.
    """
    points: dict[str, Point] = {}
    lines = TaughtLines()
    last = None
    for place in program.places(config):
        if last is None or place.joints != last.joints:
            point = f"{name}_{place.number}"
            points[point] = Point(place.joints, place.opening_mm, f"row {place.number}")
            lines.go(point, speed=place.speed)
        if last is None or abs(place.opening_mm - last.opening_mm) >= SAME_OPENING_MM:
            lines.fingers(round(max(place.opening_mm, 0.0), 1), speed=place.speed)
        last = place
    return points, lines.text
