"""A program file on one arm: where its machines come from, with the arm's own points and joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from armdrive.errors import BadRequest
from armdrive.pointbook import points_of
from armdrive.programs.program import Program, read_program
from armdrive.textfile import read_text
from kinematics import Joints, Pose

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from armdrive.programs.machine import Machine

ENDING = ".arm"


@dataclass(frozen=True)
class ArmProgram:
    """A program that has been read, and the arm that it is for."""

    program: Program
    config: ArmConfig

    def machine(self) -> Machine:
        """Return a machine at the beginning, with the arm's points as they are now."""
        taught = points_of(self.config).read().points
        points = {name: point.joints.deg for name, point in taught.items()}
        names = self.config.model.arm.joint_names
        return self.program.machine(points, fk=self._fk, joint_names=names)

    def restored(self, snapshot: Mapping[str, object]) -> Machine:
        """Return a machine where a snapshot was made, with the points that it had then."""
        return self.program.restored(snapshot, fk=self._fk)

    def _fk(self, joints_deg: Mapping[str, float]) -> Pose:
        names = self.config.model.arm.joint_names
        return self.config.model.arm.fk(Joints.of(*(joints_deg[n] for n in names), names=names))


def read_program_file(path: Path) -> Program:
    """Read a program file. Raises `BadRequest` for one that cannot be read, and `ProgramError`."""
    return read_program(read_text(path, "the program", BadRequest), str(path))
