"""A program that has been read, checked as a whole, and compiled: what runs are made from."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.programs.language.checking import checked
from armdrive.programs.language.compiling import CompiledCode, OpCode
from armdrive.programs.language.reading import read_tree
from armdrive.programs.language.syntax import Define, Tree
from armdrive.programs.language.values import ForwardKinematics, PlaceValue
from armdrive.programs.language.writing import unparse
from armdrive.programs.machine import Context, Machine, MachineState, ProgramWorld
from armdrive.programs.problems import Problem, SourceMark, program_error
from armdrive.storage.point_file import points_of
from armdrive.text.reading import read_text
from kinematics.errors import suggestion
from kinematics.spaces import Joints, Pose


@dataclass(frozen=True)
class Program:
    """A program; `tree` is what was written, `code` what the machine carries out."""

    text: str
    file: str
    tree: Tree
    code: CompiledCode
    context: Context = field(default_factory=Context)
    """What was known before it."""

    @cached_property
    def digest(self) -> str:
        """What changes when the text does: its sha256."""
        return _sha256(self.text)

    @cached_property
    def code_digest(self) -> str:
        """What changes when it is compiled to something else: its sha256."""
        rows = self.code.instructions
        plain = [(row.op.name, row.name, row.value, row.target, row.count) for row in rows]
        return _sha256(repr(plain))

    @cached_property
    def wanted(self) -> Mapping[str, SourceMark]:
        """The points of the arm's own book that it goes by, and where each stands first."""
        found: dict[str, SourceMark] = {}
        for row in self.code.instructions:
            if row.op in (OpCode.LOAD_POINT, OpCode.LOAD_SHIFTED):
                found.setdefault(row.name, row.mark)
        return found

    def machine(
        self,
        points: Mapping[str, Mapping[str, float]] | None = None,
        fk: ForwardKinematics | None = None,
        joint_names: tuple[str, ...] | None = None,
    ) -> Machine:
        """Return a run of it, from its beginning.

        `points` is the arm's book: joint angles (deg, by joint) by the names of the points; `fk`
        says the pose of joint angles; `joint_names` are the arm's joints. Raises `ProgramError`
        with every name that there is not.
        """
        book = {} if points is None else points
        places, problems = self._places(book)
        if joint_names is not None:
            problems += self._wrong_joints(joint_names)
        if problems:
            raise program_error(problems, self.text, self.file)
        known = self.context
        state = MachineState(
            variables=dict(known.variables), speed=known.speed, opening=known.opening
        )
        return Machine(self, ProgramWorld(places, fk), state)

    def restored(
        self, snapshot: Mapping[str, object], *, fk: ForwardKinematics | None = None
    ) -> Machine:
        """Return a run taken up again where its snapshot was made. Raises `ProgramError`."""
        return Machine.restored(self, snapshot, fk=fk)

    def _places(
        self, book: Mapping[str, Mapping[str, float]]
    ) -> tuple[dict[str, PlaceValue], list[Problem]]:
        places, problems = {}, []
        for name, mark in self.wanted.items():
            found = _in_book(name, book, self._names_set)
            if isinstance(found, str):
                problems.append(Problem(mark, found))
            else:
                places[name] = PlaceValue(joints_deg=dict(found))
        return places, problems

    @property
    def _names_set(self) -> set[str]:
        """The names that it sets, or that were set before it."""
        rows = self.code.instructions
        return {row.name for row in rows if row.op is OpCode.STORE} | {*self.context.variables}

    def _wrong_joints(self, joint_names: tuple[str, ...]) -> list[Problem]:
        problems = []
        for row in self.code.instructions:
            if row.op is OpCode.JOINTS:
                text = _joints_wrong(row.name.split(","), joint_names)
                problems += [Problem(row.mark, text)] if text else []
        return problems


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def written_program(tree: Tree, file: str = "") -> Program:
    """Return the program of a tree: written down, and read again, so that it can be run."""
    return read_program(unparse(tree), file)


def read_program(
    text: str, file: str = "", context: Context | None = None, first: int = 1
) -> Program:
    """Read a program and check it as a whole. Raises `ProgramError` with all that is wrong.

    With a context, as `Machine.context` gives it, the subprograms and values of what ran before
    are known, and may be replaced. Its lines are counted from `first`, as part of a longer text.
    """
    known = Context() if context is None else context
    tree, problems = read_tree(text, file, first)
    own = tuple(line for line in tree.body if isinstance(line, Define))
    rest = tuple(line for line in tree.body if not isinstance(line, Define))
    code, wrong = checked(Tree((*rest, *known.but(own))), known.kinds)
    if code is None or problems or wrong:
        raise program_error([*problems, *wrong], text, file)
    return Program(text, file, tree, code, known)


def _in_book(
    name: str, book: Mapping[str, Mapping[str, float]], own: Collection[str]
) -> Mapping[str, float] | str:
    """Return a point by its name, in any capitals where that is clear, or why there is none.

    `own` are the program's names, one of which may have been meant.
    """
    if name in book:
        return book[name]
    alike = [each for each in book if each.lower() == name.lower()]
    if len(alike) == 1:
        return book[alike[0]]
    if alike:
        return f'{" and ".join(alike)} differ by capitals alone: write taught("{alike[0]}")'
    near = suggestion(name, (*book, *own))
    return f"{name!r} is set nowhere, and the arm's book has no point of that name{near}"


def _joints_wrong(said: list[str], known: tuple[str, ...]) -> str:
    unknown = next((name for name in said if name not in known), None)
    if unknown is not None:
        return f"this arm has no joint {unknown!r}{suggestion(unknown, known)}"
    missing = [name for name in known if name not in said]
    return (
        f"a place in joint angles says every joint: {', '.join(missing)} missing" if missing else ""
    )


# A program file on one arm: where its machines come from, with the arm's own points and joints.

ENDING = ".arm"


@dataclass(frozen=True)
class ArmProgram:
    """A program that has been read, and the arm that it is for."""

    program: Program
    config: ArmConfig

    def machine(self) -> Machine:
        """Return a machine at the beginning, with the arm's points as they are now."""
        taught = points_of(self.config.name, self.config.model.arm).read().points
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
